# SPDX-License-Identifier: Apache-2.0
"""A bench whose laser hangs on an emulated LabJack: the light is the voltage of its output, its watchdog included.

Nothing of the product says whether there is light. Nodes are processes; a camera and a commander that misbehave are
publishers of this process.
"""

import math
import os
import signal
import subprocess
import tempfile
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Final

import numpy as np
from labjack_emulator import LabJackEmulator
from rosbags.highlevel import AnyReader, AnyReaderError
from sensor_msgs.msg import Temperature
from std_msgs.msg import Float64
from std_srvs.srv import SetBool, Trigger

from lce_data import experiment_file
from lce_data.errors import LceError
from lce_experiment import registry
from lce_experiment.registry import NodeSpec
from lce_ros.conversions import to_stamp
from lce_ros.testing import Graph
from lce_ros.testing.stand_still import StandStill

WATT: Final = 1.0
NOISE_K: Final = 0.05
SETTINGS: Final[Mapping[str, Mapping[str, Any]]] = {
    "outer_controller": {"kp": 2000.0, "ki": 500.0},
    "inner_controller": {"kp": 0.5, "ki": 0.05},
}
"""Gains with which the controllers follow a target."""


class Light:
    """When there was light last, looked at each millisecond by a thread."""

    def __init__(self, device: LabJackEmulator) -> None:
        self._device = device
        self._stop = threading.Event()
        self.lit_s = -math.inf
        self.dark_s = -math.inf
        threading.Thread(target=self._watch, daemon=True).start()

    def _watch(self) -> None:
        while not self._stop.wait(0.001):
            if self._device.dac0_v > 0.0:
                self.lit_s = time.monotonic()
            else:
                self.dark_s = time.monotonic()

    def close(self) -> None:
        """Look no more."""
        self._stop.set()


