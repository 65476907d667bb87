# SPDX-License-Identifier: Apache-2.0
"""Position the strip on the node graph, record each step, and judge it."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from lce_app.errors import OptionError, check_seed
from lce_control.positioning import Positioning
from lce_data.errors import LceError
from lce_data.files import write_atomically
from lce_data.given_conditions import check_conditions
from lce_data.progress import CancelToken, Progress, silent, watched
from lce_experiment import config, recording
from lce_experiment.plan import Plan, folders, seeded
from lce_experiment.positioning.outcome import evaluate
from lce_experiment.positioning.reach import check_reach
from lce_experiment.positioning.step_plan import ControlSetup, step_plan
from lce_experiment.registry import CONTROLLERS
from lce_experiment.strip import simulated_strip
from lce_model import load_model
from lce_report.pages.positioning import render_positioning

HOLD_S = 1.0, 3600.0
"""Shortest and longest time that a target is held [s]."""


@dataclass(frozen=True)
class Options:
    """Controllers, strip, and how a target is held.

    Parameters
    ----------
    mode : a key of ``CONTROLLERS``: "double" (cascade), "single" (one loop) or "model" (model control).
    model : what the controllers know, and the simulated strip; None for the default strip.
    strip : the simulated strip, if it is another one than ``model``.
    settings : parameters of the strip alone, by TERM.PARAM: what the controllers do not know of it.
    gains : ROS parameter file laid over control.yaml, as `lce tune` writes it.
    hold_s : how long a target is held [s], within 1 and 3600.
    seed : of the sensor noise, 0 or more; None for a new one.
    fast : simulated time, as quickly as the machine can, instead of real time.
    conditions : what experiment.yaml and the metadata of the bags say of the runs, as of ``record.Options``.
    """

    mode: str = "double"
    model: Path | None = None
    strip: Path | None = None
    settings: Mapping[str, float] = field(default_factory=dict)
    gains: Path | None = None
    hold_s: float = 60.0
    seed: int | None = None
    fast: bool = False
    conditions: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.mode not in CONTROLLERS:
            raise OptionError("mode", f"{self.mode!r} is not one of {', '.join(CONTROLLERS)}")
        if not HOLD_S[0] <= self.hold_s <= HOLD_S[1]:
            raise OptionError("hold_s", f"{self.hold_s:g}: must be within [{HOLD_S[0]:g}, {HOLD_S[1]:g}] s")
        check_seed(self.seed)

    @property
    def model_file(self) -> Path:
        """What the controllers know."""
        return self.model or config.default_strip()


@dataclass(frozen=True)
class Controlled:
    """What became of each target, in the order of the request."""

    mode: str
    runs: tuple[Positioning, ...]


DEFAULTS = Options()


def control(
    targets_mm: Sequence[float],
    out: Path | None = None,
    options: Options = DEFAULTS,
    json_file: Path | None = None,
    report_file: Path | None = None,
    progress: Progress = silent,
    cancel: CancelToken | None = None,
    finished: Callable[[Path], object] = lambda folder: None,
) -> Controlled:
    """Step from rest to each target, record the run, and judge it.

    Everything that can be wrong with the request is found before anything is started or written.

    Parameters
    ----------
    targets_mm : displacements [mm], one run from rest each.
    out : new folder of the recording; of several targets the folder of them; None for ``runs/TIME_control_MODE``.
    options : controllers, strip, and how long a target is held.
    json_file, report_file : the figures as JSON (fractions of the target, SI), and as one HTML file.
    progress : called after each second played; its error is NaN.
    cancel : ends the run as Ctrl-C does: the laser goes to zero, and what was recorded until then is kept.
    finished : called with each folder when its recording is complete.

    Returns
    -------
    Controlled
        Rise time, overshoot, settling time and error of each run.

    Raises
    ------
    OutOfReach
        If the strip has no such displacement, or the laser is too weak for it.
    LceError
        If a file cannot be used, or a node fails.

    Examples
    --------
    >>> found = control([0.5, 1.0], options=Options(mode="single", fast=True))  # doctest: +SKIP
    >>> print(found.runs[0].figures.rise_time_s)  # doctest: +SKIP
    """
    progress = watched(progress, cancel)
    if options.gains is not None and not options.gains.is_file():
        raise LceError(f"{options.gains}: no such file")
    strip_file = options.strip or options.model_file
    strip = simulated_strip(strip_file, options.settings)
    plans = _plans(targets_mm, out, options)
    runs = []
    for planned, target_mm in zip(plans, targets_mm, strict=True):
        recording.record(planned, progress)
        finished(planned.folder)
        runs.append(evaluate(planned.folder, 1e-3 * target_mm, strip, config.laser_limit_w()))
    if json_file:
        content = {"mode": options.mode, "targets": [run.as_json() for run in runs]}
        write_atomically(json_file, json.dumps(content, allow_nan=False) + "\n")
    if report_file:
        words = ", ".join([str(strip_file), *(f"{key}={value:g}" for key, value in options.settings.items())])
        about = (f"Model: {options.model_file}. Strip: {words}.", f"Seed: {plans[0].seed}.")
        write_atomically(report_file, render_positioning(options.mode, runs, about))
    return Controlled(options.mode, tuple(runs))


def _plans(targets_mm: Sequence[float], out: Path | None, options: Options) -> list[Plan]:
    """One run for each target. Raises LceError for everything that can be wrong with them."""
    known = load_model(options.model_file)
    for target_mm in targets_mm:
        check_reach(known, 1e-3 * target_mm, config.laser_limit_w())
    seed, given = seeded(options.seed), check_conditions(options.conditions)
    setup = ControlSetup(options.model_file, options.settings, options.gains, options.strip)
    places = folders(out, f"control_{options.mode}", _names(targets_mm))
    plans = [
        step_plan(options.mode, 1e-3 * target_mm, setup, folder, seed + k, options.hold_s, options.fast)
        for k, (target_mm, folder) in enumerate(zip(targets_mm, places, strict=True))
    ]
    return [replace(plan, conditions={**plan.conditions, **given}) for plan in plans]


def _names(targets_mm: Sequence[float]) -> list[str]:
    """A name for each target; targets that are named twice get a number."""
    return [f"{mm:g}mm_{k}" if targets_mm.count(mm) > 1 else f"{mm:g}mm" for k, mm in enumerate(targets_mm)]
