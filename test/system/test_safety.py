# SPDX-License-Identifier: Apache-2.0
"""kill -9 of any node is zero power within 200 ms: real processes, really killed.

The one suite that measures the wall clock. What it holds is a promise about real time, to somebody in front of a real
laser: the operating system, the middleware and the scheduler are part of it, and simulated time would leave them out.
It therefore runs alone. What the device's own watchdog does after kill -9 of the laser is in test_labjack.py.
"""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from rclpy.qos import QoSProfile
from run_command import started, until
from sensor_msgs.msg import Temperature
from std_msgs.msg import Float64
from std_srvs.srv import SetBool, Trigger

from lce_experiment import registry
from lce_ros.conversions import from_stamp
from lce_ros.testing import Graph, open_graph
from lce_ros.testing.stand_still import StandStill

pytestmark = [pytest.mark.alone, pytest.mark.flaky(reruns=0)]  # no light may come back, not even now and then

LIMIT_S = 0.2
TARGET_M = 1.0e-3
LASER = {"max_tick_gap_s": 0.5}
"""As in config/simulated.yaml: a shared machine stands still now and then."""
SETTINGS = {
    "outer_controller": {"kp": 2000.0, "ki": 500.0},
    "inner_controller": {"kp": 0.5, "ki": 0.05},
    "single_controller": {"kp": 1000.0, "ki": 100.0},
    "laser": LASER,
}
ENDS = [
    *((name, signal.SIGKILL) for name in ("thermal_camera", "distance_sensor", "simulator")),
    *((name, signal.SIGKILL) for name in ("outer_controller", "inner_controller")),
    ("inner_controller", signal.SIGINT),
]
"""The node that ends, and how; a sensor that is stopped is as silent as one that is killed."""
IN_A_RUN = (registry.PLAYER, registry.RECORDER, registry.SENSORS[-1])
"""The node that ends in an open-loop run: the one that commands, and two on which the laser does not depend."""


