# SPDX-License-Identifier: Apache-2.0
"""Identification of models from measured runs."""

from lce_analysis.fit.identify import FitResult, fit, fit_each

__all__ = ["FitResult", "fit", "fit_each"]
