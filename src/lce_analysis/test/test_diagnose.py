# SPDX-License-Identifier: Apache-2.0
"""Small campaigns with something hidden; how well the method does is measured by `make hidden`."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from lce_analysis.comparison.compare import compare
from lce_analysis.diagnosis import add_effect, diagnose
from lce_analysis.diagnosis.addition import _history
from lce_analysis.diagnosis.diagnosis import Column, _at_fault, _verdict
from lce_analysis.diagnosis.linearized_fit import linearised, optimum
from lce_analysis.diagnosis.misfit import Misfit
from lce_analysis.diagnosis.score import score_test
from lce_analysis.diagnosis.search import Search
from lce_analysis.diagnosis.strength import Estimate
from lce_analysis.options import DiagnoseOptions
from lce_data.channels import DISPLACEMENT, POWER, TEMPERATURE
from lce_data.errors import LceError
from lce_data.progress import silent
from lce_data.run import Run, Series
from lce_data.waveforms import RATE_HZ, SHAPES
from lce_model import Model, default_model, simulate
from lce_model.effects import Effect, find

BASE = default_model("lumped", "equilibrium")
NAMES = ("creep", "thermal_gradient", "ambient_drift", "displacement_drift", "radiation")
CANDIDATES = [find(name) for name in NAMES]
WAVES = {
    "pulse": ("pulse", {"amp": 0.8, "th": 16.0, "offset": 1.7, "rest": 30.0}),
    "stairs": ("stairs", {"low": 0.5, "high": 2.2, "steps": 4, "hold": 8.0, "rest": 20.0}),
    "prbs": ("prbs", {"low": 0.6, "high": 2.4, "bit": 4.0, "order": 4, "rest": 10.0}),
}
KEYS = {
    "verdict", "added", "steps", "candidates", "traces", "error", "error_over_noise", "away_from_jumps", "noise_floor",
    "discrepancy", "varies", "signatures", "fingerprint", "other_base", "free_forms", "seconds",
}  # fmt: skip
CANDIDATE_KEYS = {
    "effect", "stage", "standing", "reason", "evidence", "p_value", "visibility", "expected_strength",
    "expected_strength_of", "predicted_fall",
    "actual_fall", "strength", "strength_of", "held_out", "aliases",
}  # fmt: skip


def _run(name: str, strip: Model, disturbed: float = 0.0, seed: int = 0) -> Run:
    """A run of the strip; ``disturbed`` is the share by which the laser breathes without the record showing it."""
    kind, options = WAVES[name]
    power = SHAPES[kind].power_w({k: (float(v),) for k, v in options.items()})
    time = np.arange(power.size) / RATE_HZ
    noise = np.random.default_rng((seed, len(name)))
    actual = power * (1.0 + disturbed * np.sin(2.0 * np.pi * time / 7.0 + noise.uniform(0.0, 6.0)))
    true = simulate(strip, time, actual)
    camera = slice(None, None, 10)
    temperature = true.measured_temperature_k[camera] + 0.06 * noise.standard_normal(time[camera].size)
    displacement = true.measured_displacement_m + 4e-6 * noise.standard_normal(time.size)
    series = Series(time, power), Series(time[camera], temperature), Series(time, displacement)
    return Run.of(name, *series, sha256=name)


def _campaign(strip: Model, **options: float) -> tuple[list[Run], list[Run]]:
    runs = [_run(name, strip, **options) for name in WAVES]
    return runs[:2], runs[2:]


def _strip_with(name: str) -> Model:
    effect = find(name)
    return BASE.add(name).set({effect.strength_key: effect.typical})


def _heated(loss: Effect, strength: float) -> tuple[Model, list[Run]]:
    """The heat balance without a loss, and runs of a strip that has it."""
    heat = default_model("lumped", "none").set({"lumped.gain": 60.0})
    strip = heat.add(loss.reference).set({loss.strength_key: strength})
    return heat, [_run(name, strip) for name in WAVES]


def test_a_loss_of_another_form_than_the_true_one_is_not_named() -> None:
    """Beside both of them the true one is."""
    loss, like_it = find("radiation"), find("natural_convection")
    heat, runs = _heated(loss, 0.7)
    found = diagnose(heat, runs[:2], runs[2:], [like_it])
    assert found.verdict == "cannot_tell" and found.steps == ()
    assert [c.reason for c in found.candidates] == [
        "what it leaves still has its shape: it is much like what is missing, and not the same"
    ]
    (told,) = [s for s in found.sentences if "much like it" in s]
    assert told.startswith("natural_convection takes much of it")
    assert diagnose(heat, runs[:2], runs[2:], [like_it, loss]).as_json()["added"] == ["radiation"]


def test_an_effect_that_would_have_to_be_stronger_than_it_can_be_is_not_named() -> None:
    """No surface radiates more than a black one."""
    loss, like_it = find("natural_convection"), find("radiation")
    heat, runs = _heated(loss, 1.0)
    found = diagnose(heat, runs[:2], runs[2:], [like_it])
    assert found.verdict == "cannot_tell" and found.steps == ()
    assert [c.reason.split(":")[0] for c in found.candidates] == ["a parameter of it is at its bound"]
    (beyond,) = found.held_back["radiation"]
    assert beyond.key == "radiation.emissivity" and beyond.wanted is not None and beyond.wanted > 1.0
    assert any(beyond.option in sentence for sentence in found.sentences)


def test_a_complete_model_is_adequate() -> None:
    found = diagnose(BASE, *_campaign(BASE), CANDIDATES)
    assert found.verdict == "adequate"
    assert found.steps == ()
    assert found.sentences[0].startswith("Nothing is missing")
    assert all(c.standing != "missing" for c in found.candidates)
    assert not [s for s in found.sentences if "s from its jumps" in s]
    everywhere = found.train.misfit["after"]
    away = Misfit({c: 0.5 * total for c, total in everywhere.total.items()}, everywhere.samples)
    (told,) = (s for s in replace(found, away_from_jumps=away).sentences if "s from its jumps" in s)
    assert f"and {away.rms[DISPLACEMENT]:.2f} farther than 0.25 s from its jumps" in told


@pytest.mark.parametrize("name", ["creep", "displacement_drift"])
def test_a_hidden_effect_is_named_and_the_held_out_error_comes_down_to_the_noise(name: str) -> None:
    effect = find(name)
    train, test = _campaign(_strip_with(name))
    found = diagnose(BASE, train, test, CANDIDATES)
    assert found.verdict == "missing"
    assert [s.added for s in found.steps] == [name]
    assert found.candidates[0].effect is effect
    assert found.model[effect.strength_key] == pytest.approx(effect.typical, rel=0.15)
    assert found.test.misfit["before"].rms[DISPLACEMENT] > 1.5
    assert found.test.misfit["after"].rms[DISPLACEMENT] == pytest.approx(1.0, abs=0.1)
    step = found.steps[0]
    assert step.actual_reduction > 0.9
    assert step.trial.strengths is not None
    assert step.trial.strengths.overall.value == pytest.approx(found.model[effect.strength_key], rel=1e-9)
    for estimate in step.trial.strengths.by_run:
        assert estimate is not None
        assert abs(estimate.value - effect.typical) < max(5.0 * estimate.standard_error, 0.05 * effect.typical)


@pytest.mark.parametrize("key", ["camera_lag.delay", "laser_saturation.p_th"])
def test_what_acts_without_the_strength_of_its_effect_is_named_and_told(key: str) -> None:
    """A dead time without a lag, a threshold without a saturation."""
    name, _, parameter = key.partition(".")
    train, test = _campaign(BASE.add(name).set({key: 0.2}))
    found = diagnose(BASE, train, test, [find(n) for n in (*NAMES, "camera_lag", "laser_saturation")])
    assert [s.added for s in found.steps] == [name]
    (step,) = found.as_json()["steps"]
    assert found.test.misfit["after"].rms[TEMPERATURE] == pytest.approx(1.0, abs=0.1)
    assert step["strength_of"] == key
    assert found.steps[0].trial.amplitude.name == parameter
    for value, error in step["strength_by_run"].values():
        assert abs(value - found.model[key]) < 5.0 * error


def test_an_effect_is_not_rejected_for_a_strength_that_only_a_poor_minimum_gives() -> None:
    search = Search(BASE, *_campaign(_strip_with("creep")), [find("creep")], DiagnoseOptions(), silent)
    (trial,) = search.trials.likely(search._stages(heat=False))
    problem = trial.fit.problem
    others = tuple(i for i in problem.free if problem.model.values[i].key != "creep.share")
    held = replace(problem, model=problem.model.set({"creep.share": 0.03}), free=others)
    short = linearised(replace(optimum(held, "", silent, 30), free=problem.free))
    (poor,) = search.trials.judged([replace(trial, fit=short, gain=trial.stage.fit.error - short.error)])
    assert poor.objection == "varies" and search._wants_another_strength(poor)
    found = search._elsewhere(poor)
    assert found.objection == "" and found is search.trials.tried["creep"]
    assert found.strength == pytest.approx(find("creep").typical, rel=0.15)
    assert not search._wants_another_strength(replace(poor, objection="worse"))


def test_an_effect_of_the_heat_is_found_on_the_temperature_alone() -> None:
    strip = BASE.add("radiation").set({"radiation.emissivity": 0.6})
    found = diagnose(BASE, *_campaign(strip), CANDIDATES)
    assert [s.added for s in found.steps] == ["radiation"]
    assert found.steps[0].trial.stage.part == "heat"


def test_a_camera_that_lags_unknown_to_the_library_is_no_effect_of_light_on_the_order() -> None:
    """The displacement is as the model's own temperature has it, and early beside the measured one."""
    train, test = _campaign(BASE.add("camera_lag").set({"camera_lag.tau": 1.0}))
    found = diagnose(BASE, train, test, [find("photochemical_order")])
    assert (found.verdict, found.steps) == ("unexplained", ())
    (candidate,) = found.candidates
    assert candidate.trial is not None
    assert candidate.trial.objection == "driven"
    added = add_effect(BASE, "photochemical_order", train, test)
    assert not added.confirmed
    assert added.objection == candidate.reason


