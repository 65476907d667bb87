# SPDX-License-Identifier: Apache-2.0
"""Identification of models from measured runs."""

from lce_analysis.identification.identify import fit, fit_each
from lce_analysis.identification.result import FitResult

__all__ = ["FitResult", "fit", "fit_each"]
