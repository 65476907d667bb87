# SPDX-License-Identifier: Apache-2.0
"""The run of a step to a target: which nodes, with which parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from lce_experiment.config import config_file
from lce_experiment.plan import Plan
from lce_experiment.registry import CONTROLLERS, MODEL_READERS, TARGET_LISTENERS, TARGET_PLAYER
from lce_experiment.strip import conditions, measured_topics, simulated_strip


@dataclass(frozen=True)
class ControlSetup:
    """What the controllers know, and how the simulated strip differs from it.

    Parameters
    ----------
    model_file : what the controllers know of the strip.
    settings : parameters of the strip that differ from its model file, TERM.PARAM in its units.
    gains : ROS parameter file over control.yaml; None for control.yaml alone.
    strip_file : model file of the strip; None for `model_file`.
    """

    model_file: Path
    settings: Mapping[str, float] = field(default_factory=dict)
    gains: Path | None = None
    strip_file: Path | None = None


def step_plan(
    mode: str, target_m: float, setup: ControlSetup, folder: Path, seed: int, hold_s: float, fast: bool
) -> Plan:
    """The run of a step from rest to `target_m` [m], held for `hold_s` [s] and recorded in `folder`."""
    strip_file = setup.strip_file or setup.model_file
    strip = simulated_strip(strip_file, setup.settings)
    controllers = CONTROLLERS[mode]
    targets = {
        "target_m": [target_m],
        "duration_s": hold_s,
        "wait_for": [c.name for c in controllers if c in TARGET_LISTENERS],
    }
    model_files = {c.name: {"model_file": str(setup.model_file.resolve())} for c in controllers if c in MODEL_READERS}
    return Plan(
        protocol=f"control {1e3 * target_m:g} mm, {mode}",
        duration_s=hold_s,
        folder=folder,
        model=strip_file,
        settings=setup.settings,
        seed=seed,
        fast=fast,
        conditions=conditions(strip),
        measured=measured_topics(strip),
        player=TARGET_PLAYER,
        controllers=controllers,
        files=tuple(f for f in (config_file("control.yaml"), setup.gains) if f is not None),
        given={TARGET_PLAYER.name: targets, **model_files},
    )
