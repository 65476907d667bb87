# SPDX-License-Identifier: Apache-2.0
"""The camera link on Aravis' own GigE Vision camera over loopback, where Aravis is installed."""

import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import count

import pytest
from sensor_msgs.msg import Temperature

from lce_drivers.background import Background, NoReading
from lce_drivers.camera.flir import CameraSettings, FlirLink, aravis
from lce_drivers.camera.thermal_camera_node import ThermalCamera
from lce_drivers.sensor import Reading
from lce_ros.conversions import from_stamp
from lce_ros.testing import Graph

# PyGObject's, on every import of a repository.
pytestmark = [pytest.mark.alone, pytest.mark.filterwarnings("ignore:DynamicImporter:ImportWarning")]

SETTINGS = CameraSettings(camera="Aravis-Fake-GV01", ir_format="", lower_k=0.0, upper_k=700.0, packet_size=9000)
REGION = {"width": 64, "height": 64}
FAKE_CAMERA = shutil.which("arv-fake-gv-camera-0.8")


def test_a_missing_aravis_names_the_packages(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "gi", None)
    with pytest.raises(OSError, match=r"install gir1.2-aravis-0.8 and python3-gi"):
        aravis()


@pytest.fixture
def camera() -> Iterator[None]:
    pytest.importorskip("gi")
    try:
        aravis()
    except OSError as error:
        pytest.skip(str(error))
    if FAKE_CAMERA is None:
        pytest.skip("arv-fake-gv-camera-0.8 (package aravis-tools) is not installed")
    process = subprocess.Popen([FAKE_CAMERA, "-i", "127.0.0.1", "-s", "GV01"])
    yield
    process.kill()
    process.wait(timeout=5)


def opened(clock: Callable[[], float]) -> FlirLink:
    end = time.monotonic() + 10.0
    while True:
        try:
            return FlirLink(SETTINGS, clock)
        except OSError:
            assert time.monotonic() < end


def read(link: FlirLink) -> Reading | None:
    """A reading; the first frames over loopback are often incomplete."""
    try:
        return link.read()
    except NoReading:
        return None


@pytest.mark.usefixtures("camera")
def test_frames_become_ten_temperatures_a_second() -> None:
    """By the link's clock, which here goes on by 30 ms at each look: one reading in each tenth of a second."""
    ticks = count()
    link = opened(clock=lambda: 0.03 * next(ticks))
    found: list[Reading] = []
    frames = 0
    while len(found) < 15:
        found += [reading] if (reading := read(link)) else []
        frames += 1
        assert frames < 500
    link.close()
    periods = [int(r.t_s * SETTINGS.rate_hz) for r in found]
    assert len(set(periods)) == len(periods)
    assert all(0.0 < r.value < 700.0 for r in found)


@pytest.mark.usefixtures("camera")
def test_implausible_frames_are_not_temperatures() -> None:
    device = Background(lambda: FlirLink(replace(SETTINGS, lower_k=699.0), time.monotonic), "test", retry_s=0.2)
    end = time.monotonic() + 10.0
    while "not within [699, 700] K" not in (device.fault() or ""):
        assert time.monotonic() < end
        assert device.poll() is None
    device.close()


@pytest.mark.usefixtures("camera")
def test_the_node_publishes_what_the_camera_sees(graph: Graph) -> None:
    probe = graph.probe()
    received = graph.collect(Temperature, "temperature", probe)
    settings = {"camera": "Aravis-Fake-GV01", "ir_format": "", "packet_size": 9000, "lower_c": -273.15, **REGION}
    graph.add(ThermalCamera, device="flir", **{f"flir.{k}": v for k, v in settings.items()})
    graph.until(lambda: len(received) >= 5)
    ages_s = [t - from_stamp(m.header.stamp) for t, m in zip(received.times_s, received.messages, strict=True)]
    assert all(age >= 0.03 for age in ages_s), "stamped with the time of acquisition"


def test_a_camera_that_is_not_there_is_a_fault_that_names_it() -> None:
    try:
        aravis()
    except OSError as error:
        pytest.skip(str(error))
    device = Background(lambda: FlirLink(replace(SETTINGS, camera="10.255.255.1"), time.monotonic), "test")
    end = time.monotonic() + 10.0
    while "10.255.255.1" not in (device.fault() or ""):
        assert time.monotonic() < end
    device.close()


def test_the_mean_of_the_whole_frame_is_no_temperature_of_a_strip(graph: Graph) -> None:
    with pytest.raises(
        ValueError, match=r"flir\.width, flir\.height: 0 reaches to the edge of the frame, and the mean"
    ):
        graph.add(ThermalCamera, device="flir", **{"flir.x": 10, "flir.height": 5})


def test_a_camera_that_would_find_no_temperature_plausible_is_refused() -> None:
    with pytest.raises(ValueError, match=r"^flir\.lower_c"):
        CameraSettings(lower_k=300.0, upper_k=300.0)
