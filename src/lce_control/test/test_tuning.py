# SPDX-License-Identifier: Apache-2.0
"""Gains found on a plant whose best is known, requirements as constraints, and the loops of a real strip."""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from lce_control.tuning.linear import OMEGA, Complex, margins
from lce_control.tuning.options import TuneOptions
from lce_control.tuning.requirements import Parameters, Requirements, Step
from lce_control.tuning.search import Task, refine, search
from lce_control.tuning.tasks import INNER, OUTER, SINGLE, TuningPlant, tune
from lce_data.errors import Cancelled, LceError
from lce_data.progress import CancelToken, silent
from lce_model import default_model

pytestmark = pytest.mark.slow

TIME = np.linspace(0.0, 20.0, 401)
SHORT = TuneOptions(generations=8, candidates=4, local_tries=20, experiments=25)
STRIP = default_model("lumped", "kinetic").set({"lumped.gain": 73.0})


def answer(kp: float, best_kp: float) -> np.ndarray:
    """A second-order step: faster and more oscillating with kp; at ``best_kp`` damped by 0.7."""
    damping, omega = 0.7 * math.sqrt(best_kp / kp), math.sqrt(kp / best_kp)
    if damping >= 1.0:
        damping = 0.999
    damped = omega * math.sqrt(1.0 - damping**2)
    decay = np.exp(-damping * omega * TIME)
    return 1.0 - decay * (np.cos(damped * TIME) + damping * omega / damped * np.sin(damped * TIME))


def oscillator(best_kp: float) -> Task:
    def steps(parameters: Parameters) -> tuple[Step, ...]:
        return (Step(1.0, TIME, answer(parameters["node"]["kp"], best_kp), np.zeros(TIME.size)),)

    def open_loops(parameters: Parameters) -> Mapping[str, Complex]:
        return {"loop": 0.1 * parameters["node"]["kp"] / (1j * OMEGA * (1j * OMEGA + 1.0))}

    box = {"node.kp": (0.1, 100.0), "node.ti": (1.0, 2.0), "node.td": (0.1, 0.2)}
    return Task("oscillator", box, steps, open_loops)


def test_the_search_finds_the_fastest_that_meets_the_requirements() -> None:
    # Overshoot exp(-π ζ/√(1-ζ²)) = 5 % is at ζ = 0.690; the ITAE has its smallest value at less damping.
    at_limit = 3.0 * (0.7 / 0.690) ** 2
    found = search(oscillator(3.0), Requirements(overshoot=0.05), SHORT, silent)
    assert found.parameters["node"]["kp"] == pytest.approx(at_limit, rel=0.05)
    assert found.worst()["overshoot"] <= 0.05
    free = search(oscillator(3.0), Requirements(overshoot=0.5), SHORT, silent)
    assert free.itae <= found.itae


def test_margins_are_constraints_too() -> None:
    task = oscillator(100.0)
    wanted = Requirements(phase_margin_deg=70.0)
    found = search(task, wanted, SHORT, silent)
    assert margins(found.open_loops["loop"]).phase_deg >= 70.0
    assert (
        search(task, Requirements(phase_margin_deg=30.0), SHORT, silent).parameters["node"]["kp"]
        > found.parameters["node"]["kp"]
    )


def test_what_cannot_be_met_is_said_with_its_figures() -> None:
    with pytest.raises(LceError, match=r"oscillator: no gains found .* rise_s \d+\.?\d* instead of 0\.01"):
        search(oscillator(3.0), Requirements(rise_s=0.01), SHORT, silent)
    with pytest.raises(LceError, match="overshoot: -1 must be above 0"):
        Requirements(overshoot=-1.0)


def test_the_refinement_follows_the_experiment() -> None:
    """The model was wrong by 40 %: in the experiment its gains overshoot too much, the refined ones do not."""
    wanted = Requirements(overshoot=0.05)
    start = search(oscillator(3.0), wanted, SHORT, silent)
    experiment = oscillator(1.8)
    assert experiment.tuned(start.parameters).worst()["overshoot"] > 0.05
    found = refine(experiment, start, wanted, SHORT, silent)
    assert found.worst()["overshoot"] <= 0.05
    assert found.parameters["node"]["kp"] == pytest.approx(1.8 * (0.7 / 0.690) ** 2, rel=0.1)


def test_undershoot_is_a_fall_after_the_target_was_reached() -> None:
    reached = np.interp(TIME, [0.0, 2.0, 4.0, 6.0, 20.0], [0.0, 1.1, 0.9, 1.0, 1.0])
    assert Step(1.0, TIME, reached, TIME).undershoot == pytest.approx(0.1, abs=0.01)
    assert Step(1.0, TIME, 0.5 * reached, TIME).undershoot == 0.0


def test_ripple_is_the_power_around_its_trend() -> None:
    slow = Step(1.0, TIME, TIME, 2.0 - 0.05 * TIME)
    assert slow.power_ripple_w == pytest.approx(0.0, abs=1e-12)
    noisy = Step(1.0, TIME, TIME, 2.0 - 0.05 * TIME + 0.1 * (-1.0) ** np.arange(TIME.size))
    assert noisy.power_ripple_w == pytest.approx(0.1, rel=0.01)


def test_a_strip_is_tuned_within_the_requirements() -> None:
    plant = TuningPlant.of(STRIP, options=TuneOptions(generations=1, candidates=2, local_tries=30))
    assert 0.0 < plant.targets_m[0] < plant.targets_m[-1] < 3e-3
    wanted = Requirements(overshoot=0.3, undershoot=0.3)
    inner, double, single = tune(plant, wanted, silent)
    for found, nodes in ((inner, {INNER}), (double, {INNER, OUTER}), (single, {SINGLE})):
        assert set(found.parameters) == nodes
        worst = found.worst()
        assert (
            worst["overshoot"] <= 0.3
            and worst["power_ripple_w"] <= 0.05
            and worst["gain_margin"] >= 2.0
            and worst["phase_margin_deg"] >= 45.0
        )
    assert double.parameters[INNER]["kp"] <= inner.parameters[INNER]["kp"], "softer, if anything, than alone"


def test_a_model_without_both_stages_is_refused() -> None:
    with pytest.raises(LceError, match="a thermal and a deformation stage"):
        TuningPlant.of(default_model("lumped", "none"))


@pytest.mark.parametrize("calls", [1, 15])
def test_a_cancelled_search_ends_at_its_next_candidate(calls: int) -> None:
    token, seen = CancelToken(), []

    def watch(label: str, done: int, total: int, itae: float) -> None:
        seen.append((label, done, total))
        if len(seen) == calls:
            token.cancel()

    with pytest.raises(Cancelled):
        search(oscillator(3.0), Requirements(overshoot=0.5), SHORT, token.watching(watch))
    assert len(seen) == calls and seen[0] == ("oscillator", 0, SHORT.generations)


@pytest.mark.parametrize(
    ("field", "value", "said"),
    [
        ("generations", 0, "generations: 0 is not 1 or more"),
        ("first_step", 0.0, "first_step: 0 must be above 0"),
        ("filter_s", math.nan, "filter_s: nan must be 0 or above"),
        ("shortest_s", 400.0, "shortest_s: 400 is above longest_s, 300"),
        ("shares", (0.5, 1.2), "each must be within"),
    ],
)
def test_options_that_cannot_be_used_are_refused(field: str, value: object, said: str) -> None:
    with pytest.raises(LceError, match=said):
        replace(TuneOptions(), **{field: value})  # type: ignore[arg-type]
