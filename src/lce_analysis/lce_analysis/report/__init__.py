# SPDX-License-Identifier: Apache-2.0
"""A comparison as one HTML file that opens anywhere, without a network."""

from lce_analysis.report.page import render

__all__ = ["render"]
