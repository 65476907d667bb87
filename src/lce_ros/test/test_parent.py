# SPDX-License-Identifier: Apache-2.0
"""What a process does when the one that started it ends."""

import os
import subprocess
import sys
import threading

import pytest

from lce_data.errors import LceError
from lce_ros.parent import PARENT, parent_id, when_parent_ends


def _sleeper() -> "subprocess.Popen[bytes]":
    return subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)


def test_the_end_of_the_process_that_is_named_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    noticed = threading.Event()
    with _sleeper() as process:
        monkeypatch.setenv(PARENT, str(process.pid))
        with when_parent_ends(noticed.set):
            assert not noticed.is_set()
            process.kill()
            assert noticed.wait(5.0)


def test_a_process_that_has_ended_before_is_noticed_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    with _sleeper() as process:
        process.kill()
    monkeypatch.setenv(PARENT, str(process.pid))
    noticed = threading.Event()
    with when_parent_ends(noticed.set):
        assert noticed.is_set()


def test_nothing_is_called_when_the_context_ends_first() -> None:
    noticed = threading.Event()
    before = threading.active_count()
    with _sleeper() as process:
        with when_parent_ends(noticed.set, process.pid):
            pass
        process.kill()
    assert not noticed.is_set() and threading.active_count() == before


def test_the_parent_counts_unless_the_environment_names_another(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(PARENT, raising=False)
    assert parent_id() == os.getppid()
    monkeypatch.setenv(PARENT, "0")
    assert parent_id() == 0
    with when_parent_ends(lambda: pytest.fail("there is none")):
        pass
    monkeypatch.setenv(PARENT, "launch")
    with pytest.raises(LceError, match=r"^LCE_PARENT is 'launch', not a process id$"):
        parent_id()
