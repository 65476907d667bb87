# SPDX-License-Identifier: Apache-2.0
"""Identification of models from measured runs."""

from lce_analysis.fit.identify import fit, fit_each
from lce_analysis.fit.result import FitResult

__all__ = ["FitResult", "fit", "fit_each"]
