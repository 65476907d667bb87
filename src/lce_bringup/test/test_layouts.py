# SPDX-License-Identifier: Apache-2.0
"""The layouts for Foxglove and PlotJuggler plot fields that the topics of the bench have."""

import importlib
import json
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

from lce_data.topics import RECORDED
from lce_experiment.registry import NAMESPACE

CONFIG = Path(__file__).resolve().parents[1] / "config"


def plotted() -> dict[str, list[str]]:
    """Paths TOPIC/FIELD by file."""
    layout = json.loads((CONFIG / "foxglove.json").read_text(encoding="utf-8"))
    panels = layout["configById"]
    placed = re.findall(r'"(\w+!\w+)"', json.dumps(layout["layout"]))
    assert sorted(placed) == sorted(panels)
    paths = [path for panel in panels.values() for path in [*panel.get("paths", []), panel.get("xAxisPath")] if path]
    curves = ElementTree.parse(CONFIG / "plotjuggler.xml").iter("curve")
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
