# SPDX-License-Identifier: Apache-2.0
"""The layouts for Foxglove and PlotJuggler plot fields that the topics of the bench have."""

import importlib
import json
import re
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import pytest

from lce_data.topics import RECORDED
from lce_experiment.registry import NAMESPACE

CONFIG = Path(__file__).resolve().parents[1] / "config"
GUIDE = Path(__file__).resolve().parents[3] / "docs" / "how-to" / "workbench.md"


def plotted(
    foxglove: Path = CONFIG / "foxglove.json", plotjuggler: Path = CONFIG / "plotjuggler.xml"
) -> dict[str, list[str]]:
    """Paths TOPIC/FIELD by the name of the shipped file."""
    layout = json.loads(foxglove.read_text(encoding="utf-8"))
    panels = layout["configById"]
    placed = re.findall(r'"(\w+!\w+)"', json.dumps(layout["layout"]))
    assert sorted(placed) == sorted(panels)
    paths = [path for panel in panels.values() for path in [*panel.get("paths", []), panel.get("xAxisPath")] if path]
    curves = ElementTree.parse(plotjuggler).iter("curve")
    return {
        "foxglove.json": [path["value"].replace(".", "/") for path in paths],
        "plotjuggler.xml": [curve.attrib["name"] for curve in curves],
    }


@pytest.mark.parametrize("file", ["foxglove.json", "plotjuggler.xml"])
def test_what_is_plotted_is_published(file: str) -> None:
    paths = plotted()[file]
    assert len(set(paths)) >= 8
    for path in paths:
        topic, _, field = path.removeprefix(f"{NAMESPACE}/").rpartition("/")
        package, _, name = RECORDED[topic].split("/")
        message = getattr(importlib.import_module(f"{package}.msg"), name)
        assert message.get_fields_and_field_types()[field] == "double"


def test_the_commands_of_the_guide_make_layouts_for_another_namespace(tmp_path: Path) -> None:
    commands = re.findall(r"^sed .*$", GUIDE.read_text(encoding="utf-8"), re.MULTILINE)
    for command in commands:
        here = command.replace("src/lce_bringup/config", str(CONFIG))
        subprocess.run(["bash", "-c", here], cwd=tmp_path, check=True)
    copies = plotted(tmp_path / "left_arm.json", tmp_path / "left_arm.xml")
    for file, paths in plotted().items():
        assert copies[file] == [path.replace(f"{NAMESPACE}/", "/left_arm/") for path in paths]
        assert all(path.startswith("/left_arm/") for path in copies[file])
