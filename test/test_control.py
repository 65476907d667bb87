# SPDX-License-Identifier: Apache-2.0
"""The controller nodes on the simulated strip, in lockstep: the double loop and the single one."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import Temperature
from std_msgs.msg import Float64

from lce_bringup import graph
from lce_bringup.lockstep import Lockstep
from lce_model import default_model, save_model
from lce_ros.testing import Graph, Heard

TARGET_M = 1.5e-3
STRIP = default_model("lumped", "kinetic").set({"lumped.gain": 73.0})


class Bench:
    """The simulated bench under a mode of control, with an operator who sets targets and listens."""

    def __init__(self, g: Graph, mode: str, folder: Path, **parameters: dict[str, Any]) -> None:
        save_model(STRIP, folder / "strip.yaml")
        given: dict[str, dict[str, Any]] = {
            "simulator": {"model_file": str(folder / "strip.yaml")},
            "feedforward": {"model_file": str(folder / "strip.yaml"), "branch": "actual"},
        }
        for name, content in yaml.safe_load(graph.config_file("control.yaml").read_text()).items():
            given.setdefault(name.removeprefix("/**/"), {}).update(content["ros__parameters"])
        for name, values in parameters.items():
            given.setdefault(name, {}).update(values)
        self.nodes = {
            spec.name: g.add(graph.node_class(spec), sim_time=True, **given.get(spec.name, {}))
            for spec in (*graph.BENCH, *graph.CONTROLLERS[mode])
        }
        self.operator = g.probe("operator", sim_time=True)
        self.targets = self.operator.advertise(Float64, "target_displacement", latched=True)
        topics = {"laser/power": Float64, "sim/displacement": Float64, "temperature_setpoint": Temperature}
        self.heard = {topic: g.hear(kind, topic, self.operator) for topic, kind in topics.items()}
        self.told: Heard = g.hear(DiagnosticArray, "/diagnostics", self.operator)
        self.steps = Lockstep(g.nodes)

    def follow(self, target_m: float, duration_s: float) -> np.ndarray:
        """Set a target; the displacement [m] at 100 Hz from then on."""
        before = len(self.heard["sim/displacement"])
        self.targets.publish(Float64(data=target_m))
        for _ in range(round(duration_s * 100)):
            self.steps.tick()
        return np.array(self.heard["sim/displacement"].data[before:])

    def said(self, name: str) -> list[str]:
        return [s.message for m in self.told.messages for s in m.status if s.name == f"/lce/{name}"]


@contextmanager
def control(g: Graph, mode: str, folder: Path, **parameters: dict[str, Any]) -> Iterator[Bench]:
    b = Bench(g, mode, folder, **parameters)
    try:
        yield b
    finally:
        b.steps.close()


@pytest.mark.parametrize("mode", graph.CONTROLLERS)
def test_a_target_is_reached_and_held(bench: Graph, tmp_path: Path, mode: str) -> None:
    with control(bench, mode, tmp_path) as b:
        d = b.follow(TARGET_M, 60.0)
        power = np.array(b.heard["laser/power"].data)
    assert np.sqrt(np.mean((d[4000:] / TARGET_M - 1.0) ** 2)) < 0.03
    assert power.max() <= 2.0 and power[-1] > 0.0
