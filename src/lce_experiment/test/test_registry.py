# SPDX-License-Identifier: Apache-2.0
"""The registry of nodes: how each of them is started as a process of its own."""

import subprocess
from pathlib import Path

from lce_experiment.registry import NodeSpec


def test_a_node_imports_nothing_from_the_folder_that_it_is_started_in(tmp_path: Path) -> None:
    (tmp_path / "this.py").write_text("print('what lay in the folder was run')\n")
    command = NodeSpec("node", "this", "").command  # a module of Python's own, as any that a node imports
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=20.0)
    assert done.stdout.startswith("The Zen of Python")  # and ends there: that module has no main
