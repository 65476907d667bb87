# SPDX-License-Identifier: Apache-2.0
"""The use cases without a command line or a page around them: cancelled work, refused options."""

from collections.abc import Callable
from dataclasses import FrozenInstanceError
from pathlib import Path

import numpy as np
import pytest

from lce_app import cluster
from lce_app.errors import ContradictoryOptions
from lce_app.use_cases import compare, control, design, fit, record, simulate
from lce_app.use_cases.loading import load_runs_and_tests
from lce_data.errors import Cancelled, LceError
from lce_data.progress import CancelToken
from lce_model import default_model, load_model, save_model


@pytest.fixture
def model(tmp_path: Path) -> Path:
    save_model(default_model(), tmp_path / "model.yaml")
    return tmp_path / "model.yaml"


@pytest.fixture
def run(tmp_path: Path, model: Path) -> Path:
    return simulate.simulate(model, "pulse:th=10,rest=20", tmp_path / "run.csv").file


@pytest.mark.parametrize("options", [fit.Options(), record.Options(), control.Options(), design.Options()])
def test_options_are_frozen(options: object) -> None:
    with pytest.raises(FrozenInstanceError):
        options.anything = 1  # type: ignore[attr-defined]


def test_a_run_held_out_has_another_name_than_the_runs_to_learn_from(tmp_path: Path, model: Path) -> None:
    days = [tmp_path / day / "prbs.csv" for day in ("monday", "tuesday")]
    for file, seconds in zip(days, (10, 12), strict=True):
        file.parent.mkdir()
        simulate.simulate(model, f"pulse:th={seconds},rest=20", file)
    (run,), (test,) = load_runs_and_tests(days[:1], days[1:])
    assert (run.name, test.name) == ("monday/prbs", "tuesday/prbs")


def test_a_run_that_is_learnt_from_is_not_held_out(run: Path) -> None:
    copy = run.with_name("copy.csv")
    copy.write_bytes(run.read_bytes())
    with pytest.raises(LceError, match=r"copy\.csv: is held out, and learnt from as .*run\.csv"):
        load_runs_and_tests([run], [copy])


def test_fits_of_runs_of_one_name_are_saved_beside_each_other(tmp_path: Path, model: Path) -> None:
    days = [tmp_path / day / "pulse.csv" for day in ("monday", "tuesday")]
    for file, seconds in zip(days, (10, 12), strict=True):
        file.parent.mkdir()
        simulate.simulate(model, f"pulse:th={seconds},rest=20", file)
    options = fit.Options(per_run=True, judged=False)
    fits = fit.fit(days, tmp_path / "m.yaml", fit.ModelChoice(deformation="none"), options)
    assert [one.file.name for one in fits.models] == ["m-monday-pulse.yaml", "m-tuesday-pulse.yaml"]
    assert all(one.file.exists() for one in fits.models)


def test_a_fit_is_saved_before_anything_is_said_of_it(
    tmp_path: Path, run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(fit, "differing", interrupted)
    with pytest.raises(KeyboardInterrupt):
        fit.fit([run], tmp_path / "m.yaml", fit.ModelChoice(deformation="none"))
    assert load_model(tmp_path / "m.yaml").thermal == "lumped"


def test_a_cancelled_comparison_writes_nothing(tmp_path: Path, run: Path, model: Path) -> None:
    cancel, report = CancelToken(), tmp_path / "compare.html"
    cancel.cancel()
    with pytest.raises(Cancelled):
        compare.compare([run], model, report_file=report, cancel=cancel)
    assert not report.exists()


def test_a_cancelled_fit_keeps_the_best_values_so_far(tmp_path: Path, run: Path) -> None:
    cancel, seen = CancelToken(), []

    def progress(label: str, done: int, total: int, rms: float) -> None:
        seen.append(rms)
        if len(seen) == 3:
            cancel.cancel()

    fits = fit.fit([run], tmp_path / "m.yaml", fit.ModelChoice(deformation="none"), progress=progress, cancel=cancel)
    assert fits.interrupted and len(seen) == 3
    assert load_model(tmp_path / "m.yaml").thermal == "lumped"


def test_a_fit_names_its_files(tmp_path: Path, run: Path) -> None:
    fits = fit.fit([run], tmp_path / "m.yaml", fit.ModelChoice(deformation="none"), fit.Options(per_run=True))
    (fitted,) = fits.models
    assert fitted.file == tmp_path / "m-run.yaml"
    assert load_model(fitted.file) == fitted.result.model
    assert fits.warnings == ()


def test_a_choice_that_contradicts_its_start_is_refused(tmp_path: Path, run: Path, model: Path) -> None:
    choice = fit.ModelChoice(deformation="dynamic", start=model)
    with pytest.raises(ContradictoryOptions, match=r"^deformation dynamic contradicts the start model"):
        fit.fit([run], tmp_path / "m.yaml", choice)


def test_a_simulated_run_is_what_the_sensors_show_without_noise(run: Path, model: Path) -> None:
    table = np.loadtxt(run, delimiter=",", skiprows=1)
    again = simulate.simulate(model, "pulse:th=10,rest=20", run, simulate.Options(overwrite=True)).trajectory
    np.testing.assert_allclose(table[:, 3], again.measured_displacement_m, rtol=1e-8)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: cluster.Cluster("dask"), "^backend dask and the address of a scheduler belong together"),
        (lambda: cluster.Cluster(scheduler="tcp://1.2.3.4:5"), "^scheduler tcp://1.2.3.4:5 and .* belong together"),
        (lambda: cluster.Cluster("cloud"), "'cloud' is not one of threads, dask"),
        (lambda: control.Options(mode="triple"), "'triple' is not one of double, single, model"),
        (lambda: control.Options(hold_s=0.5), r"^hold_s 0.5: must be within \[1, 3600\] s"),
        (lambda: control.Options(seed=-1), "^seed -1: must be 0 or more"),
        (lambda: record.Options(seed=-1), "^seed -1: must be 0 or more"),
        (lambda: record.Options(plant="moon"), "'moon' is not one of simulated, hardware"),
        (
            lambda: record.Options(plant="hardware", fast=True),
            "^plant hardware excludes model, settings, seed and fast",
        ),
    ],
)
def test_options_refuse_what_makes_no_sense(make: Callable[[], object], said: str) -> None:
    with pytest.raises(LceError, match=said):
        make()


