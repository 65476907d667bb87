# SPDX-License-Identifier: Apache-2.0
"""The tests of launch_testing in `launch_tests`, where ROS's launch is installed."""

import importlib.util
import os
import subprocess
from pathlib import Path

import pytest

from lce_ros.testing import Graph

ROOT = Path(__file__).resolve().parents[2]
FILES = sorted(Path(__file__).with_name("launch_tests").glob("*.py"))

needs_launch_testing = pytest.mark.skipif(
    importlib.util.find_spec("launch_testing_ros") is None,
    reason="launch_testing is not among the wheels: Ubuntu 24.04, or LCE_UNDERLAY (test/README.md)",
)


@pytest.mark.alone
@needs_launch_testing
@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_launch_testing_passes(file: Path, graph: Graph, tmp_path: Path) -> None:
    environment = os.environ | {"ROS_DOMAIN_ID": str(graph.domain), "TMPDIR": str(tmp_path)}
    done = subprocess.run(["launch_test", str(file)], env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.skipif(not (ROOT / ".venv" / "setup.bash").exists(), reason="tools/env.sh is for the wheels")
def test_another_workspace_can_lie_under_this_one(tmp_path: Path) -> None:
    (tmp_path / "local_setup.bash").write_text("export OF_THE_UNDERLAY=yes\n")
    environment = os.environ | {"LCE_UNDERLAY": str(tmp_path)}
    command = [str(ROOT / "tools" / "env.sh"), "printenv", "OF_THE_UNDERLAY"]
    assert subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout == "yes\n"
