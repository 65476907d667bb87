# SPDX-License-Identifier: Apache-2.0
from setuptools import find_packages, setup

PACKAGE = "lce_control"

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
    description="Position control: filter, PID and the loops of the double closed-loop structure, and their nodes.",
    license="Apache-2.0",
    url="https://lce-bench.example.org",
    entry_points={
        "console_scripts": [
            "feedforward = lce_control.executables:feedforward",
            "inner_controller = lce_control.executables:inner_controller",
            "joint_bridge = lce_control.executables:joint_bridge",
            "outer_controller = lce_control.executables:outer_controller",
            "model_controller = lce_control.executables:model_controller",
            "single_controller = lce_control.executables:single_controller",
        ],
    },
)
