# SPDX-License-Identifier: Apache-2.0
"""Runs prepared by recipes: what each step keeps, what it refuses, and the files."""

from pathlib import Path

import numpy as np
import pytest

from lce_data.channels import DISPLACEMENT, POWER, TEMPERATURE
from lce_data.errors import LceError
from lce_data.preparing.prepared_run import prepare, read_back, write_prepared
from lce_data.preparing.recipe import Recipe, prepared, read_recipe, write_recipe
from lce_data.preparing.steps import Cut, Detrend, Merge, Resample
from lce_data.read_runs import read_recording, read_run
from lce_data.run import Run, Series
from lce_data.run_csv import write_run_csv

TIME = np.arange(0.0, 20.0, 0.01)
LIGHT = np.where((TIME > 2.0) & (TIME < 12.0), 1.5, 0.0)


def run(name: str = "pulse") -> Run:
    """Power and displacement at 100 Hz, temperature at 10 Hz; everything at rest up to 2 s."""
    warm = np.clip(TIME - 2.0, 0.0, 10.0)
    return Run.of(
        name,
        power=Series(TIME, LIGHT),
        temperature=Series(TIME[::10], 296.0 + 2.0 * warm[::10]),
        displacement=Series(TIME, 1e-4 * warm),
    )


def after(*steps: Cut | Detrend | Resample | Merge, of: Run | None = None, **others: Run) -> Run:
    return prepared(of or run(), steps, others)[0]


def test_a_cut_leaves_the_power_because_the_strip_remembers() -> None:
    found = after(Cut(5.0, 8.0))
    assert found.power == run().power or np.array_equal(found.series[POWER].value, LIGHT)
    for channel in (TEMPERATURE, DISPLACEMENT):
        time_s = found.series[channel].time_s
        assert not ((time_s >= 5.0) & (time_s <= 8.0)).any() and time_s[-1] > 19.0
    alone = after(Cut(5.0, 8.0, ("displacement",)))
    assert alone.series[TEMPERATURE].time_s.size == 200


def test_a_cut_tail_takes_the_power_with_it_unless_a_sensor_goes_on() -> None:
    assert after(Cut(10.0, 20.0)).series[POWER].time_s[-1] < 10.0
    assert after(Cut(10.0, 20.0, ("displacement",))).series[POWER].time_s[-1] > 19.0


def test_a_cut_may_not_take_the_temperature_that_a_model_starts_with() -> None:
    assert after(Cut(0.0, 1.5)).series[TEMPERATURE].time_s[0] == pytest.approx(1.6)
    with pytest.raises(
        LceError, match=r"pulse: step 1, cut all sensors from 0 to 3 s: a model starts with the temp.*after 2.01 s"
    ):
        after(Cut(0.0, 3.0))
    assert after(Cut(0.0, 3.0, ("displacement",))).series[DISPLACEMENT].time_s[0] > 3.0


def test_a_line_fitted_at_rest_takes_a_drift_off_and_says_what_goes_with_it() -> None:
    straight = run()
    drift = 3e-6 * TIME + 2e-5
    drifting = straight.with_series(
        DISPLACEMENT, Series(TIME, 1e-4 * np.clip(TIME - 2.0, 0, 4) * (TIME < 12.0) + drift)
    )
    step = Detrend("displacement", "line", ((0.0, 2.0), (13.0, 20.0)), level=0.0)
    found, said = prepared(drifting, (step,), {})
    assert np.allclose(found.series[DISPLACEMENT].value[TIME < 2.0], 0.0, atol=1e-9)
    assert np.allclose(found.series[DISPLACEMENT].value[TIME > 13.0], 0.0, atol=1e-9)
    assert "displacement_drift" in said[0] and len(said) == 1
    _, far = prepared(drifting, (Detrend("displacement", "line", ((0.0, 2.0),)),), {})
    assert "far beyond" in far[1]


def test_an_offset_shifts_to_a_level_in_the_unit_of_the_files() -> None:
    found = after(Detrend("temperature", "offset", ((0.0, 2.0),), level=22.5))
    assert np.allclose(found.series[TEMPERATURE].value[:20], 273.15 + 22.5)
    assert np.ptp(found.series[TEMPERATURE].value) == pytest.approx(np.ptp(run().series[TEMPERATURE].value))


def test_means_keep_the_energy_of_the_light_and_leave_slow_channels_alone() -> None:
    found = after(Resample(0.03))
    power = found.series[POWER]
    energy = float(np.sum(np.diff(power.time_s) * power.value[:-1]))
    assert energy == pytest.approx(float(np.sum(np.diff(TIME) * LIGHT[:-1])), rel=1e-12)
    assert power.time_s.size < 700 and found.series[TEMPERATURE].time_s.size == 200
    ramp = found.series[DISPLACEMENT]
    inside = (ramp.time_s > 3.0) & (ramp.time_s < 11.0)
    assert np.allclose(ramp.value[inside], 1e-4 * (ramp.time_s[inside] - 2.0), atol=1e-12)  # means lie on the line


def test_means_are_not_folded() -> None:
    hum = run().with_series(DISPLACEMENT, Series(TIME, 1e-5 * np.sin(2.0 * np.pi * 49.0 * TIME)))
    assert np.abs(after(Resample(0.5), of=hum).series[DISPLACEMENT].value).max() < 1e-6


