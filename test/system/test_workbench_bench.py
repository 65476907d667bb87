# SPDX-License-Identifier: Apache-2.0
"""The workbench on the simulated bench: its live values, its stop button, and what is left of the run."""

import asyncio
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from rcl_interfaces.msg import Log
from run_command import experiment, lce, read, until, values
from std_msgs.msg import Float64

from lce_app.workbench import jobs, tasks
from lce_app.workbench.live_series import Series
from lce_app.workbench.snapshot import Snapshot
from lce_app.workbench.state import WorkbenchState
from lce_app.workbench.tabs.bench import shown_besides
from lce_data.read_runs import read_run
from lce_ros.testing import Graph

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
    assert state.entries["stopped"].run is not None and state.session.roles["stopped"] == "off"


def custom_data(bag: Path) -> dict[str, Any]:
    """What the metadata of a bag says of the run."""
    content = yaml.safe_load((bag / "metadata.yaml").read_text(encoding="utf-8"))
    found: dict[str, Any] = content["rosbag2_bagfile_information"]["custom_data"]
    return found


def test_what_others_run_is_recorded_with_markers_and_never_stopped(
    state: WorkbenchState, graph: Graph, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", str(graph.domain))
    monkeypatch.setattr(state, "_recorded", lambda: None)
    out, monitor, node = state.folder / "theirs", state.monitor, graph.probe("theirs")
    power, pump = node.advertise(Float64, "laser/power"), node.advertise(Float64, "pump")
    displacement = node.advertise(Float64, "displacement")

    def publish() -> None:
        for publisher in (power, pump, displacement):
            publisher.publish(Float64(data=1e-4))

    node.every(0.01, publish)
    monitor.open()
    state.live.viewers.add("page")
    state.live.change(state.live.layout.with_plot((Series("/lce/pump", "data"),)))

    def sees(seen: Any, what: str) -> None:
        graph.until(lambda: (state.poll(), seen())[1], 60.0, what)

    sees(lambda: Series("/lce/pump", "data") in monitor.histories, "the topic of others on the plot")
    assert shown_besides(state) == ["/lce/pump std_msgs/msg/Float64"]
    conditions = {"specimen": "007", "notes": "theirs: <b>", "ambient_c": 21.5}
    state.record(
        "Record",
        tasks.record_topics,
        out=out,
        domain=graph.domain,
        conditions=conditions,
        topics=shown_besides(state),
        only_listens=True,
    )
    sees(lambda: monitor.recording, "the recorder")
    state.stop()  # Esc: there is nothing of this page to stop
    monitor.mark("lamp on", age_s=0.5)
    sees(lambda: monitor.marker_count == 1, "the marker")
    first = sum(power.counts.values())
    sees(lambda: sum(power.counts.values()) > first + 100, "a second more")
    assert state.working, state.job
    state.cancel()
    sees(lambda: not state.working, "the end of the recording")

    assert (experiment(out)["outcome"], experiment(out)["mode"]) == ("complete", "recorder")
    assert experiment(out)["conditions"] == {"ambient_c": 21.5, "specimen": "007", "notes": "theirs: <b>"}
    assert custom_data(out)["conditions.specimen"] == "007" and custom_data(out)["lce_state"] == "finished"
    assert len(read(out)["/lce/pump"][1]) > 100
    assert [m.msg for m in read(out)["/lce/marker"][1]] == ["lamp on"]
    (marker,) = read_run(out).markers
    assert marker.text == "lamp on"


def test_a_marker_by_hand_is_in_the_bag(graph: Graph, tmp_path: Path) -> None:
    """As ``ros2 topic pub --once`` sends it."""
    recorder = graph.start("lce_experiment.nodes.recorder_node", out=str(tmp_path / "bag"))
    node = graph.probe()
    out, power = node.create_publisher(Log, "marker", 10), node.advertise(Float64, "laser/power")
    graph.until(lambda: out.get_subscription_count() and power.get_subscription_count(), 20.0, "the recorder")
    stamp = node.get_clock().now().to_msg()
    power.publish(Float64(data=0.0))
    out.publish(Log(stamp=stamp, level=20, name="operator", msg="lamp on"))
    until(lambda: (tmp_path / "bag" / "recording.mcap").stat().st_size > 2000, "flush")
    recorder.terminate()
    recorder.communicate(timeout=10)
    (message,) = read(tmp_path / "bag")["/lce/marker"][1]
    assert (message.msg, message.stamp.sec) == ("lamp on", stamp.sec)


def test_the_command_line_gives_the_same_provenance(tmp_path: Path) -> None:
    said = ("--specimen", "A7", "--day", "2026-11-22", "--notes", "odd: <b>\n\U0001f600", "--condition", "hall=B")
    run = ("run", "pulse:amp=0.4,th=1,rest=1", "--fast", "--seed", "1", "--out")
    done = lce(*run, str(tmp_path / "bag"), *said)
    assert done.returncode == 0, done.stderr
    conditions = experiment(tmp_path / "bag")["conditions"]
    assert conditions.items() >= {"specimen": "A7", "notes": "odd: <b>\n\U0001f600", "hall": "B"}.items()
    assert conditions["strip_length_m"] > 0.0, "what the simulated strip is known to be"
    found = custom_data(tmp_path / "bag")
    assert found["conditions.notes"] == conditions["notes"] and found["software.python"]
    refused = lce(*run, str(tmp_path / "other"), "--condition", "strip_length_m=-1")
    assert (refused.returncode, refused.stderr.count("\n")) == (1, 1)
    assert "must be a number > 0.0" in refused.stderr and not (tmp_path / "other").exists()