def test_what_no_effect_explains_is_called_unexplained_and_nothing_is_named() -> None:
    found = diagnose(BASE, *_campaign(BASE, disturbed=0.08), CANDIDATES)
    assert found.verdict == "unexplained"
    assert found.steps == ()
    assert found.fingerprint


@pytest.mark.parametrize(("runs", "how"), [(2, "each run in turn"), (1, "each block in turn")])
def test_without_a_run_held_out_runs_are_left_out_or_blocks_of_a_single_one(runs: int, how: str) -> None:
    train, _ = _campaign(_strip_with("creep"))
    found = diagnose(BASE, train[:runs], effects=CANDIDATES)
    creep = next(c for c in found.candidates if c.effect.name == "creep")
    assert creep.trial is not None
    assert creep.trial.held_out is not None
    assert creep.trial.held_out.how == how
    what = {2: "each run", 1: "each block of every run"}[runs]
    assert f"No run was held out: instead, {what} was left out in turn. Give one with --test." in found.sentences
    if runs == 1:  # one pulse has too little in its blocks for what is left out
        assert found.verdict == "cannot_tell"
    else:
        assert [s.added for s in found.steps] == ["creep"]


def test_runs_held_out_without_a_displacement_do_not_judge_the_deformation() -> None:
    train, (test,) = _campaign(_strip_with("creep"))
    found = diagnose(BASE, train, [test.with_series(DISPLACEMENT, None)], CANDIDATES)
    (step,) = found.steps
    assert (step.added, step.held_out.how) == ("creep", "each run in turn")
    (told,) = [s for s in found.sentences if "held out show no displacement" in s]
    assert told.startswith("The runs held out show no displacement: instead, each run was left out in turn.")


