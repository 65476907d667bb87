# SPDX-License-Identifier: Apache-2.0
"""ROS's linters pass on the packages that declare them. The wheels have none of them; `make lint` asks more."""

from pathlib import Path
from xml.etree import ElementTree

import pytest

HERE = Path(__file__).parent
OPTIONS = {
    "ament_flake8": ["--config", str(HERE / "ament_flake8.ini")],
    "ament_lint_cmake": ["--linelength", "120"],
}
DECLARED = [
    pytest.param(depend.text, file.parent, id=f"{depend.text}-{file.parent.name}")
    for file in sorted(HERE.parents[1].glob("src/*/package.xml"))
    for depend in ElementTree.parse(file).getroot().findall("test_depend")
    if depend.text in OPTIONS
]


@pytest.mark.parametrize(("linter", "package"), DECLARED)
def test_a_linter_of_ros_passes(linter: str, package: Path) -> None:
    module = pytest.importorskip(f"{linter}.main", reason=f"{linter} is no wheel: rosdep brings it on Ubuntu")
    assert module.main(argv=[*OPTIONS[linter], str(package)]) == 0
