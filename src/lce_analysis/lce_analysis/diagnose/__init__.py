# SPDX-License-Identifier: Apache-2.0
"""Which physical effect is missing: the score test, refits, and what no effect explains."""

from lce_analysis.diagnose.addition import Addition, add
from lce_analysis.diagnose.diagnosis import Diagnosis, diagnose

__all__ = ["Addition", "Diagnosis", "add", "diagnose"]
