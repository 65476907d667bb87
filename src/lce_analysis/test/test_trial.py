# SPDX-License-Identifier: Apache-2.0
"""What speaks against an effect: each objection has its case, made from plain numbers."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from lce_analysis.diagnosis.accepted import Step
from lce_analysis.diagnosis.held_out import DataLeftOut, HeldOut
from lce_analysis.diagnosis.linearized_fit import LinearizedFit
from lce_analysis.diagnosis.looking_back import _explained, _explains, bends_the_heat, not_borne_out
from lce_analysis.diagnosis.misfit import JudgedRuns, Misfit, Pair
from lce_analysis.diagnosis.score import Direction, Score
from lce_analysis.diagnosis.search import Search
from lce_analysis.diagnosis.stage_problem import StageProblem
from lce_analysis.diagnosis.strength import Estimate, Strengths
from lce_analysis.diagnosis.trial import (
    Trial,
    effect_alone,
    gets_worse,
    goes_far,
    objection,
    outlasts,
    penalty,
    untouched_by,
    with_effect,
)
from lce_analysis.diagnosis.trials import Trials
from lce_analysis.diagnosis.words import _gets_worse, _held_out_levels, _less_as_given, outcome
from lce_analysis.identification.problem import ObservedSeries, Problem
from lce_analysis.options import DiagnoseOptions, Drive
from lce_analysis.prediction import Sampling
from lce_data.channels import DISPLACEMENT, SENSORS, TEMPERATURE, Channel
from lce_data.progress import silent
from lce_data.run import Run, Series
from lce_data.units import KELVIN
from lce_model import default_model, simulate
from lce_model.effects import find

CREEP = find("creep")
OPTIONS = DiagnoseOptions()
LIBRARY = 21
MODEL = default_model("lumped", "equilibrium").add("creep")
N = 1000


def _fit(mean_square: float, strength: float = 0.1, channel: Channel = DISPLACEMENT) -> LinearizedFit:
    """A fit of one series that leaves this error, with creep of this strength in its model."""
    grid = np.arange(float(N))
    series = ObservedSeries(0, channel, Sampling.between(grid, grid), np.zeros(N), 1.0)
    problem = Problem(MODEL.set({CREEP.strength_key: strength}), (), (), np.empty(0), (series,))
    return LinearizedFit(problem, np.empty((N, 0)), np.full(N, np.sqrt(mean_square)))


def _misfit(squares: dict[Channel, float]) -> Misfit:
    return Misfit({c: np.array([x * N]) for c, x in squares.items()}, {c: np.array([float(N)]) for c in squares})


def _held_out(before: dict[Channel, float], after: dict[Channel, float], **judged: dict[Channel, float]) -> HeldOut:
    """Mean squared errors on a test run; on samples away from jumps the same unless given."""
    of_jumps = (judged.get("judged_before", before), judged.get("judged_after", after))
    return HeldOut("test runs", ("prbs",), Pair(*map(_misfit, (before, after, *of_jumps))))


def _strengths(*by_run: float, error: float = 0.005, overall: float = 0.1, inflation: float = 1.0) -> Strengths:
    each = tuple(Estimate(x, error) for x in by_run)
    return Strengths(CREEP.strength, Estimate(overall, error), inflation, 1.0, each)


STAGE = StageProblem("deformation", _fit(5.0, 0.0), (CREEP,), "model")
SCORE = Score(
    effect=CREEP,
    direction=Direction(CREEP, CREEP.parameter("share"), {"creep.tau_v": 8.0}, 1e-4),
    index=0,
    evidence=500.0,
    p_value=0.0,
    visibility=0.5,
    expected_strength=0.1,
    detectable=0.01,
    predicted_gain=3500.0,
)
GOOD = Trial(
    STAGE,
    SCORE,
    _fit(1.0),
    gain=4000.0,
    strengths=_strengths(0.098, 0.103),
    held_out=_held_out({DISPLACEMENT: 5.0}, {DISPLACEMENT: 1.05}),
)


def _objection(**changes: Any) -> str:
    return objection(replace(GOOD, **changes), LIBRARY, OPTIONS)


def test_nothing_speaks_against_what_helps_everywhere_with_one_strength() -> None:
    assert _objection() == ""
    assert GOOD.strength == 0.1
    assert GOOD.reduction == pytest.approx(1.0)


@pytest.mark.parametrize(
    "changes",
    [{"gain": 0.0}, {"gain": -3.0}, {"fit": _fit(1.0, 0.0)}, {"fit": _fit(1.0, 1e-9)}],
    ids=["no gain", "a loss", "at its null value", "as good as there"],
)
def test_a_strength_at_its_null_value_or_no_gain_is_none_at_all(changes: dict[str, Any]) -> None:
    assert _objection(**changes) == "null"


def test_a_gain_within_what_chance_gives() -> None:
    price = penalty(CREEP, LIBRARY, OPTIONS.false_alarm)
    freed = sum(not p.fixed for p in CREEP.parameters)
    assert price == pytest.approx(2.0 * freed * np.log(LIBRARY / OPTIONS.false_alarm))
    assert _objection(gain=0.99 * price, held_out=None) == "chance"
    assert _objection(gain=1.01 * price, held_out=None) == ""


def test_correlated_residuals_raise_the_price() -> None:
    price = penalty(CREEP, LIBRARY, OPTIONS.false_alarm)
    inflated = _strengths(0.1, 0.1, inflation=10.0)
    assert _objection(gain=9.0 * price, strengths=inflated) == "chance"
    assert _objection(gain=11.0 * price, strengths=inflated) == ""


@pytest.mark.parametrize(("error", "found"), [(0.02, ""), (0.001, "varies"), (0.06, "varies")])
def test_a_strength_of_all_runs_is_as_sure_as_its_own_error(error: float, found: str) -> None:
    """It may differ from the mean of the runs by twice that error; one that is not significant allows nothing."""
    runs = _strengths(*[0.04] * 6, error=0.02)
    assert _objection(strengths=replace(runs, overall=Estimate(0.065, error))) == found


def test_a_strength_of_all_runs_within_its_own_error_is_none() -> None:
    """As 2.1 ± 4.5 J/g of latent heat, beside a laser whose droop follows its power: each run alone is sure."""
    strengths = _strengths(0.098, 0.103)
    assert _objection(strengths=replace(strengths, overall=Estimate(0.1, 0.049))) == ""
    assert _objection(strengths=replace(strengths, overall=Estimate(0.1, 0.051))) == "varies"


def test_an_effect_that_the_free_parameters_mask() -> None:
    masked = replace(SCORE, visibility=0.5 * OPTIONS.min_visibility)
    assert _objection(score=masked) == "masked"
    most = CREEP.parameter("share").upper
    assert _objection(score=masked, fit=_fit(1.0, most)) == "bound", "a larger share would explain more"
    assert _objection(score=masked, fit=_fit(4.9, most)) == "masked", "it explains too little"


def test_an_error_that_rises_on_data_left_out() -> None:
    assert _objection(held_out=_held_out({DISPLACEMENT: 5.0}, {DISPLACEMENT: 5.2})) == "worse"
    both = {TEMPERATURE: 1.0, DISPLACEMENT: 5.0}
    assert _objection(held_out=_held_out(both, {TEMPERATURE: 1.5, DISPLACEMENT: 1.05})) == "worse"


@pytest.mark.parametrize(
    ("after", "judged_after", "told"),
    [
        (1.0, 1.0, "confirmed on prbs: d 3.00 → 1.00 × noise"),
        (9.5, 1.0, "confirmed on prbs, away from jumps: d 3.00 → 1.00 × noise; with them: d 3.00 → 3.08 × noise"),
        (9.5, 9.5, "judged on prbs: d 3.00 → 3.08 × noise"),
    ],
)
def test_confirmed_is_said_only_where_an_error_falls(after: float, judged_after: float, told: str) -> None:
    judged = {"judged_before": {DISPLACEMENT: 9.0}, "judged_after": {DISPLACEMENT: judged_after}}
    assert outcome(_held_out({DISPLACEMENT: 9.0}, {DISPLACEMENT: after}, **judged), "") == told


@pytest.mark.parametrize(("tau_s", "longer"), [(30.0, False), (119.0, False), (121.0, True)])
def test_an_effect_with_a_time_constant_longer_than_the_runs_outlasts_them(tau_s: float, longer: bool) -> None:
    runs = [
        Run.of(name, None, Series(np.linspace(0.0, end_s, 50), np.zeros(50)))
        for name, end_s in (("a", 60.0), ("b", 120.0))
    ]
    assert outlasts(MODEL.set({"creep.share": 0.1, "creep.tau_v": tau_s}), CREEP, runs) is longer


def test_the_answer_says_which_sensor_gets_worse_that_did_not_decide() -> None:
    """The heat's own effect may raise the displacement: "confirmed" is said of the temperature alone."""

    def said(before: float, after: float) -> list[str]:
        held_out = _held_out({TEMPERATURE: 9.0, DISPLACEMENT: before}, {TEMPERATURE: 1.0, DISPLACEMENT: after})
        trial = SimpleNamespace(stage=SimpleNamespace(channels=(TEMPERATURE,)), effect=find("radiation"))
        return list(_gets_worse(SimpleNamespace(held_out=held_out, trial=trial)))

    (sentence,) = said(50.0, 60.0)
    assert sentence == "The displacement is explained worse with it; the effect was judged on the temperature."
    assert said(50.0, 40.0) == said(50.0, 50.5) == said(0.9, 0.99) == []


