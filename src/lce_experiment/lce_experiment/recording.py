# SPDX-License-Identifier: Apache-2.0
"""From the arguments of `lce run` and `lce control` to recordings: where they go, on which strip, with which seed."""

from __future__ import annotations

import secrets
import signal
import sys
from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from tqdm import tqdm

from lce_data import experiment_file as experiment
from lce_data.errors import LceError
from lce_data.units import KELVIN
from lce_experiment.domain import own_domain
from lce_model import Model, default_model, load_model

if TYPE_CHECKING:
    from lce_experiment.graph import Plan


def seeded(seed: int | None) -> int:
    """The seed asked for, or a new one. Raises LceError for a negative one."""
    if seed is not None and seed < 0:
        raise LceError(f"--seed {seed}: must be 0 or more")
    return secrets.randbelow(2**31) if seed is None else seed


def folders(out: Path | None, name: str, runs: Sequence[str]) -> list[Path]:
    """Where the runs are recorded: in `out`, or in folders of it if there are several; runs/TIME_NAME by default.

    Raises LceError for one that exists.
    """
    out = out or Path("runs") / f"{datetime.now(UTC):%Y%m%d-%H%M%S}_{name}"
    places = [out] if len(runs) == 1 else [out / run for run in runs]
    for place in places:
        if place.exists():
            raise LceError(f"{place}: exists already; a recording is never overwritten")
    return places


def simulated_strip(model: Path | None, settings: Mapping[str, float]) -> Model:
    """The strip of the simulator. Raises LceError for what the simulator would refuse."""
    strip = (default_model() if model is None else load_model(model)).configured(settings)
    if strip.thermal == "none":
        raise LceError(f"{model}: has no thermal stage; a strip on the bench is driven by laser power")
    return strip


def conditions(strip: Model) -> dict[str, float]:
    """What experiment.yaml tells of the strip's surroundings."""
    found = {}
    if "ambient.t_env" in strip:
        found["ambient_temperature_c"] = round(strip["ambient.t_env"] - KELVIN, 6)
    if "strip.length" in strip:
        found["strip_length_m"] = strip["strip.length"]
    return found


def topics(strip: Model) -> tuple[str, ...]:
    """The topics that a run on the strip gives."""
    return ("laser/power", "temperature", *(() if strip.deformation == "none" else ("displacement",)))


def interruptible() -> None:
    """Let SIGTERM end a run as Ctrl-C does, and Ctrl-C also where a shell's background job has it ignored."""
    signal.signal(signal.SIGTERM, _terminated)
    signal.signal(signal.SIGINT, signal.default_int_handler)


def record(plan: Plan) -> None:
    """Run a plan under a progress bar."""
    bar = tqdm(
        total=plan.duration_s,
        desc=plan.folder.name,
        unit="s",
        file=sys.stderr,
        bar_format="{desc}: {percentage:3.0f}%|{bar}| {n:.0f}/{total:.0f} s [{elapsed}<{remaining}]",
        mininterval=0.1 if sys.stderr.isatty() else 2.0,
    )
    try:
        with bar:
            play(plan, lambda played_s: bar.update(min(max(played_s, 0.0), plan.duration_s) - bar.n))
    except BaseException:
        if (plan.folder / experiment.FILE_NAME).exists():
            print(f"lce: what was recorded until then is in {plan.folder}", file=sys.stderr)
        raise


def play(plan: Plan, progress: Callable[[float], object]) -> None:
    """Run a plan on the node graph, `progress` is told the seconds played; experiment.yaml tells how it ended."""
    outcome = "failed"
    try:
        with own_domain():
            _runner(plan)(plan, progress)
        outcome = "complete"
    except KeyboardInterrupt:
        outcome = "interrupted"
        raise
    finally:
        if (plan.folder / experiment.FILE_NAME).exists():
            experiment.update(plan.folder, outcome=outcome)


def _runner(plan: Plan) -> Callable[[Plan, Callable[[float], object]], None]:
    if plan.fast:
        from lce_experiment.runners.fast import run_fast

        return run_fast
    from lce_experiment.runners.realtime import run_realtime

    return run_realtime


def _terminated(number: int, frame: object) -> NoReturn:
    raise KeyboardInterrupt