def test_two_files_of_one_experiment_are_joined_with_their_offset() -> None:
    whole = run()
    late = Run.of("camera", temperature=Series(TIME[100::10] - 1.0, whole.series[TEMPERATURE].value[10:]))
    found = after(Merge("camera.csv", 1.0), of=whole.with_series(TEMPERATURE, None), **{"camera.csv": late})
    assert np.allclose(found.series[TEMPERATURE].time_s, TIME[100::10])
    light = Run.of("laser", power=Series(TIME, LIGHT))
    sensors = whole.with_series(POWER, None)
    assert after(Merge("laser.csv", 0.5), of=sensors, **{"laser.csv": light}).series[DISPLACEMENT].time_s[0] == -0.5


def test_a_recording_that_was_continued_is_joined_behind_the_gap() -> None:
    found = after(Merge("next.csv", 30.0), **{"next.csv": run("next")})
    assert found.series[POWER].time_s.size == 2 * TIME.size and found.series[POWER].time_s[-1] == pytest.approx(49.99)
    with pytest.raises(LceError, match=r"both have power between 10 and 19.99 s; cut one, or begin it elsewhere"):
        after(Merge("next.csv", 10.0), **{"next.csv": run("next")})


@pytest.mark.parametrize(
    ("step", "why"),
    [
        (Cut(30.0, 40.0), "no sample lies there"),
        (Resample(0.001), "no channel was recorded faster than every 0.01 s"),
        (Detrend("temperature", "line", ((0.01, 0.02),)), "0 samples of temperature are at rest there"),
    ],
)
def test_a_step_without_meaning_is_refused_with_its_number(step: Cut, why: str) -> None:
    with pytest.raises(LceError, match=rf"^pulse: step 1, .*: {why}"):
        after(step)


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ("{step: cut, begin_s: 5.0, end_s: 4.0}", "the interval from 5 to 4 s ends before it begins"),
        ("{step: cut, begin_s: .nan, end_s: 4.0}", "nan is not a finite number"),
        ("{step: cut, begin_s: 1, end_s: 4, channels: [temprature]}", r"did you mean 'temperature'\?"),
        ("{step: cut, begin_s: 1, end: 4}", "end"),
        ("{step: grind}", "grind"),
        ("{step: resample, dt_s: -1.0}", "dt_s is -1.0"),
        ("{step: detrend, channel: displacement, order: offset}", "an offset needs the level"),
        ("{step: merge}", "file"),
    ],
)
def test_a_recipe_file_says_what_is_wrong_in_it(tmp_path: Path, line: str, why: str) -> None:
    file = tmp_path / "recipe.yaml"
    file.write_text(f"format: lce-recipe-1\nsteps:\n- {line}\n")
    with pytest.raises(LceError, match=rf"recipe\.yaml: .*{why}") as error:
        read_recipe(file)
    assert "\n" not in str(error.value)


RECIPE: Recipe = (
    Merge("parts/camera.csv", 0.5),
    Cut(5.0, 6.0, ("temperature",)),
    Detrend("displacement", "line", ((0.0, 2.0), (15.0, 20.0)), 0.0),
    Resample(0.02),
)


def test_a_recipe_is_read_as_it_was_written(tmp_path: Path) -> None:
    write_recipe(tmp_path / "recipe.yaml", RECIPE)
    assert read_recipe(tmp_path / "recipe.yaml") == RECIPE


def written(folder: Path, name: str, found: Run) -> Path:
    file = folder / name
    file.parent.mkdir(exist_ok=True)
    write_run_csv(file, *found.aligned())
    return file


def test_what_is_written_is_the_run_and_where_it_came_from(tmp_path: Path) -> None:
    whole = run()
    file = written(tmp_path, "pulse.csv", whole.with_series(TEMPERATURE, None))
    written(tmp_path, "parts/camera.csv", Run.of("camera", temperature=whole.series[TEMPERATURE]))
    before = file.read_bytes()
    found = prepare(read_recording(file), RECIPE)
    out = write_prepared(found, RECIPE, tmp_path / "made" / "pulse.csv")
    again = read_back(found, out)
    for channel, series in found.run.series.items():
        assert np.allclose(again.series[channel].value, series.value, rtol=1e-8, atol=1e-6)
    assert (again.name, file.read_bytes()) == ("pulse", before)
    origin = read_run(out).experiment.other["prepared"]
    assert origin["file"] == "pulse.csv" and origin["sha256"] == found.recording.sha256
    assert read_recipe(out.with_suffix(".recipe.yaml")) == RECIPE
    with pytest.raises(LceError, match="is the recording"):
        write_prepared(found, RECIPE, file)


def test_a_merge_stays_in_the_folder_that_it_is_held_in(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    file = written(tmp_path, "in/pulse.csv", run().with_series(TEMPERATURE, None))
    written(tmp_path, "out.csv", Run.of("out", temperature=run().series[TEMPERATURE]))
    (tmp_path / "in" / "link.csv").symlink_to(tmp_path / "out.csv")
    for name in ("../out.csv", "link.csv", str(tmp_path / "out.csv")):
        assert TEMPERATURE in prepare(read_recording(file), (Merge(name),)).run.series
        with pytest.raises(LceError, match="not in the folder"):
            prepare(read_recording(file), (Merge(name),), within=file.parent)


def test_what_is_left_must_be_a_run(tmp_path: Path) -> None:
    file = written(tmp_path, "pulse.csv", run().with_series(DISPLACEMENT, None))
    with pytest.raises(LceError, match="temperature has 6 samples"):
        prepare(read_recording(file), (Cut(0.6, 20.0),))
