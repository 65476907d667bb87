# SPDX-License-Identifier: Apache-2.0
"""A node's process can be stopped from its first moment: before Python has started, and while it imports."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from lce_ros.signals import STOP_SIGNALS

BLOCKED = ("env", "--block-signal=INT")
SLOW = """
import threading
print("importing", flush=True)
threading.Event().wait(60.0)
"""
QUICK = """
def main():
    print("ran", flush=True)
    return 7
"""


def start(folder: Path, code: str, *before: str) -> "subprocess.Popen[str]":
    (folder / "made_up_node.py").write_text(code, encoding="utf-8")
    return subprocess.Popen(
        [*before, sys.executable, "-m", "lce_ros.executable", "made_up_node", "--ros-args"],
        env=os.environ | {"PYTHONPATH": os.pathsep.join([str(folder), os.environ.get("PYTHONPATH", "")])},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.mark.parametrize("number", STOP_SIGNALS)
def test_a_stop_signal_during_the_imports_ends_the_process_in_silence(tmp_path: Path, number: signal.Signals) -> None:
    with start(tmp_path, SLOW) as process:
        assert process.stdout is not None and process.stdout.readline() == "importing\n"
        process.send_signal(number)
        assert process.communicate(timeout=20) == ("", "")
    assert process.returncode == 0


def test_an_interrupt_before_python_has_started_waits_until_it_is_handled(tmp_path: Path) -> None:
    with start(tmp_path, SLOW, *BLOCKED) as process:
        command = Path(f"/proc/{process.pid}/cmdline")
        while not command.read_bytes().startswith(sys.executable.encode()):
            pass  # it is env still, which blocks the signal and becomes Python
        process.send_signal(signal.SIGINT)
        assert process.communicate(timeout=20)[1] == ""
    assert process.returncode == 0


def test_the_status_is_that_of_the_node(tmp_path: Path) -> None:
    with start(tmp_path, QUICK, *BLOCKED) as process:
        assert process.communicate(timeout=20) == ("ran\n", "")
    assert process.returncode == 7
