# SPDX-License-Identifier: Apache-2.0
import socket
import socketserver
import struct
import subprocess
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from sensor_msgs.msg import Temperature
from std_msgs.msg import Float64
from std_srvs.srv import Trigger

from lce_drivers.camera.thermal_camera_node import ThermalCamera
from lce_drivers.distance.distance_sensor_node import DistanceSensor
from lce_drivers.laser.labjack import Calibration, LabJackLaser, ModbusRegisters
from lce_drivers.laser.laser_node import Laser
from lce_ros.conversions import to_stamp
from lce_ros.node import NodeFault
from lce_ros.testing import Graph

pytestmark = pytest.mark.alone

WATCHDOG = range(61600, 61700)


class LabJackEmulator:
    """A LabJack as far as the laser needs one: registers over Modbus TCP and the watchdog.

    Written from the register table with plain sockets, so that nothing of it is the client's own library.
    Listens on 127.0.0.1:``port``; ``dac0_v`` is what the output gives now, watchdog included. The watchdog goes by
    ``time_s``, which the test sets.
    """

    def __init__(self, product: float = 8.0) -> None:
        self.registers = dict.fromkeys([1000, 61600, 61604, 61610, 61612, 61620, 61640, 61642], 0)
        self.registers |= {55100: 0x00112233, 60000: _bits(product), 61604: 60}
        self.flash_writes: list[tuple[int, int]] = []
        self.wrong_keys = 0
        self.time_s = self._fed_s = 0.0
        emulator = self

        class Handler(socketserver.BaseRequestHandler):
            def handle(self) -> None:
                while len(head := _exactly(self.request, 7)) == 7:
                    transaction, _, length, unit = struct.unpack(">HHHB", head)
                    answer = emulator.answer(_exactly(self.request, length - 1))
                    self.request.sendall(struct.pack(">HHHB", transaction, 0, len(answer) + 1, unit) + answer)

        class Server(socketserver.ThreadingTCPServer):
            daemon_threads = True
            allow_reuse_address = True

        self._server = Server(("127.0.0.1", 0), Handler)
        self.port: int = self._server.server_address[1]
        threading.Thread(target=self._server.serve_forever, args=(0.05,), daemon=True).start()

    @property
    def dac0_v(self) -> float:
        r = self.registers
        hungry = self.time_s - self._fed_s > r[61604]
        if r[61600] == 1 and hungry and r[61640] == 1:
            r[1000] = r[61642]
        return float(struct.unpack(">f", r[1000].to_bytes(4, "big"))[0])

    def answer(self, request: bytes) -> bytes:
        function, address, count = struct.unpack(">BHH", request[:5])
        if function == 3 and count == 2 and address in self.registers:
            return struct.pack(">BBI", 3, 4, self.registers[address])
        if function == 16 and count == 2 and (address in self.registers or address == 61614):
            self._set(address, int.from_bytes(request[6:10], "big"))
            return struct.pack(">BHH", 16, address, 2)
        return struct.pack(">BB", function | 0x80, 2)

    def _set(self, address: int, value: int) -> None:
        self.dac0_v  # noqa: B018  the watchdog may have struck before this write
        if address == 61614:
            if value == self.registers[61612]:
                self._fed_s = self.time_s
            else:
                self.wrong_keys += 1
            return
        if address in WATCHDOG:
            self.flash_writes.append((address, value))
        if address == 61600 and value == 1:
            self._fed_s = self.time_s
        self.registers[address] = value

    def close(self) -> None:
        self._server.shutdown()
        self._server.server_close()


def _exactly(connection: object, count: int) -> bytes:
    data = b""
    while len(data) < count and (more := connection.recv(count - len(data))):  # type: ignore[attr-defined]
        data += more
    return data


def _bits(value: float) -> int:
    return int.from_bytes(struct.pack(">f", value), "big")


CALIBRATION = Calibration(volts_per_watt=2.0, threshold_v=0.5, max_v=4.5)


@pytest.fixture
def device() -> Iterator[LabJackEmulator]:
    emulator = LabJackEmulator()
    yield emulator
    emulator.close()


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


def started(graph: Graph, device: LabJackEmulator) -> subprocess.Popen[str]:
    """The laser node as a process, its light on."""
    settings = {"host": "127.0.0.1", "port": device.port, "volts_per_watt": 2.0, "timeout_s": 0.5}
    process = graph.start(
        "lce_drivers.laser.laser_node",
        device="labjack",
        temperature_required="false",
        **{f"labjack.{k}": v for k, v in settings.items()},
    )
    probe = graph.probe()
    commands = probe.advertise(Float64, "laser/power_command")
    probe.every(0.01, lambda: commands.publish(Float64(data=1.0)))
    graph.until(lambda: device.dac0_v == 2.0, 20.0, "light")
    return process


