# SPDX-License-Identifier: Apache-2.0
import signal
import socket
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest
import yaml
from labjack_emulator import LabJackEmulator
from rcl_interfaces.msg import Log
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import Temperature
from std_msgs.msg import Bool, Float64
from std_srvs.srv import SetBool, Trigger

from lce_drivers.camera.thermal_camera_node import ThermalCamera
from lce_drivers.distance.distance_sensor_node import DistanceSensor
from lce_drivers.laser.labjack import Calibration, LabJackLaser
from lce_drivers.laser.laser_node import Laser
from lce_drivers.laser.modbus import ModbusRegisters
from lce_ros.conversions import to_stamp
from lce_ros.node import LceNode, NodeFault
from lce_ros.testing import Graph

pytestmark = pytest.mark.alone

CALIBRATION = Calibration(volts_per_watt=2.0, threshold_v=0.5, max_v=4.5)


@pytest.fixture
def device() -> Iterator[LabJackEmulator]:
    emulator = LabJackEmulator()
    yield emulator
    emulator.close()


def on(device: LabJackEmulator, **others: Any) -> dict[str, Any]:
    """Parameters of the laser node on the device, without a camera."""
    own = {"host": "127.0.0.1", "port": device.port, "volts_per_watt": 2.0, "timeout_s": 0.5, **others}
    return {
        "device": "labjack", "temperature_required": False, "max_tick_gap_s": 0.5, "command_fault_s": 2.0,
        **{f"labjack.{key}": value for key, value in own.items()},
    }  # fmt: skip


def arm(graph: Graph, probe: LceNode) -> SetBool.Response:
    return graph.call(probe, SetBool, "laser/arm", data=True)


def connect(device: LabJackEmulator) -> LabJackLaser:
    return LabJackLaser(ModbusRegisters("127.0.0.1", device.port, 0.5), CALIBRATION, watchdog_s=2)


def test_voltage_is_zero_for_no_power_and_linear_above_the_threshold() -> None:
    assert [CALIBRATION.voltage(p) for p in (0.0, 0.5, 2.0)] == [0.0, 1.5, 4.5]
    assert CALIBRATION.max_power_w == 2.0


@pytest.mark.parametrize("power", [2.001, -0.1, float("nan"), float("inf")])
def test_a_power_that_the_output_cannot_give_is_refused_not_clipped(power: float) -> None:
    with pytest.raises(ValueError, match=r"outside \[0, 2\] W"):
        CALIBRATION.voltage(power)


@pytest.mark.parametrize("arguments", [(0.0, 0.0, 5.0), (float("nan"), 0.0, 5.0), (1.0, 5.0, 5.0), (1.0, 0.0, 11.0)])
def test_a_calibration_that_is_none_is_refused(arguments: tuple[float, float, float]) -> None:
    with pytest.raises(ValueError, match=r"labjack\."):
        Calibration(*arguments)


def test_the_watchdog_is_armed_before_there_is_any_power(device: LabJackEmulator) -> None:
    laser = connect(device)
    r = device.registers
    assert device.dac0_v == 0.0
    assert (r[61600], r[61604], r[61610], r[61620], r[61640], r[61642]) == (1, 2, 1, 0, 1, 0)
    assert (r[61602], r[61606]) == (0, 2), "nothing else happens, and the same after a power failure"
    assert r[61612] != 0
    assert device.flash_writes[0] == (61600, 0) and device.flash_writes[-1] == (61600, 1)
    laser.write(1.0)
    assert device.dac0_v == 2.5
    laser.close()
    assert device.dac0_v == 0.0
    assert device.wrong_keys == 0


def test_flash_memory_is_written_once_not_at_every_start(device: LabJackEmulator) -> None:
    connect(device).close()
    writes = len(device.flash_writes)
    connect(device).close()
    assert len(device.flash_writes) == writes


def test_the_outputs_come_up_at_zero_volts(device: LabJackEmulator) -> None:
    device.registers[49000] = 0
    connect(device).close()
    assert device.registers[49000] == 1 and (49004, 1) in device.flash_writes
    device.stuck[49000] = 0
    with pytest.raises(OSError, match="49004: the outputs of the LabJack may come up lit"):
        connect(device)


