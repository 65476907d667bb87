# SPDX-License-Identifier: Apache-2.0
import os
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from keyence_emulator import Controller
from std_msgs.msg import Float64

from lce_drivers.background import Background, NoReading
from lce_drivers.distance.distance_sensor_node import DistanceSensor
from lce_drivers.distance.keyence import KeyenceLink, Mounting, Refused, open_port, parse
from lce_ros.testing import Graph

pytestmark = pytest.mark.alone


@pytest.fixture
def controller() -> Iterator[Controller]:
    c = Controller()
    yield c
    c.close()


def link(controller: Controller, dialect: str = "lk_g5000", clock: Callable[[], float] = lambda: 0.0) -> KeyenceLink:
    return KeyenceLink(open_port(controller.path, 115200, 0.2), dialect, 1, Mounting(), clock)


@pytest.mark.parametrize(
    ("answer", "value"),
    [
        (b"MS,01,+000.073\r", 0.073),
        (b"MS,01,-12.3456\r", -12.3456),
        (b"MS,01,+0001.50\r", 1.5),
        (b"MS,01,+0000073\r", 73.0),
    ],
)
def test_the_number_is_read_wherever_its_point_is(answer: bytes, value: float) -> None:
    assert parse(answer, "MS,01") == value


def test_the_older_dialect_is_read_too() -> None:
    assert parse(b"M1,+00.0421\r", "M1") == 0.0421


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        (b"MS,01,+FFFFFFF\r", "over range"),
        (b"MS,01,-FFFFFFF\r", "over range"),
        (b"MS,01,XXXXXXXX\r", "no value"),
        (b"ER,MS,50\r", "command error"),
        (b"ER,MS,51\r", "state error"),
        (b"ER,MS,88\r", "time-out"),
        (b"ER,MS,77\r", "unknown error"),
        (b"ER,MS\r", "refuses"),
        (b"MS,02,+000.073\r", "no answer to MS,01"),
        (b"MS,01,\r", "not a number"),
        (b"MS,01,+nan\r", "not a number"),
        (b"MS,01,12..3\r", "not a number"),
        (b"MS,01,+1e5\r", "not a number"),
        (b"MS,01,+1_000\r", "not a number"),
        (b"MS,01,+inf\r", "not a number"),
        (b"\xff\xfe\r", "no answer"),
        (b"\r", "no answer"),
    ],
)
def test_what_is_not_a_number_says_what_it_is(answer: bytes, words: str) -> None:
    with pytest.raises(NoReading, match=words):
        parse(answer, "MS,01")


@pytest.mark.parametrize("sign", [0.0, 0.5, -2.0])
def test_a_sign_is_no_scale(sign: float) -> None:
    with pytest.raises(ValueError, match=r"^keyence\.sign: "):
        Mounting(sign=sign)


def test_display_becomes_displacement() -> None:
    assert Mounting().displacement_m(1.5) == pytest.approx(1.5e-3)
    assert Mounting(sign=-1.0, zero=2.0).displacement_m(-3.0) == pytest.approx(1e-3)


def test_a_displacement_that_cannot_be_is_no_reading() -> None:
    with pytest.raises(NoReading, match=r"a displacement of 100 m is outside \[-0\.08, 0\.08\] m"):
        Mounting().displacement_m(1e5)
    assert Mounting(lower_m=-1.0, upper_m=0.2).displacement_m(150.0) == pytest.approx(0.15)


def test_a_port_that_is_lost_is_an_os_error_which_the_thread_outlives(controller: Controller) -> None:
    """Flushing a descriptor that is none of a terminal raises termios.error, as after an adapter was pulled out."""
    port: Any = open_port(controller.path, 115200, 0.2)
    sensor = KeyenceLink(port, "lk_g5000", 1, Mounting(), lambda: 0.0)
    assert sensor.read() is not None
    with Path(os.devnull).open() as nothing:
        os.dup2(nothing.fileno(), port.fileno())
    with pytest.raises(OSError, match="Inappropriate ioctl"):
        sensor.read()
    sensor.close()