class Light:
    """The power that the laser publishes, with its times."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.node = graph.probe("watcher")
        self.samples: list[tuple[float, float]] = []
        self.node.create_subscription(Float64, "laser/power", self._keep, QoSProfile(depth=100))
        self.on()

    def _keep(self, message: Float64, info: dict[str, Any]) -> None:
        self.samples.append((info["source_timestamp"] * 1e-9, message.data))

    def on(self) -> None:
        """Wait for half a second of light."""
        assert self.comes_within(120.0), "half a second of light did not come"

    def comes_within(self, patience_s: float) -> bool:
        """Whether there is half a second of light within a time [s]."""
        self.samples.clear()
        until_s = time.monotonic() + patience_s
        while time.monotonic() < until_s:
            self.graph.spin_for(0.05)
            recent = self.samples[-50:]
            if len(recent) == 50 and all(power > 0.0 for _, power in recent):
                return True
        return False

    def after(self, kill: Callable[[], object], *, returned: bool = False) -> float:
        """How long there was light after ``kill`` was called, or after it ``returned`` [s].

        It is dark for half a second then, if the laser still speaks.

        Time in which this whole machine stood still is not counted: a shared one is halted now and then, everybody at
        once, and no software on it can do anything then.
        """
        with StandStill() as machine:
            killed_s = time.time()
            kill()
            if returned:
                killed_s = time.time()
            self.graph.spin_for(0.7)
        lit = [t for t, power in self.samples if power > 0.0]
        light_s = max(lit) - killed_s - machine.stood_s
        assert light_s < 0.5, (
            f"it stays dark ({light_s:.2f} s of light, the machine stood still {machine.stood_s:.2f} s)"
        )
        return light_s


class ControlledStrip:
    """The nodes of a mode of control as processes, chasing a target."""

    def __init__(self, graph: Graph, mode: str) -> None:
        self.graph = graph
        self.specs = {spec.name: spec for spec in (*registry.BENCH, *registry.CONTROLLERS[mode])}
        self.processes: dict[str, subprocess.Popen[str]] = {}
        operator = graph.probe("operator")
        self.reset = operator.create_client(Trigger, "laser/reset")
        self.arm = operator.create_client(SetBool, "laser/arm")
        self.target = operator.advertise(Float64, "target_displacement", latched=True)
        self.target.publish(Float64(data=TARGET_M))
        readings = graph.collect(Temperature, "temperature", operator)
        self.displacements = graph.collect(Float64, "displacement", operator)
        self.mend()
        # Which node is up first is chance: a laser that was commanded before the camera spoke has a fault by now.
        graph.until(lambda: readings.messages, 40.0, "a camera")
        graph.until(self._armed, 30.0, "a laser that is armed")
        self.light = Light(graph)

    def mend(self) -> None:
        """Start what does not run."""
        for name, spec in self.specs.items():
            if name not in self.processes or self.processes[name].poll() is not None:
                self.processes[name] = self.graph.start(spec.module, **SETTINGS.get(name, {}))

    def relight(self) -> None:
        """Start what was killed, clear the fault that it left, arm, and wait for light.

        A controller may find the new sensor later than we do, and be at fault once more: then it is armed again.
        """
        self.mend()
        before = len(self.displacements)
        self.graph.until(lambda: len(self.displacements) > before + 5, 30.0, "a distance sensor")
        for _ in range(5):
            self.graph.until(self._armed, 30.0, "a laser that is armed")
            if self.light.comes_within(8.0):
                return
        self.light.on()

    def _armed(self) -> bool:
        """Whether the laser is armed after a reset; until then the controllers rest at zero and forget their faults."""
        disarm, arm = (SetBool.Request(data=on) for on in (False, True))
        for client, request in ((self.reset, Trigger.Request()), (self.arm, disarm), (self.arm, arm)):
            if not client.service_is_ready():
                return False
            answer = client.call_async(request)
            self.graph.until(answer.done)
            if not answer.result().success:
                return False
        return True


@pytest.mark.parametrize("mode", ["single", "model"])
def test_the_end_of_a_controller_by_itself_is_zero_power(graph: Graph, mode: str) -> None:
    controlled = ControlledStrip(graph, mode)
    assert controlled.light.after(lambda: Graph.kill(controlled.processes[f"{mode}_controller"])) < LIMIT_S


@pytest.fixture(scope="module")
def double() -> Iterator[ControlledStrip]:
    with open_graph() as g:
        yield ControlledStrip(g, "double")


@pytest.mark.parametrize(("name", "number"), ENDS)
def test_the_end_of_a_node_in_the_loop_is_zero_power(
    double: ControlledStrip, name: str, number: signal.Signals
) -> None:
    double.relight()
    process = double.processes[name]
    end = (lambda: Graph.kill(process)) if number is signal.SIGKILL else (lambda: process.send_signal(number))
    lit_s = double.light.after(end)
    assert lit_s < LIMIT_S, f"light for {lit_s * 1e3:.0f} ms after the end of {name}"


def test_a_killed_camera_is_a_fault_that_only_reset_and_arming_clear(double: ControlledStrip) -> None:
    double.relight()
    double.light.after(lambda: Graph.kill(double.processes["thermal_camera"]))
    double.light.samples.clear()
    readings = double.graph.collect(Temperature, "temperature", double.light.node)
    double.mend()
    double.graph.until(lambda: len(readings) >= 5, 20.0, "a camera again")
    assert len(double.light.samples) > 50 and not any(power for _, power in double.light.samples)
    double.relight()


@pytest.mark.parametrize("spec", IN_A_RUN, ids=lambda spec: spec.name)
def test_the_end_of_any_node_of_a_run_is_zero_power(tmp_path: Path, spec: registry.NodeSpec) -> None:
    with started("run", "hold:power=1.0,hold=60,rest=0", "--out", str(tmp_path / "bag")) as run:
        (pid,) = until(lambda: run.processes(spec.module), spec.name)
        graph = Graph(_domain(pid))
        try:
            light = Light(graph)
            lit_s = light.after(lambda: os.kill(pid, signal.SIGKILL))
        finally:
            graph.close()
    assert lit_s < LIMIT_S, f"light for {lit_s * 1e3:.0f} ms after the end of {spec.name}"


def test_kill_9_of_the_laser_is_zero_power_at_the_strip(graph: Graph) -> None:
    laser = graph.start(registry.LASER.module, temperature_required="false", **LASER)
    graph.add(registry.SIMULATOR.load())
    probe = graph.probe()
    commands = probe.advertise(Float64, "laser/power_command")
    probe.every(0.01, lambda: commands.publish(Float64(data=2.0)))
    truth = graph.collect(Temperature, "sim/temperature", probe)
    graph.until(lambda: truth.messages and truth.messages[-1].temperature > 29.0, 20.0, "a warm strip")
    with StandStill() as machine:
        killed_s = probe.now_s()
        graph.kill(laser)
        graph.until(lambda: truth.messages[-1].temperature < truth.messages[-5].temperature, what="cooling")
        graph.spin_for(0.5)
    warmest = max(truth.messages, key=lambda m: m.temperature)
    assert from_stamp(warmest.header.stamp) - killed_s - machine.stood_s < LIMIT_S


STARTER = """
import subprocess, sys
node = subprocess.Popen(sys.argv[1:])
print(node.pid, flush=True)
node.wait()
"""


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_nodes_end_with_the_process_that_started_them(graph: Graph, number: signal.Signals) -> None:
    """As under `ros2 launch` and `ros2 run`, which leave their nodes behind when they are ended so."""
    node = [sys.executable, "-m", registry.LASER.module, "--ros-args", "-r", "__ns:=/lce"]
    starter = subprocess.Popen(
        [sys.executable, "-c", STARTER, *node, "-p", "temperature_required:=false"],
        env=os.environ | {"ROS_DOMAIN_ID": str(graph.domain)},
        stdout=subprocess.PIPE,
        text=True,
    )
    assert starter.stdout is not None
    laser = int(starter.stdout.readline())
    try:
        probe = graph.probe()
        commands = probe.advertise(Float64, "laser/power_command")
        probe.every(0.01, lambda: commands.publish(Float64(data=1.0)))
        light = Light(graph)
        assert light.after(lambda: starter.send_signal(number)) < LIMIT_S
        assert light.samples[-1][1] == 0.0
        until(lambda: not Path(f"/proc/{laser}").exists(), "the end of the node", 5.0)
    finally:
        with suppress(ProcessLookupError):
            os.kill(laser, signal.SIGKILL)
        starter.kill()
        starter.communicate()


SERVER = """
import os, sys
from pathlib import Path
from lce_app.workbench import jobs, tasks

