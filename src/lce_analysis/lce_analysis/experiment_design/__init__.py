# SPDX-License-Identifier: Apache-2.0
"""The experiment that would tell two effects apart."""

from lce_analysis.experiment_design.design import Design, design

__all__ = ["Design", "design"]
