# SPDX-License-Identifier: Apache-2.0
"""Laser and sensors as managed nodes: what each state does, and that every way out of light is dark."""

import signal
from collections.abc import Iterator
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from keyence_emulator import Controller
from labjack_emulator import LabJackEmulator
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from rcl_interfaces.msg import Log
from std_msgs.msg import Bool, Float64
from std_srvs.srv import SetBool, Trigger

from lce_drivers import background
from lce_drivers.camera.thermal_camera_node import ThermalCamera
from lce_drivers.distance.distance_sensor_node import DistanceSensor
from lce_drivers.laser.laser_node import Laser
from lce_ros.testing import Graph

pytestmark = pytest.mark.alone

CONFIGURE, CLEANUP, ACTIVATE, DEACTIVATE, SHUTDOWN = (
    Transition.TRANSITION_CONFIGURE,
    Transition.TRANSITION_CLEANUP,
    Transition.TRANSITION_ACTIVATE,
    Transition.TRANSITION_DEACTIVATE,
    Transition.TRANSITION_ACTIVE_SHUTDOWN,
)
ALONE = {"temperature_required": False, "max_tick_gap_s": 0.5, "command_fault_s": 2.0}
"""No camera, and a machine that others load: it stands still now and then."""


@pytest.fixture
def device() -> Iterator[LabJackEmulator]:
    emulator = LabJackEmulator()
    yield emulator
    emulator.close()


def real(device: LabJackEmulator) -> dict[str, Any]:
    """Parameters of a laser on the device that waits to be configured."""
    own = {"host": "127.0.0.1", "port": device.port, "volts_per_watt": 2.0, "timeout_s": 0.5}
    return {"device": "labjack", "autostart": False, **ALONE, **{f"labjack.{key}": v for key, v in own.items()}}


class Operator:
    """Commands a laser at 100 Hz, arms it, and takes it through its states."""

    def __init__(self, graph: Graph, managed: str = "laser") -> None:
        self.graph, self.managed = graph, managed
        self.probe = graph.probe("operator")
        self.power = graph.collect(Float64, "laser/power", self.probe)
        self.armed = graph.collect(Bool, "laser/armed", self.probe)
        self.diagnostics = graph.collect(DiagnosticArray, "/diagnostics", self.probe)
        self._commands = self.probe.advertise(Float64, "laser/power_command")
        self.command_w = 0.0
        self.probe.every(0.01, lambda: self._commands.publish(Float64(data=self.command_w)))

    def change(self, transition: int) -> bool:
        request = Transition(id=transition)
        return bool(
            self.graph.call(self.probe, ChangeState, f"{self.managed}/change_state", transition=request).success
        )

    def state(self) -> str:
        return str(self.graph.call(self.probe, GetState, f"{self.managed}/get_state").current_state.label)

    def arm(self) -> SetBool.Response:
        return self.graph.call(self.probe, SetBool, "laser/arm", data=True)

    def light(self, power_w: float) -> None:
        self.command_w = 0.0
        self.graph.until(lambda: self.arm().success, what="an armed laser")
        self.command_w = power_w
        self.graph.until(lambda: self.power.data[-1:] == [power_w], what="light")

    def silent_for(self, duration_s: float) -> bool:
        """Whether nothing comes on laser/power any more."""
        self.graph.spin_for(0.1)
        before = len(self.power)
        self.graph.spin_for(duration_s)
        return len(self.power) == before

    def said(self) -> list[str]:
        own = [s for m in self.diagnostics.messages for s in m.status if s.name.startswith(f"/lce/{self.managed}: ")]
        return [s.message for s in own]


@pytest.mark.parametrize("number", [CONFIGURE, 200])
def test_a_transition_that_the_state_does_not_have_is_refused(
    graph: Graph, device: LabJackEmulator, number: int
) -> None:
    operator = Operator(graph)
    graph.add(Laser, **real(device))
    assert operator.change(CONFIGURE)
    assert not operator.change(number) and operator.state() == "inactive"
    assert operator.change(ACTIVATE)


def test_a_laser_opens_its_device_when_configured_and_lights_when_active_and_armed(
    graph: Graph, device: LabJackEmulator
) -> None:
    operator = Operator(graph)
    graph.add(Laser, **real(device))
    assert operator.state() == "unconfigured" and device.registers[61600] == 0, "the device is untouched"
    assert "not active" in operator.arm().message
    assert operator.change(CONFIGURE)
    assert operator.state() == "inactive" and device.registers[61600] == 1, "its watchdog is set"
    operator.command_w = 1.0
    assert "not active" in operator.arm().message
    assert operator.silent_for(0.3) and device.dac0_v == 0.0
    assert operator.change(ACTIVATE)
    graph.until(lambda: len(operator.power) > 10, what="ten messages of the power")
    assert device.dac0_v == 0.0 and not any(operator.power.data), "a real laser is armed by a person"
    operator.light(1.0)
    assert device.dac0_v == 2.0


@pytest.mark.parametrize("transition", [DEACTIVATE, SHUTDOWN])
def test_a_laser_that_leaves_its_active_state_is_dark_and_disarmed(
    graph: Graph, device: LabJackEmulator, transition: int
) -> None:
    operator = Operator(graph)
    graph.add(Laser, **real(device))
    assert operator.change(CONFIGURE) and operator.change(ACTIVATE)
    operator.light(1.0)
    assert operator.change(transition)
    assert device.dac0_v == 0.0
    graph.until(lambda: operator.power.data[-1] == 0.0 and operator.armed.data[-1] is False, what="a last zero")
    assert operator.silent_for(0.3) and device.dac0_v == 0.0, "whatever is commanded"
    assert operator.state() == ("inactive" if transition == DEACTIVATE else "finalized")


