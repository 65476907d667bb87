# SPDX-License-Identifier: Apache-2.0
"""Children of a run: ended in order, named when they die, never left behind."""

import sys
import threading
import time
from pathlib import Path

import pytest

from lce_data.errors import LceError
from lce_experiment.domain import own_domain
from lce_experiment.runners.processes import Processes

pytestmark = pytest.mark.alone

DIE = [sys.executable, "-c", "import sys\nprint('the reason', file=sys.stderr)\nsys.exit(3)"]
READY = [sys.executable, "-c", "import time\nprint('ready', flush=True)\ntime.sleep(60)"]


def test_a_child_that_dies_is_named_with_its_last_line(tmp_path: Path) -> None:
    end = time.monotonic() + 10
    said = r"^laser ended early \(status 3\): the reason$"
    with pytest.raises(LceError, match=said), Processes(tmp_path) as processes:  # noqa: PT012
        processes.start("recorder", READY)
        processes.start("laser", DIE)
        while time.monotonic() < end:
            processes.check()
            threading.Event().wait(0.02)


def test_children_end_with_the_context_the_last_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stopped: list[str] = []
    stop = Processes.stop
    monkeypatch.setattr(Processes, "stop", lambda self, name, **kw: (stopped.append(name), stop(self, name, **kw)))
    with Processes(tmp_path) as processes:
        children = [processes.start(name, READY, pipe=True) for name in ("recorder", "laser", "player")]
        for child in children:
            assert child.stdout is not None and child.stdout.readline() == b"ready\n"
    assert stopped == ["player", "laser", "recorder"]
    assert all(child.poll() is not None for child in children)


def test_each_run_has_a_domain_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    with own_domain() as first:
        monkeypatch.delenv("ROS_DOMAIN_ID")
        with own_domain() as second:
            assert first != second
        monkeypatch.setenv("ROS_DOMAIN_ID", str(first))
    monkeypatch.setenv("ROS_DOMAIN_ID", "42")
    with own_domain() as mine:
        assert mine == 42
