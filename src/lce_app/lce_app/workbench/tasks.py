# SPDX-License-Identifier: Apache-2.0
"""What jobs do, each the same library calls as the command of its name; results are files, written whole and last."""

from __future__ import annotations

import json
import math
import os
import tempfile
import time
from argparse import Namespace
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Final

import lce_analysis.design.design
import lce_analysis.diagnosis
import lce_analysis.identification
from lce_analysis.comparison.compare import compare
from lce_app.cli.commands.run import plans
from lce_data.files import write_atomically
from lce_data.progress import Progress
from lce_data.read_runs import read_runs
from lce_data.units import KELVIN
from lce_experiment.graph import check_power
from lce_experiment.protocols import load
from lce_experiment.recording import play
from lce_experiment.runners.processes import Processes
from lce_model import default_model, load_model, save_model
from lce_report.diagnosis_page import addition_page, page

LOOK_S: Final = 0.1


def fit(runs: Sequence[Path], thermal: str, deformation: str, out: Path, *, progress: Progress) -> None:
    """`lce fit`."""
    save_model(
        lce_analysis.identification.fit(default_model(thermal, deformation), read_runs(runs), "model", progress).model,
        out,
    )


def diagnose(runs: Sequence[Path], test: Sequence[Path], model: Path, out: Path, *, progress: Progress) -> None:
    """`lce diagnose`: the contract's JSON, with the sentences, and the values at which each effect was judged."""
    train, held_out = read_runs(runs), read_runs(test)
    found = lce_analysis.diagnosis.diagnose(load_model(model), train, held_out, progress=progress)
    record = found.as_json()
    record["sentences"] = list(found.sentences)
    for candidate, score in zip(record["candidates"], found.scores, strict=True):
        spec = score.effect.parameter(score.effect.strength)
        strength = min(max(score.expected_strength, spec.lower), spec.upper)
        candidate["settings"] = {**score.direction.settings, score.effect.strength_key: strength}
        candidate["shown"] = score.shown
    write_atomically(out.with_suffix(".html"), page(found, train, held_out))
    write_atomically(out, json.dumps(record, indent=1) + "\n")


def add(effect: str, runs: Sequence[Path], test: Sequence[Path], model: Path, out: Path, *, progress: Progress) -> None:
    """`lce add`."""
    train, held_out = read_runs(runs), read_runs(test)
    addition = lce_analysis.diagnosis.add(load_model(model), effect, train, held_out, progress)
    every = [*train, *held_out]
    before, after = compare(addition.before, every), compare(addition.model, every)
    report = addition_page(addition, before, after, {run.name for run in held_out})
    write_atomically(out.with_suffix(".html"), report)
    save_model(addition.model, out)


def design(
    model: Path,
    between: tuple[str, str],
    limits: tuple[float, float, float],
    command: str,
    out: Path,
    *,
    progress: Progress,
) -> None:
    """`lce design`: the waveform, and beside it what it is worth and the command that does the same.

    limits are of power [W], temperature [°C] and duration [s].
    """
    power_w, temperature_c, duration_s = limits
    within = lce_analysis.design.design.Limits(power_w, temperature_c + KELVIN, duration_s)
    found = lce_analysis.design.design.design(load_model(model), between, within, progress)
    rows = [f"{t:.2f},{p:.6g}" for t, p in zip(found.time_s, found.power_w, strict=True)]
    about = {"between": between, "protocol": found.protocol, "separation": found.separation}
    about |= {"hottest_c": found.hottest_k - KELVIN, "command": command}
    write_atomically(out, "\n".join(["time_s,power_w", *rows]) + "\n")
    write_atomically(out.with_suffix(".json"), json.dumps(about) + "\n")


def run(
    protocol: str, out: Path, model: Path | None, settings: Sequence[str], domain: int, *, progress: Progress
) -> None:
    """`lce run`, in real time on the simulated bench of a ROS domain."""
    os.environ["ROS_DOMAIN_ID"] = str(domain)
    words = {"protocol": protocol, "out": out, "model": model, "set": list(settings), "seed": None, "fast": False}
    for plan in plans(Namespace(**words)):
        label, total = f"recording {plan.folder.name}", round(plan.duration_s)
        play(plan, partial(_played, progress, label, total))


def _played(progress: Progress, label: str, total: int, played_s: float) -> None:
    progress(label, min(max(round(played_s), 0), total), total, math.nan)


def run_hardware(protocol: str, out: Path, domain: int, *, progress: Progress) -> None:
    """The experiment on the real bench: the launch file of that name, which ends with the experiment."""
    os.environ["ROS_DOMAIN_ID"] = str(domain)
    launch = ["ros2", "launch", "lce_bringup", "experiment.launch.py", "plant:=hardware"]
    (wave,) = load(protocol)
    check_power(wave)
    began = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="lce_run_") as logs, Processes(Path(logs)) as nodes:
        process = nodes.start("launch", [*launch, f"protocol:={protocol}", f"out:={out}"])
        while process.poll() is None:
            _played(progress, f"recording {out.name}", round(wave.duration_s), time.monotonic() - began)
            time.sleep(LOOK_S)
        nodes.stop("launch")