def test_an_answer_to_something_else_is_no_answer(device: LabJackEmulator) -> None:
    laser = connect(device)
    device.echo = 1002
    with pytest.raises(OSError, match="register 1000 cannot be written"):
        laser.write(1.0)
    device.echo = None
    laser.close()
    assert device.dac0_v == 0.0


def test_without_writes_the_device_itself_goes_to_zero(device: LabJackEmulator) -> None:
    laser = connect(device)
    laser.write(1.0)
    device.time_s = 1.99
    assert device.dac0_v == 2.5
    laser.write(1.0)
    device.time_s = 3.98
    assert device.dac0_v == 2.5
    device.time_s = 4.0
    assert device.dac0_v == 0.0
    laser.close()


def test_something_else_at_the_address_is_recognised() -> None:
    emulator = LabJackEmulator(product=4.0)
    with pytest.raises(OSError, match="product 4 is not"):
        connect(emulator)
    emulator.registers[55100] = 0x22330011
    with pytest.raises(OSError, match="55100 reads 0x22330011"):
        connect(emulator)
    emulator.close()


def test_nobody_at_the_address_is_an_error_with_the_address() -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with pytest.raises(OSError, match=f"127.0.0.1:{port} does not answer"):
        ModbusRegisters("127.0.0.1", port, 0.1)


class Bench:
    """The laser node as a process on the device, and its commander: one watt, its light on."""

    def __init__(self, graph: Graph, device: LabJackEmulator, **others: Any) -> None:
        self.graph, self.device = graph, device
        self.process = graph.start("lce_drivers.laser.laser_node", **on(device, **others))
        self.probe = graph.probe()
        self.power = graph.collect(Float64, "laser/power", self.probe)
        self.armed = graph.collect(Bool, "laser/armed", self.probe)
        self._commands = self.probe.advertise(Float64, "laser/power_command")
        self.command_w = 0.0
        self.probe.every(0.01, lambda: self._commands.publish(Float64(data=self.command_w)))
        graph.until(lambda: self.power.messages, 20.0, "the laser")
        self.light()

    def light(self) -> None:
        """Command zero, arm, command a watt."""
        self.command_w = 0.0
        self.graph.until(lambda: arm(self.graph, self.probe).success, what="an armed laser")
        self.command_w = 1.0
        self.graph.until(lambda: self.device.dac0_v == 2.0, 20.0, "light")

    def lines(self) -> list[str]:
        """What the process said on stderr, once it has ended."""
        self.graph.until(lambda: self.process.poll() is not None, 20.0, "the end of the node")
        assert self.process.stderr is not None
        return self.process.stderr.read().splitlines()


def test_the_node_drives_the_device_and_leaves_it_dark(graph: Graph, device: LabJackEmulator) -> None:
    process = Bench(graph, device).process
    process.terminate()
    process.wait(timeout=20)
    assert device.dac0_v == 0.0
    assert process.returncode == 0


def test_a_laser_that_another_process_has_is_refused_before_its_device_is_touched(
    graph: Graph, device: LabJackEmulator
) -> None:
    def taken(_: Laser) -> None:
        raise NodeFault("another process has it")

    before = dict(device.registers)
    with pytest.raises(NodeFault, match="another process has it"):
        graph.add(partial(Laser, taken), **on(device))
    assert device.registers == before


def test_a_real_laser_starts_disarmed_and_lights_up_for_nobody_who_has_not_armed_it(
    graph: Graph, device: LabJackEmulator
) -> None:
    graph.add(Laser, **on(device))
    probe = graph.probe()
    commands, power = probe.advertise(Float64, "laser/power_command"), graph.collect(Float64, "laser/power", probe)
    armed = graph.collect(Bool, "laser/armed", probe)
    command_w = [1.0]
    probe.every(0.01, lambda: commands.publish(Float64(data=command_w[0])))
    graph.until(lambda: len(power) > 50)
    assert device.dac0_v == 0.0 and not any(power.data)
    answer = arm(graph, probe)
    assert not answer.success and "1 W are commanded" in answer.message
    command_w[0] = 0.0
    graph.until(lambda: arm(graph, probe).success)
    command_w[0] = 1.0
    graph.until(lambda: device.dac0_v == 2.0, what="light")
    assert graph.call(probe, SetBool, "laser/arm", data=False).success
    graph.until(lambda: device.dac0_v == 0.0, 3.0, "darkness")
    graph.until(lambda: armed.data[-2:] == [True, False], what="the state on laser/armed")