class Bench:
    """The laser on its device, and what drives it.

    Parameters
    ----------
    graph : of this process.
    nodes : that run beside the laser, as processes.
    by_hand : a camera and a commander of this process take their part.

    Attributes
    ----------
    show : what the camera of this process publishes at each of its ticks, 10 times a second; None: nothing.
    command : the same of the commander, 100 times a second.
    """

    def __init__(self, graph: Graph, nodes: tuple[NodeSpec, ...], by_hand: bool) -> None:
        self.graph = graph
        self.device = LabJackEmulator(clock=time.monotonic)
        self.light = Light(self.device)
        self._open = ExitStack()
        self.machine = self._open.enter_context(StandStill())
        self.folder = Path(tempfile.mkdtemp(prefix="lce-faults-"))
        self.bag = self.folder / "bag"
        self.specs = {spec.name: spec for spec in (registry.LASER, registry.RECORDER, *nodes)}
        self.processes: dict[str, subprocess.Popen[bytes]] = {}
        self.node = graph.probe("hand")
        self.reset = self.node.create_client(Trigger, "laser/reset")
        self.arm = self.node.create_client(SetBool, "laser/arm")
        self.target = self.node.advertise(Float64, "target_displacement", latched=True)
        self.target.publish(Float64(data=1.0e-3))
        self.displacements = graph.collect(Float64, "displacement", self.node)
        self.rng = np.random.default_rng(1)
        self.command_w = 0.0
        self.show: Callable[[], None] | None = self.measured
        self.command: Callable[[], None] | None = self.commanded
        if by_hand:
            self.camera = self.node.advertise(Temperature, "temperature")
            self.commander = self.node.advertise(Float64, "laser/power_command")
            self.node.every(0.1, lambda: self.show and self.show())
            self.node.every(0.01, lambda: self.command and self.command())
        self.mend()

    def mend(self) -> bool:
        """Start what does not run, and let the camera and the commander be as they should; whether a node started."""
        self.show, self.command = self.measured, self.commanded
        self.device.mute, self.device.resets, self.device.echo = False, 0, None
        self.device.stuck.clear()
        ended = [n for n in self.specs if n not in self.processes or self.processes[n].poll() is not None]
        for name in ended:
            self.processes[name] = self._start(self.specs[name])
        return bool(ended)

    def lit(self) -> None:
        """Reset, arm, and wait until there was light for half a second without a pause.

        A controller may find a new sensor later than we do, and be at fault once more: then all is armed again.
        """
        if "distance_sensor" in self.specs:
            before = len(self.displacements)
            self.graph.until(lambda: self._runs() and len(self.displacements) > before + 5, 40.0, "a distance sensor")
        for _ in range(5):
            self.command_w = 0.0
            self.graph.until(self._armed, 40.0, "an armed laser")
            self.command_w = WATT
            until_s = time.monotonic() + 8.0
            while time.monotonic() < until_s:
                self.graph.spin_for(0.02)
                if self.light.lit_s - self.light.dark_s > 0.5:
                    return
        raise AssertionError("no light in spite of arming")

    def signal(self, name: str, number: signal.Signals) -> None:
        """Send a signal to a node."""
        self.processes[name].send_signal(number)

    def measured(self, celsius: float | None = None, ahead_s: float = 0.0) -> None:
        """Publish a temperature [°C]: some 40 °C with noise, or the one given, stamped so far ahead."""
        value = 40.0 + NOISE_K * float(self.rng.standard_normal()) if celsius is None else celsius
        message = Temperature(temperature=value)
        message.header.stamp = to_stamp(self.node.now_s() + ahead_s)
        self.camera.publish(message)

    def commanded(self, power_w: float | None = None) -> None:
        """Publish a command [W]: the present one, or the one given."""
        self.commander.publish(Float64(data=self.command_w if power_w is None else power_w))

    def tracebacks(self) -> int:
        """How many exceptions the nodes have told on stderr."""
        return sum(path.read_text(errors="replace").count("Traceback") for path in self.folder.glob("*.err"))

    def lost(self) -> int:
        """Messages that the recording lacks, once everything has ended. Raises LceError if it is not whole."""
        about = experiment_file.beside(self.bag)
        try:
            with AnyReader([self.bag]) as reader:
                read = sum(1 for _ in reader.messages())
        except AnyReaderError as error:
            raise LceError(f"{self.bag}: {error}") from error
        if about.ended is None or read != sum((about.messages or {}).values()):
            raise LceError(f"{self.bag}: not finished")
        return sum((about.lost or {}).values())

    def close(self) -> None:
        """End everything."""
        for process in self.processes.values():
            process.send_signal(signal.SIGCONT)
            process.terminate()
        for process in self.processes.values():
            try:
                process.wait(timeout=5)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self.light.close()
        self._open.close()
        self.device.close()

    def _runs(self) -> bool:
        """Whether the laser runs; started again if not: this process, its LabJack, may have kept it waiting."""
        ended = self.processes[registry.LASER.name].poll() is not None
        if ended:
            self.mend()
        return not ended

    def _armed(self) -> bool:
        if not self._runs():
            return False
        requests = (
            (self.reset, Trigger.Request()),
            (self.arm, SetBool.Request(data=False)),
            (self.arm, SetBool.Request(data=True)),
        )
        for client, request in requests:
            if not client.service_is_ready():
                return False
            answer = client.call_async(request)
            try:
                self.graph.until(answer.done, 1.0)
            except AssertionError:  # a laser that has just ended answers nobody
                client.remove_pending_request(answer)
                return False
            if not answer.result().success:
                return False
        return True

    def _start(self, spec: NodeSpec) -> "subprocess.Popen[bytes]":
        parameters = dict(SETTINGS.get(spec.name, {}))
        if spec is registry.LASER:
            parameters |= {
                "device": "labjack",
                "labjack.host": "127.0.0.1",
                "labjack.port": self.device.port,
                "labjack.volts_per_watt": 2.0,
            }
        if spec is registry.RECORDER:
            parameters["out"] = str(self.bag)
        options = [word for name, value in parameters.items() for word in ("-p", f"{name}:={value}")]
        with (self.folder / f"{spec.name}.err").open("ab") as errors:
            return subprocess.Popen(
                [*spec.command, "--ros-args", "-r", f"__ns:={registry.NAMESPACE}", *options],
                env=os.environ | {"ROS_DOMAIN_ID": str(self.graph.domain)},
                stdout=subprocess.DEVNULL,
                stderr=errors,
            )
