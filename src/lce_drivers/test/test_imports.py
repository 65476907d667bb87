# SPDX-License-Identifier: Apache-2.0
"""The nodes of a real bench load no simulation, no physics and no test code."""

import subprocess
import sys

import pytest

FORBIDDEN = ("lce_drivers.simulation", "lce_model", "lce_ros.testing", "numba")
REPORT = f"""
import sys
found = [name for name in sys.modules if name.startswith({FORBIDDEN})]
print(*sorted(found))
"""
REAL_DEVICE = """
import rclpy
from rclpy.parameter import Parameter as P
from {module} import {factory}

rclpy.init(domain_id=1)
node = {factory}(parameter_overrides=[P("device", value="{device}"), P("flir.statistic", value="max")])
node.close()
"""


def loaded(code: str) -> list[str]:
    """Forbidden modules that a process has loaded after ``code``."""
    done = subprocess.run([sys.executable, "-c", code + REPORT], capture_output=True, text=True, timeout=60, check=True)
    return done.stdout.split()


@pytest.mark.parametrize(
    "module",
    [
        "lce_drivers.laser.laser_node",
        "lce_drivers.camera.thermal_camera_node",
        "lce_drivers.distance.distance_sensor_node",
    ],
)
def test_a_driver_loads_no_simulation(module: str) -> None:
    assert loaded(f"import {module}") == []


@pytest.mark.ros
@pytest.mark.parametrize(
    ("module", "factory", "device"),
    [
        ("lce_drivers.camera.thermal_camera_node", "ThermalCamera", "flir"),
        ("lce_drivers.distance.distance_sensor_node", "DistanceSensor", "keyence"),
    ],
)
def test_a_sensor_with_a_real_device_loads_no_simulation(module: str, factory: str, device: str) -> None:
    assert loaded(REAL_DEVICE.format(module=module, factory=factory, device=device)) == []


def test_the_simulator_loads_the_physics() -> None:
    """Else the tests above would prove nothing."""
    assert {"lce_model", "lce_drivers.simulation.strip"} <= set(loaded("import lce_drivers.simulation.simulator_node"))
