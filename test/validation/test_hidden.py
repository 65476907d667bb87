# SPDX-License-Identifier: Apache-2.0
"""The strips of the hidden suite, its counting, and a small fixed part of it (`make hidden` runs it all)."""

import ast
import json
import math
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from campaign import CAMPAIGNS, Case, campaign, waves
from cases import KINDS, cases, kind
from chapter5 import Dynamic, changed, wells
from effects import OUTSIDE, STRENGTH
from families import ALL, FAMILIES, HEAT_FAMILIES
from judge import judge, over_noise
from relays import Relays, turn
from report import Gate, false_additions, gates, named_first, report
from stages import Body, Floats
from suite import ran, read, run, until

from lce_analysis.diagnosis import add_effect, diagnose
from lce_analysis.diagnosis.looking_back import _leaves_its_shape
from lce_analysis.diagnosis.search import Search
from lce_analysis.identification import fit
from lce_analysis.options import DiagnoseOptions, FitOptions
from lce_data.channels import DISPLACEMENT, POWER, TEMPERATURE
from lce_data.progress import silent
from lce_data.run import Run, Series
from lce_model import Model, default_model
from lce_model.effects import library

HERE = Path(__file__).parents[2] / "validation" / "hidden"
TRUTHS = ("effects", "stages", "noise", "equilibrium", "chapter5", "relays", "independent", "families")
FAST = [name for name in FAMILIES if name != "independent"]
SECONDS = np.arange(5000) / 100.0


def _pulse(body: Body, share: float = 0.8) -> Floats:
    return np.where(SECONDS < 20.0, share * body.top_w, 0.0)


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))


@pytest.mark.parametrize("name", TRUTHS)
def test_a_truth_imports_nothing_of_the_product(name: str) -> None:
    nodes = list(ast.walk(ast.parse((HERE / f"{name}.py").read_text(encoding="utf-8"))))
    imported = [alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names]
    imported += [str(node.module) for node in nodes if isinstance(node, ast.ImportFrom)]
    assert not [module for module in imported if module.startswith("lce_")]


def test_what_can_be_hidden_is_of_the_library_but_for_some_that_it_does_not_know() -> None:
    assert set(STRENGTH) - set(library()) == set(OUTSIDE)


@pytest.mark.parametrize("name", FAST)
def test_with_nothing_hidden_the_strip_heats_as_a_body_of_first_order(name: str) -> None:
    strip = FAMILIES[name].random(np.random.default_rng(1))
    body = strip.body
    camera, distance = strip.ideal(_pulse(body), {}, np.random.default_rng(5))
    time = SECONDS[::10]
    on = 0.8 * body.reach_k * (1.0 - np.exp(-np.minimum(time, 20.0) / body.tau))
    expected = body.ambient + on * np.exp(-np.maximum(time - 20.0, 0.0) / body.tau)
    np.testing.assert_allclose(camera, expected, atol=1e-6)
    assert 1e-3 < distance.max() < 5e-3


@pytest.mark.parametrize("name", FAMILIES)
def test_noise_has_the_level_that_it_says(name: str) -> None:
    strip = FAMILIES[name].random(np.random.default_rng(1))
    for noise in strip.noise:
        spoiled = [noise.spoil(np.zeros(20000), np.random.default_rng(seed)) for seed in range(6)]
        rms = [_rms(values) for values in spoiled]
        assert all(0.65 * noise.rms < value < 1.35 * noise.rms for value in rms)
        first = np.mean([np.corrcoef(values[1:], values[:-1])[0, 1] for values in spoiled])
        assert first == pytest.approx(noise.slow * noise.memory, abs=0.03)


@pytest.mark.parametrize("name", FAST)
@pytest.mark.parametrize("effect", STRENGTH)
def test_everything_hidden_changes_what_is_measured(name: str, effect: str) -> None:
    case = Case(name, (effect,), "clear", 1)
    run = case.record("stairs", waves(case.strip.body.top_w)["stairs"])
    plain, hidden = case.ideal(run, hidden=False), case.ideal(run)
    changed_by = [_rms(hidden[channel] - plain[channel]) for channel in (TEMPERATURE, DISPLACEMENT)]
    assert changed_by[0] > 0.02 or changed_by[1] > 1.5e-6


