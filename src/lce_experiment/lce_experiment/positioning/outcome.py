# SPDX-License-Identifier: Apache-2.0
"""What a positioning experiment achieved: its bag as series and figures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lce_control.positioning import Positioning
from lce_control.step_metrics import step_metrics
from lce_control.tuning.bang_bang import bang_bang
from lce_data.bag.reader import read_numbers
from lce_data.channels import DISPLACEMENT, POWER, TEMPERATURE
from lce_data.errors import LceError
from lce_data.topics import TARGET, simulated_topic
from lce_experiment.registry import NAMESPACE
from lce_model import Model

Floats = NDArray[np.float64]


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
