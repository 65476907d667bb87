# SPDX-License-Identifier: Apache-2.0
"""What jobs do: the use cases that the commands of `lce` call, with the files that the page reads afterwards.

A job runs in a process of its own, so each task takes plain values and the ``progress`` of its job.
"""

from __future__ import annotations

import json
import os
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from lce_app.use_cases import add_effect as adding
from lce_app.use_cases import design as designing
from lce_app.use_cases import diagnose as diagnosing
from lce_app.use_cases import fit as fitting
from lce_app.use_cases import record as recording
from lce_data.files import write_atomically
from lce_data.progress import Progress
from lce_data.units import KELVIN
from lce_experiment.runners.processes import Processes

if TYPE_CHECKING:
    from lce_analysis.diagnosis import Diagnosis

LOOK_S: Final = 0.1
"""How often the end of a launch is looked for [s]."""


def fit(runs: Sequence[Path], thermal: str, deformation: str, out: Path, *, progress: Progress) -> None:
    """`lce fit`."""
    choice = fitting.ModelChoice(thermal, deformation)
    fitting.fit(runs, out, choice, fitting.Options(homogeneity=False), progress)


def diagnose(runs: Sequence[Path], test: Sequence[Path], model: Path, out: Path, *, progress: Progress) -> None:
    """`lce diagnose`, its report beside ``out``."""
    options = diagnosing.Options(homogeneity=False)
    report = out.with_suffix(".html")
    found = diagnosing.diagnose(runs, model, test, options, report_file=report, progress=progress)
    write_atomically(out, json.dumps(_record(found.diagnosis), indent=1) + "\n")


def _record(found: Diagnosis) -> dict[str, Any]:
    """The record of `lce diagnose --json`, with the sentences, and the values at which each effect was judged."""
    record = found.as_json()
    record["sentences"] = list(found.sentences)
    for candidate, score in zip(record["candidates"], found.scores, strict=True):
        spec = score.effect.parameter(score.effect.strength)
        strength = min(max(score.expected_strength, spec.lower), spec.upper)
        candidate["settings"] = {**score.direction.settings, score.effect.strength_key: strength}
        candidate["shown"] = score.shown
    return record


def add(effect: str, runs: Sequence[Path], test: Sequence[Path], model: Path, out: Path, *, progress: Progress) -> None:
    """`lce add`, its report beside ``out``."""
    adding.add_effect(effect, runs, model, out, test, report_file=out.with_suffix(".html"), progress=progress)


def design(
    model: Path,
    between: tuple[str, str],
    limits: tuple[float, float, float],
    command: str,
    out: Path,
    *,
    progress: Progress,
) -> None:
    """`lce design`; a JSON file beside the waveform says what it is worth, and the command that does the same.

    limits are of power [W], temperature [°C] and duration [s].
    """
    power_w, temperature_c, duration_s = limits
    search = designing.DesignOptions(power_w, temperature_c + KELVIN, duration_s)
    found = designing.design(model, between, out, designing.Options(search), progress).design
    about = {"between": between, "protocol": found.protocol, "separation": found.separation}
    about |= {"hottest_c": found.hottest_k - KELVIN, "command": command}
    write_atomically(out.with_suffix(".json"), json.dumps(about) + "\n")


def run(
    protocol: str, out: Path, model: Path | None, settings: Mapping[str, float], domain: int, *, progress: Progress
) -> None:
    """`lce run`, in real time on the simulated bench of a ROS domain."""
    os.environ["ROS_DOMAIN_ID"] = str(domain)
    recording.record(protocol, out, recording.Options(model, settings), progress)


def run_hardware(protocol: str, out: Path, domain: int, *, progress: Progress) -> None:
    """The experiment on the real bench: the launch file of that name, which ends with the experiment."""
    os.environ["ROS_DOMAIN_ID"] = str(domain)
    launch = ["ros2", "launch", "lce_bringup", "experiment.launch.py", "plant:=hardware"]
    (plan,) = recording.plan_recordings(protocol, out, recording.Options())
    began = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="lce_run_") as logs, Processes(Path(logs)) as nodes:
        process = nodes.start("launch", [*launch, f"protocol:={protocol}", f"out:={out}"])
        while process.poll() is None:
            plan.report(progress, time.monotonic() - began)
            time.sleep(LOOK_S)
        nodes.stop("launch")