def test_a_real_laser_cannot_be_configured_to_arm_itself(graph: Graph, device: LabJackEmulator) -> None:
    with pytest.raises(ValueError, match="arm_at_start"):
        graph.add(Laser, **on(device), arm_at_start=True)


def test_after_kill_9_the_watchdog_makes_it_dark(graph: Graph, device: LabJackEmulator) -> None:
    graph.kill(Bench(graph, device).process)
    device.time_s = 1.99
    assert device.dac0_v == 2.0
    device.time_s = 2.01
    assert device.dac0_v == 0.0


def test_a_stopped_node_that_continues_leaves_dark_what_the_watchdog_made_dark(
    graph: Graph, device: LabJackEmulator
) -> None:
    bench = Bench(graph, device)
    bench.process.send_signal(signal.SIGSTOP)
    graph.spin_for(0.7)
    device.time_s = 3.0
    assert device.dac0_v == 0.0, "the watchdog"
    bench.process.send_signal(signal.SIGCONT)
    bench.power.messages.clear()
    graph.until(lambda: len(bench.power) > 50, what="a laser that speaks again")
    # What it had written when it was stopped it may still publish.
    assert device.dac0_v == 0.0 and not any(bench.power.data[1:])
    said = graph.call(bench.probe, Trigger, "laser/reset")
    assert said.success and "stood still" in said.message
    graph.spin_for(0.3)
    assert device.dac0_v == 0.0, "a reset alone gives no light"
    bench.light()


@pytest.mark.parametrize(
    ("register", "value", "reason"),
    [(1000, 0, "DAC0 is 0 V, not 2 V as written"), (61600, 0, "the watchdog of the LabJack is off")],
)
def test_a_device_that_is_not_as_it_was_left_is_a_fault(
    graph: Graph, device: LabJackEmulator, register: int, value: int, reason: str
) -> None:
    bench = Bench(graph, device)
    device.stuck[register] = value
    graph.until(lambda: bench.armed.data[-1:] == [False], 5.0, "the fault")
    graph.until(lambda: bench.power.data[-1] == 0.0, 1.0, "darkness")
    answer = graph.call(bench.probe, Trigger, "laser/reset")
    assert answer.success == (register == 1000) and reason in answer.message
    device.stuck.clear()


def test_a_fault_of_the_temperature_is_zero_volts_until_reset_and_arming(graph: Graph, device: LabJackEmulator) -> None:
    graph.add(Laser, **on(device) | {"temperature_required": True})
    probe = graph.probe()
    commands, camera = probe.advertise(Float64, "laser/power_command"), probe.advertise(Temperature, "temperature")
    shown_c, command_w = [40.0], [0.0]

    def show() -> None:
        shown_c[0] += 0.01
        message = Temperature(temperature=shown_c[0])
        message.header.stamp = to_stamp(probe.now_s())
        camera.publish(message)

    probe.every(0.01, lambda: commands.publish(Float64(data=command_w[0])))
    probe.every(0.1, show)
    graph.until(lambda: arm(graph, probe).success)
    command_w[0] = 1.0
    graph.until(lambda: device.dac0_v == 2.0, what="light")
    shown_c[0] = 130.0
    graph.until(lambda: device.dac0_v == 0.0, what="darkness")
    shown_c[0] = 40.0
    graph.spin_for(0.5)
    assert device.dac0_v == 0.0
    assert graph.call(probe, Trigger, "laser/reset").success
    graph.spin_for(0.3)
    assert device.dac0_v == 0.0, "the command still stands"
    command_w[0] = 0.0
    graph.until(lambda: arm(graph, probe).success)
    command_w[0] = 1.0
    graph.until(lambda: device.dac0_v == 2.0, what="light again")


