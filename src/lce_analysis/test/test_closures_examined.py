# SPDX-License-Identifier: Apache-2.0
"""The evidence for a function, beside its formula; what the model absorbs of a curve."""

import numpy as np
import pytest
from numpy.typing import NDArray

from lce_analysis.discovery.closures import Moments, prior_factor, weighed
from lce_analysis.unknown_function import Candidate
from lce_model.closures import PLACES, closure
from lce_model.closures.covariates import COVARIATES
from lce_model.closures.forms import KNOTS

Floats = NDArray[np.float64]

HEAT = next(place for place in PLACES if place.name == "heat")
CANDIDATE = Candidate(HEAT, COVARIATES[0], None, 300.0, 340.0, 300.0)
UNIT = closure("heat").parameter("w_1").knee


def moments_of(directions: Floats, basis: Floats, residual: Floats) -> Moments:
    """Of directions (K, N), an orthonormal basis (N, m) of the free parameters, and a residual (N,)."""
    left = directions - (directions @ basis) @ basis.T
    rest = residual - basis @ (basis.T @ residual)
    return Moments(CANDIDATE, directions @ directions.T, left @ left.T, left @ rest)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(5)


def test_the_evidence_is_that_of_the_formula_at_its_best_width(rng: np.random.Generator) -> None:
    directions, residual = 30.0 * rng.standard_normal((KNOTS, 400)), rng.standard_normal(400)
    residual = residual + 0.02 * directions.sum(axis=0)
    basis = np.linalg.qr(rng.standard_normal((400, 3)))[0]
    moments, variance = moments_of(directions, basis, residual), 1.3
    found = weighed(moments, variance)
    gram, moment = moments.gram / variance, moments.moment / variance
    correlation = prior_factor() @ prior_factor().T

    def evidence(width: float) -> float:
        prior = width**2 * correlation
        inner = np.linalg.solve(gram + np.linalg.inv(prior), moment)
        return float(0.5 * moment @ inner - 0.5 * np.linalg.slogdet(np.eye(KNOTS) + gram @ prior)[1])

    best = max(evidence(UNIT * width) for width in np.geomspace(1e-2, 1e6, 65))
    assert found.ln_evidence == pytest.approx(best, rel=1e-6)
    assert found.gain == pytest.approx(
        2.0 * found.weights @ moments.moment - found.weights @ moments.gram @ found.weights
    )
    assert found.gain > 0.0


def test_what_the_free_parameters_do_is_absorbed(rng: np.random.Generator) -> None:
    temperature = rng.uniform(300.0, 340.0, 500)
    hats = np.array([np.interp(temperature, CANDIDATE.knots, row) for row in np.eye(KNOTS)])
    line = np.linalg.qr(np.column_stack([np.ones(500), temperature]))[0]
    moments = moments_of(hats, line, rng.standard_normal(500))
    assert moments.absorbs(np.ones(KNOTS)) and moments.absorbs(CANDIDATE.knots)
    assert not moments.absorbs((CANDIDATE.knots - 320.0) ** 2)
    np.testing.assert_allclose(moments.seen @ (2.0 + 0.1 * CANDIDATE.knots), 0.0, atol=1e-5)
    bent = moments.seen @ (CANDIDATE.knots - 320.0) ** 2
    np.testing.assert_allclose(np.diff(bent, 2), np.diff((CANDIDATE.knots - 320.0) ** 2, 2), rtol=1e-4)


def test_a_knot_that_was_not_visited_lies_on_a_smooth_curve(rng: np.random.Generator) -> None:
    temperature = np.concatenate([rng.uniform(300.0, 316.0, 300), rng.uniform(329.0, 340.0, 300)])
    hats = np.array([np.interp(temperature, CANDIDATE.knots, row) for row in np.eye(KNOTS)])
    none = np.zeros((600, 1))
    moments = moments_of(hats, none, rng.standard_normal(600))
    hidden = sorted(set(range(KNOTS)) - set(moments.visited.tolist()))
    assert hidden == [4]
    smooth = moments.seen @ np.where(np.arange(KNOTS) == 4, 1e6, 1.0)
    assert smooth[4] == pytest.approx(1.0, abs=0.1)