def test_the_answer_says_which_sensor_the_model_as_given_explains_better() -> None:
    """The refit may raise what the effect then takes: "confirmed" compares with the refitted model."""

    def said(given: float, after: float, steps: tuple[str, ...] = ("camera_lag",)) -> list[str]:
        misfit = {"given": _misfit({DISPLACEMENT: given}), "after": _misfit({DISPLACEMENT: after})}
        found: Any = SimpleNamespace(test=SimpleNamespace(misfit=misfit), steps=steps, held_out=("prbs",))
        return list(_less_as_given(found))

    (sentence,) = said(36.0, 49.0)
    assert sentence == (
        "On prbs the model as given leaves less of the displacement: 6.00 × the noise; "
        "refitted, with what was added, 7.00."
    )
    assert said(49.0, 36.0) == said(49.0, 49.5) == said(0.9, 0.99) == said(36.0, 49.0, ()) == []


def test_the_answer_says_that_runs_held_out_are_explained_less_well_than_those_learnt_from() -> None:
    def said(learnt: float, held_out: float, only_if_more: bool = True) -> list[str]:
        train, test = ({"after": _misfit({DISPLACEMENT: x})} for x in (learnt, held_out))
        found: Any = SimpleNamespace(
            train=SimpleNamespace(misfit=train), test=SimpleNamespace(misfit=test), held_out=("prbs",)
        )
        return list(_held_out_levels(found, only_if_more))

    (sentence,) = said(1.0, 4.0)
    assert sentence == (
        "Of prbs, held out, the model leaves 2.00 × the noise in the displacement, more than of the runs learnt from."
    )
    assert said(3.9, 4.0) == said(0.5, 1.3) == []
    assert len(said(3.9, 4.0, only_if_more=False)) == 1


