# SPDX-License-Identifier: Apache-2.0
from pathlib import Path

from setuptools import setup

PACKAGE = "lce_bringup"

HERE = Path(__file__).parent
SHARED = [*HERE.glob("launch/*.launch.py"), *(file for file in HERE.glob("config/**/*") if file.is_file())]


def by_folder() -> list[tuple[str, list[str]]]:
    """Launch and configuration files as setuptools' data_files, in the folders that they have here."""
    folders: dict[str, list[str]] = {}
    for file in sorted(path.relative_to(HERE) for path in SHARED):
        folders.setdefault(f"share/{PACKAGE}/{file.parent}", []).append(str(file))
    return sorted(folders.items())


setup(
    name=PACKAGE,
    version="0.1.0",
    packages=[],  # launch, configuration, models and layouts; no logic
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
        *by_folder(),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest", "pytest-timeout"]},  # by which colcon test knows its runner
    zip_safe=False,
    maintainer="LCE bench maintainers",
    maintainer_email="maintainers@lce-bench.example.org",
    description="Launch files, configuration, models and layouts. No logic.",
    license="Apache-2.0",
    url="https://lce-bench.example.org",
    entry_points={
        "console_scripts": [
            # `ros2 run lce_bringup NAME`, as it was before these had packages of their own.
            "experiment_player = lce_experiment.executables:experiment_player",
            "target_player = lce_experiment.executables:target_player",
            "recorder = lce_experiment.executables:recorder",
            "lce = lce_app.cli.main:main",
        ],
    },
)
