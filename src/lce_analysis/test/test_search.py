# SPDX-License-Identifier: Apache-2.0
"""The search takes back what it has accepted, in any order."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from lce_analysis import DiagnoseOptions, FitOptions
from lce_analysis.diagnosis import chain
from lce_analysis.diagnosis.accepted import VariationStep
from lce_analysis.diagnosis.looking_back import (
    _is_at_a_bound,
    _without_difference,
    keep_what_explains,
    take_back_refuted,
)
from lce_analysis.diagnosis.search import Search
from lce_analysis.diagnosis.stage_problem import Data, StagedFit
from lce_analysis.diagnosis.variation import _refitted, variation_trial
from lce_data.channels import DISPLACEMENT, TEMPERATURE
from lce_data.progress import silent
from lce_data.run import Run, Series
from lce_model import Model, default_model, simulate
from lce_model.effects import find

HEATER = default_model("lumped", "none")


def heater(name: str, gain: float, ambient_k: float, seed: int, tau_s: float = 12.0) -> Run:
    """A run of 60 s of dT/dt = (K P - (T - T_env))/τ, solved exactly for a power held over 0.1 s."""
    time = np.arange(0.0, 60.0, 0.1)
    power = np.where(time % 30.0 > 5.0, 1.2, 0.2)
    kelvin = [ambient_k]
    for watt in power[:-1]:
        steady = ambient_k + gain * watt
        kelvin.append(steady + (kelvin[-1] - steady) * float(np.exp(-0.1 / tau_s)))
    noise = 0.05 * np.random.default_rng(seed).standard_normal(time.size)
    return Run.of(name, Series(time, power), Series(time, np.array(kelvin) + noise), sha256=name)


def test_what_differs_is_not_refitted_where_it_explains_nothing() -> None:
    """A wave is no other gain or ambient temperature, though these would take a little of it."""
    runs = [heater(f"day-{i}", 40.0, 296.0, i) for i in range(4)]
    for i, run in enumerate(runs):
        run.series[TEMPERATURE].value[:] += 0.5 * np.sin(0.5 * run.series[TEMPERATURE].time_s + i)
    search = Search(HEATER, runs, (), (), DiagnoseOptions(), silent)
    refits: list[str] = []
    found = variation_trial(
        search.present.heat[0], search.left_out, search.options, lambda label, *_: refits.append(label)
    )
    assert found is None and refits == []


def test_a_parameter_at_its_bound_promises_nothing_in_the_name_of_an_effect() -> None:
    """The gain is 50 K/W and may be 40: whatever lets it go on would explain all, and no refit does."""
    runs = [heater(f"day-{i}", 50.0, 296.0, i) for i in range(2)]
    effects = [find(name) for name in ("camera_lag", "ambient_drift", "laser_droop", "radiation")]
    search = Search(HEATER.hold({"lumped.gain": (20.0, 40.0)}), runs, (), effects, DiagnoseOptions(), silent)
    (heat,) = search.present.heat
    at = [heat.fit.problem.model.values[i].key for i in heat.fit.problem.free].index("lumped.gain")
    assert heat.fit.problem.model["lumped.gain"] > 39.99 and heat.fit.jacobian[:, at].any()
    assert not heat.fit.movable[:, at].any()
    others = [j for j in range(heat.fit.free) if j != at]
    assert np.array_equal(heat.fit.movable[:, others], heat.fit.jacobian[:, others])
    for trial in (search.trials.of(effect, (heat,)) for effect in effects):
        assert trial.predicted_reduction < trial.reduction + 0.1


def test_a_better_minimum_that_the_search_comes_upon_is_that_of_the_base() -> None:
    runs = [heater(f"day-{i}", 40.0, 296.0, i) for i in range(2)]
    search = Search(HEATER.set({"lumped.tau": 12.0}).fix(["lumped.tau"]), runs, (), (), DiagnoseOptions(), silent)
    poor = search.refitted(search.given.set({"lumped.tau": 30.0}))
    good, search.base, search.present = search.present, poor, poor
    search.move(good)
    search.finish()
    assert search.present is search.base and search.base.error < 1.2 < poor.error


def test_the_heat_alone_is_refitted_as_it_is_before_the_deformation(strip: Model, recorded: Callable[..., Run]) -> None:
    search = Search(strip, [recorded(duration_s=45.0)], (), (), DiagnoseOptions(), silent)
    warmer = strip.set({"lumped.gain": 1.1 * strip["lumped.gain"]})
    whole, part = search.refitted(warmer), search.refitted_part(warmer, "heat")
    assert part.deformation is None and whole.deformation is not None
    assert part.heat[0].fit.error == whole.heat[0].fit.error
    behind = [v.key for v in strip.values if v.term not in ("ambient", "lumped")]
    assert [part.model[key] for key in behind] == [strip[key] for key in behind]


@pytest.mark.parametrize(
    ("settings", "left", "at_bound"),
    [
        ({"creep.share": 0.2, "creep.tau_v": 999.9}, 4.0, True),
        ({"creep.share": 0.2, "creep.tau_v": 999.9}, 1.1, True),
        ({"creep.share": 0.2, "creep.tau_v": 999.9}, 1.04, False),
        ({"creep.share": 0.2, "creep.tau_v": 30.0}, 4.0, False),
        ({"creep.share": 0.0, "creep.tau_v": 30.0}, 4.0, False),
    ],
)
def test_any_parameter_at_a_bound_speaks_against_an_effect_that_leaves_more_than_noise(
    settings: dict[str, float], left: float, at_bound: bool
) -> None:
    effect = find("creep")
    stage = SimpleNamespace(
        part="both", channels=(DISPLACEMENT,), fit=SimpleNamespace(mean_squares={DISPLACEMENT: left})
    )
    model = default_model("lumped", "equilibrium", ("creep",)).set(settings)
    chain = SimpleNamespace(present=SimpleNamespace(stage=lambda _: stage, model=model), options=DiagnoseOptions())
    assert _is_at_a_bound(chain, SimpleNamespace(trial=SimpleNamespace(effect=effect, stage=stage))) is at_bound


def test_two_differences_of_one_part_are_taken_out_one_after_the_other() -> None:
    runs = [heater(f"day-{i}", 40.0 + 3.0 * i, 296.0 + 1.5 * (i % 2), i) for i in range(4)]
    options = DiagnoseOptions()
    search = Search(HEATER, runs, (), (), options, silent)
    for _ in range(2):
        stage = search.present.heat[0]
        trial = variation_trial(stage, search.left_out, options, silent)
        assert trial is not None
        search.accept(search._variation_step(trial))
    steps = [a for a in search.accepted if isinstance(a, VariationStep)]
    assert len({step.key for step in steps}) == 2
    for step in steps:
        change = partial(_without_difference, key=step.key)
        search.take_out(step, search.refitted(change(search.present.model)), change)
    assert search.accepted == [] and not search.present.model.varies


def test_what_stands_between_what_is_taken_out_and_what_stays_goes_with_it() -> None:
    """Of three differences the first two are taken out, one after the other: the third stands on the base alone."""
    own = [(40.0, 296.0, 12.0), (46.0, 298.0, 9.0), (52.0, 295.0, 15.0), (43.0, 299.0, 19.0)]
    runs = [heater(f"day-{i}", gain, ambient, i, tau) for i, (gain, ambient, tau) in enumerate(own)]
    search = Search(HEATER, runs, (), (), DiagnoseOptions(), silent)
    while (trial := variation_trial(search.present.heat[0], search.left_out, search.options, silent)) is not None:
        search.accept(search._variation_step(trial))
    first, second, third = search.variations
    for step in (first, second):
        change = partial(_without_difference, key=step.key)
        search.take_out(step, search.refitted(change(search.present.model)), change)
    (left,) = search.variations
    assert left.key == third.key
    assert not left.without.model.varies and set(left.with_it.model.varies) == {third.key}


def test_on_runs_held_out_only_those_that_show_a_sensor_judge_what_differs() -> None:
    runs = [heater(f"day-{i}", 40.0, 296.0 + 1.5 * i, i) for i in range(3)]
    blind = runs[2].with_series(TEMPERATURE, None).with_series(DISPLACEMENT, runs[2].temperature)
    search = Search(HEATER, runs[:2], (runs[2], blind), (), DiagnoseOptions(), silent)
    stage = search.present.heat[0]
    trial = variation_trial(stage, search.left_out, search.options, silent)
    assert trial is not None
    held_out = search.left_out.on_test_runs(stage, stage.fit.problem.model, trial.fit.problem.model)
    assert held_out is not None
    assert held_out.errors.after.samples[TEMPERATURE].size == 1


def test_an_effect_is_judged_anew_once_what_differed_beside_it_is_taken_out() -> None:
    runs = [heater(f"day-{i}", 40.0, 296.0 + 1.5 * i, i) for i in range(3)]
    search = Search(HEATER, runs, (), [find("ambient_drift")], DiagnoseOptions(), silent)
    varying = variation_trial(search.present.heat[0], search.left_out, search.options, silent)
    assert varying is not None
    search.accept(search._variation_step(varying))
    search.accept(search._step(search.trials.of(find("ambient_drift"), search.present.heat), ("ambient_drift",)))
    assert [step.held_out.how for step in search.steps] == ["each block in turn"]
    (difference,) = search.variations
    change = partial(_without_difference, key=difference.key)
    search.take_out(difference, search.refitted(change(search.present.model)), change)
    search.finish()
    (step,) = search.steps
    assert (step.held_out.how, step.held_out.names) == ("each run in turn", tuple(run.name for run in runs))


def test_what_differs_beside_an_effect_that_is_taken_back_has_to_explain_most_without_it() -> None:
    """A wave that nothing explains is most of what is left; the ambient temperatures differ by a little."""
    runs = [heater(f"day-{i}", 40.0, 296.0 + 0.3 * i, i) for i in range(3)]
    for i, run in enumerate(runs):
        run.series[TEMPERATURE].value[:] += np.sin(0.5 * run.series[TEMPERATURE].time_s + i)
    search = Search(HEATER, runs, (), [find("ambient_drift")], DiagnoseOptions(), silent)
    stage = search.present.heat[0]
    differing = _refitted(stage, "ambient.t_env", 1.0, search.options, silent)
    held_out = search.left_out.errors(stage, differing.fit.problem, differing.key)
    search.accept(search._variation_step(replace(differing, held_out=held_out)))
    search.accept(search._step(search.trials.of(find("ambient_drift"), search.present.heat), ("ambient_drift",)))
    take_back_refuted(search)
    assert search.accepted == [] and not search.present.model.varies


def test_an_effect_that_takes_nearly_all_is_named_beside_a_model_of_each_run() -> None:
    """Runs that share neither gain nor ambient temperature nor time constant, before a camera that is 2 s late."""
    own = [(40.0, 296.0, 12.0), (46.0, 298.0, 9.0), (52.0, 295.0, 15.0), (43.0, 299.0, 19.0)]
    runs = [heater(f"day-{i}", gain, ambient, i, tau) for i, (gain, ambient, tau) in enumerate(own)]
    for run in runs:
        camera = run.series[TEMPERATURE].value
        camera[:] = np.convolve(np.pad(camera, (40, 0), "edge"), np.full(41, 1 / 41), "valid")
        camera += 0.05 * np.random.default_rng(9).standard_normal(camera.size)
    search = Search(HEATER, runs, (), [find("camera_lag")], DiagnoseOptions(), silent)
    while (trial := variation_trial(search.present.heat[0], search.left_out, search.options, silent)) is not None:
        search.accept(search._variation_step(trial))
    search.accept(search._step(search.trials.of(find("camera_lag"), search.present.heat), ("camera_lag",)))
    keep_what_explains(search, heat=True)
    assert set(search.present.model.varies) == {"lumped.gain", "lumped.tau", "ambient.t_env"}
    assert [step.added for step in search.steps] == ["camera_lag"]


def test_a_refit_on_every_sample_that_ends_far_from_the_finer_grid_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    strip = default_model("lumped", "equilibrium")
    time = np.arange(0.0, 60.0, 0.05)
    power = np.repeat([1.6, 0.6, 1.4], 400)
    made, rng = simulate(strip, time, power), np.random.default_rng(0)
    noisy = {c: made[c] + x * rng.standard_normal(time.size) for c, x in ((TEMPERATURE, 0.06), (DISPLACEMENT, 4e-6))}
    run = Run.of("a", Series(time, power), *(Series(time, noisy[c]) for c in (TEMPERATURE, DISPLACEMENT)))
    search = Search(strip, [run], (), (), DiagnoseOptions(), silent)
    found = search.present
    assert found.deformation is not None
    fit = found.deformation.fit
    spoiled = replace(found, deformation=replace(found.deformation, fit=replace(fit, residual=3.0 * fit.residual)))
    begun: list[Model] = []
    steps: list[int] = []

    def refitted(model: Model, data: Data, iterations: int) -> StagedFit:
        begun.append(model)
        steps.append(iterations)
        return spoiled if len(begun) == 2 else found

    monkeypatch.setattr(search, "_refitted", refitted)
    assert search._on_every_sample(found.model) is found
    assert steps[2] > steps[1]
    assert begun == [found.model] * 3


def test_an_identification_from_scratch_goes_on_from_other_starts_where_the_first_end_worse(
    strip: Model, recorded: Callable[..., Run], monkeypatch: pytest.MonkeyPatch
) -> None:
    search = Search(strip, [recorded(duration_s=45.0)], (), (), DiagnoseOptions(), silent)
    left = {share * strip["lumped.gain"]: error for share, error in ((1.0, 1.0), (0.5, 3.0), (0.2, 5.0))}
    best, poor, poorest = (strip.set({"lumped.gain": gain}) for gain in left)
    seeds: list[int] = []
    ends: list[Model] = []

    def begun(_model: Model, runs: object, options: FitOptions, _progress: object) -> Model:
        # With sensors thinned to the grid of the search another minimum may be the best.
        assert runs is search.data.judged.runs
        seeds.append(options.seed)
        return ends.pop(0)

    def refitted(model: Model) -> StagedFit:
        assert search.present.deformation is not None
        fit = search.present.deformation.fit
        scaled = replace(fit, residual=fit.residual * left[model["lumped.gain"]])
        return replace(search.present, model=model, deformation=replace(search.present.deformation, fit=scaled))

    monkeypatch.setattr(chain, "rough_fit", begun)
    monkeypatch.setattr(search, "refitted", refitted)
    cases = (
        ([best, poorest], best, [1]),
        ([poorest, best], best, [1, 2]),
        ([poorest, poorest], None, [1, 2]),
        ([poor, best], None, [1]),  # it ends where the present model is, from elsewhere
    )
    for reached, expected, tried in cases:
        seeds.clear()
        ends[:] = reached
        found = search.identified_anew(refitted(poor))
        assert (None if found is None else found.model) == expected
        assert seeds == tried


def test_each_part_of_the_model_may_have_as_many_effects(strip: Model) -> None:
    droop, creep = find("laser_droop"), find("creep")
    hides = strip.add(droop).add(creep).set({droop.strength_key: 0.2, creep.strength_key: 0.3})
    time = np.arange(0.0, 90.0, 0.01)
    runs = []
    for i in range(2):
        power = np.where((time > 1.0) & (time < 40.0 + 10.0 * i), 1.3 - 0.2 * i, 0.0)
        made, rng = simulate(hides, time, power), np.random.default_rng(i)
        camera = Series(time[::10], made.temperature_k[::10] + 0.05 * rng.standard_normal(time[::10].size))
        distance = Series(time, made.displacement_m + 4e-6 * rng.standard_normal(time.size))
        runs.append(Run.of(f"pulse-{i}", Series(time, power), camera, distance, sha256=f"{i}"))
    search = Search(strip, runs, (), (droop, creep), DiagnoseOptions(max_effects=1), silent)
    search.run()
    assert [step.added for step in search.steps] == ["laser_droop", "creep"]


@pytest.mark.parametrize(
    ("scale_k", "alike", "first"),
    [
        (300.0, ("elastic_softening", "thermal_expansion"), "thermal_expansion"),
        (300.0, ("elastic_softening",), "elastic_softening"),
        (40.0, ("elastic_softening", "thermal_expansion"), "elastic_softening"),
    ],
)
def test_an_effect_at_a_bound_comes_after_one_that_does_the_same(
    strip: Model,
    recorded: Callable[..., Run],
    monkeypatch: pytest.MonkeyPatch,
    scale_k: float,
    alike: tuple[str, ...],
    first: str,
) -> None:
    search = Search(strip, [recorded(duration_s=45.0)], (), (), DiagnoseOptions(), silent)
    names = ("elastic_softening", "creep", "thermal_expansion")
    model = default_model("lumped", "equilibrium", names).set(
        {"elastic_softening.t_e": scale_k, "elastic_softening.sag": 0.01, "creep.share": 0.1}
    )
    fit = SimpleNamespace(problem=SimpleNamespace(model=model))
    trials = [SimpleNamespace(objection="", fit=fit, effect=find(name)) for name in names]
    monkeypatch.setattr(search.trials, "alias_set", lambda _best, _trials: alike)
    found = [trial.effect.name for trial in search._in_their_order(trials)]
    assert (found[0], sorted(found)) == (first, sorted(names))


def test_only_the_best_trial_of_a_step_is_identified_from_scratch(
    strip: Model, recorded: Callable[..., Run], monkeypatch: pytest.MonkeyPatch
) -> None:
    search = Search(strip, [recorded(duration_s=45.0)], (), (), DiagnoseOptions(), silent)
    asked: list[tuple[str, bool]] = []
    refused = SimpleNamespace(objection="chance", name="refused")
    fit = SimpleNamespace(problem=SimpleNamespace(model=strip))
    first, second, third = (
        SimpleNamespace(objection="", name=name, fit=fit, effect=find("creep")) for name in ("first", "second", "third")
    )

    def confirmed(trial: SimpleNamespace, _trials: object, anew: bool) -> SimpleNamespace | None:
        asked.append((trial.name, anew))
        return trial if trial is second else None

    monkeypatch.setattr(search, "_confirmed", confirmed)
    for anew in (True, False):
        asked.clear()
        assert search._next([refused, first, second, third], heat=False, may_differ=False, anew=anew) is second
        assert asked == [("first", anew), ("second", False)]
