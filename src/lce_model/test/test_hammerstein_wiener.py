# SPDX-License-Identifier: Apache-2.0
"""The Hammerstein–Wiener model against (6.3)–(6.6), at any step."""

import numpy as np
import pytest
from scipy.signal import lfilter

from lce_data.errors import LceError
from lce_model import Model, Stepper, default_model, simulate
from lce_model.terms import Parameter, Term
from lce_model.thermal.hammerstein_wiener import PIECES, curve, inverse

POLES, ZERO, SAMPLE_S, AMBIENT_K = (15.0, 2.0, 0.3), 1.2, 0.01, 300.0
RNG = np.random.default_rng(1)
PHI = np.append(1.0, RNG.uniform(0.3, 2.0, PIECES - 1))
PSI = RNG.uniform(20.0, 60.0, PIECES)


def model() -> Model:
    names = dict(zip(("tau_1", "tau_2", "tau_3", "tau_z"), (*POLES, ZERO), strict=True))
    slopes = {f"{name}_{i + 1}": x for name, row in (("phi", PHI), ("psi", PSI)) for i, x in enumerate(row)}
    changes = {f"hammerstein_wiener.{k}": x for k, x in {**names, **slopes}.items()}
    return default_model("hammerstein_wiener", "none").set({**changes, "ambient.t_env": AMBIENT_K})


def levels(time_s: np.ndarray) -> np.ndarray:
    """A power that changes every second."""
    return np.array([0.0, 1.7, 0.4, 2.0, 1.1, 0.0])[np.floor(time_s + 1e-9).astype(int) % 6]


def broken(values: np.ndarray, top: float, slopes: np.ndarray) -> np.ndarray:
    """(6.3) and (6.4) by their break points."""
    at = np.linspace(0.0, top, PIECES + 1)
    return np.interp(values, at, np.append(0.0, np.cumsum(slopes) * top / PIECES))


def test_it_is_the_difference_equation_of_6_5_and_6_6() -> None:
    time = np.arange(3000) * SAMPLE_S
    f = np.poly(np.exp(-SAMPLE_S / np.array(POLES)))
    b = np.array([1.0, -np.exp(-SAMPLE_S / ZERO)])
    b *= f.sum() / b.sum()
    w = lfilter(np.concatenate([[0.0, 0.0], b]), f, broken(levels(time), 2.0, PHI))
    expected = AMBIENT_K + broken(w, 2.0, PSI)
    assert len(f) - 1 == 3 and len(b) == 2
    np.testing.assert_allclose(simulate(model(), time, levels(time)).temperature_k, expected, atol=1e-6)


@pytest.mark.parametrize("dt_s", [0.1, 0.05, 0.004, 0.0025])
def test_the_samples_do_not_depend_on_the_steps(dt_s: float) -> None:
    fine, coarse = np.arange(0.0, 20.0, SAMPLE_S), np.arange(0.0, 20.0, dt_s)
    reference = simulate(model(), fine, levels(fine)).temperature_k
    found = simulate(model(), coarse, levels(coarse)).temperature_k
    # Halfway between two samples of T_s the output is the mean of them, where ψ does not bend.
    np.testing.assert_allclose(found, np.interp(coarse, fine, reference), atol=0.01)
    both = np.isin(np.round(coarse, 9), np.round(fine, 9))
    np.testing.assert_allclose(found[both], np.interp(coarse[both], fine, reference), atol=1e-9)


def test_a_power_that_changes_within_a_sample_counts_for_its_share() -> None:
    half, whole = Stepper(model()), Stepper(model())
    for _ in range(200):
        half.step(2.0, 0.25 * SAMPLE_S)
        half.step(0.0, 0.75 * SAMPLE_S)
        whole.step(float(inverse(0.25 * curve(2.0, 2.0, PHI), 2.0, PHI)), SAMPLE_S)
    assert half.temperature_k == pytest.approx(whole.temperature_k, abs=1e-9)


@pytest.mark.parametrize("temperature_k", [290.0, 300.0, 310.0, 345.0, 500.0])
def test_it_starts_at_rest_at_any_temperature(temperature_k: float) -> None:
    strip = Stepper(model(), temperature_k)
    assert strip.temperature_k == pytest.approx(temperature_k, abs=1e-9)
    strip.step(0.0, SAMPLE_S)
    assert strip.temperature_k == pytest.approx(temperature_k, abs=1e-9), "n_k = 1: nothing before the second sample"


def test_the_static_gain_is_that_of_the_curves() -> None:
    strip = Stepper(model())
    for _ in range(2000):
        strip.step(1.3, 0.1)
    expected = AMBIENT_K + broken(broken(np.array([1.3]), 2.0, PHI), 2.0, PSI)[0]
    assert strip.temperature_k == pytest.approx(expected, abs=1e-3)


def test_a_vector_needs_its_parameters_in_a_row() -> None:
    with pytest.raises(LceError, match="vector a needs parameters a_1 to a_2, in a row"):
        Term(
            name="broken",
            stage="heat",
            equation="T = a",
            parameters=(Parameter("a_1", "K", 1.0, 0.0, 2.0, "one", "test"),),
            vectors=(("a", 2),),
            outputs=("temperature",),
            step=lambda a: a[0],
        )
