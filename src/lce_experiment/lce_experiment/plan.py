# SPDX-License-Identifier: Apache-2.0
"""One run: its nodes, their parameters, its folder and its seed; the same for every runner."""

from __future__ import annotations

import json
import math
import secrets
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Final

from lce_data import experiment_file as experiment
from lce_data.channels import CHANNELS, INPUTS
from lce_data.errors import LceError
from lce_data.progress import Progress
from lce_data.settings import format_settings
from lce_data.yaml_text import dump
from lce_experiment.config import config_file
from lce_experiment.registry import BENCH, NAMESPACE, PLAYER, RECORDER, SENSORS, SIMULATOR, NodeSpec

RUNS: Final = Path("runs")
"""The folder of recordings, in the folder where the command was given."""


@dataclass(frozen=True)
class Plan:
    """One run on the simulated strip.

    Parameters
    ----------
    protocol : text for experiment.yaml: the protocol, or what is controlled.
    duration_s : how long that takes [s].
    folder : of the recording.
    model : model file of the strip; None for the bench's default strip.
    settings : parameters of the strip that differ from the model, TERM.PARAM in its units.
    seed : of the sensor noise.
    fast : whether the run is on simulated time.
    conditions : of the strip's surroundings, for experiment.yaml.
    measured : topics that must have a message before a run in real time begins.
    player : the node that plays the run.
    controllers : the nodes that control the strip, if any.
    files : ROS parameter files over those of the bench.
    given : ROS parameters by node name, over those of the files.
    """

    protocol: str
    duration_s: float
    folder: Path
    model: Path | None
    settings: Mapping[str, float]
    seed: int
    fast: bool
    conditions: Mapping[str, float] = field(default_factory=dict)
    measured: tuple[str, ...] = tuple(channel.topic for channel in CHANNELS if channel not in INPUTS)
    player: NodeSpec = PLAYER
    controllers: tuple[NodeSpec, ...] = ()
    files: tuple[Path, ...] = ()
    given: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    @property
    def nodes(self) -> tuple[NodeSpec, ...]:
        """Every node, in the order in which they are closed: who commands first, the recorder last."""
        return (self.player, *self.controllers, *BENCH, RECORDER)

    def parameters(self) -> dict[str, dict[str, Any]]:
        """ROS parameters by node name, over those of the files."""
        about = experiment.describe(
            self.protocol,
            "fast" if self.fast else "realtime",
            "simulated",
            self.seed,
            self.model,
            self.settings,
            self.conditions,
        )
        strip: dict[str, Any] = {"set": format_settings(self.settings) or [""]}
        if self.model is not None:
            strip["model_file"] = str(self.model.resolve())
        own = {
            SIMULATOR.name: strip,
            RECORDER.name: {
                "out": str(self.folder.resolve()),
                "experiment": json.dumps(experiment.content_of(about)),
                "after": [""] if self.fast else list(self.measured),
            },
            self.player.name: {"wait_for_recorder": True, "progress": not self.fast},
            **{sensor.name: {"seed": self.seed} for sensor in SENSORS},
        }
        return {name: {**own.get(name, {}), **self.given.get(name, {})} for name in (*own, *self.given)}

    def ros_arguments(self, parameter_file: Path) -> list[str]:
        """Write `parameter_file` and return the arguments that give it to every node."""
        content: dict[str, Any] = {"/**": {"ros__parameters": {"use_sim_time": self.fast}}}
        for name, values in self.parameters().items():
            content[f"/**/{name}"] = {"ros__parameters": values}
        parameter_file.write_text(dump(content), encoding="utf-8")
        files = [config_file("bench.yaml"), config_file("simulated.yaml"), *self.files, parameter_file]
        return [
            "--ros-args",
            "-r",
            f"__ns:={NAMESPACE}",
            *(word for f in files for word in ("--params-file", str(f))),
        ]

    def report(self, progress: Progress, played_s: float) -> None:
        """Report whole seconds: ``played_s`` [s] of the run are over."""
        total = round(self.duration_s)
        progress(f"recording {self.folder.name}", min(max(round(played_s), 0), total), total, math.nan)


def seeded(seed: int | None) -> int:
    """``seed``, or a new one if it is None. Raises LceError for a negative one."""
    if seed is not None and seed < 0:
        raise LceError(f"seed {seed}: must be 0 or more")
    return secrets.randbelow(2**31) if seed is None else seed


def new_folder(parent: Path, name: str = "") -> Path:
    """Where a new recording goes if the user names no folder: ``parent``/DATE-TIME_NAME, in UTC."""
    return parent / "_".join(word for word in (f"{datetime.now(UTC):%Y%m%d-%H%M%S}", name) if word)


def folders(out: Path | None, name: str, runs: Sequence[str]) -> list[Path]:
    """Where the runs are recorded: in `out`, or in folders of it if there are several; by default a new one in RUNS.

    Raises LceError for a folder that exists.
    """
    out = out or new_folder(RUNS, name)
    places = [out] if len(runs) == 1 else [out / run for run in runs]
    for place in places:
        if place.exists():
            raise LceError(f"{place}: exists already; a recording is never overwritten")
    return places
