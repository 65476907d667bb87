# SPDX-License-Identifier: Apache-2.0
"""Children of a run: ended in order, named when they die, never left behind."""

import sys
import threading
import time
from pathlib import Path

import pytest
from std_msgs.msg import Float64

from lce_data.errors import LceError
from lce_experiment.domain import own_domain
from lce_experiment.plan import Plan
from lce_experiment.recording import record
from lce_experiment.registry import LASER, PLAYER
from lce_experiment.runners.processes import Processes
from lce_ros.domain import claimed, free_domain, only_laser
from lce_ros.testing import Graph

pytestmark = pytest.mark.alone

LAST = "print('the reason\\n[INFO] [1.0] [lce.laser]: dark', file=sys.stderr)"
DIE = [sys.executable, "-c", f"import sys\n{LAST}\nsys.exit(3)"]
READY = [sys.executable, "-c", "import time\nprint('ready', flush=True)\ntime.sleep(60)"]


def test_a_child_that_dies_is_named_with_its_last_line_that_is_more_than_information(tmp_path: Path) -> None:
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


def test_the_domain_of_the_user_is_claimed_so_that_no_other_run_lands_in_it(monkeypatch: pytest.MonkeyPatch) -> None:
    with free_domain() as domain:
        pass
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    with own_domain() as mine:
        assert mine == domain
        with claimed(domain) as free, own_domain() as again:
            assert not free and again == domain, "what the user says counts"
    with claimed(domain) as free:
        assert free


@pytest.mark.parametrize("text", ["mine", "-1", "233"])
def test_what_is_no_domain_is_refused(monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", text)
    with pytest.raises(LceError, match=f"^ROS_DOMAIN_ID is '{text}', not a number from 0 to 232$"), own_domain():
        pass


@pytest.mark.parametrize("fast", [True, False])
def test_a_run_refuses_a_domain_that_has_a_laser(
    graph: Graph, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fast: bool
) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", str(graph.domain))
    graph.start(LASER.module)
    probe = graph.probe()
    light = graph.collect(Float64, "laser/power", probe)
    graph.until(lambda: light.data, 30.0, "a laser")
    commands = probe.count_publishers("laser/power_command")
    plan = Plan("hold", 1.0, tmp_path / "bag", None, {}, 1, fast, given={PLAYER.name: {"protocol": "hold:hold=1"}})
    said = f"^ROS domain {graph.domain} already has a laser /lce/laser; end it, or set another ROS_DOMAIN_ID$"
    with pytest.raises(LceError, match=said):
        record(plan)
    assert not (tmp_path / "bag").exists()
    assert probe.count_publishers("laser/power_command") == commands


def test_a_second_laser_of_the_same_name_does_not_start(graph: Graph) -> None:
    graph.start(LASER.module)
    light = graph.collect(Float64, "laser/power", graph.probe())
    graph.until(lambda: light.data, 30.0, "a laser")
    second = graph.start(LASER.module)
    _, errors = second.communicate(timeout=30)
    assert second.returncode == 1
    assert f"ROS domain {graph.domain} already has a laser /lce/laser" in errors
    with only_laser(graph.domain, "/lce2/laser"), only_laser(graph.domain + 1, "/lce/laser"):
        pass
