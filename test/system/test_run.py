# SPDX-License-Identifier: Apache-2.0
"""`lce run`: the same in real time as fast, the same seed the same data, and nothing lost on any way out."""

import os
import signal
from pathlib import Path

import numpy as np
import pytest
from run_command import experiment, lce, read, started, until, values

from lce_app.cli import main as cli
from lce_experiment import protocols, recording

PROTOCOL = "hold:power=1.5,hold=3,rest=2"
POWER, TEMPERATURE, DISPLACEMENT = "/lce/laser/power", "/lce/temperature", "/lce/displacement"
NOISE = {TEMPERATURE: 0.06, DISPLACEMENT: 4e-6}
"""rms of the sensors: K, m."""


@pytest.fixture(scope="module")
def fast(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A fast run, seed 5."""
    folder = tmp_path_factory.mktemp("runs") / "fast"
    done = lce("run", PROTOCOL, "--fast", "--seed", "5", "--out", str(folder))
    assert (done.returncode, done.stdout) == (0, f"{folder}\n"), done.stderr
    return folder


@pytest.fixture(scope="module")
def realtime(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same in real time, another seed; again, twice at most, where the machine stood still meanwhile."""
    for _ in range(3):
        folder = tmp_path_factory.mktemp("runs") / "realtime"
        done = lce("run", PROTOCOL, "--seed", "6", "--out", str(folder))
        if "the system clock was set back" in done.stderr:
            continue
        assert (done.returncode, done.stdout) == (0, f"{folder}\n"), done.stderr
        times, power = values(folder, POWER)
        if np.diff(times[np.flatnonzero(power)]).max() < 0.09:
            break
    assert done.returncode == 0, done.stderr
    return folder


def test_a_run_says_what_it_was(fast: Path) -> None:
    about = experiment(fast)
    assert about["protocol"] == PROTOCOL and about["mode"] == "fast" and about["seed"] == 5
    assert about["outcome"] == "complete"
    assert about["conditions"] == {"ambient_temperature_c": 28.0, "strip_length_m": 0.01}
    assert about["messages"][POWER] == read(fast)[POWER][0].size


def test_the_laser_gets_the_protocol_exactly(fast: Path) -> None:
    _, power = values(fast, "/lce/laser/power_command")
    wave = protocols.one(PROTOCOL).power_w
    start = int(np.flatnonzero(power)[0])
    np.testing.assert_array_equal(power[start : start + wave.size], wave)
    assert not power[:start].any() and not power[start + wave.size :].any() and start >= 50


def test_the_same_seed_gives_the_same_file(fast: Path, tmp_path: Path) -> None:
    assert lce("run", PROTOCOL, "--fast", "--seed", "5", "--out", str(tmp_path / "again")).returncode == 0
    assert (tmp_path / "again" / "recording.mcap").read_bytes() == (fast / "recording.mcap").read_bytes()


def test_another_seed_gives_other_noise_on_the_same_strip(fast: Path, tmp_path: Path) -> None:
    assert lce("run", PROTOCOL, "--fast", "--seed", "6", "--out", str(tmp_path / "other")).returncode == 0
    ours, theirs = read(fast), read(tmp_path / "other")
    assert [m.data for m in ours[POWER][1]] == [m.data for m in theirs[POWER][1]]
    difference = values(fast, DISPLACEMENT)[1] - values(tmp_path / "other", DISPLACEMENT)[1]
    assert np.std(difference) == pytest.approx(np.sqrt(2) * NOISE[DISPLACEMENT], rel=0.2)


def test_the_strip_can_be_set(fast: Path, tmp_path: Path) -> None:
    done = lce("run", PROTOCOL, "--fast", "--seed", "5", "--set", "lumped.gain=45", "--out", str(tmp_path / "hot"))
    assert done.returncode == 0, done.stderr
    assert experiment(tmp_path / "hot")["model"]["set"] == {"lumped.gain": 45.0}
    rise = [np.ptp(values(bag, TEMPERATURE)[1]) for bag in (fast, tmp_path / "hot")]
    assert rise[1] == pytest.approx(1.5 * rise[0], rel=0.05)


def test_fast_keeps_every_tick(fast: Path) -> None:
    """The very last sample is the laser's last word, out of turn."""
    for topic, (times, _) in read(fast).items():
        if topic not in ("/diagnostics", TEMPERATURE):
            np.testing.assert_allclose(np.diff(times[:-1]), 0.01, atol=1e-9, err_msg=topic)


@pytest.mark.alone
def test_real_time_equals_fast_within_the_sensor_noise(fast: Path, realtime: Path) -> None:
    assert not any(experiment(realtime)["lost"].values())
    for topic, noise in NOISE.items():
        (fast_s, fast_values), (real_s, real_values) = (_since_light(bag, topic) for bag in (fast, realtime))
        inside = (real_s > -0.4) & (real_s < 5.0)
        difference = real_values[inside] - np.interp(real_s[inside], fast_s, fast_values)
        assert np.sqrt(np.mean(difference**2)) < 3 * noise, topic
        assert abs(np.mean(difference)) < noise, topic


def _since_light(bag: Path, topic: str) -> tuple[np.ndarray, np.ndarray]:
    """Times since the light came on, and values; a temperature by its own stamp."""
    power_s, power = values(bag, POWER)
    light_s = power_s[np.flatnonzero(power)[0]]
    times, numbers = values(bag, topic)
    if topic == TEMPERATURE:
        stamps = [message.header.stamp for message in read(bag)[topic][1]]
        times = np.array([stamp.sec + stamp.nanosec * 1e-9 for stamp in stamps])
    return times - light_s, numbers


@pytest.mark.alone
def test_real_time_begins_and_ends_dark_with_everything_heard(realtime: Path) -> None:
    times, power = values(realtime, POWER)
    assert power[0] == 0 and power[-1] == 0
    began = times[np.flatnonzero(power)[0]]
    assert all(read(realtime)[topic][0][0] < began for topic in (POWER, TEMPERATURE, DISPLACEMENT))


@pytest.mark.alone
def test_ctrl_c_keeps_what_was_recorded(tmp_path: Path) -> None:
    with started("run", PROTOCOL, "--out", str(tmp_path / "bag")) as run:
        until(lambda: _light_is_on(tmp_path / "bag"), "light")
        run.process.send_signal(signal.SIGINT)
        _, errors = run.process.communicate(timeout=30)
        assert run.process.returncode == 130
        assert "Traceback" not in errors and str(tmp_path / "bag") in errors
        assert run.processes() == []
    assert experiment(tmp_path / "bag")["outcome"] == "interrupted"
    _, power = values(tmp_path / "bag", POWER)
    assert power.max() == 1.5 and power[-1] == 0


def test_ctrl_c_keeps_a_fast_run_too(tmp_path: Path) -> None:
    with started("run", "hold:power=1,hold=3600,rest=0", "--fast", "--out", str(tmp_path / "bag")) as run:
        until(lambda: _light_is_on(tmp_path / "bag"), "light")
        run.process.send_signal(signal.SIGINT)
        _, errors = run.process.communicate(timeout=30)
        assert run.process.returncode == 130 and "Traceback" not in errors
    assert experiment(tmp_path / "bag")["outcome"] == "interrupted"
    assert values(tmp_path / "bag", POWER)[1].max() == 1.0


@pytest.mark.alone
def test_nodes_do_not_outlive_a_killed_run(tmp_path: Path) -> None:
    with started("run", PROTOCOL, "--out", str(tmp_path / "bag")) as run:
        until(lambda: _light_is_on(tmp_path / "bag"), "light")
        run.process.kill()
        until(lambda: not run.processes(), "the end of the nodes")
    assert values(tmp_path / "bag", POWER)[1].max() == 1.5


@pytest.mark.alone
def test_a_node_that_dies_is_named_and_the_bag_is_finished(tmp_path: Path) -> None:
    with started("run", PROTOCOL, "--out", str(tmp_path / "bag")) as run:
        until(lambda: _light_is_on(tmp_path / "bag"), "light")
        for pid in run.processes("lce_drivers.simulation.simulator_node"):
            os.kill(pid, signal.SIGKILL)
        _, errors = run.process.communicate(timeout=30)
        assert run.process.returncode == 1
        assert "lce: simulator ended early (killed by SIGKILL)" in errors
        assert run.processes() == []
    assert experiment(tmp_path / "bag")["outcome"] == "failed"
    _, power = values(tmp_path / "bag", POWER)
    assert power.max() == 1.5 and power[-1] == 0


@pytest.mark.parametrize("mode", [["--fast"], pytest.param([], marks=pytest.mark.alone)], ids=["fast", "realtime"])
def test_a_fault_of_the_laser_ends_a_run(tmp_path: Path, mode: list[str]) -> None:
    done = lce("run", "hold:power=2,hold=60,rest=0", "--set", "lumped.gain=300", "--out", str(tmp_path / "bag"), *mode)
    assert done.returncode == 1
    assert "experiment_player: stopped by the laser: fault: the strip is" in done.stderr.splitlines()[-1]
    assert experiment(tmp_path / "bag")["outcome"] == "failed"
    times, power = values(tmp_path / "bag", POWER)
    assert power.max() == 2.0 and power[-1] == 0 and np.ptp(times) < 30.0


def _light_is_on(bag: Path) -> bool:
    """Whether a recording under way holds a second and more of commands; dark time is half a second."""
    file = bag / "recording.mcap"
    data = file.read_bytes() if file.exists() else b""
    begin = data.find(b"/lce/laser/power_command")
    return begin > 0 and len(data) - begin > 60_000


def test_a_campaign_is_one_bag_for_each_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    parts = ("pulse:th=1,rest=1", "stairs:steps=2,hold=1,rest=1")
    monkeypatch.setitem(protocols.CAMPAIGNS, "two", parts)
    monkeypatch.setattr(recording.signal, "signal", lambda *_: None)
    assert cli.main(["run", "two", "--fast", "--seed", "7", "--out", str(tmp_path / "two")]) == 0
    bags = [Path(line) for line in capfd.readouterr().out.splitlines()]
    assert bags == [tmp_path / "two" / "pulse_th1_rest1", tmp_path / "two" / "stairs_steps2_hold1_rest1"]
    assert [(experiment(bag)["protocol"], experiment(bag)["seed"]) for bag in bags] == [
        (parts[0], 7),
        (parts[1], 8),
    ]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["puls"], "unknown protocol 'puls' (did you mean 'pulse'?); it is one of pulse, stairs"),
        (["pulse:amp=1"], "asks for 2.5 W; the laser gives 2 W"),
        (["none.csv"], "none.csv: No such file"),
        (["pulse", "--set", "lumped.gain=1e9"], "lumped.gain: 1e+09"),
        (["pulse", "--set", "lumped.gain=nan"], "lumped.gain"),
        (["pulse", "--set", "lumped.gian=3"], "unknown parameter 'lumped.gian'"),
        (["pulse", "--set", "lumped.gain"], "not of the form term.param=value"),
        (["pulse", "--model", "none.yaml"], "none.yaml"),
        (["pulse", "--seed", "-1"], "seed -1: must be 0 or more"),
    ],
)
def test_a_bad_request_is_one_line_and_nothing_is_written(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    words: list[str],
    said: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(recording.signal, "signal", lambda *_: None)
    assert cli.main(["run", *words, "--out", "bag"]) == 1
    out, errors = capsys.readouterr()
    assert out == "" and errors.startswith("lce: ") and errors.count("\n") == 1 and said in errors
    assert list(tmp_path.iterdir()) == []


def test_a_recording_is_never_overwritten(fast: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = {path.name: path.read_bytes() for path in fast.iterdir()}
    done = lce("run", PROTOCOL, "--fast", "--out", str(fast))
    assert done.returncode == 1 and "exists already" in done.stderr
    assert {path.name: path.read_bytes() for path in fast.iterdir()} == before