@pytest.mark.parametrize(
    ("name", "part", "after", "bends"),
    [
        ("latent_heat", "both", 1.05, True),
        ("latent_heat", "both", 1.01, False),
        ("latent_heat", "heat", 1.05, False),
        ("creep", "both", 1.05, False),
    ],
)
def test_an_effect_of_the_heat_may_not_mend_the_displacement_alone(
    name: str, part: str, after: float, bends: bool
) -> None:
    def misfit(temperature: float, displacement: float) -> Misfit:
        total = {TEMPERATURE: np.array([100.0 * temperature]), DISPLACEMENT: np.array([100.0 * displacement])}
        return Misfit(total, dict.fromkeys(total, np.array([100.0])))

    trial = SimpleNamespace(effect=find(name), stage=SimpleNamespace(part=part))
    step: Any = SimpleNamespace(trial=trial, train=(misfit(1.0, 1.3), misfit(after, 1.1)))
    assert bends_the_heat(step, DiagnoseOptions()) == bends


@pytest.mark.parametrize(
    ("before", "after"),
    [(1.04, 1.0), (50.0, 49.0), (0.9, 0.87), (5.0, 5.05)],
    ids=["a trifle of the noise", "a small share", "below the noise", "hardly worse"],
)
def test_an_effect_that_removes_too_little(before: float, after: float) -> None:
    assert _objection(held_out=_held_out({DISPLACEMENT: before}, {DISPLACEMENT: after})) == "small"


