# SPDX-License-Identifier: Apache-2.0
"""Run experiments on the node graph and record them."""

from __future__ import annotations

import json
import os
import re
import subprocess
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, Literal, get_args

from lce_app.errors import ContradictoryOptions, OptionError, check_seed
from lce_data import experiment_file
from lce_data.errors import LceError
from lce_data.given_conditions import check_conditions
from lce_data.progress import CancelToken, Progress, silent, watched
from lce_experiment import protocols, recording
from lce_experiment.config import check_power
from lce_experiment.plan import Plan, folders, seeded
from lce_experiment.registry import LASER, NAMESPACE, PLAYER, arm_call
from lce_experiment.runners.processes import Processes
from lce_experiment.strip import conditions, measured_topics, simulated_strip
from lce_ros.domain import domain_of, only_laser

Plant = Literal["simulated", "hardware"]
LAUNCH: Final = ("ros2", "launch", "lce_bringup", "experiment.launch.py", "plant:=hardware")
POLL_S: Final = 0.1
"""Time between two looks whether a launch has ended [s]."""
ARM_S: Final = 10.0
"""Longest wait for the answer of laser/arm [s]."""


@dataclass(frozen=True)
class Options:
    """The bench, and how its time passes.

    Parameters
    ----------
    model : model file of the strip; None for the built-in one.
    settings : parameters of the strip by TERM.PARAM, in the units of the model; one of an effect adds the effect.
    seed : of the sensor noise, 0 or more; None for a new one. The runs of a campaign take seed, seed + 1, …
    fast : simulated time, as quickly as the machine can, instead of real time.
    plant : "simulated", or "hardware": the real laser and the real strip, to which the options above do not apply.
    conditions : what experiment.yaml and the metadata of the bag say of the run: ``specimen``, ``day``, ``notes``,
        ``strip_length_m``, ``ambient_c``, ``load_n``, and anything else by a key of its own. They are notes: nothing on
        the simulated bench changes by them.
    """

    model: Path | None = None
    settings: Mapping[str, float] = field(default_factory=dict)
    seed: int | None = None
    fast: bool = False
    plant: Plant = "simulated"
    conditions: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.plant not in get_args(Plant):
            raise OptionError("plant", f"{self.plant!r} is not one of {', '.join(get_args(Plant))}")
        check_seed(self.seed)
        if self.plant == "hardware" and (self.model or self.settings or self.seed is not None or self.fast):
            raise ContradictoryOptions(
                "plant", "hardware excludes model, settings, seed and fast: they are of a strip that is simulated"
            )


@dataclass(frozen=True)
class Recorded:
    """The bag folders that were written, in the order of the protocol."""

    folders: tuple[Path, ...]


DEFAULTS = Options()


def record(
    protocol: str,
    out: Path | None = None,
    options: Options = DEFAULTS,
    progress: Progress = silent,
    cancel: CancelToken | None = None,
    finished: Callable[[Path], object] = lambda folder: None,
) -> Recorded:
    """Run a protocol, or each of a campaign, on the bench and record it.

    Everything that can be wrong with the request is found before anything is started or written.

    Parameters
    ----------
    protocol : a name with options, as ``pulse:amp=0.4,th=20``, a campaign, or a CSV file of a waveform.
    out : new folder of the recording; of a campaign the folder of them; None for ``runs/TIME_NAME``.
    options : the plant, a simulated strip and its seed, and real or simulated time.
    progress : called after each second played; its error is NaN.
    cancel : ends the run as Ctrl-C does: the laser goes to zero, and what was recorded until then is kept.
    finished : called with each folder when its recording is complete.

    Returns
    -------
    Recorded
        The recordings.

    Raises
    ------
    LceError
        If the protocol, the strip or the folder cannot be used, or a node fails.

    Examples
    --------
    >>> from pathlib import Path
    >>> record("pulse:amp=0.4,th=20", Path("runs/pulse"), Options(fast=True))  # doctest: +SKIP
    """
    progress = watched(progress, cancel)
    plans = plan_recordings(protocol, out, options)
    for plan in plans:
        if options.plant == "hardware":
            _launch(plan, progress)
        else:
            recording.record(plan, progress)
        finished(plan.folder)
    return Recorded(tuple(plan.folder for plan in plans))


def plan_recordings(protocol: str, out: Path | None, options: Options) -> tuple[Plan, ...]:
    """The runs of a protocol. Raises LceError for everything that can be wrong with them."""
    waves, given = protocols.load(protocol), check_conditions(options.conditions)
    for wave in waves:
        check_power(wave)
    strip = simulated_strip(options.model, options.settings)
    seed = seeded(options.seed)
    name = protocol if len(waves) > 1 else waves[0].name
    places = folders(out, name, [wave.name for wave in waves])
    return tuple(
        Plan(
            protocol=wave.text,
            duration_s=wave.duration_s,
            folder=folder,
            model=options.model,
            settings=options.settings,
            seed=seed + k,
            fast=options.fast,
            conditions=given if options.plant == "hardware" else conditions(strip) | given,
            measured=measured_topics(strip),
            given={PLAYER.name: {"protocol": wave.text}},
        )
        for k, (wave, folder) in enumerate(zip(waves, places, strict=True))
    )


def arm_laser(domain: int) -> None:
    """Arm the laser of the real bench in a ROS domain. Raises LceError with the reason if it refuses."""
    try:
        call = subprocess.run(
            arm_call(),
            env=os.environ | {"ROS_DOMAIN_ID": str(domain)},
            capture_output=True,
            text=True,
            timeout=ARM_S,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise LceError(f"the laser is not armed: {error}") from None
    if "success=True" not in call.stdout:
        lines = (call.stdout + call.stderr).strip().splitlines()
        raise LceError(f"the laser is not armed: {lines[-1] if lines else 'no answer'}")


def _launch(plan: Plan, progress: Progress) -> None:
    """Run a plan on the real bench, in the ROS domain of the environment, by a launch file that ends with the run.

    Raises LceError if that domain has a laser already, the launch fails, or its recording is not of a complete run.
    """
    with only_laser(domain_of(os.environ.get("ROS_DOMAIN_ID") or "0"), f"{NAMESPACE}/{LASER.name}"):
        pass  # there is none so far; the launch brings its own
    began = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="lce_run_") as logs, Processes(Path(logs)) as nodes:
        stated = f"conditions:={json.dumps(dict(plan.conditions))}"
        launch = nodes.start("launch", [*LAUNCH, f"protocol:={plan.protocol}", f"out:={plan.folder}", stated])
        while launch.poll() is None:
            plan.report(progress, time.monotonic() - began)
            time.sleep(POLL_S)
        if launch.returncode != 0:
            raise LceError(failure(nodes.log("launch")))
    outcome = experiment_file.read(plan.folder / experiment_file.FILE_NAME).outcome
    if outcome != "complete":
        raise LceError(f"{plan.folder}: the run is {outcome or 'not finished'}")


def failure(log: str) -> str:
    """Why a launch failed, by what it printed: the last line of the node that failed first, or else its own."""
    lines = [line.strip() for line in log.splitlines() if line.strip()]
    found = re.search(r"([\w-]+) ended with status -?\d+$", log, re.MULTILINE)
    if found is None:
        return f"the launch failed: {lines[-1] if lines else 'no word of it'}"
    of_node = [line.removeprefix(f"[{found[1]}] ") for line in lines if line.startswith(f"[{found[1]}] ")]
    return f"{found[0]}: {of_node[-1]}" if of_node else found[0]
