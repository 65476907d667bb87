# SPDX-License-Identifier: Apache-2.0
"""The experiment of the simulation–experiment method: gains judged on the running nodes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import yaml

from lce_control.tuning.requirements import Parameters, Step
from lce_control.tuning.search import Task
from lce_data.channels import DISPLACEMENT, POWER
from lce_data.progress import silent
from lce_data.topics import TARGET, simulated_topic
from lce_experiment.domain import own_domain
from lce_experiment.positioning.outcome import read_series
from lce_experiment.positioning.step_plan import ControlSetup, step_plan
from lce_experiment.runners.fast import run_fast


def gains_yaml(parameters: Parameters) -> str:
    """Gains as a ROS parameter file, in the form of control.yaml."""
    content = {f"/**/{node}": {"ros__parameters": dict(own)} for node, own in parameters.items()}
    return yaml.safe_dump(content, sort_keys=False)


def on_nodes(task: Task, setup: ControlSetup, targets_m: tuple[float, ...], duration_s: float) -> Task:
    """The same task, its steps made by the nodes on simulated time; ``task.name`` is the mode of control."""

    def steps(parameters: Parameters) -> tuple[Step, ...]:
        with TemporaryDirectory(prefix="lce_tune_") as name, own_domain():
            gains = Path(name) / "gains.yaml"
            gains.write_text(gains_yaml(parameters), encoding="utf-8")
            with_gains = replace(setup, gains=gains)
            return tuple(
                _step(task.name, target_m, with_gains, Path(name) / f"run{seed}", seed, duration_s)
                for seed, target_m in enumerate(targets_m)
            )

    return replace(task, steps=steps)


def _step(mode: str, target_m: float, setup: ControlSetup, folder: Path, seed: int, duration_s: float) -> Step:
    run_fast(step_plan(mode, target_m, setup, folder, seed, duration_s, fast=True), silent)
    series = read_series(folder)
    begin_s = series[TARGET][0][0]
    time_s, displacement_m = series[simulated_topic(DISPLACEMENT)]
    power_time_s, power_w = series[POWER.topic]
    after = time_s >= begin_s
    light_w = np.interp(time_s[after], power_time_s, power_w)
    return Step(target_m, time_s[after] - begin_s, displacement_m[after], light_w)