def test_a_reading_over_a_serial_line(controller: Controller) -> None:
    sensor = link(controller, clock=iter((10.0, 10.004, 11.0, 11.004)).__next__)
    reading = sensor.read()
    assert reading is not None and reading.value == pytest.approx(73e-6)
    assert reading.t_s == pytest.approx(10.002), "half-way between question and answer"
    controller.display = "-001.500"
    reading = sensor.read()
    assert reading is not None and reading.value == pytest.approx(-1.5e-3)
    sensor.close()


def test_the_older_dialect_over_a_serial_line() -> None:
    controller = Controller(older=True)
    sensor = link(controller, dialect="lk_g")
    reading = sensor.read()
    assert reading is not None and reading.value == pytest.approx(73e-6)
    assert controller.asked == ["M1"]
    sensor.close()
    controller.close()


def test_a_controller_left_in_its_settings_is_set_to_measure(controller: Controller) -> None:
    controller.measuring = False
    sensor = link(controller)
    with pytest.raises(Refused, match="state error"):
        sensor.read()
    assert sensor.read() is not None
    assert controller.asked == ["MS,01", "R0", "MS,01"]
    sensor.close()


def test_an_answer_that_is_missing_is_an_error_and_a_late_one_is_not_taken_for_the_next(
    controller: Controller,
) -> None:
    sensor = link(controller)
    controller.dumb = True
    with pytest.raises(OSError, match="no answer to MS,01"):
        sensor.read()
    os.write(controller._master, b"MS,01,+999.999\r")
    controller.dumb = False
    reading = sensor.read()
    assert reading is not None and reading.value == pytest.approx(73e-6)
    sensor.close()


def test_a_port_that_is_not_there_is_an_error() -> None:
    with pytest.raises(OSError, match="/dev/ttyNOWHERE"):
        open_port("/dev/ttyNOWHERE", 9600, 0.1)


def wait_for(condition: Callable[[], object], timeout_s: float = 5.0) -> None:
    end, pause = time.monotonic() + timeout_s, threading.Event()
    while not condition():
        assert time.monotonic() < end
        pause.wait(0.005)


def test_each_reading_is_given_once_and_a_fault_passes(controller: Controller) -> None:
    device = Background(lambda: link(controller), "test", retry_s=0.05)
    wait_for(lambda: device.fault() is None)
    wait_for(lambda: device.poll() is not None)
    controller.display = "+FFFFFFF"
    wait_for(lambda: device.fault() == "over range (+FFFFFFF)")
    device.poll()
    assert device.poll() is None
    controller.display = "+001.000"
    wait_for(lambda: (r := device.poll()) is not None and r.value == pytest.approx(1e-3))
    assert device.fault() is None
    device.close()


def test_a_broken_line_is_a_fault_and_is_connected_again(controller: Controller) -> None:
    device = Background(lambda: link(controller), "test", retry_s=0.05)
    wait_for(lambda: device.poll() is not None)
    controller.dumb = True
    wait_for(lambda: "no answer" in (device.fault() or ""))
    controller.dumb = False
    device.poll()
    wait_for(lambda: device.poll() is not None)
    device.close()


def test_the_node_publishes_what_the_controller_shows(controller: Controller, graph: Graph) -> None:
    probe = graph.probe()
    received = graph.collect(Float64, "displacement", probe)
    graph.add(
        DistanceSensor,
        device="keyence",
        **{"keyence.port": controller.path, "keyence.sign": -1.0, "keyence.timeout_s": 0.2},
    )
    graph.until(lambda: len(received) > 5)
    assert received.data[-1] == pytest.approx(-73e-6)
    controller.display = "XXXXXXXX"
    asked = len(controller.asked)
    graph.until(lambda: len(controller.asked) > asked + 20)
    count = len(received)
    graph.spin_for(0.2)
    assert len(received) <= count + 1