def test_the_node_drives_the_device_and_leaves_it_dark(graph: Graph, device: LabJackEmulator) -> None:
    process = started(graph, device)
    process.terminate()
    process.wait(timeout=20)
    assert device.dac0_v == 0.0
    assert process.returncode == 0


def test_after_kill_9_the_watchdog_makes_it_dark(graph: Graph, device: LabJackEmulator) -> None:
    process = started(graph, device)
    graph.kill(process)
    device.time_s = 1.99
    assert device.dac0_v == 2.0
    device.time_s = 2.01
    assert device.dac0_v == 0.0


def test_a_fault_of_the_temperature_is_zero_volts_until_the_reset(graph: Graph, device: LabJackEmulator) -> None:
    settings = {"host": "127.0.0.1", "port": device.port, "volts_per_watt": 2.0, "timeout_s": 0.5}
    graph.add(Laser, device="labjack", **{f"labjack.{k}": v for k, v in settings.items()})
    probe = graph.probe()
    commands, camera = probe.advertise(Float64, "laser/power_command"), probe.advertise(Temperature, "temperature")
    shown_c = [40.0]

    def show() -> None:
        message = Temperature(temperature=shown_c[0])
        message.header.stamp = to_stamp(probe.now_s())
        camera.publish(message)

    probe.every(0.01, lambda: commands.publish(Float64(data=1.0)))
    probe.every(0.1, show)
    graph.until(lambda: device.dac0_v == 2.0, what="light")
    shown_c[0] = 130.0
    graph.until(lambda: device.dac0_v == 0.0, what="darkness")
    shown_c[0] = 40.0
    graph.spin_for(0.5)
    assert device.dac0_v == 0.0
    reset = probe.create_client(Trigger, "laser/reset")
    graph.until(reset.service_is_ready)
    answer = reset.call_async(Trigger.Request())
    graph.until(answer.done)
    assert answer.result().success
    graph.until(lambda: device.dac0_v == 2.0, what="light again")


def test_a_device_that_is_lost_ends_the_node_with_one_line(graph: Graph, device: LabJackEmulator) -> None:
    process = started(graph, device)
    del device.registers[1000]
    graph.until(lambda: process.poll() is not None, 20.0, "the end of the node")
    assert process.returncode == 1
    assert process.stderr is not None
    lines = process.stderr.read().splitlines()
    assert "zero power could not be set" in lines[0] and "register 1000 cannot be written" in lines[-1]


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
    settings = {"host": "127.0.0.1", "port": device.port, "volts_per_watt": 10.0, "timeout_s": 0.5}
    graph.add(
        Laser,
        device="labjack",
        temperature_required=False,
        max_power_w=2.0,
        **{f"labjack.{k}": v for k, v in settings.items()},
    )
    probe = graph.probe()
    commands = probe.advertise(Float64, "laser/power_command")
    power = graph.collect(Float64, "laser/power", probe)
    probe.every(0.01, lambda: commands.publish(Float64(data=1.0)))
    graph.until(lambda: power.data and power.data[-1] == 0.5)
    assert device.dac0_v == 5.0


@pytest.mark.filterwarnings("ignore:DynamicImporter:ImportWarning")  # PyGObject's, where Aravis is installed
def test_hardware_yaml_names_parameters_that_exist(graph: Graph, device: LabJackEmulator) -> None:
    """A misspelt name in a parameter file is silently ignored by ROS."""
    config = Path(__file__).parents[2] / "lce_bringup" / "config" / "hardware.yaml"
    content = yaml.safe_load(config.read_text(encoding="utf-8"))
    here = {"labjack.host": "127.0.0.1", "labjack.port": device.port, "labjack.volts_per_watt": 1.0}
    for name, factory, own in (
        ("laser", Laser, here),
        ("thermal_camera", ThermalCamera, {}),
        ("distance_sensor", DistanceSensor, {}),
    ):
        given = dict(flat(content[f"/**/{name}"]["ros__parameters"]))
        node = graph.add(factory, **given | own)
        assert [parameter for parameter in given if not node.has_parameter(parameter)] == []


def flat(tree: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in tree.items():
        if isinstance(value, dict):
            yield from flat(value, f"{prefix}{key}.")
        else:
            yield prefix + key, value