def test_one_sensor_that_gains_is_enough() -> None:
    before, after = {TEMPERATURE: 1.0, DISPLACEMENT: 1.2}, {TEMPERATURE: 1.0, DISPLACEMENT: 1.1}
    assert _objection(held_out=_held_out(before, after)) == ""


def test_a_fall_below_the_noise_as_estimated_counts() -> None:
    """The noise is estimated from the series; what a model explains of it was none."""
    assert _objection(held_out=_held_out({DISPLACEMENT: 0.98}, {DISPLACEMENT: 0.9})) == ""


def test_samples_around_jumps_do_not_decide() -> None:
    told = {DISPLACEMENT: 5.0}, {DISPLACEMENT: 9.0}
    judged = {"judged_before": {DISPLACEMENT: 5.0}, "judged_after": {DISPLACEMENT: 1.1}}
    assert _objection(held_out=_held_out(*told, **judged)) == ""
    assert _objection(held_out=_held_out(*reversed(told), judged_before=told[0], judged_after=told[1])) == "worse"


@pytest.mark.parametrize(
    "by_run",
    [(0.1, -0.09), (0.3, 0.001), (0.25, 0.26)],
    ids=["of both signs", "in one run only", "other than that of all together"],
)
def test_a_strength_that_varies_from_run_to_run(by_run: tuple[float, ...]) -> None:
    assert _objection(strengths=_strengths(*by_run)) == "varies"


def test_strengths_of_runs_that_can_hardly_tell_do_not_speak_against_it() -> None:
    assert _objection(strengths=_strengths(0.07, 0.14, error=0.04)) == ""


def test_the_plainest_objection_comes_first() -> None:
    worse = _held_out({DISPLACEMENT: 5.0}, {DISPLACEMENT: 9.0})
    assert _objection(gain=-1.0, held_out=worse, strengths=_strengths(0.1, -0.1)) == "null"
    assert _objection(gain=1.0, held_out=worse, strengths=_strengths(0.1, -0.1)) == "chance"
    assert _objection(held_out=worse, strengths=_strengths(0.1, -0.1)) == "worse"


@pytest.mark.parametrize(
    ("channel", "share"), [(DISPLACEMENT, OPTIONS.worse), (TEMPERATURE, OPTIONS.bent)], ids=["own", "of another stage"]
)
@pytest.mark.parametrize("level", [1.0, 4.0])
def test_an_error_may_rise_by_a_share_of_itself(channel: Channel, share: float, level: float) -> None:
    allowed = share * level
    for factor, worse in ((0.99, False), (1.01, True)):
        held_out = _held_out({channel: level}, {channel: level + factor * allowed})
        assert gets_worse(STAGE, held_out, OPTIONS) is worse


