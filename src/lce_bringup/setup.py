# SPDX-License-Identifier: Apache-2.0
from pathlib import Path

from setuptools import find_packages, setup

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
    packages=find_packages(include=[PACKAGE, f"{PACKAGE}.*"]),
    package_data={f"{PACKAGE}.workbench": ["*.css", "*.js"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
        *by_folder(),
        ("bin", ["bin/lce"]),  # `lce` on PATH; the script of the same name under lib/ serves `ros2 run`
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest", "pytest-timeout"]},  # by which colcon test knows its runner
    zip_safe=False,
    maintainer="LCE bench contributors",
    maintainer_email="lce-bench@example.org",
    description="Launch, configuration, experiment player, recorder and the lce command, on top of all the others.",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "experiment_player = lce_bringup.experiment_player_node:main",
            "target_player = lce_bringup.target_player_node:main",
            "recorder = lce_bringup.recorder_node:main",
            "lce = lce_bringup.cli:main",
        ],
    },
)
