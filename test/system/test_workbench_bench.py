# SPDX-License-Identifier: Apache-2.0
"""The workbench on the simulated bench: what it hears, what its stop button does, and what is left of the run."""

import asyncio
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from run_command import experiment, until, values

from lce_app.workbench import jobs
from lce_app.workbench import tasks as work
from lce_app.workbench.bench import Workbench
from lce_app.workbench.snapshot import Heard

pytestmark = pytest.mark.alone


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Workbench]:
    jobs.warm_up()
    workbench = Workbench(tmp_path)
    yield workbench
    workbench.close()


def heard(bench: Workbench) -> Heard:
    """What was heard last, of a run that has not failed."""
    bench.poll()
    assert bench.job is not None and not bench.job.error, bench.job
    return bench.ear.heard[-1] if bench.ear.heard else Heard(0.0, {})


def test_a_run_is_heard_live_and_stopped_at_once(bench: Workbench, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    ear, out = bench.ear, bench.folder / "stopped"
    monkeypatch.setattr(bench, "_recorded", lambda: None)
    bench.record(
        "Run", work.run, protocol="hold:power=1.5,hold=60", out=out, model=None, settings=[], domain=ear.open()
    )

    until(lambda: heard(bench).values.get("laser/power", 0.0) > 1.0, "light on the strip", timeout_s=60.0)
    begin, count = time.monotonic(), ear.count
    until(lambda: heard(bench) and ear.count >= count + 20, "twenty moments")
    assert (time.monotonic() - begin) / 20 < 0.1  # 10 Hz and more
    assert {"temperature", "displacement", "laser/power", "laser/power_command"} <= set(ear.heard[-1].values)
    until(lambda: heard(bench) and any("following" in text for _, text in ear.conditions.values()), "the laser's word")

    begin = time.monotonic()
    bench.cancel()
    until(lambda: heard(bench).values.get("laser/power", 0.0) == 0.0, "darkness")
    assert time.monotonic() - begin < 1.0
    until(lambda: (bench.poll(), not bench.working)[1], "the end of the run")
    assert bench.job is not None and bench.job.state == "cancelled"
    assert experiment(out)["outcome"] == "interrupted"
    assert values(out, "/lce/laser/power")[1][-1] == 0.0
    asyncio.run(bench.open())
    assert set(bench.runs("train")) == {"stopped"}
