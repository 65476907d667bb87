# SPDX-License-Identifier: Apache-2.0
from setuptools import find_packages, setup

PACKAGE = "lce_app"

setup(
    name=PACKAGE,
    version="0.1.0",
    packages=find_packages(include=[PACKAGE, f"{PACKAGE}.*"]),
    package_data={f"{PACKAGE}.workbench": ["*.css", "*.js"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
        ("bin", ["bin/lce"]),  # `lce` on PATH; the script of the same name under lib/ serves `ros2 run`
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest", "pytest-timeout"]},  # by which colcon test knows its runner
    zip_safe=False,
    maintainer="LCE bench maintainers",
    maintainer_email="maintainers@lce-bench.example.org",
    description="Use cases of the bench, the lce command and the workbench page.",
    license="Apache-2.0",
    url="https://lce-bench.example.org",
    entry_points={
        "console_scripts": [
            "lce = lce_app.cli.main:main",
        ],
    },
)
