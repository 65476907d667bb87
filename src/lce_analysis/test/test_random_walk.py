# SPDX-License-Identifier: Apache-2.0
"""Walks of a heated body that this file integrates itself, in plain NumPy: nothing of the product makes the data."""

from collections.abc import Callable, Sequence

import numpy as np
import pytest
from numpy.typing import NDArray

from lce_analysis.diagnosis.misfit import JudgedRuns
from lce_analysis.diagnosis.stage_problem import Data, StagedFit, refit_stages
from lce_analysis.discovery.random_walk import Walk, WalkOptions, disturbances
from lce_analysis.options import DiagnoseOptions
from lce_analysis.prediction import simulation_input
from lce_data.channels import TEMPERATURE
from lce_data.errors import LceError
from lce_data.progress import silent
from lce_data.run import Run, Series
from lce_model import default_model

Floats = NDArray[np.float64]
Change = Callable[[Floats, np.random.Generator], Floats]
"""Time (n,) [s] → relative change of a parameter (n,)."""

AMBIENT_K, GAIN, TAU = 301.15, 30.0, 18.0
TIME_S = np.arange(0.0, 60.0, 0.01)


def _power(i: int) -> Floats:
    """A pulse, a staircase, a wave, each a little different; always on for most of the time."""
    shapes = (
        np.where(35.0 + i > TIME_S, 1.2, 0.3),
        0.3 * (1.0 + np.floor(TIME_S / 15.0) % 4.0),
        0.8 + 0.5 * np.sin(2.0 * np.pi * TIME_S / (17.0 + i)),
    )
    return shapes[i % 3]


def _none(time_s: Floats, rng: np.random.Generator) -> Floats:
    return np.zeros_like(time_s)


def _heated(light: Change = _none, loss: Change = _none, law: float = 0.0, runs: int = 4, seed: int = 0) -> list[Run]:
    """A body of one temperature; ``law`` [1/K] lets its loss grow with the excess temperature. Camera: 10 Hz, AR(1)."""
    found = []
    for i in range(runs):
        rng = np.random.default_rng([seed, i])
        power = _power(i)
        lit, lost = power * (1.0 + light(TIME_S, rng)), 1.0 + loss(TIME_S, rng)
        excess = np.zeros(TIME_S.size)
        for n in range(TIME_S.size - 1):
            rate = (GAIN * lit[n] - excess[n] * lost[n] * (1.0 + law * excess[n])) / TAU
            excess[n + 1] = excess[n] + 0.01 * rate
        noise = rng.standard_normal(TIME_S[::10].size)
        for n in range(1, noise.size):
            noise[n] = 0.5 * noise[n - 1] + np.sqrt(0.75) * noise[n]
        camera = AMBIENT_K + excess[::10] + 0.05 * noise
        found.append(
            Run.of(f"run-{i}", Series(TIME_S, power), Series(TIME_S[::10], camera), None, sha256=f"{seed}-{i}")
        )
    return found


def _fitted(runs: Sequence[Run]) -> StagedFit:
    model = default_model("lumped", "none").set({"lumped.gain": GAIN, "lumped.tau": TAU, "ambient.t_env": AMBIENT_K})
    data = Data(JudgedRuns.of(runs), tuple(simulation_input(run, model) for run in runs))
    return refit_stages(model, data, [], DiagnoseOptions(), silent)


def _walk(runs: Sequence[Run]) -> Walk:
    (walk,) = disturbances(_fitted(runs))
    return walk


def _hops(time_s: Floats, rng: np.random.Generator) -> Floats:
    modes = rng.integers(0, 2, 40) * 2.0 - 1.0
    return np.asarray(0.1 * modes[(time_s // 4.0).astype(int)])


def _draught(time_s: Floats, rng: np.random.Generator) -> Floats:
    return 0.2 * np.sin(2.0 * np.pi * time_s / 11.0 + rng.uniform(0.0, 2.0 * np.pi))


def _gusts(time_s: Floats, rng: np.random.Generator) -> Floats:
    found, memory = np.empty(time_s.size), np.exp(-0.01 / 4.0)
    found[0] = rng.standard_normal()
    for n in range(1, time_s.size):
        found[n] = memory * found[n - 1] + np.sqrt(1.0 - memory**2) * rng.standard_normal()
    return 0.2 * found


def test_a_laser_that_hops_is_a_disturbance_of_the_light_in_steps() -> None:
    walk = _walk(_heated(light=_hops))
    assert (walk.kind, walk.parameter.name, walk.pattern.kind) == ("disturbance", "light", "steps")
    assert walk.pattern.seconds == pytest.approx(4.0, abs=1.5)
    assert walk.words.startswith("a disturbance of the light, in steps, ")


def test_the_smoothed_path_is_the_one_that_was_put_in() -> None:
    walk = _walk(_heated(light=_hops))
    for i, path in enumerate(walk.paths):
        truth = _hops(path.time_s, np.random.default_rng([0, i]))
        moved = path.level - path.level.mean() - (truth - truth.mean())
        assert np.sqrt(np.mean(moved**2)) < 0.04
        assert np.mean(np.abs(moved) < 3.0 * path.band + 0.01) > 0.9


def test_a_draught_has_a_period() -> None:
    walk = _walk(_heated(loss=_draught))
    assert (walk.kind, walk.parameter.name, walk.pattern.kind) == ("disturbance", "loss", "period")
    assert walk.pattern.seconds == pytest.approx(11.0, rel=0.05)
    assert walk.words == "a disturbance of the heat loss, with a period of 11 s"


def test_gusts_have_none() -> None:
    walk = _walk(_heated(loss=_gusts))
    assert (walk.kind, walk.pattern.kind) == ("disturbance", "correlated")
    assert "loss" in [p.name for p in walk.alike]
    assert 1.0 <= walk.pattern.seconds <= 12.0


def test_a_path_that_repeats_is_a_law_and_no_disturbance() -> None:
    walk = _walk(_heated(law=0.004))
    assert (walk.kind, walk.parameter.name) == ("follows", "loss")
    assert walk.dependences["temperature"] > 0.9
    assert walk.words.startswith("the heat loss follows the temperature (")


def test_what_the_model_explains_needs_no_walk() -> None:
    assert [disturbances(_fitted(_heated(seed=seed, runs=3))) for seed in range(20)] == [()] * 20


def test_a_zero_that_wanders_is_told_from_the_heat() -> None:
    runs = _heated()
    rng = np.random.default_rng(5)
    wandering = []
    for run in runs:
        series = run.series[TEMPERATURE]
        zero = np.repeat(rng.normal(0.0, 0.4, 30), 20)
        camera = Series(series.time_s, series.value + zero)
        wandering.append(Run.of(run.name, run.power, camera, None, sha256=f"zero-{run.name}"))
    walk = _walk(wandering)
    assert (walk.kind, walk.parameter.name) == ("disturbance", "temperature_zero")


def test_options_name_the_field_that_cannot_be_used() -> None:
    with pytest.raises(LceError, match="repeats: 2 must be within"):
        WalkOptions(repeats=2.0)
