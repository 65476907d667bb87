# SPDX-License-Identifier: Apache-2.0
"""The workbench on the simulated bench: its live values, its stop button, and what is left of the run."""

import asyncio
from collections.abc import Iterator
from pathlib import Path

import pytest
from run_command import experiment, until, values

from lce_app.workbench import jobs, tasks
from lce_app.workbench.snapshot import Snapshot
from lce_app.workbench.state import WorkbenchState

pytestmark = pytest.mark.alone


@pytest.fixture
def state(tmp_path: Path) -> Iterator[WorkbenchState]:
    jobs.warm_up()
    workbench = WorkbenchState(tmp_path)
    yield workbench
    workbench.close()


def latest(state: WorkbenchState) -> Snapshot:
    """The latest snapshot of a run that has not failed."""
    state.poll()
    assert state.job is not None and not state.job.error, state.job
    return state.monitor.snapshots[-1] if state.monitor.snapshots else Snapshot(0.0, {})


def test_a_run_is_shown_live_and_can_be_stopped(state: WorkbenchState, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    monitor, out = state.monitor, state.folder / "stopped"
    monkeypatch.setattr(state, "_recorded", lambda: None)
    state.record(
        "Run", tasks.run, protocol="hold:power=1.5,hold=60", out=out, model=None, settings={}, domain=monitor.open()
    )

    until(lambda: latest(state).values.get("laser/power", 0.0) > 1.0, "light on the strip", timeout_s=60.0)
    count = monitor.count
    until(lambda: latest(state) and monitor.count >= count + 20, "twenty snapshots")
    assert {"temperature", "displacement", "laser/power", "laser/power_command"} <= set(latest(state).values)
    until(
        lambda: latest(state) and any("following" in text for _, text in monitor.conditions.values()),
        "the condition of the laser",
    )

    state.cancel()
    until(lambda: latest(state).values.get("laser/power", 0.0) == 0.0, "darkness")
    until(lambda: (state.poll(), not state.working)[1], "the end of the run")
    assert state.job is not None and state.job.state == "cancelled"
    assert experiment(out)["outcome"] == "interrupted"
    time_s, power_w = values(out, "/lce/laser/power")
    assert power_w[-1] == 0.0 and time_s[-1] - time_s[0] < 60.0
    asyncio.run(state.open())
    assert set(state.runs("train")) == {"stopped"}