def test_a_device_that_is_lost_ends_the_node_with_one_line(graph: Graph, device: LabJackEmulator) -> None:
    bench = Bench(graph, device)
    del device.registers[1000]
    lines = bench.lines()
    assert bench.process.returncode == 1
    assert "zero power could not be set" in lines[-2] and "register 1000 cannot be written" in lines[-1]


def test_a_connection_that_is_reset_is_dark_at_once_over_a_new_one(graph: Graph, device: LabJackEmulator) -> None:
    bench = Bench(graph, device)
    device.resets = 1
    began_s = time.monotonic()
    graph.until(lambda: device.dac0_v == 0.0, 3.0, "darkness without the watchdog")
    assert time.monotonic() - began_s < 0.5
    lines = bench.lines()
    assert bench.process.returncode == 1
    assert "cannot be written" in lines[-1] and not any("zero power could not be set" in line for line in lines)


def test_a_device_that_answers_no_more_is_told_from_one_that_is_dark(graph: Graph, device: LabJackEmulator) -> None:
    bench = Bench(graph, device, timeout_s=0.3)
    device.mute = True
    lines = bench.lines()
    assert "zero power could not be set" in lines[-2]
    assert device.dac0_v == 0.0, "it heard, and answered not"


def test_a_laser_without_calibration_or_on_simulated_time_does_not_start(graph: Graph) -> None:
    with pytest.raises(ValueError, match=r"volts_per_watt: 0 V/W"):
        graph.add(Laser, device="labjack")
    with pytest.raises(ValueError, match="simulated time"):
        graph.add(Laser, device="labjack", sim_time=True)
    with pytest.raises(NodeFault, match="does not answer"):
        graph.add(
            Laser,
            device="labjack",
            **{"labjack.host": "127.0.0.1", "labjack.port": 1, "labjack.volts_per_watt": 1.0},
        )


def test_the_limit_is_never_above_what_the_device_can_give(graph: Graph, device: LabJackEmulator) -> None:
    graph.add(Laser, max_power_w=2.0, **on(device, volts_per_watt=10.0))
    probe = graph.probe()
    commands = probe.advertise(Float64, "laser/power_command")
    power = graph.collect(Float64, "laser/power", probe)
    graph.until(lambda: arm(graph, probe).success)
    probe.every(0.01, lambda: commands.publish(Float64(data=1.0)))
    graph.until(lambda: power.data and power.data[-1] == 0.5)
    assert device.dac0_v == 5.0


@pytest.mark.filterwarnings("ignore:DynamicImporter:ImportWarning")  # PyGObject's, where Aravis is installed
def test_hardware_yaml_names_parameters_that_exist(graph: Graph, device: LabJackEmulator) -> None:
    """A misspelt name in a parameter file is ignored by ROS; ours is named in the log, and the launch gives a seed."""
    said: list[Log] = []
    logs = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    graph.probe().create_subscription(Log, "/rosout", said.append, logs)
    config = Path(__file__).parents[2] / "lce_bringup" / "config" / "hardware.yaml"
    content = yaml.safe_load(config.read_text(encoding="utf-8"))
    here = {"labjack.host": "127.0.0.1", "labjack.port": device.port, "labjack.volts_per_watt": 1.0}
    for name, factory, own in (
        ("laser", Laser, here),
        ("thermal_camera", ThermalCamera, {"flir.width": 64, "flir.height": 64, "seed": 1}),
        ("distance_sensor", DistanceSensor, {"seed": 1}),
    ):
        given = dict(flat(content[f"/**/{name}"]["ros__parameters"]))
        node = graph.add(factory, **given | own | {"mispelt": 1})
        assert [parameter for parameter in given if not node.has_parameter(parameter)] == []
        node.warn_of_unknown_parameters()
    graph.until(lambda: sum("mispelt" in m.msg for m in said) == 3, what="the warnings of three nodes")
    assert not [m.msg for m in said if "no parameter" in m.msg and "mispelt" not in m.msg]


def flat(tree: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in tree.items():
        if isinstance(value, dict):
            yield from flat(value, f"{prefix}{key}.")
        else:
            yield prefix + key, value