def test_a_loop_without_laser_power_says_nothing_of_the_heat() -> None:
    train, test = _campaign(_strip_with("radiation"))
    loops = [replace(run.with_series(POWER, None), name=f"loop {run.name}") for run in (*train, *test)]
    found = diagnose(BASE, [*train, loops[0]], [*test, loops[-1]], CANDIDATES)
    assert [s.added for s in found.steps] == ["radiation"]
    assert found.steps[0].held_out.errors.judged_after.samples[TEMPERATURE].size == len(test)


def test_a_loop_alone_held_out_does_not_judge_the_heat() -> None:
    train, (test, *_) = _campaign(_strip_with("radiation"))
    loop = test.with_series(POWER, None)
    found = diagnose(BASE, train, [loop], CANDIDATES)
    (step,) = found.steps
    assert (step.added, step.held_out.how) == ("radiation", "each run in turn")
    alone = diagnose(default_model("lumped", "none"), train, [test, loop], CANDIDATES)
    assert [(s.added, s.held_out.names) for s in alone.steps] == [("radiation", (test.name,))]


@pytest.mark.parametrize("held_out", [False, True])
def test_a_run_without_a_temperature_is_driven_by_the_models_own(held_out: bool) -> None:
    train, (test,) = (tuple(_run(name, BASE, 0.2) for name in names) for names in (("pulse", "stairs"), ("prbs",)))
    blind = test.with_series(TEMPERATURE, None)
    found = diagnose(BASE, train if held_out else [*train, blind], [blind] if held_out else (), CANDIDATES[:1])
    assert found.apart == "fails" and found.drive == "model"
    assert any("The heat does not explain the temperature, so it was fitted alone" in s for s in found.sentences)
    assert found.train.misfit["after"].rms[TEMPERATURE] > 2.0