def test_in_the_independent_strip_hides_what_happens_outside_of_it() -> None:
    family = FAMILIES["independent"]
    strip = family.random(np.random.default_rng(1))
    power = np.where(SECONDS[:1500] < 10.0, strip.body.top_w, 0.0)
    plain = strip.ideal(power, {}, np.random.default_rng(2))
    assert plain[0].max() > strip.body.ambient + 10.0
    lagged = strip.ideal(power, {"camera_lag": 0.4}, np.random.default_rng(2))
    np.testing.assert_array_equal(lagged[1], plain[1])
    assert _rms(lagged[0] - plain[0]) > 0.1
    assert not set(family.own) & set(family.may_hide)


@pytest.fixture(scope="module")
def late_strip() -> tuple[Model, list[Run], list[Run]]:
    """The independent strip loses heat by convection, into its clamp and by turning; its camera lags."""
    train, test = campaign(Case("independent", ("camera_lag",), "clear", 5))
    return fit(default_model("lumped", "none"), train).model, train, test


def test_a_loss_that_bears_what_else_is_missing_is_named_although_more_is_left_than_noise(
    late_strip: tuple[Model, list[Run], list[Run]],
) -> None:
    effects = [effect for effect in library().values() if effect.name != "camera_lag"]
    found = diagnose(*late_strip, effects)
    assert found.as_json()["added"] == ["natural_convection"]
    before, after = (found.test.misfit[column].rms[TEMPERATURE] for column in ("before", "after"))
    assert before > 2.0 * after > 2.0 * 1.2
    assert {c.effect.name for c in found.candidates if c.reason.startswith("it removes a part")} >= {"latent_heat"}


def test_a_lag_is_found_behind_what_a_strip_has_of_its_own(late_strip: tuple[Model, list[Run], list[Run]]) -> None:
    found = diagnose(*late_strip)
    added = found.as_json()["added"]
    assert added[0] == "natural_convection" and "camera_lag" in added
    assert set(added) <= {"camera_lag", *FAMILIES["independent"].own}
    assert found.test.misfit["before"].rms[TEMPERATURE] > 3.0 * found.test.misfit["after"].rms[TEMPERATURE]


def test_a_loss_of_another_form_is_not_named_where_it_leaves_a_little_more_than_noise() -> None:
    train, test = campaign(Case("chapter-5-continuous", ("natural_convection",), "clear", 6))
    found = diagnose(fit(default_model("lumped", "none"), train).model, train, test, [library()["radiation"]])
    (like_it,) = found.candidates
    assert like_it.trial is not None and 1.2**2 < like_it.trial.fit.mean_squares[TEMPERATURE] < 2.0**2
    assert (found.as_json()["added"], like_it.trial.objection) == ([], "form")


@pytest.mark.parametrize(("effect", "resembles"), [("radiation", True), ("natural_convection", False)])
def test_a_loss_of_another_form_leaves_its_shape_in_the_residual(effect: str, resembles: bool) -> None:
    train, test = campaign(Case("chapter-5-continuous", ("natural_convection",), "clear", 6))
    model = fit(default_model("lumped", "none"), train).model
    search = Search(model, train, test, [library()[effect]], DiagnoseOptions(), silent)
    assert _leaves_its_shape(search, search.force(library()[effect])) is resembles


def _molecules(strip: Dynamic, temperatures: Floats, x: float = 1.0) -> Floats:
    """The share of nematic molecules along temperatures [K] in small steps."""
    shares = []
    for before, after in pairwise(temperatures):
        branch = strip.heating if after > before else strip.cooling
        x = changed(x, 0.5 * (before + after), after - before, branch, strip.literal)
        shares.append(x)
    return np.asarray(shares)


