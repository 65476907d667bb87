# SPDX-License-Identifier: Apache-2.0
"""What the node of a controller loads: its start does not wait for code that it does not need."""

import subprocess
import sys

import pytest

LOADED = """
import sys
from importlib import import_module
import_module(sys.argv[1])
print(*sorted(sys.modules))
"""
OFFLINE = ("lce_control.tuning", "control", "lce_app", "lce_report", "lce_ros.testing", "pytest")
PHYSICS = ("lce_model", "numba", "scipy")


@pytest.mark.parametrize(
    ("node", "unwanted"),
    [
        ("inner_controller", OFFLINE + PHYSICS),
        ("outer_controller", OFFLINE + PHYSICS),
        ("single_controller", OFFLINE + PHYSICS),
        ("feedforward", OFFLINE),
        ("model_controller", OFFLINE),
    ],
)
def test_a_node_loads_only_what_it_needs(node: str, unwanted: tuple[str, ...]) -> None:
    words = [sys.executable, "-c", LOADED, f"lce_control.nodes.{node}_node"]
    done = subprocess.run(words, check=True, capture_output=True, text=True)
    assert set(unwanted).isdisjoint(done.stdout.split())
