# SPDX-License-Identifier: Apache-2.0
"""The packages declare what they import, and carry one version and licence."""

import ast
import re
import sys
from fnmatch import fnmatch
from pathlib import Path
from xml.etree import ElementTree

import pytest
from catkin_pkg.package import parse_package

SOURCES = Path(__file__).resolve().parents[2] / "src"
PACKAGES = sorted(file.parent.name for file in SOURCES.glob("*/package.xml"))
ROSDEP = {  # import name: rosdep key, where they differ
    "gi": "python3-gi",
    "launch_testing": "",
    "distributed": "",  # optional: docs/explanation/diagnosis.md
    "control": "",  # requirements/ubuntu.txt
    "fastapi": "python3-fastapi",
    "jinja2": "python3-jinja2",
    "joblib": "python3-joblib",
    "markupsafe": "",  # comes with jinja2
    "matplotlib": "python3-matplotlib",
    "mcap": "",  # requirements/ubuntu.txt
    "msgspec": "",  # requirements/ubuntu.txt
    "nicegui": "",  # requirements/ubuntu.txt
    "numba": "python3-numba",
    "numpy": "python3-numpy",
    "polars": "",  # requirements/ubuntu.txt
    "pymodbus": "python3-pymodbus",
    "pytest": "python3-pytest",
    "rosbags": "python3-rosbags-pip",
    "scipy": "python3-scipy",
    "serial": "python3-serial",
    "starlette": "",  # comes with nicegui
    "tqdm": "python3-tqdm",
    "uplot": "",  # requirements/ubuntu.txt
    "yaml": "python3-yaml",
    "zstandard": "",  # comes with mcap
}


def imported(files: list[Path]) -> set[str]:
    """Top-level names of the third-party modules that files import, at any depth, but for types alone."""
    names: set[str] = set()
    for file in files:
        tree = ast.parse(file.read_text(encoding="utf-8"))
        types = [n for n in ast.walk(tree) if isinstance(n, ast.If) and ast.unparse(n.test) == "TYPE_CHECKING"]
        left_out = {id(n) for branch in types for n in ast.walk(branch)}
        for node in ast.walk(tree):
            if id(node) in left_out:
                continue
            if isinstance(node, ast.Import):
                names |= {alias.name.split(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module and node.level == 0:
                names.add(node.module.split(".")[0])
    return names - sys.stdlib_module_names


def declared(package: str, *tags: str) -> set[str]:
    root = ElementTree.parse(SOURCES / package / "package.xml").getroot()
    return {element.text or "" for tag in tags for element in root.findall(tag)}


@pytest.mark.parametrize("package", [name for name in PACKAGES if name != "lce_interfaces"])
def test_package_xml_names_what_is_imported(package: str) -> None:
    folder = SOURCES / package
    run = declared(package, "exec_depend")
    for files, known in (
        ([*(folder / package).rglob("*.py"), *folder.glob("launch/*.py")], run),
        ([*folder.glob("test/*.py")], run | declared(package, "test_depend")),
    ):
        keys = {ROSDEP.get(name, name) for name in imported(files)} - {"", package, *(f.stem for f in files)}
        assert keys <= known, f"{package}/package.xml lacks {sorted(keys - known)}"


@pytest.mark.parametrize("package", PACKAGES)
def test_one_version_and_licence(package: str) -> None:
    assert declared(package, "version") == {"0.1.0"}
    assert declared(package, "license") == {"Apache-2.0"}
    setup = SOURCES / package / "setup.py"
    assert not setup.exists() or 'version="0.1.0"' in setup.read_text(encoding="utf-8")


@pytest.mark.parametrize("name", PACKAGES)
def test_a_package_says_whom_to_ask_and_how_it_is_linted(name: str) -> None:
    warnings: list[str] = []
    package = parse_package(str(SOURCES / name), warnings=warnings)
    package.validate(warnings=warnings)
    assert warnings == []
    assert [maintainer.name for maintainer in package.maintainers] == ["LCE bench maintainers"], "a role, not a person"
    assert [url.type for url in package.urls] == ["repository"]
    linter = "ament_lint_cmake" if name == "lce_interfaces" else "ament_flake8"
    assert linter in declared(name, "test_depend")


def test_the_service_says_its_units() -> None:
    for file in SOURCES.glob("lce_interfaces/srv/*.srv"):
        for line in file.read_text(encoding="utf-8").splitlines():
            assert re.match(r"#|---|(bool|string) \w+ +# |float64 \w+ +# (m|degC)\b", line), line


def test_every_source_file_names_its_licence() -> None:
    for file in [*SOURCES.glob("*/**/*.py"), *SOURCES.parent.glob("test/**/*.py"), *SOURCES.parent.glob("tools/*")]:
        if file.is_file() and "__pycache__" not in file.parts:
            head = file.read_text(encoding="utf-8").splitlines()[:2]
            assert any("SPDX-License-Identifier: Apache-2.0" in line for line in head), file


@pytest.mark.parametrize("package", [name for name in PACKAGES if name != "lce_interfaces"])
def test_files_beside_the_modules_are_installed_too(package: str) -> None:
    setup = (SOURCES / package / "setup.py").read_text(encoding="utf-8")
    patterns = re.findall(r'"([^"]+)"', setup)
    for file in (SOURCES / package / package).rglob("*.*"):
        if file.is_file() and not {"__pycache__", ".ruff_cache", ".mypy_cache"} & set(file.parts):
            name = str(file.relative_to(SOURCES / package / package))
            assert file.suffix == ".py" or any(fnmatch(name, pattern) for pattern in patterns), file