def test_a_displacement_held_out_that_never_changes_has_no_relative_error() -> None:
    train, (test,) = _campaign(BASE)
    still = test.series[DISPLACEMENT]
    flat = test.with_series(DISPLACEMENT, Series(still.time_s, np.zeros_like(still.value)))
    record = diagnose(BASE, train, [flat], CANDIDATES).as_json()
    assert record["error"]["test"]["after"]["displacement_nrmse"] is None
    assert record["error"]["test"]["after"]["temperature_nrmse"] > 0.0


def test_an_effect_that_begins_at_a_time_of_its_own_is_no_candidate_beside_a_run_held_out() -> None:
    train, test = _campaign(BASE)
    step = find("loss_step")
    assert diagnose(BASE, train[:1], effects=[step]).not_examined == {}
    assert list(diagnose(BASE, train[:1], test, [step]).not_examined) == ["loss_step"]


def test_only_what_might_explain_a_sensor_that_is_left_makes_an_answer_doubtful() -> None:
    """An effect of the heat may be objected to and the temperature explained since, by what differs between runs."""
    left = Search(BASE, *_campaign(_strip_with("creep")), (), DiagnoseOptions(), silent)
    assert _verdict(left) == "unexplained"
    heat, runs = _heated(find("radiation"), 0.7)
    heated = Search(heat, runs, (), [find("radiation")], DiagnoseOptions(), silent)
    left.trials.reject(heated._tried(heat=True)[0], "varies")
    assert _verdict(left) == "unexplained"
    beside = Search(BASE, *_campaign(_strip_with("creep")), [find("creep")], DiagnoseOptions(), silent)
    beside.trials.reject(beside._tried(heat=False)[0], "varies")
    assert _verdict(beside) == "cannot_tell"