@pytest.mark.parametrize("literal", [False, True])
def test_chapter_5_runs_from_nematic_to_isotropic_and_back(literal: bool) -> None:
    strip = Dynamic.random(np.random.default_rng(4), literal)
    up = np.arange(299.0, strip.heating.t_1 + 2.0, 0.002)
    path = np.concatenate([up, up[::-1]])
    shares = _molecules(strip, path)
    assert shares[up.size // 20] == pytest.approx(1.0, abs=1e-3)
    assert shares[up.size - 2] < 1e-3
    assert shares[-1] == pytest.approx(1.0, abs=1e-3)  # the loop is closed
    middle = np.argmin(np.abs(up - strip.cooling.t_star - 10.0))
    assert shares[middle] > shares[2 * up.size - 2 - middle] + 0.3  # and open in between


@pytest.mark.parametrize("literal", [False, True])
def test_chapter_5_jumps_at_t_star_if_it_is_literal_and_only_then(literal: bool) -> None:
    strip = Dynamic.random(np.random.default_rng(4), literal)
    down = np.arange(strip.cooling.t_1 + 1.0, strip.cooling.t_star - 3.0, -0.002)
    steps = np.abs(np.diff(_molecules(strip, down, x=0.0)))
    largest = np.argmax(steps)
    if literal:
        assert 0.01 < steps[largest] < 0.15
        assert down[largest + 1] == pytest.approx(strip.cooling.t_star, abs=0.005)
    else:
        assert steps[largest] < 0.005


def test_the_wells_of_chapter_5_are_one_above_t1_and_the_barrier_is_at_zero_below_t_star() -> None:
    branch = Dynamic.random(np.random.default_rng(4), False).heating
    barrier, well = wells(branch.t_1 + 1.0, branch)
    assert barrier == pytest.approx(well)
    assert wells(branch.t_star - 1.0, branch)[0] == 0.0


def _turned(strip: Relays, temperatures: Floats) -> Floats:
    half_widths, middles, spread = strip.population()
    last = temperatures[0] + half_widths
    form = strip.widening, strip.skewed
    return np.asarray([turn(last, t, half_widths, middles, spread, *form) for t in temperatures])


@pytest.mark.parametrize("random", [Relays.random, Relays.random_skewed])
def test_relays_close_their_loops_and_do_not_care_how_fast(random: Callable[[np.random.Generator], Relays]) -> None:
    strip = random(np.random.default_rng(2))
    out, back = np.linspace(290.0, 326.0, 400), np.linspace(326.0, 316.0, 100)
    path = np.concatenate([out, back, back[::-1], np.linspace(326.0, 350.0, 200), np.linspace(350.0, 290.0, 600)])
    order = _turned(strip, path)
    assert order[599] == pytest.approx(order[399], abs=1e-9)  # the minor loop is closed: return-point memory
    assert order[499] < 0.99 * np.interp(316.0, out, order[:400])  # and open in between
    assert order[-1] == pytest.approx(order[0], abs=1e-3)
    np.testing.assert_allclose(_turned(strip, path[::7])[-1], order[-1], atol=1e-3)


def test_a_case_makes_the_same_runs_each_time_and_others_for_another_seed() -> None:
    case = Case("relays", ("gusts",), "weak", 3, campaign="short")
    first, again = campaign(case), campaign(Case("relays", ("gusts",), "weak", 3, campaign="short"))
    assert [run.name for run in (*first[0], *first[1])] == [*CAMPAIGNS["short"][0], *CAMPAIGNS["short"][1]]
    for one, other in zip(first[0], again[0], strict=True):
        np.testing.assert_array_equal(one.series[TEMPERATURE].value, other.series[TEMPERATURE].value)
        noise = one.series[DISPLACEMENT].value - case.ideal(one)[DISPLACEMENT]
        assert 2e-6 < _rms(noise) < 6e-6
    assert Case("relays", ("gusts",), "weak", 4).strip.body != case.strip.body


def test_the_first_cases_are_a_fair_sample() -> None:
    every = cases(1)
    assert len({case.name for case in every}) == len(every)
    part = every[: len(every) // 4]
    for name in FAST:
        for kind_ in KINDS:
            whole = sum(case.family == name and kind(case.hidden, case.library) == kind_ for case in every)
            first = sum(case.family == name and kind(case.hidden, case.library) == kind_ for case in part)
            assert abs(first - whole / 4) <= 1.0
        nothing = [case for case in every if case.family == name and not case.hidden]
        assert len(nothing) == 20
    with_whole = [case for case in every if case.library == "without"]
    assert all(len(case.hidden) == 1 for case in with_whole)


FOUND: dict[str, Any] = {
    "case": "equilibrium/creep/clear/0", "family": "equilibrium", "hidden": ["creep"], "level": "clear",
    "library": "whole", "misfit": 3.0, "visible": 3.0, "verdict": "missing", "added": ["creep"], "sets": [["creep"]],
    "before": {"temperature": 1.0, "displacement": 3.2}, "after": {"temperature": 1.0, "displacement": 1.1},
    "after_on_every_sample": {"temperature": 1.0, "displacement": 1.4},
    "fingerprint": "", "fit_s": 2.0, "diagnose_s": 20.0, "advised": "",
}  # fmt: skip
ALIAS = FOUND | {"added": ["backlash"], "sets": [["backlash", "creep"]]}
WRONG = FOUND | {"added": ["creep", "radiation"], "sets": [["creep"], ["radiation"]]}
FAILED = {key: FOUND[key] for key in ("case", "family", "hidden", "level", "library")} | {"failed": "LceError: no"}


def _gates(results: list[dict[str, Any]]) -> dict[str, Gate]:
    return {gate.name: gate for gate in gates(results, FAMILIES["equilibrium"])}


def test_the_gates_count_what_they_say() -> None:
    found = _gates([FOUND, ALIAS, WRONG, FAILED])
    assert found["visible effect: named first"].passed == [True, False, True, False]
    assert found["visible effect: in a set"].passed == [True, True, True, False]
    assert found["named first: held-out error ≤ 1.3 × noise"].passed == [True, True]
    assert [false_additions(r) for r in (FOUND, ALIAS, WRONG, FAILED)] == [0, 0, 1, 1]


def test_what_the_library_lacks_must_not_get_a_name() -> None:
    outside = WRONG | {"hidden": ["draught"], "added": ["radiation"], "sets": [["radiation", "creep"]]}
    left_out = FOUND | {"library": "without", "added": [], "sets": []}
    nothing = FOUND | {"hidden": [], "added": [], "sets": [], "verdict": "adequate"}
    found = _gates([outside, left_out, nothing])
    assert found["outside the library: no wrong name"].passed == [False]
    assert found["effect left out: no wrong name"].passed == [True]
    assert found["nothing hidden: nothing added"].passed == [True]
    assert found["nothing hidden: adequate"].passed == [True]


def test_the_own_physics_of_a_family_is_no_false_addition_and_may_come_first() -> None:
    first = WRONG | {"family": "independent", "added": ["radiation", "creep"], "sets": [["radiation"], ["creep"]]}
    assert named_first(first)
    assert not named_first(first | {"family": "equilibrium"})
    assert false_additions(WRONG | {"family": "independent"}) == 0
    assert false_additions(WRONG | {"family": "independent", "added": ["backlash"], "sets": [["backlash"]]}) == 1


def test_the_advice_of_another_base_is_wrong_where_the_base_is_exact() -> None:
    advised = FOUND | {"hidden": [], "added": [], "sets": [], "verdict": "unexplained", "advised": "kinetic"}
    assert _gates([advised])["nothing hidden: nothing added"].passed == [False]
    assert false_additions(advised) == 1
    assert false_additions(advised | {"family": "relays"}) == 0


def test_families_with_a_base_of_the_same_kind_are_counted_together_as_well() -> None:
    other = WRONG | {"family": "chapter-5-literal", "added": ["radiation"], "sets": [["radiation"]]}
    text = report([FOUND, other], "v1")
    assert "| all with an exact base | 2 | **1 of 2** |" in text
    assert "all with an imperfect base" not in text


def test_seeds_that_no_version_was_mended_on() -> None:
    new = cases(1, ["relays"], first=1)
    assert not {case.name for case in new} & {case.name for case in cases(1, ["relays"])}
    assert {case.seed for case in new if not case.hidden} == set(range(20, 40))


def test_a_file_of_results_says_which_commands_made_it(tmp_path: Path) -> None:
    path = tmp_path / "results.jsonl"
    read(path, "v1")
    with path.open("a", encoding="utf-8") as log:
        log.writelines(json.dumps(line) + "\n" for line in ({"ran": "--seeds 1"}, {"case": "a"}, {"ran": "--only x"}))
    assert ran(path) == "`--seeds 1`, then `--only x`"
    assert read(path, "v1") == [{"case": "a"}]


def test_the_report_has_the_bars_and_every_case() -> None:
    text = report([FOUND, ALIAS, WRONG, FAILED], "v1")
    assert "| equilibrium | 4 | **2 of 4** | **3 of 4** | 2 of 2 |" in text
    assert "| visible effect: named first | ≥ 95% | 2 of 4 | 50% | 15%–85% |" in text
    assert "| false additions a case (nothing, one or two hidden) | ≤ 0.05 | 2 in 4 | 0.50 |" in text
    assert "| something visible hidden: names that are right | | 3 of 4 | 75% |" in text
    assert "| something visible hidden: no name given | | 0 of 3 | 0% |" in text
    assert "| failed | LceError: no |" in text


def test_the_report_says_where_the_answer_advises_another_base_model() -> None:
    text = report([FOUND | {"verdict": "unexplained", "advised": "equilibrium"}], "v1")
    assert "| equilibrium/creep/clear/0 | 3.00 | unexplained, begin with equilibrium | creep | 3.20 → 1.10 |" in text


def test_results_of_another_version_are_refused_and_a_line_that_was_cut_off_is_left_out(tmp_path: Path) -> None:
    path = tmp_path / "results.jsonl"
    assert read(path, "v1") == []
    with path.open("a", encoding="utf-8") as log:
        log.write(json.dumps({"case": "a"}) + "\n" + '{"case": "b')
    assert read(path, "v1") == [{"case": "a"}]
    assert read(path, "v1") == [{"case": "a"}]
    with pytest.raises(SystemExit, match="is of version v1, the software is v2: --fresh"):
        read(path, "v2")


def test_no_case_begins_after_the_time_is_over() -> None:
    todo = [Case("relays", (), "clear", seed) for seed in range(3)]
    assert list(until(-math.inf, todo)) == []
    assert list(until(math.inf, todo)) == todo


def test_a_case_that_raises_is_a_result() -> None:
    found = judge(Case("relays", ("no such effect",), "clear", 0))
    assert found["failed"] == "KeyError: 'no such effect'"


def test_cases_run_side_by_side_and_one_that_raises_does_not_stop_the_others() -> None:
    todo = [Case("relays", (name,), "clear", 0) for name in ("no such effect", "nor this one", "nor that one")]
    found = list(run(todo, minutes=10.0, scheduler=None, jobs=2))
    assert {r["case"] for r in found} == {case.name for case in todo}
    assert all("KeyError" in r["failed"] for r in found)
    assert list(run(todo, minutes=0.0, scheduler=None, jobs=2)) == []


@pytest.mark.slow
def test_cases_run_on_a_dask_cluster() -> None:
    distributed = pytest.importorskip("distributed", reason="distributed is an optional package")
    todo = [Case("relays", (name,), "clear", 0) for name in ("no such effect", "nor this one")]
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        found = list(run(todo, minutes=10.0, scheduler=cluster.scheduler_address, jobs=1))
    assert {r["case"] for r in found} == {case.name for case in todo}
    assert all("KeyError" in r["failed"] for r in found)


@pytest.mark.parametrize("name", [name for name in HEAT_FAMILIES if not HEAT_FAMILIES[name].own])
def test_where_the_camera_alone_looks_on_all_that_is_hidden_changes_what_it_shows(name: str) -> None:
    for case in (c for c in cases(1, [name], "short") if c.hidden and c.level == "clear" and c.library == "whole"):
        changes = []
        for recorded in campaign(case)[0]:
            assert set(recorded.series) == {POWER, TEMPERATURE}
            with_it, without = (case.ideal(recorded, hidden) for hidden in (True, False))
            changes.append(_rms(with_it[TEMPERATURE] - without[TEMPERATURE]))
        assert max(changes) > 0.01, case.name


@pytest.mark.slow
@pytest.mark.timeout(300)  # half a minute on a machine to itself
@pytest.mark.parametrize(
    ("family", "hidden", "verdict"),
    [
        ("equilibrium", (), "adequate"),
        ("equilibrium", ("laser_droop",), "missing"),
        ("chapter-5-continuous", ("camera_lag",), "missing"),
        ("chapter-5-literal", (), "adequate"),
        ("relays", ("radiation",), "missing"),
        ("relays-heat", ("radiation",), "missing"),
    ],
)
def test_the_diagnosis_of_a_strip_that_the_product_has_never_seen(
    family: str, hidden: tuple[str, ...], verdict: str
) -> None:
    result = judge(Case(family, hidden, "clear", 0, campaign="short"))
    assert result.get("failed") is None
    assert result["verdict"] == verdict
    assert result["added"][:1] == list(hidden)
    if verdict == "adequate":
        assert result["added"] == []
    elif ALL[family].exact:
        assert max(result["after"].values()) < 1.3


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_an_effect_is_named_although_the_forms_of_the_base_model_are_wrong() -> None:
    # A transition that takes time, in a strip whose loop and stretch no base model describes.
    train, test = campaign(Case("skewed-relays", ("phase_kinetics",), "clear", 9, campaign="short"))
    found = diagnose(fit(default_model("lumped", "kinetic"), train).model, train, test)
    assert found.as_json()["added"] == ["phase_kinetics"]
    assert found.test.misfit["after"].rms[DISPLACEMENT] > 2.0  # the base model is wrong as well
    errors = found.free_forms["phase_kinetics"]
    assert errors.before.rms[DISPLACEMENT] > 2.0 * errors.after.rms[DISPLACEMENT]
    assert any("do not replace phase_kinetics" in sentence for sentence in found.sentences)


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_wrong_forms_of_the_base_model_are_no_effect() -> None:
    result = judge(Case("skewed-relays", (), "clear", 180, campaign="short"))
    assert (result["added"], result["verdict"]) == ([], "unexplained")
    assert result["after"]["displacement"] > 4.0


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_what_explains_only_the_runs_that_it_was_fitted_to_is_not_named() -> None:
    # Clamps that warm up, and an ambient temperature for each run, do in the six runs what a drift of it does.
    result = judge(Case("skewed-relays", ("ambient_drift",), "clear", 9, "without"))
    assert (result["added"], result["verdict"]) == ([], "cannot_tell")


@pytest.mark.parametrize(
    ("hidden", "level", "seed", "added"),
    [
        (("temperature_clip",), "weak", 0, ["natural_convection", "temperature_clip"]),
        # A value of the laser's gain for each run takes some of what the strip has of its own.
        ((), "clear", 14, ["natural_convection", "latent_heat"]),
    ],
)
def test_what_takes_most_beside_the_others_is_named_although_one_of_those_only_resembles_what_is_missing(
    hidden: tuple[str, ...], level: str, seed: int, added: list[str]
) -> None:
    result = judge(Case("independent-heat", hidden, level, seed))
    assert result["added"] == added
    assert result["before"]["temperature"] > 3.0 * result["after"]["temperature"]


def test_what_bears_another_only_while_a_parameter_differs_from_run_to_run_is_not_named() -> None:
    case = Case("equilibrium-by-dynamic", ("ambient_drift",), "clear", 0, "without")
    result = judge(case)
    assert (result["added"], result["verdict"]) == ([], "cannot_tell")
    assert result["before"]["temperature"] > 2.0


@pytest.mark.slow
@pytest.mark.timeout(900)  # two minutes on a machine to itself
def test_the_deformation_is_judged_behind_the_heat_that_drives_it_in_the_end() -> None:
    result = judge(Case("independent", (), "clear", 1))
    # The measured temperature drove it when the kinetics were tried; with them, the temperature of the model does.
    assert "phase_kinetics" in result["added"]
    assert result["before"]["displacement"] > 2.0 * result["after"]["displacement"]


@pytest.mark.slow
@pytest.mark.timeout(300)  # a minute on a machine to itself
def test_an_imitation_that_fits_a_little_better_does_not_stand_in_the_way_of_the_true_effect() -> None:
    result = judge(Case("chapter-5-literal", ("thermal_gradient",), "weak", 2))
    assert result.get("failed") is None
    assert result["added"] == ["thermal_gradient"]  # phase_kinetics is found first, and taken back


@pytest.mark.slow
@pytest.mark.timeout(400)  # a minute on a machine to itself
@pytest.mark.parametrize(
    ("missing", "seed", "imitation", "objection"),
    [
        # Softening with its longest scale is a straight line, and leaves 1.03 × noise.
        ("thermal_expansion", 3, "elastic_softening", "bound"),
        # A curve takes most of the 3.4 × noise that an expansion leaves, though not all.
        ("elastic_softening", 4, "thermal_expansion", "form"),
    ],
)
def test_a_near_twin_of_what_is_missing_is_not_named(missing: str, seed: int, imitation: str, objection: str) -> None:
    family = "equilibrium" if objection == "bound" else "chapter-5-continuous"
    train, test = campaign(Case(family, (missing,), "clear", seed))
    model = fit(default_model("lumped", ALL[family].base), train, FitOptions(seed=seed)).model
    found = diagnose(model, train, test, [e for e in library().values() if e.name != missing])
    (like_it,) = (c.trial for c in found.candidates if c.effect.name == imitation)
    assert like_it is not None
    assert (found.as_json()["added"], like_it.objection) == ([], objection)


@pytest.mark.slow
@pytest.mark.timeout(300)  # half a minute on a machine to itself
def test_of_two_effects_that_do_the_same_the_one_at_a_bound_comes_second() -> None:
    result = judge(Case("chapter-5-continuous", ("thermal_expansion",), "clear", 3))
    assert result.get("failed") is None
    assert result["sets"] == [["thermal_expansion", "elastic_softening"]]


@pytest.mark.slow
@pytest.mark.timeout(300)  # a minute on a machine to itself
def test_what_is_found_in_the_place_of_an_imitation_has_to_explain_everything() -> None:
    result = judge(Case("equilibrium", ("phase_kinetics",), "clear", 2, "without"))
    assert result.get("failed") is None
    assert result["added"] == []  # thermal_gradient takes 91 % after creep is taken back, and leaves 3.7 × noise


@pytest.mark.slow
@pytest.mark.timeout(300)  # a minute on a machine to itself
@pytest.mark.parametrize("family", ["chapter-5-literal", "chapter-5-continuous"])
def test_a_loss_of_another_form_is_not_named_although_it_takes_nearly_all_of_the_error(family: str) -> None:
    train, test = campaign(Case(family, ("natural_convection",), "clear", 1))
    model = fit(default_model("lumped", ALL[family].base), train, FitOptions(seed=1)).model
    found = diagnose(model, train, test, [e for e in library().values() if e.name != "natural_convection"])
    (like_it,) = (c.trial for c in found.candidates if c.effect.name == "radiation")
    assert like_it is not None
    assert (found.as_json()["added"], like_it.objection) == ([], "form")


@pytest.mark.slow
@pytest.mark.timeout(300)  # half a minute on a machine to itself
def test_an_expansion_is_found_whatever_the_temperature_at_which_the_strip_had_its_length() -> None:
    result = judge(Case("chapter-5-literal", ("thermal_expansion",), "clear", 1))
    assert result["added"] == ["thermal_expansion"]
    assert result["after"]["displacement"] < 1.05


@pytest.mark.slow
@pytest.mark.timeout(300)  # a minute on a machine to itself
def test_a_refit_does_not_let_the_jumps_of_a_strip_drift() -> None:
    result = judge(Case("chapter-5-literal", ("sticking_guide",), "clear", 0))
    assert result["added"] == []
    assert result["after"]["displacement"] < 1.1 * result["before"]["displacement"]


@pytest.mark.slow
@pytest.mark.timeout(300)  # a minute on a machine to itself
@pytest.mark.parametrize(("hidden", "level"), [("thermal_gradient", "weak"), ("elastic_softening", "clear")])
def test_a_strip_that_jumps_is_explained_to_the_noise_away_from_its_jumps(hidden: str, level: str) -> None:
    result = judge(Case("chapter-5-literal", (hidden,), level, 0))
    assert result["added"] == [hidden]
    assert result["before"]["displacement"] > 5.0
    assert max(result["after"].values()) < 1.3


POOR = {
    "ambient.t_env": 296.17,
    "lumped.gain": 34.879,
    "lumped.tau": 23.513,
    "dynamic.a0_r": 5.01e-23,
    "dynamic.b_r": 2.272e-20,
    "dynamic.c_r": 5.302e-20,
    "dynamic.a0_f": 2.999e-21,
    "dynamic.b_f": 8.001e-21,
    "dynamic.c_f": 1.999e-19,
    "dynamic.t_star": 313.25,
    "dynamic.cr1_r": 3e-4,
    "dynamic.cr2_r": 309.6,
    "dynamic.cf1_r": 2.945,
    "dynamic.cr1_f": 0.0616,
    "dynamic.cf1_f": 999.0,
    "dynamic.cf2_f": 25.28,
    "dynamic.spinodal": 1948.0,
    "stretch_law.alpha": 6.481,
}
"""Where `lce fit` once ended on chapter-5-continuous/nothing/clear/19: 40 × the noise on the runs held out."""


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_a_fit_hops_out_of_a_poor_minimum_beside_the_best_one() -> None:
    case = Case("chapter-5-continuous", (), "clear", 1)
    train, _ = campaign(case)
    base = default_model("lumped", "dynamic")
    alone, hopped = (fit(base, train, FitOptions(hops=hops)).model for hops in (0, 8))
    left = [over_noise(m, train, {run.name: case.ideal(run) for run in train})["displacement"] for m in (alone, hopped)]
    assert left[1] <= min(1.02, left[0])


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_an_effect_that_only_led_out_of_a_poor_minimum_is_not_named() -> None:
    train, test = campaign(Case("chapter-5-continuous", (), "clear", 19))
    poor = default_model("lumped", "dynamic").set(POOR)
    found = diagnose(poor, train, test, [library()["transition_distribution"]])
    assert found.steps == ()
    assert found.verdict == "adequate"
    assert found.test.misfit["before"].rms[DISPLACEMENT] < 1.3
    assert found.test.misfit["given"].rms[DISPLACEMENT] > 10.0


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_no_other_base_is_advised_beside_one_in_a_poor_minimum() -> None:
    train, test = campaign(Case("chapter-5-continuous", (), "clear", 19))
    poor = default_model("lumped", "dynamic").set(POOR)
    found = diagnose(poor, train, test, [library()["displacement_clip"]])  # which nothing passes that leads out of it
    assert (found.verdict, found.other_base) == ("adequate", None)
    assert found.test.misfit["after"].rms[DISPLACEMENT] < 1.3
    assert [candidate.trial for candidate in found.candidates] == [None]


@pytest.mark.slow
@pytest.mark.timeout(300)  # a minute on a machine to itself
def test_an_effect_beside_another_base_that_leaves_more_than_noise_is_not_named() -> None:
    result = judge(Case("equilibrium-by-dynamic", ("displacement_drift",), "clear", 4, "without"))
    assert result.get("failed") is None
    # The equilibrium model with creep leaves 1.5 × the noise, and without creep no less than the dynamic one.
    assert (result["advised"], result["added"]) == ("", [])


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_creep_longer_than_the_runs_does_not_stand_in_for_a_sensor_that_drifts() -> None:
    result = judge(Case("equilibrium", ("displacement_drift",), "clear", 11, "without"))
    assert result.get("failed") is None
    assert result["added"] == []
    (creep,) = [one for one in result["tried"] if one["effect"] == "creep"]
    assert creep["standing"] == "trace" and "longer than the runs" in creep["reason"]


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_an_effect_that_only_led_out_of_a_poor_minimum_is_not_confirmed_where_it_is_added() -> None:
    train, test = campaign(Case("chapter-5-continuous", (), "clear", 19))
    poor = default_model("lumped", "dynamic").set(POOR)
    added = add_effect(poor, "transition_distribution", train, test)
    assert added.objection
    assert added.actual_reduction < 0.01
    assert added.test.misfit["before"].rms[DISPLACEMENT] < 1.3


def _late(run: Run) -> Run:
    """Shown by a camera with a dead time of two of its samples."""
    time_s, shown = run.series[TEMPERATURE].time_s, run.series[TEMPERATURE].value
    late = Series(time_s, np.concatenate([np.full(2, shown[0]), shown[:-2]]))
    return replace(run, series={**run.series, TEMPERATURE: late})


def _with_threshold(run: Run) -> Run:
    """Heated by a laser that was asked for 0.1 W more than it gave."""
    time_s, given_w = run.series[POWER].time_s, run.series[POWER].value
    asked = Series(time_s, np.where(given_w > 0.0, given_w + 0.1, 0.0))
    return replace(run, series={**run.series, POWER: asked})


@pytest.mark.slow
@pytest.mark.timeout(300)
@pytest.mark.parametrize(("name", "changed"), [("camera_lag", _late), ("laser_saturation", _with_threshold)])
def test_a_dead_time_and_a_threshold_are_named_without_a_lag_or_a_saturation(
    name: str, changed: Callable[[Run], Run]
) -> None:
    made = campaign(Case("equilibrium", (), "clear", 0, campaign="short"))
    train, test = ([changed(one) for one in runs] for runs in made)
    found = diagnose(fit(default_model("lumped", "equilibrium"), train).model, train, test)
    assert [step.added for step in found.steps] == [name]
    assert found.test.misfit["after"].rms[TEMPERATURE] < 1.1
