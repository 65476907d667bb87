# SPDX-License-Identifier: Apache-2.0
"""What a positioning experiment achieved: its bag as series and figures."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lce_control.step_metrics import StepMetrics, step_metrics
from lce_control.tuning.bang_bang import bang_bang
from lce_data.bag.reader import read_numbers
from lce_data.channels import DISPLACEMENT, POWER, TEMPERATURE
from lce_data.errors import LceError
from lce_data.topics import TARGET, simulated_topic
from lce_experiment.registry import NAMESPACE
from lce_model import Model

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Positioning:
    """A target and the response of the strip, from the moment it was set.

    Attributes
    ----------
    series : time [s] and value, (n,) each, by topic; T in °C, P in W, d in m.
    figures : of the true displacement on a simulated strip, of the measured one on a real one.
    limit_rise_time_s : of the bang-bang limit of the same strip.
    energy_j : light on the strip.
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


def evaluate(folder: Path, target_m: float, strip: Model, max_power_w: float) -> Positioning:
    """Figures of the bag of a step from rest to ``target_m`` [m]; the bang-bang bound is that of ``strip``."""
    series = read_series(folder)
    missing = [topic for topic in (DISPLACEMENT.topic, TEMPERATURE.topic, POWER.topic, TARGET) if topic not in series]
    if missing:
        raise LceError(f"{folder}: nothing was recorded of {', '.join(missing)}")
    begin_s = series[TARGET][0][0]
    series = {topic: (time_s - begin_s, value) for topic, (time_s, value) in series.items()}
    time_s, displacement_m = series.get(simulated_topic(DISPLACEMENT), series[DISPLACEMENT.topic])
    after = time_s >= 0.0
    best = bang_bang(strip, target_m, 30.0, max_power_w)
    power_time_s, power_w = series[POWER.topic]
    since_target_s = np.clip(power_time_s, 0.0, None)
    return Positioning(
        folder,
        target_m,
        series,
        step_metrics(time_s[after], displacement_m[after], target_m),
        step_metrics(best.time_s, best.displacement_m, target_m).rise_time_s,
        float(np.sum(power_w[:-1] * np.diff(since_target_s))),
    )


def read_series(folder: Path) -> dict[str, tuple[Floats, Floats]]:
    """Log time [s] and number, (n,) each, of every topic of a bag that holds numbers, by its name in the namespace."""
    return {topic.removeprefix(f"{NAMESPACE}/"): series for topic, series in read_numbers(folder).items()}
