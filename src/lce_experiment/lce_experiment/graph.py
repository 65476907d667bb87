# SPDX-License-Identifier: Apache-2.0
"""The nodes of an experiment on the simulated strip and their parameters, the same for both modes."""

from __future__ import annotations

import importlib
import json
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from lce_data import experiment_file as experiment
from lce_data.bag import metadata as bag_metadata
from lce_data.errors import LceError
from lce_experiment.protocols import Wave

NAMESPACE = "/lce"


@dataclass(frozen=True)
class NodeSpec:
    """A node: its name, the module that runs it (`python -m`), and its class there."""

    name: str
    module: str
    factory: str


PLAYER = NodeSpec("experiment_player", "lce_experiment.nodes.experiment_player_node", "ExperimentPlayer")
TARGET_PLAYER = NodeSpec("target_player", "lce_experiment.nodes.target_player_node", "TargetPlayer")
RECORDER = NodeSpec("recorder", "lce_experiment.nodes.recorder_node", "Recorder")
BENCH = (
    NodeSpec("laser", "lce_drivers.laser.laser_node", "Laser"),
    NodeSpec("simulator", "lce_drivers.simulation.simulator_node", "Simulator"),
    NodeSpec("thermal_camera", "lce_drivers.camera.thermal_camera_node", "ThermalCamera"),
    NodeSpec("distance_sensor", "lce_drivers.distance.distance_sensor_node", "DistanceSensor"),
)
FEEDFORWARD = NodeSpec("feedforward", "lce_control.nodes.feedforward_node", "Feedforward")
OUTER = NodeSpec("outer_controller", "lce_control.nodes.outer_controller_node", "OuterController")
INNER = NodeSpec("inner_controller", "lce_control.nodes.inner_controller_node", "InnerController")
SINGLE = NodeSpec("single_controller", "lce_control.nodes.single_controller_node", "SingleController")
MODEL = NodeSpec("model_controller", "lce_control.nodes.model_controller_node", "ModelController")
CONTROLLERS = {"double": (FEEDFORWARD, OUTER, INNER), "single": (FEEDFORWARD, SINGLE), "model": (MODEL,)}
"""Nodes of each mode of control."""
FOLLOWERS = (OUTER, SINGLE, MODEL)
"""Those that listen to targets."""
MODEL_READERS = (FEEDFORWARD, MODEL)
"""Those that have a model file."""


@dataclass(frozen=True)
class Plan:
    """One run: what is played, where it is recorded, on which strip, and the seed of its sensor noise.

    `protocol` says in words what the `player` does for `duration_s` [s], `given` is what it and the `controllers` are
    told: ROS parameters by node name, over those of `files`. `model` None stands for the bench's default strip;
    `settings` are TERM.PARAM of the model, in its units; `measured` are the topics that must be heard before a run in
    real time begins.
    """

    protocol: str
    duration_s: float
    folder: Path
    model: Path | None
    settings: Mapping[str, float]
    seed: int
    fast: bool
    conditions: Mapping[str, float] = field(default_factory=dict)
    measured: tuple[str, ...] = ("laser/power", "temperature", "displacement")
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
        strip: dict[str, Any] = {"set": [f"{key}={value!r}" for key, value in self.settings.items()] or [""]}
        if self.model is not None:
            strip["model_file"] = str(self.model.resolve())
        own = {
            "simulator": strip,
            "recorder": {
                "out": str(self.folder.resolve()),
                "experiment": json.dumps(about),
                "after": [""] if self.fast else list(self.measured),
            },
            self.player.name: {"wait_for_recorder": True, "progress": not self.fast},
            "thermal_camera": {"seed": self.seed},
            "distance_sensor": {"seed": self.seed},
        }
        return {name: {**own.get(name, {}), **self.given.get(name, {})} for name in (*own, *self.given)}

    def ros_arguments(self, parameter_file: Path) -> list[str]:
        """Write `parameter_file` and return the arguments that give it to every node."""
        content: dict[str, Any] = {"/**": {"ros__parameters": {"use_sim_time": self.fast}}}
        for name, values in self.parameters().items():
            content[f"/**/{name}"] = {"ros__parameters": values}
        parameter_file.write_text(bag_metadata.dump(content), encoding="utf-8")
        files = [config_file("bench.yaml"), config_file("simulated.yaml"), *self.files, parameter_file]
        return [
            "--ros-args",
            "-r",
            f"__ns:={NAMESPACE}",
            *(word for f in files for word in ("--params-file", str(f))),
        ]


def laser_limit_w() -> float:
    """The most power that the laser of bench.yaml gives [W]."""
    entries = yaml.safe_load(config_file("bench.yaml").read_text(encoding="utf-8"))
    return float(entries["/**/laser"]["ros__parameters"]["max_power_w"])


def check_power(wave: Wave) -> None:
    """Raise LceError for a waveform that the laser would cut off."""
    limit_w, most_w = laser_limit_w(), float(wave.power_w.max())
    if most_w > limit_w:
        raise LceError(f"{wave.text}: asks for {most_w:g} W; the laser gives {limit_w:g} W (max_power_w in bench.yaml)")


def default_strip() -> Path:
    """The model file of position control: what the controllers know, and the simulated strip."""
    return config_file("models/strip.yaml")


def config_file(name: str) -> Path:
    """A file of lce_bringup's config folder, as installed."""
    from ament_index_python.packages import get_package_share_directory

    return Path(get_package_share_directory("lce_bringup")) / "config" / name


def node_class(spec: NodeSpec) -> Any:
    """The class of a node, whose module is imported only now."""
    return getattr(importlib.import_module(spec.module), spec.factory)


def python(spec: NodeSpec) -> list[str]:
    """Command line that runs a node as a process of its own."""
    return [sys.executable, "-m", spec.module]
