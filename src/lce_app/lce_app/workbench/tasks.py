# SPDX-License-Identifier: Apache-2.0
"""What jobs do: the use cases that the commands of `lce` call, with the files that the page reads afterwards.

A job runs in a process of its own, so each task takes plain values and the ``progress`` of its job.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

from msgspec import to_builtins

from lce_app.use_cases import add_effect as adding
from lce_app.use_cases import design as designing
from lce_app.use_cases import diagnose as diagnosing
from lce_app.use_cases import discover as discovering
from lce_app.use_cases import fit as fitting
from lce_app.use_cases import record as recording
from lce_app.use_cases import record_topics as recording_topics
from lce_app.workbench.records import AdditionRecord, diagnosis_record, discovery_record
from lce_app.workbench.session import from_folder
from lce_data.files import write_atomically
from lce_data.progress import Progress
from lce_data.units import KELVIN


def fit(runs: Sequence[Path], choice: fitting.ModelChoice, out: Path, *, progress: Progress) -> Sequence[str]:
    """`lce fit`; returns its warnings, and what is wrong with the model."""
    fits = fitting.fit(runs, out, choice, progress=progress)
    return (*fits.warnings, *(fault for fitted in fits.models for fault in fitted.faults))


def diagnose(runs: Sequence[Path], test: Sequence[Path], model: Path, out: Path, *, progress: Progress) -> None:
    """`lce diagnose`, its report beside ``out``."""
    found = diagnosing.diagnose(runs, model, test, report_file=out.with_suffix(".html"), progress=progress)
    files = {role: from_folder(read, out.parent) for role, read in (("train", runs), ("test", test))}
    write_atomically(out, json.dumps(diagnosis_record(found, files)) + "\n")


def discover(
    runs: Sequence[Path], test: Sequence[Path], model: Path, effect_file: Path, out: Path, *, progress: Progress
) -> None:
    """`lce discover`, what it found in ``effect_file``, its report beside ``out``."""
    report = out.with_suffix(".html")
    written = discovering.discover(runs, model, effect_file, test, report_file=report, progress=progress)
    write_atomically(out, json.dumps(discovery_record(written)) + "\n")


def add(effect: str, runs: Sequence[Path], test: Sequence[Path], model: Path, out: Path, *, progress: Progress) -> None:
    """`lce add`, beside ``out`` its report, and a JSON file of what the page shows."""
    found = adding.add_effect(effect, runs, model, out, test, report_file=out.with_suffix(".html"), progress=progress)
    record = AdditionRecord(found.addition.sentence, found.tables, found.strength)
    write_atomically(out.with_suffix(".json"), json.dumps(to_builtins(record)) + "\n")


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
    designed = designing.design(model, between, out, designing.Options(search), progress)
    found = designed.design
    about = {
        "between": between,
        "protocol": found.protocol,
        "separation": found.separation,
        "hottest_c": found.hottest_k - KELVIN,
        "sentences": designed.sentences,
        "command": command,
    }
    write_atomically(out.with_suffix(".json"), json.dumps(about) + "\n")


def run(
    protocol: str,
    out: Path,
    model: Path | None,
    settings: Mapping[str, float],
    domain: int,
    conditions: Mapping[str, Any] = MappingProxyType({}),
    *,
    progress: Progress,
) -> None:
    """`lce run`, in real time on the simulated bench of a ROS domain."""
    os.environ["ROS_DOMAIN_ID"] = str(domain)
    recording.record(protocol, out, recording.Options(model, settings, conditions=conditions), progress)


def run_hardware(
    protocol: str, out: Path, domain: int, conditions: Mapping[str, Any] = MappingProxyType({}), *, progress: Progress
) -> None:
    """The same on the real bench."""
    os.environ["ROS_DOMAIN_ID"] = str(domain)
    recording.record(protocol, out, recording.Options(plant="hardware", conditions=conditions), progress)


def record_topics(
    out: Path, domain: int, conditions: Mapping[str, Any], topics: Sequence[str], *, progress: Progress
) -> None:
    """Record what others run in a ROS domain, until the job is interrupted."""
    os.environ["ROS_DOMAIN_ID"] = str(domain)
    recording_topics.record_topics(out, conditions, topics, progress)