@pytest.mark.parametrize("channel", [DISPLACEMENT, TEMPERATURE])
def test_an_error_within_the_noise_does_not_rise(channel: Channel) -> None:
    assert not gets_worse(STAGE, _held_out({channel: 0.6}, {channel: 0.99}), OPTIONS)
    assert gets_worse(STAGE, _held_out({channel: 0.6}, {channel: 1.3}), OPTIONS)


def test_a_sensor_of_its_own_stage_may_rise_less_than_one_of_another() -> None:
    heat = StageProblem("heat", _fit(5.0, 0.0, TEMPERATURE), (), "model")
    bent = _held_out({TEMPERATURE: 1.0}, {TEMPERATURE: 1.1})
    assert not gets_worse(STAGE, bent, OPTIONS)
    assert gets_worse(heat, bent, OPTIONS)


def test_a_temperature_that_an_effect_does_nothing_to_does_not_speak() -> None:
    """A distance sensor that drifts cannot heat the strip; a refit of all stages together bends the heat."""
    both = StageProblem("both", _fit(5.0, 0.0, TEMPERATURE), (), "model")
    bent = _held_out({TEMPERATURE: 1.0, DISPLACEMENT: 50.0}, {TEMPERATURE: 1.9, DISPLACEMENT: 1.0})
    assert untouched_by(CREEP) is TEMPERATURE and untouched_by(find("radiation")) is None
    assert not gets_worse(both, bent, OPTIONS, untouched=TEMPERATURE)
    assert gets_worse(both, bent, OPTIONS)


@pytest.mark.parametrize(
    ("temperature", "displacement", "worse"),
    [
        ((50.0, 1.0), (20.0, 60.0), False),
        ((50.0, 1.0), (3.0, 60.0), True),
        ((50.0, 2.0), (20.0, 60.0), True),
        ((50.0, 2.0), (20.0, 40.0), False),
    ],
    ids=["explained", "the displacement was near its noise", "not explained", "by less than half of what it gains"],
)
def test_a_displacement_far_from_explained_says_nothing_of_what_explains_the_temperature(
    temperature: tuple[float, float], displacement: tuple[float, float], worse: bool
) -> None:
    heat = StageProblem("heat", _fit(50.0, 0.0, TEMPERATURE), (), "model")
    before, after = ({TEMPERATURE: t, DISPLACEMENT: d} for t, d in zip(temperature, displacement, strict=True))
    assert gets_worse(heat, _held_out(before, after), OPTIONS) is worse


@pytest.mark.parametrize(("after", "reason"), [(1.0, ""), (1.46, "small"), (1.6, "worse")])
def test_the_final_tables_have_to_show_that_an_effect_is_worth_having(after: float, reason: str) -> None:
    train = _misfit({DISPLACEMENT: 1.5}), _misfit({DISPLACEMENT: 1.0})
    held_out = _held_out({DISPLACEMENT: 1.5}, {DISPLACEMENT: after})
    step: Any = SimpleNamespace(trial=GOOD, train=train, held_out=held_out, actual_reduction=1.0)
    assert not_borne_out(step, OPTIONS) == reason


def test_a_trial_frees_every_parameter_of_the_effect_that_a_fit_may_change() -> None:
    radiation = find("radiation")
    model = MODEL.add("radiation")
    problem = replace(STAGE.fit.problem, model=model, free=(model.index("lumped.tau"),))
    freed = with_effect(problem, radiation)
    assert {model.values[i].key for i in freed.free} == {"lumped.tau", "radiation.emissivity"}
    assert freed.free == tuple(sorted(freed.free))
    assert with_effect(freed, radiation).free == freed.free


