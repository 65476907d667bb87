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
    maintainer="LCE bench contributors",
    maintainer_email="lce-bench@example.org",
    description="Position control: filter, PID and the loops of the double closed-loop structure, and their nodes.",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "feedforward = lce_control.nodes.feedforward_node:main",
            "inner_controller = lce_control.nodes.inner_controller_node:main",
            "outer_controller = lce_control.nodes.outer_controller_node:main",
            "model_controller = lce_control.nodes.model_controller_node:main",
            "single_controller = lce_control.nodes.single_controller_node:main",
        ],
    },
)
