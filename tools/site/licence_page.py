# SPDX-License-Identifier: Apache-2.0
"""The page of the dependencies and their licences, from the metadata of what is installed."""

import re
from importlib import metadata
from xml.etree import ElementTree as ET

from links import ROOT

HEAD = """# Licences of the dependencies

The bench itself is Apache-2.0. This page lists what `make setup` and `make docs` install, with the licence that each
distribution states of itself.

| distribution | version | licence |
|---|---|---|
"""
TAIL = """
On Ubuntu, apt's packages take the place of many of these; `/usr/share/doc/PACKAGE/copyright` has their licences.

Next: [what the bench does with files of others](../how-to/security.md).
"""


def licences_page() -> str:
    """A table of every distribution in the lock files."""
    lines = [line for name in ("venv", "docs") for line in _lock(name)]
    rows = [
        f"| {name} | {version} | {licence_of(name)} |" for name, version in sorted(lines, key=lambda x: x[0].lower())
    ]
    return HEAD + "\n".join(rows) + "\n" + TAIL


def licence_of(name: str) -> str:
    """The licence of an installed distribution.

    As it states it itself, as its package.xml does, or the first line of its licence file.
    """
    about = metadata.metadata(name)
    own = (about.get("License-Expression") or about.get("License") or "").strip()
    classifiers = [c.rpartition(" :: ")[2] for c in about.get_all("Classifier") or [] if c.startswith("License ::")]
    if re.fullmatch(r"[\w.()+, -]{3,80}", own) and own not in ("UNKNOWN", "licence"):
        return own
    return ", ".join(classifiers) or _of_ros_package(name) or _first_line(name)


def _of_ros_package(name: str) -> str:
    """The licence in the package.xml of a wheel of ROS; one that only names another wheel has that one's."""
    for file in metadata.files(name) or []:
        if file.name == "package.xml":
            found = ET.fromstring(file.read_text(encoding="utf-8")).findall("license")
            return " AND ".join(str(element.text) for element in found)
    return _of_ros_package(name.replace("ros-jazzy-", "ros-")) if name.startswith("ros-jazzy-") else ""


def _first_line(name: str) -> str:
    """The first line of the licence file that came with a distribution, or what its module says of itself."""
    files = metadata.files(name) or []
    for file in files:
        if re.search(r"licen[cs]e|copying", file.name, re.IGNORECASE) and file.suffix in ("", ".txt", ".md", ".rst"):
            for line in file.read_text(encoding="utf-8").splitlines():
                if line.strip(" #="):
                    return line.strip(" #=").replace("|", "")
    for file in files:
        if file.suffix == ".py" and (found := re.search(r"__license__ = '(.+)'", file.read_text(encoding="utf-8"))):
            return found[1]
    return "not stated"


def _lock(name: str) -> list[tuple[str, str]]:
    text = (ROOT / "requirements" / f"{name}.lock").read_text(encoding="utf-8")
    return re.findall(r"^([\w.-]+)==([^\s;#]+)", text, re.MULTILINE)