@pytest.fixture
def ros2(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A script in place of ros2, which a test writes."""
    file = tmp_path / "ros2"
    file.touch(mode=0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    return file


def test_the_real_bench_is_a_launch_that_ends_with_the_run(tmp_path: Path, ros2: Path) -> None:
    ros2.write_text(
        f'#!/bin/sh\nprintf "%s\\n" "$@" > {tmp_path}/words\n'
        f"mkdir {tmp_path}/out; echo outcome: complete > {tmp_path}/out/experiment.yaml\n"
    )
    reported: list[str] = []
    out, options = tmp_path / "out", record.Options(plant="hardware", conditions={"specimen": "A 7"})
    found = record.record("pulse:th=2,rest=2", out, options, lambda label, *_: reported.append(label))
    assert found.folders == (out,) and set(reported) <= {"recording out"}
    words = (tmp_path / "words").read_text().splitlines()
    assert words == [
        *record.LAUNCH[1:],
        "protocol:=pulse:th=2,rest=2",
        f"out:={out}",
        'conditions:={"specimen": "A 7"}',
    ]


@pytest.mark.parametrize("outcome", ["failed", "interrupted", None])
def test_a_launch_whose_recording_is_not_complete_has_failed(tmp_path: Path, ros2: Path, outcome: str | None) -> None:
    """`ros2 launch` may return 0 all the same."""
    line = f"outcome: {outcome}" if outcome else "protocol: pulse"
    ros2.write_text(f"#!/bin/sh\nmkdir {tmp_path}/out; echo '{line}' > {tmp_path}/out/experiment.yaml\n")
    with pytest.raises(LceError, match=f"out: the run is {outcome or 'not finished'}"):
        record.record("pulse:th=2,rest=2", tmp_path / "out", record.Options(plant="hardware"))


@pytest.mark.parametrize(
    ("printed", "said"),
    [
        (
            "[laser-1] labjack: no answer\n[ERROR] [laser-1]: process has died [pid 1, exit code 1, cmd 'laser'].\n"
            "[ERROR] [launch]: Caught exception in launch (see debug for traceback): laser-1 ended with status 1\n"
            "[recorder-4] last words\n[INFO] [recorder-4]: process has finished cleanly [pid 4]",
            "laser-1 ended with status 1: labjack: no answer",
        ),
        (
            "[ERROR] [launch]: Caught exception in launch: recorder-4 ended with status -9",
            "recorder-4 ended with status -9",
        ),
        ("Package 'lce_bringup' not found", "the launch failed: Package 'lce_bringup' not found"),
    ],
)
def test_a_launch_that_failed_is_told_in_the_words_of_the_node(
    tmp_path: Path, ros2: Path, printed: str, said: str
) -> None:
    ros2.write_text(f'#!/bin/sh\ncat >&2 <<"END"\n{printed}\nEND\nexit 1\n')
    with pytest.raises(LceError) as caught:
        record.record("pulse:th=2,rest=2", tmp_path / "out", record.Options(plant="hardware"))
    assert str(caught.value) == said


def test_the_real_laser_is_armed_by_a_service_call_whose_refusal_is_told(tmp_path: Path, ros2: Path) -> None:
    answer = "std_srvs.srv.SetBool_Response(success={}, message='{}')"
    ros2.write_text(
        f'#!/bin/sh\nprintf "%s\\n" $ROS_DOMAIN_ID "$@" > {tmp_path}/words\necho "{answer.format(True, "armed")}"\n'
    )
    record.arm_laser(7)
    words = (tmp_path / "words").read_text().splitlines()
    assert words == ["7", "service", "call", "/lce/laser/arm", "std_srvs/srv/SetBool", "{data: true}"]
    ros2.write_text(f'#!/bin/sh\necho "{answer.format(False, "not armed: 1 W are commanded")}"\n')
    with pytest.raises(LceError, match=r"the laser is not armed: .*1 W are commanded"):
        record.arm_laser(7)
