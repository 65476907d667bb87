# SPDX-License-Identifier: Apache-2.0
"""A positioning run as plain values: the target, what was recorded, and how well the strip followed."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lce_control.step_metrics import StepMetrics

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Positioning:
    """A target and the response of the strip, from the moment it was set.

    Attributes
    ----------
    folder : the bag.
    target_m : [m].
    series : time [s] and value, (n,) each, by topic; T in °C, P in W, d in m.
    figures : of the true displacement on a simulated strip, of the measured one on a real one.
    limit_rise_time_s : rise time of the same strip under full power until the switching time (bang-bang) [s].
    energy_j : light on the strip [J].
    """

    folder: Path
    target_m: float
    series: Mapping[str, tuple[Floats, Floats]]
    figures: StepMetrics
    limit_rise_time_s: float
    energy_j: float

    def as_json(self) -> dict[str, float | None]:
        """As `lce control --json` has it: fractions of the target; null for a time that was never reached."""
        figures = self.figures
        numbers = {
            "target_m": self.target_m,
            "rise_time_s": figures.rise_time_s,
            "limit_rise_time_s": self.limit_rise_time_s,
            "overshoot": figures.overshoot,
            "settling_time_s": figures.settling_time_s,
            "rmse_after_30s": figures.rmse_after_30s,
            "energy_j": self.energy_j,
        }
        return {name: float(f"{number:.6g}") if math.isfinite(number) else None for name, number in numbers.items()}
