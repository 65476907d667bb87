# SPDX-License-Identifier: Apache-2.0
from setuptools import find_packages, setup

PACKAGE = "lce_experiment"

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
    description="Protocols, player, recorder, the registry of nodes, and runs of the node graph.",
    license="Apache-2.0",
    url="https://lce-bench.example.org",
    entry_points={
        "console_scripts": [
            "experiment_player = lce_experiment.executables:experiment_player",
            "target_player = lce_experiment.executables:target_player",
            "recorder = lce_experiment.executables:recorder",
        ],
    },
)