jobs.warm_up()
bench = dict(model=None, settings={}, domain=int(os.environ["ROS_DOMAIN_ID"]))
run = dict(protocol="hold:power=1.0,hold=60,rest=0", out=Path(sys.argv[1]), **bench)
job = jobs.Job("Run", tasks.run, run, gentle=True)
while job.state == "running":
    job.wait(0.1)
    job.poll()
sys.exit(job.error)
"""


def test_kill_9_of_the_server_of_the_page_is_zero_power(graph: Graph, tmp_path: Path) -> None:
    server = subprocess.Popen(
        [sys.executable, "-c", SERVER, str(tmp_path / "bag")], env=os.environ | {"ROS_DOMAIN_ID": str(graph.domain)}
    )

    def end() -> None:
        server.kill()
        server.wait(timeout=1.0)

    try:
        light = Light(graph)
        # The operating system frees its memory first, which takes tens of ms, and tells nobody of its end before.
        assert light.after(end, returned=True) < LIMIT_S
    finally:
        server.kill()
        server.wait()


def test_a_stopped_laser_that_continues_does_not_take_old_commands_for_new(graph: Graph) -> None:
    laser = graph.start(registry.LASER.module, temperature_required="false", **LASER)
    probe = graph.probe()
    commands = probe.advertise(Float64, "laser/power_command")
    timer = probe.every(0.01, lambda: commands.publish(Float64(data=2.0)))
    light = Light(graph)
    laser.send_signal(signal.SIGSTOP)
    graph.spin_for(0.1)  # its queue fills
    timer.cancel()
    graph.spin_for(0.25)  # not long enough for the fault of a laser that stood still
    light.samples.clear()
    laser.send_signal(signal.SIGCONT)
    graph.until(lambda: len(light.samples) > 20, what="a laser that speaks again")
    # What it had computed when it was stopped it may still publish.
    assert not any(power > 0.0 for _, power in light.samples[1:])


def _domain(pid: int) -> int:
    """The ROS domain of a process; while it is being started its environment is still empty."""
    environment = until(lambda: Path(f"/proc/{pid}/environ").read_text(), "the environment of a node")
    return int(dict(entry.split("=", 1) for entry in environment.split("\0") if "=" in entry)["ROS_DOMAIN_ID"])
