# SPDX-License-Identifier: Apache-2.0
"""Identification finds what was put in, says what it cannot find, and refuses what cannot be fitted."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from lce_analysis.identification import fit, fit_each
from lce_analysis.identification.identify import check_runs, rough_fit
from lce_analysis.identification.stages import thermal_stage
from lce_analysis.options import FitOptions
from lce_data.channels import DISPLACEMENT, POWER, TEMPERATURE
from lce_data.errors import LceError
from lce_data.experiment_file import Conditions, Experiment
from lce_data.progress import Progress, silent
from lce_data.run import Run, Series
from lce_model import Model, default_model, simulate

HEATER = default_model("lumped", "none").set({"lumped.tau": 31.0, "lumped.gain": 22.0, "ambient.t_env": 296.0})


def runs_of(strip: Model, seed: int, count: int = 2, duration_s: float = 90.0) -> list[Run]:
    """Runs with steps of different lengths, the sensors at 10 Hz, white noise."""
    found = []
    for k in range(count):
        rng = np.random.default_rng((seed, k))
        time = np.arange(0.0, duration_s, 0.02)
        power = np.where((time > 2.0) & (time < 25.0 + 12.0 * k), 1.2 + 0.4 * k, 0.0)
        made = simulate(strip, time, power)
        seen = slice(None, None, 5)
        noisy = made.temperature_k[seen] + 0.06 * rng.standard_normal(time[seen].size)
        displacement = None
        if strip.deformation != "none":
            displacement = Series(time, made.displacement_m + 4e-6 * rng.standard_normal(time.size))
        temperature = Series(time[seen], noisy)
        found.append(Run.of(f"run-{k}", Series(time, power), temperature, displacement, f"{k}" * 64))
    return found


def test_thermal_parameters_are_found_within_their_standard_errors() -> None:
    z = []
    for seed in range(16):
        found = fit(default_model("lumped", "none"), runs_of(HEATER, seed))
        for value in found.model.values:
            if not value.fixed:
                assert value.standard_error is not None
                z.append((value.value - HEATER[value.key]) / value.standard_error)
    assert np.abs(z).max() < 4.0
    assert 0.5 < np.std(z) < 1.4  # neither boastful nor shy


def test_a_joint_fit_ends_at_the_noise_and_finds_what_the_data_determine() -> None:
    strip = default_model().set({"lumped.tau": 20.0, "equilibrium.t_star_r": 307.0, "stretch_law.alpha": 2.1})
    runs = runs_of(strip, seed=1)
    found = fit(default_model(), runs)
    assert found.identifiability is not None
    for value in found.model.values:
        if value.determined and not value.fixed:
            assert value.standard_error is not None
            assert abs(value.value - strip[value.key]) < 4.0 * value.standard_error, value.key
    for entry, run in zip(found.model.fit["runs"], runs, strict=True):
        assert run.temperature is not None and run.displacement is not None
        assert entry["temperature_nrmse"] == pytest.approx(0.06 / np.std(run.temperature.value), rel=0.06)
        assert entry["displacement_nrmse"] == pytest.approx(4e-6 / np.std(run.displacement.value), rel=0.06)
    ratios = {"only the ratio equilibrium.a3_r/equilibrium.a1_r", "only the ratio equilibrium.a1_r/equilibrium.a3_r"}
    assert ratios & {s.removesuffix(" is determined") for s in found.identifiability.sentences}


def test_without_rounds_of_the_joint_fit_each_stage_ends_at_the_noise_by_itself() -> None:
    runs, labels = runs_of(default_model(), seed=3), set[str]()
    found = fit(default_model(), runs, FitOptions(reweighted=0), lambda label, *_: labels.add(label))
    assert {"temperature", "equilibrium model, all samples"} <= labels and "both stages" not in labels
    for entry, run in zip(found.model.fit["runs"], runs, strict=True):
        assert run.temperature is not None and run.displacement is not None
        assert entry["temperature_nrmse"] == pytest.approx(0.06 / np.std(run.temperature.value), rel=0.06)
        assert entry["displacement_nrmse"] == pytest.approx(4e-6 / np.std(run.displacement.value), rel=0.1)


def test_without_time_constants_the_heat_begins_where_it_stands() -> None:
    runs = runs_of(HEATER, seed=0)
    everywhere = fit(HEATER, runs)
    there = fit(everywhere.model, runs, FitOptions(time_constants=()))
    np.testing.assert_allclose(there.model.vector, everywhere.model.vector, rtol=1e-4)
    assert there.evaluations < 0.25 * everywhere.evaluations


def test_the_same_seed_gives_the_same_model() -> None:
    """But for rounding, which was seen to change with where in memory the arrays lie."""
    runs = runs_of(default_model(), seed=2, count=1, duration_s=50.0)
    one, other = (fit(default_model(), runs, FitOptions(seed=5)).model for _ in range(2))
    np.testing.assert_allclose(one.vector, other.vector, rtol=1e-6)


def test_fixed_and_held_parameters_stay_where_they_are_told_to() -> None:
    asked = default_model("lumped", "none").set({"lumped.tau": 30.0}).fix(["lumped.tau"])
    asked = asked.hold({"lumped.gain": (20.0, 21.5)})
    found = fit(asked, runs_of(HEATER, seed=0)).model
    assert found["lumped.tau"] == 30.0
    assert 20.0 <= found["lumped.gain"] <= 21.5


def test_bounds_that_leave_out_a_default_value_are_kept() -> None:
    strip = default_model("lumped", "equilibrium")
    lowest = strip["equilibrium.t_star_r"] + 1.0
    start = strip.hold({"equilibrium.t_star_r": (lowest, lowest + 30.0)})
    assert rough_fit(start, runs_of(strip, seed=6), FitOptions(starts=2), silent)["equilibrium.t_star_r"] >= lowest


def test_one_parameter_set_for_each_run() -> None:
    other = HEATER.set({"lumped.tau": 40.0})
    first, second = fit_each(default_model("lumped", "none"), [*runs_of(HEATER, 0, 1), *runs_of(other, 1, 1)])
    assert first.model["lumped.tau"] == pytest.approx(31.0, rel=0.02)
    assert second.model["lumped.tau"] == pytest.approx(40.0, rel=0.02)


def test_ctrl_c_keeps_the_fits_of_the_runs_before() -> None:
    def interrupt(label: str, *_: float) -> None:
        if label.startswith("run-1"):
            raise KeyboardInterrupt

    found = fit_each(HEATER, runs_of(HEATER, seed=3, count=3), progress=interrupt)
    assert len(found) in (1, 2) and not found[0].interrupted


def test_a_run_that_begins_under_power_has_a_step_in_it() -> None:
    (run,) = runs_of(HEATER, 0, 1)
    time, noise = np.arange(0.0, 90.0, 0.1), 0.06 * np.random.default_rng(0).standard_normal(900)
    lit = run.with_series(POWER, Series(time, np.full_like(time, 0.8)))
    warming = Series(time, simulate(HEATER, time, np.full_like(time, 0.8)).temperature_k + noise)
    found = fit(default_model("lumped", "none"), [lit.with_series(TEMPERATURE, warming)])
    assert found.model["lumped.tau"] == pytest.approx(31.0, rel=0.02)
    with pytest.raises(LceError, match=r"run-0: the laser power is 0\.8 W throughout; nothing can be identified"):
        fit(default_model("lumped", "none"), [lit.with_series(TEMPERATURE, Series(time, 320.0 + noise))])


def impatient() -> Progress:
    """A progress that is interrupted, as by Ctrl-C, at its 25th call."""
    calls = 0

    def progress(label: str, done: int, total: int, rms: float) -> None:
        nonlocal calls
        calls += 1
        if calls == 25:
            raise KeyboardInterrupt

    return progress


def test_ctrl_c_leaves_the_best_so_far() -> None:
    found = fit(default_model(), runs_of(default_model(), 0), progress=impatient())
    assert found.interrupted
    assert found.model.fit["interrupted"] is True
    assert found.identifiability is None
    assert all(value.standard_error is None for value in found.model.values)


def test_ctrl_c_ends_a_rough_fit() -> None:
    with pytest.raises(KeyboardInterrupt):
        rough_fit(default_model(), runs_of(default_model(), 0), FitOptions(), impatient())


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda runs: [], "no runs to fit"),
        (lambda runs: [r.with_series(DISPLACEMENT, None) for r in runs], "no run has a displacement"),
        (
            lambda runs: [
                replace(r, experiment=Experiment(conditions=Conditions(strip_length_m=x)))
                for r, x in zip(runs, (0.01, 0.02), strict=True)
            ],
            r"strips of different length .*run-0: 0\.01 m, run-1: 0\.02 m",
        ),
        (
            lambda runs: [runs[0], runs[1].with_series(POWER, Series(runs[1].power.time_s, 0.0 * runs[1].power.value))],
            r"run-1: the laser power is 0 W throughout",
        ),
    ],
)
def test_what_cannot_be_fitted(change: Callable[[list[Run]], list[Run]], told: str) -> None:
    with pytest.raises(LceError, match=told):
        fit(default_model(), change(runs_of(default_model(), 0, duration_s=30.0)))


def test_the_thermal_stage_is_fitted_alone_unless_the_strip_acts_back_on_it() -> None:
    model = default_model("lumped", "kinetic", ("natural_convection", "camera_lag", "creep"))
    alone = thermal_stage(model)
    assert (alone.deformation, alone.effects) == ("none", ("natural_convection", "camera_lag"))
    heat = [v.key for v in model.values if v.term in ("ambient", "natural_convection", "lumped")]
    assert [v.key for v in alone.values][: len(heat)] == [v.key for v in model.values][: len(heat)] == heat
    acts_back = default_model("lumped", "kinetic", ("order_dependent_absorption",))
    assert thermal_stage(acts_back) is acts_back


def test_a_sensor_that_is_stuck_is_named_before_anything_is_fitted(recorded: Callable[..., Run]) -> None:
    run = recorded("stuck")
    assert run.displacement is not None
    stuck = run.with_series(DISPLACEMENT, Series(run.displacement.time_s, np.full_like(run.displacement.value, 1e-3)))
    with pytest.raises(LceError, match=r"^stuck: the displacement is 1 mm throughout"):
        fit(default_model(), [stuck])
    check_runs(default_model("lumped", "none"), [stuck])
