# SPDX-License-Identifier: Apache-2.0
from setuptools import find_packages, setup

PACKAGE = "lce_drivers"

setup(
    name=PACKAGE,
    version="0.1.0",
    packages=find_packages(include=[PACKAGE, f"{PACKAGE}.*"]),
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest", "pytest-timeout"]},  # by which colcon test knows its runner
    zip_safe=False,
    maintainer="LCE bench contributors",
    maintainer_email="lce-bench@example.org",
    description="Nodes and device adapters: laser, thermal camera, distance sensor, simulator.",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "laser = lce_drivers.laser.laser_node:main",
            "thermal_camera = lce_drivers.camera.thermal_camera_node:main",
            "distance_sensor = lce_drivers.distance.distance_sensor_node:main",
            "simulator = lce_drivers.simulation.simulator_node:main",
        ],
    },
)
