# SPDX-License-Identifier: Apache-2.0
"""What `lce fit` says of its own result, and bounds that a user widens; the heater is solved by scipy."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from scipy.signal import lsim

from lce_app.cli.main import main as lce
from lce_app.use_cases.fit import ModelChoice, choose_model, fit
from lce_data.experiment_file import Conditions, Experiment
from lce_data.run import Run, Series
from lce_model import load_model

LAG_S = 30.0


@pytest.fixture
def late(tmp_path: Path) -> Path:
    """A heater whose sensor is 30 s late."""
    time = np.arange(0.0, 900.0, 2.0)
    power = np.where((time // 150.0) % 2 == 0, 0.6, 0.1)
    _, rise, _ = lsim(([60.0], [100.0 * LAG_S, 100.0 + LAG_S, 1.0]), power, time, interp=False)
    temperature = 23.0 + rise + 0.05 * np.random.default_rng(1).standard_normal(time.size)
    path = tmp_path / "late.csv"
    table = np.column_stack([time, power, temperature])
    np.savetxt(path, table, fmt="%.6f", delimiter=",", header="time_s,power_w,temperature_c", comments="")
    return path


def fitted(late: Path, *options: str) -> dict[str, object]:
    """The record of the fit with these options."""
    out = late.with_suffix(".yaml")
    assert lce(["fit", str(late), "--deformation", "none", "--out", str(out), *options]) == 0
    return dict(yaml.safe_load(out.read_text(encoding="utf-8")))


@pytest.mark.slow
def test_a_fit_says_what_it_does_not_describe_and_what_would(late: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model = fitted(late)
    told = capsys.readouterr().out
    assert "This model does not describe the temperature" in told
    assert "lumped + second_mass does better: --thermal lumped --effect second_mass." in told
    record = model["fit"]
    assert isinstance(record, dict) and record["not_described"][0]["better"] == "lumped + second_mass"


def test_a_fit_that_describes_its_data_says_nothing(late: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model = fitted(late, "--effect", "second_mass")
    told = capsys.readouterr().out
    assert "does not describe" not in told and "At a bound" not in told
    record = model["fit"]
    assert isinstance(record, dict) and (record["at_bounds"], record["not_described"]) == ([], [])


def test_a_bound_is_told_widened_and_kept(late: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lagging = ("--effect", "camera_lag", "--fix", "camera_lag.delay")
    fitted(late, *lagging, "--bounds", "camera_lag.tau=0,10")
    told = capsys.readouterr().out
    assert "- camera_lag.tau is at its upper bound, 10 s; the data want 30 s" in told
    assert "--bounds camera_lag.tau=0,100" in told
    model = fitted(late, *lagging, "--hold", "camera_lag.tau=0,100")
    assert "At a bound" not in capsys.readouterr().out
    parameters = model["parameters"]
    assert isinstance(parameters, dict)
    entry = parameters["camera_lag"]["tau"]
    assert entry["bounds"] == [0.0, 100.0]
    assert entry["value"] == pytest.approx(LAG_S, abs=1.0)


def test_ctrl_c_ends_the_comparison_and_leaves_the_fit(late: Path) -> None:
    out = late.with_suffix(".yaml")

    def stop_once_the_file_stands(label: str, done: int, total: int, rms: float) -> None:
        if out.exists():
            raise KeyboardInterrupt

    choice = ModelChoice(deformation="none")
    fits = fit([late], out, choice, progress=stop_once_the_file_stands)
    (fitted,) = fits.models
    assert not fits.interrupted and fitted.judgements == ()
    assert load_model(out)["lumped.tau"] == fitted.result.model["lumped.tau"]
    assert "not_described" not in load_model(out).fit


@pytest.mark.parametrize(
    ("option", "message"),
    [
        ("lumped.tau=1", "--bounds lumped.tau=1: expected TERM.PARAM=LOWER,UPPER"),
        ("lumped.tau=-1,5", "lumped.tau: the lower bound, -1 s, must be above 0"),
        ("lumped.tua=1,5", "unknown parameter 'lumped.tua'"),
    ],
)
def test_bounds_that_cannot_be_are_one_line(
    late: Path, option: str, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    out = str(late.with_suffix(".yaml"))
    assert lce(["fit", str(late), "--deformation", "none", "--out", out, "--bounds", option]) == 1
    assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("lengths", "settings", "length_m", "warned"),
    [
        ((0.1, None), {}, 0.1, False),
        ((0.1, 0.1), {"strip.length": 0.02}, 0.02, False),
        ((None, None), {}, 0.01, True),
        ((None, None), {"strip.length": 0.02}, 0.02, False),
    ],
    ids=["of a run", "as asked for", "of nobody", "as asked for, of nobody"],
)
def test_a_strip_is_as_long_as_the_runs_say(
    lengths: tuple[float | None, ...], settings: dict[str, float], length_m: float, warned: bool
) -> None:
    series = Series(np.arange(3.0), np.zeros(3))
    runs = [
        replace(
            Run.of(f"{i}", series, series, series, sha256=f"{i}"),
            experiment=Experiment(conditions=Conditions(strip_length_m=length)),
        )
        for i, length in enumerate(lengths)
    ]
    model, warnings = choose_model(ModelChoice(settings=settings), runs)
    assert model["strip.length"] == length_m
    sentence = "no run says how long its strip is: fitting one of 0.01 m (--set strip.length=METRES)"
    assert warnings == ((sentence,) if warned else ())