def test_an_identification_from_scratch_that_parts_the_stages_is_not_gone_on_with(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The errors of the trial are of both sensors, and could not be compared."""
    campaign = _campaign(_strip_with("creep"))
    together = Search(BASE, *campaign, [find("creep")], DiagnoseOptions(bent=99.0), silent)
    (trial,) = together._tried(heat=False)
    fit = together.refitted(together.with_effect_of(trial))
    apart = Search(BASE, *campaign, [find("creep")], DiagnoseOptions(bent=0.0), silent).present
    assert apart.deformation is not None and set(apart.deformation.channels) < set(trial.stage.channels)
    monkeypatch.setattr(together, "identified_anew", lambda _: apart)
    assert together._searched_anew(fit, trial) == (fit, trial)


def test_where_no_noise_is_left_to_compare_with_there_is_no_evidence() -> None:
    (stage, *_) = Search(BASE, *_campaign(BASE), CANDIDATES, DiagnoseOptions(), silent).present.heat
    tested = replace(score_test(stage.fit, stage.candidates, 10.0), s2=0.0)
    assert tested.scores and {score.evidence for score in tested.scores} == {0.0}


def test_a_thermal_model_is_diagnosed_on_runs_that_hold_a_displacement_too() -> None:
    strip = BASE.add("ambient_drift").set({"ambient_drift.rate": 0.02})
    train, test = _campaign(strip)
    found = diagnose(default_model("lumped", "none"), train, test, CANDIDATES)
    assert [s.added for s in found.steps] == ["ambient_drift"]
    assert DISPLACEMENT not in found.train.misfit["after"].rms


def test_the_record_has_every_key_of_the_contract() -> None:
    train, test = _campaign(_strip_with("creep"))
    found = diagnose(BASE, train, test, CANDIDATES)
    record = found.as_json()
    assert json.loads(json.dumps(record, allow_nan=False)) == record
    unknown = Estimate(1.0, math.inf)
    trial = replace(found.steps[0].trial, strengths=replace(found.steps[0].trial.strengths, overall=unknown))
    undetermined = replace(found, candidates=(replace(found.candidates[0], trial=trial),)).as_json()
    assert undetermined["candidates"][0]["strength"] == [1.0, None]
    assert set(record) == KEYS
    assert {c["effect"] for c in record["candidates"]} == set(NAMES)
    assert set(record["candidates"][0]) == CANDIDATE_KEYS
    assert {side: set(columns) for side, columns in record["error"].items()} == {
        side: {"given", "before", "after"} for side in ("train", "test")
    }
    assert record["noise_floor"]["temperature_c"] == pytest.approx(0.06, rel=0.15)
    (step,) = record["steps"]
    assert {"added", "set", "predicted_fall", "actual_fall", "strength_by_run", "held_out"} <= set(step)
    assert set(step["strength_by_run"]) == {run.name for run in train}
    assert set(step["held_out"]["before"]) == {"temperature", "displacement"}
    detailed = found.as_detailed_json()
    assert detailed["sentences"] == list(found.sentences)
    for candidate, of_contract in zip(detailed["candidates"], record["candidates"], strict=True):
        assert {key: candidate.pop(key) for key in of_contract} == of_contract
        assert set(candidate) == {"settings", "meaning", "shown"}
        for key, value in candidate["settings"].items():
            effect, _, name = key.partition(".")
            bounds = find(effect).parameter(name)
            assert bounds.lower <= value <= bounds.upper


def test_what_is_told_is_what_the_models_give_when_they_are_compared() -> None:
    train, test = _campaign(_strip_with("creep"))
    found = diagnose(BASE, train, test, CANDIDATES)
    models: dict[Column, Model] = {"given": found.given, "before": found.before, "after": found.model}
    for column, model in models.items():
        told = found.test.misfit[column]
        (compared,) = compare(model, test).runs
        for channel in (TEMPERATURE, DISPLACEMENT):
            assert told.rms[channel] == pytest.approx(compared.channels[channel].metrics.over_noise, rel=1e-9)


def test_adding_an_effect_keeps_its_standard_error_and_the_history() -> None:
    strip = BASE.add("creep").set({"creep.share": 0.1, "creep.tau_v": 8.0})
    train, test = _campaign(strip)
    addition = add_effect(BASE, "creep", train, test)
    share = addition.model.values[addition.model.index("creep.share")]
    assert share.standard_error is not None
    assert abs(share.value - 0.1) < 5.0 * share.standard_error
    assert addition.confirmed
    assert "confirmed on prbs" in addition.sentence
    assert 0.5 < addition.predicted_reduction <= 1.0
    assert addition.actual_reduction > 0.95
    before, after = addition.model.fit["history"]
    assert after["effects"] == ["creep"]
    assert after["verdict"] == "confirmed"
    assert after["test"]["displacement_nrmse"] < 0.5 * before["test"]["displacement_nrmse"]
    with pytest.raises(LceError, match="has creep already"):
        add_effect(addition.model, "creep", train)


def test_an_effect_that_is_not_there_is_not_confirmed() -> None:
    found = add_effect(BASE, "creep", *_campaign(BASE))
    assert not found.confirmed
    assert "not confirmed: " in found.sentence and "; on prbs: " in found.sentence


def test_without_a_temperature_nothing_says_which_part_is_at_fault() -> None:
    train, _ = _campaign(_strip_with("creep"))
    blind = [replace(run, series={c: s for c, s in run.series.items() if c is not TEMPERATURE}) for run in train]
    search = Search(BASE, blind, (), (), DiagnoseOptions(), silent)
    assert search.base.worst > DiagnoseOptions().explained
    assert _at_fault(search) is None
    seen = Search(BASE, train, (), (), DiagnoseOptions(), silent)
    assert _at_fault(seen) == "deformation"


def test_a_history_that_is_none_is_begun_anew() -> None:
    kept = {"thermal": "lumped", "deformation": "none", "effects": [], "train": {}, "test": {}, "verdict": ""}
    assert _history(BASE.with_values(BASE.values, {"history": [kept]})) == [kept]
    for odd in (None, "a text", [1], [{"thermal": "lumped"}]):
        assert _history(BASE.with_values(BASE.values, {"history": odd})) == []
