# SPDX-License-Identifier: Apache-2.0
"""Which physical effect is missing: the score test, refits, and what no effect explains."""

from lce_analysis.diagnosis.addition import Addition, add_effect
from lce_analysis.diagnosis.diagnosis import Diagnosis, diagnose
from lce_analysis.diagnosis.signature import Signature, effect_signature

__all__ = ["Addition", "Diagnosis", "Signature", "add_effect", "diagnose", "effect_signature"]