def test_a_second_start_has_the_strength_that_is_expected_and_all_else_as_it_was() -> None:
    there, before = effect_alone(STAGE, SCORE).model, STAGE.fit.problem.model
    assert there[CREEP.strength_key] == SCORE.expected_strength
    assert there["creep.tau_v"] == 8.0
    assert there.set({key: before[key] for key in (CREEP.strength_key, "creep.tau_v")}) == before


def test_a_second_start_without_a_slope_is_where_the_effect_leaves_least() -> None:
    """The score test expects the end of the camera's range at 103 °C, which the model never reaches."""
    time_s = np.arange(0.0, 120.0, 0.1)
    power_w = np.where(time_s % 40.0 < 25.0, 1.6, 0.2)
    plain = default_model("lumped", "none")
    shown = np.minimum(simulate(plain, time_s, power_w)[TEMPERATURE], KELVIN + 60.0)
    noise = 0.05 * np.random.default_rng(0).standard_normal(time_s.size)
    run = Run.of("a", Series(time_s, power_w), Series(time_s, shown + noise))
    clip = find("temperature_clip")
    [stage] = Search(plain, [run], (), [clip], OPTIONS, silent).present.heat
    direction = Direction(clip, clip.parameter(clip.strength), {}, 0.0125)
    score = replace(SCORE, effect=clip, direction=direction, expected_strength=0.0097)
    there = effect_alone(stage, score).model
    assert 1.0 / there[clip.strength_key] == pytest.approx(60.0, abs=0.3)
    assert there.set({clip.strength_key: 0.0}) == stage.fit.problem.model


def test_the_sizes_of_the_strength_are_not_tried_on_a_parameter_that_acts_alone() -> None:
    lag = replace(find("camera_lag"), step_sizes=(0.05, 0.2))
    fit = _fit(5.0, 0.0)
    problem = replace(fit.problem, model=fit.problem.model.add(lag.name))
    stage = replace(STAGE, fit=replace(fit, problem=problem))
    score = replace(SCORE, effect=lag, direction=Direction(lag, lag.parameter("delay"), {}, 5e-5))
    there = effect_alone(stage, score).model
    assert (there["camera_lag.delay"], there["camera_lag.tau"]) == (SCORE.expected_strength, 0.0)


@pytest.mark.parametrize(
    ("promised", "left", "far"),
    [(0.1, 4.6, False), (0.3, 4.6, True), (0.1, 3.8, True)],
    ids=["neither", "promises a quarter", "takes a quarter"],
)
def test_an_effect_goes_far_if_it_takes_or_promises_a_quarter_of_what_is_above_the_noise(
    promised: float, left: float, far: bool
) -> None:
    trial = Trial(STAGE, replace(SCORE, predicted_reduction=promised), _fit(left), gain=1.0)
    assert goes_far(trial, OPTIONS) is far


@pytest.mark.parametrize(
    ("left", "alike", "alias_set"),
    [
        (1.0, True, ("creep",)),
        (1.6, True, ("creep", "backlash")),
        (1.6, False, ("creep",)),
    ],
    ids=["the base explains all else", "the base lacks more than lies between them", "of another shape"],
)
def test_two_effects_of_one_shape_are_told_apart_by_more_than_what_the_base_lacks(
    left: float, alike: bool, alias_set: tuple[str, ...]
) -> None:
    """Both are refitted, and the better one leads by 300 of a squared error; the noise makes 1000 of it."""
    best = replace(GOOD, fit=_fit(left), gain=4000.0)
    rival = replace(GOOD, score=replace(SCORE, effect=find("backlash")), gain=3700.0, objection="varies")
    trials = Trials(LIBRARY, DataLeftOut(JudgedRuns.of([]), JudgedRuns.of([]), silent), OPTIONS, silent)
    trials.aliases["creep"] = ("backlash",) if alike else ()
    assert trials.alias_set(best, [best, rival]) == alias_set


