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
    maintainer="LCE bench maintainers",
    maintainer_email="maintainers@lce-bench.example.org",
    description="Nodes and device adapters: laser, thermal camera, distance sensor, simulator.",
    license="Apache-2.0",
    url="https://lce-bench.example.org",
    entry_points={
        "console_scripts": [
            "laser = lce_drivers.executables:laser",
            "thermal_camera = lce_drivers.executables:thermal_camera",
            "distance_sensor = lce_drivers.executables:distance_sensor",
            "simulator = lce_drivers.executables:simulator",
        ],
    },
)