def test_a_laser_that_is_activated_again_has_to_be_armed_again(graph: Graph, device: LabJackEmulator) -> None:
    operator = Operator(graph)
    graph.add(Laser, **real(device))
    assert operator.change(CONFIGURE) and operator.change(ACTIVATE)
    operator.light(1.0)
    assert operator.change(DEACTIVATE) and operator.change(CLEANUP)
    assert operator.change(CONFIGURE) and operator.change(ACTIVATE)
    before = len(operator.power)
    graph.until(lambda: len(operator.power) > before + 20)
    assert device.dac0_v == 0.0
    operator.light(1.0)
    assert device.dac0_v == 2.0


def test_a_simulated_laser_that_is_activated_again_follows_again(graph: Graph) -> None:
    operator = Operator(graph)
    graph.add(Laser, **ALONE)
    operator.command_w = 0.5
    graph.until(lambda: operator.power.data[-1:] == [0.5])
    assert operator.change(DEACTIVATE)
    assert operator.silent_for(0.2) and operator.power.data[-1] == 0.0
    assert operator.change(ACTIVATE)
    graph.until(lambda: operator.power.data[-1] == 0.5)


def test_a_laser_without_its_device_stays_unconfigured_and_says_why_until_it_is_there(
    graph: Graph, device: LabJackEmulator
) -> None:
    operator = Operator(graph)
    device.registers[55100] = 1  # something else at its address
    graph.add(Laser, **real(device))
    assert not operator.change(CONFIGURE)
    assert operator.state() == "unconfigured"
    graph.until(lambda: any("not a LabJack" in words for words in operator.said()), 3.0, "the reason")
    device.registers[55100] = 0x00112233
    assert operator.change(CONFIGURE)
    assert operator.state() == "inactive"


def test_an_error_of_a_transition_is_dark_and_a_fault(graph: Graph, device: LabJackEmulator) -> None:
    operator = Operator(graph)
    laser = graph.add(Laser, **real(device))
    assert operator.change(CONFIGURE) and operator.change(ACTIVATE)
    operator.light(1.0)

    def fail() -> None:
        raise RuntimeError("burnt")

    laser.rest = fail
    assert not operator.change(DEACTIVATE)
    assert device.dac0_v == 0.0 and operator.state() == "unconfigured"
    graph.until(lambda: operator.armed.data[-1] is False and operator.power.data[-1] == 0.0)
    operator.command_w = 0.0
    assert operator.change(CONFIGURE) and operator.change(ACTIVATE)
    answer = operator.arm()
    assert not answer.success and "burnt" in answer.message
    graph.until(lambda: graph.call(operator.probe, Trigger, "laser/reset").success)
    operator.light(1.0)


def test_a_process_is_dark_however_it_was_driven(graph: Graph, device: LabJackEmulator) -> None:
    operator = Operator(graph)
    process = graph.start("lce_drivers.laser.laser_node", **real(device))
    assert operator.change(CONFIGURE) and operator.change(ACTIVATE)
    operator.light(1.0)
    process.send_signal(signal.SIGTERM)
    graph.until(lambda: process.poll() is not None, 20.0, "the end of the process")
    assert (process.returncode, device.dac0_v, operator.power.data[-1]) == (0, 0.0, 0.0)


def test_a_sensor_publishes_while_it_is_active(graph: Graph) -> None:
    controller = Controller()
    operator = Operator(graph, "distance_sensor")
    received = graph.collect(Float64, "displacement", operator.probe)
    graph.add(DistanceSensor, autostart=False, device="keyence", **{"keyence.port": controller.path})
    graph.spin_for(0.2)
    assert controller.asked == []
    assert operator.change(CONFIGURE)
    assert len(controller.asked) > 0
    graph.spin_for(0.2)
    assert len(received) == 0
    assert operator.change(ACTIVATE)
    graph.until(lambda: len(received) > 5)
    assert operator.change(DEACTIVATE)
    graph.spin_for(0.1)
    count = len(received)
    graph.spin_for(0.2)
    assert len(received) == count
    assert operator.change(CLEANUP)
    asked = len(controller.asked)
    graph.spin_for(0.2)
    assert len(controller.asked) <= asked + 1
    controller.close()


def test_a_sensor_without_its_device_is_not_configured(graph: Graph, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(background, "START_S", 0.2)
    operator = Operator(graph, "distance_sensor")
    graph.add(DistanceSensor, autostart=False, device="keyence", **{"keyence.port": "/dev/no_such_port"})
    assert not operator.change(CONFIGURE)
    assert operator.state() == "unconfigured"
    graph.until(lambda: any("/dev/no_such_port" in words for words in operator.said()), 3.0, "the reason")


def test_a_sensor_that_starts_itself_waits_for_its_device(graph: Graph) -> None:
    operator = Operator(graph, "distance_sensor")
    told = graph.collect(Log, "/rosout", operator.probe)
    graph.add(DistanceSensor, device="keyence", **{"keyence.port": "/dev/no_such_port"})
    assert operator.state() == "active"

    def reasons() -> list[str]:
        return [words for words in operator.said() if "/dev/no_such_port" in words]

    graph.until(lambda: len(reasons()) >= 3, what="the reason in the diagnostics of every second")
    errors = [m for m in told.messages if m.name == "lce.distance_sensor" and "could not open port" in m.msg]
    assert len(errors) == 1, "the log has it once"


def test_a_simulated_camera_is_active_from_its_start(graph: Graph) -> None:
    operator = Operator(graph, "thermal_camera")
    graph.add(ThermalCamera)
    assert operator.state() == "active"