@pytest.mark.parametrize(
    ("effect", "after", "runs", "explained"),
    [
        ("creep", 1.9, (8.0, 2.4), True),
        ("creep", 1.9, (18.0, 7.0), False),
        ("creep", 1.9, (5.0, 3.0), False),
        ("creep", 1.9, (1.6, 1.3), True),
        ("creep", 3.7, (8.0, 2.4), False),
        ("creep", 1.9, (8.0, 3.0), False),
        ("order_dependent_absorption", 4.5, (8.0, 3.0), True),
    ],
    ids=[
        "near the noise everywhere",
        "in the runs not",
        "in the runs not most",
        "in the runs not most, but they are explained",
        "most is not enough far from the noise",
        "nor is it in the runs",
        "the temperature, that it acts on, comes to its noise",
    ],
)
def test_the_last_effect_takes_most_of_a_sensor_that_it_acts_on(
    effect: str, after: float, runs: tuple[float, float], explained: bool
) -> None:
    trial: Any = SimpleNamespace(stage=SimpleNamespace(channels=SENSORS, drive="model"), effect=find(effect))
    unused: Any = None
    last = Step(unused, unused, unused, unused, trial, (effect,))

    def pair(temperature: tuple[float, float], displacement: tuple[float, float]) -> Pair:
        before, now = (
            _misfit({TEMPERATURE: t, DISPLACEMENT: d}) for t, d in zip(temperature, displacement, strict=True)
        )
        return Pair(before, now, before, now)

    assert _explains(last, "model", OPTIONS, pair((1.1, 0.97), (8.0, after)), pair((1.2, 0.99), runs)) is explained


@pytest.mark.parametrize(
    ("tried", "in_the_end", "after", "explained"),
    [
        ("measured", "measured", 3.0, False),
        ("measured", "measured", 1.5, True),
        ("measured", "model", 3.0, True),
        ("model", "measured", 3.0, True),
    ],
)
def test_the_last_effect_has_to_take_nearly_all_where_the_measured_temperature_drives_it_in_the_end_as_well(
    tried: Drive, in_the_end: Drive, after: float, explained: bool
) -> None:
    """It leaves ``after`` of 11, where 2.0 is nine tenths of what is above the noise, and 3.0 most of it."""
    trial: Any = SimpleNamespace(stage=SimpleNamespace(channels=SENSORS, drive=tried), effect=find("creep"))
    unused: Any = None
    before, now = _misfit({DISPLACEMENT: 11.0}), _misfit({DISPLACEMENT: after})
    last = Step(unused, unused, unused, unused, trial, ("creep",))
    assert _explains(last, in_the_end, OPTIONS, Pair(before, now, before, now)) is explained


@pytest.mark.parametrize(
    ("differing", "after", "explained"), [(1, 1.9, False), (1, 1.4, True), (0, 1.9, True), (0, 2.3, False)]
)
def test_beside_what_differs_in_its_part_most_is_enough_only_of_what_is_explained(
    differing: int, after: float, explained: bool
) -> None:
    """It leaves ``after`` of 4, where most would be 2.35 and explained is 1.44."""
    stage = SimpleNamespace(channels=(TEMPERATURE,), drive="model", part="heat")
    trial: Any = SimpleNamespace(stage=stage, effect=find("radiation"))
    unused: Any = None
    before, now = _misfit({TEMPERATURE: 4.0}), _misfit({TEMPERATURE: after})
    model = SimpleNamespace(varies={"lumped.gain": unused}, without=lambda _: unused)
    chain: Any = SimpleNamespace(
        options=OPTIONS,
        present=SimpleNamespace(model=model, drive="model"),
        of_part=lambda heat, _: [unused] * differing,
        refitted_part=lambda *_: SimpleNamespace(model=unused),
        left_out=SimpleNamespace(on_test_runs=lambda *_: None),
        of_the_runs=lambda _: Pair(before, now, before, now),
    )
    assert _explained(chain, Step(unused, unused, unused, unused, trial, ("radiation",))) is explained
