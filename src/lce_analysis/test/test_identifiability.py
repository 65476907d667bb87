# SPDX-License-Identifier: Apache-2.0
"""What the data do not determine is found and said plainly."""

import numpy as np
import pytest

from lce_analysis.identification.identifiability import identifiability

TIME = np.linspace(0.0, 1.0, 200)
COLUMNS = 100.0 * np.column_stack([np.sin(3.0 * TIME), np.cos(5.0 * TIME), TIME**2])
LOGARITHMIC = np.array([True, True, True])


def test_determined_parameters_have_the_errors_of_least_squares() -> None:
    found = identifiability(COLUMNS, ["a", "b", "c"], LOGARITHMIC)
    expected = np.sqrt(np.diag(np.linalg.inv(COLUMNS.T @ COLUMNS)))
    assert found.standard_errors == pytest.approx(expected)
    assert found.determined.all()
    assert found.sentences == ()
    assert np.diag(found.correlation) == pytest.approx(1.0)


def test_the_errors_are_those_of_many_noisy_fits() -> None:
    noise = np.random.default_rng(0).standard_normal((2000, TIME.size))
    estimates = np.linalg.lstsq(COLUMNS, noise.T)[0]
    found = identifiability(COLUMNS, ["a", "b", "c"], LOGARITHMIC)
    assert found.standard_errors == pytest.approx(estimates.std(axis=1), rel=0.05)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda a, b, c: (a, b, np.zeros_like(c)), "c is not determined"),
        (lambda a, b, c: (a, b, a), "only the product a·c is determined"),
        (lambda a, b, c: (a, b, -a), "only the ratio a/c is determined"),
        (lambda a, b, c: (a, b, a + b), "these change together without a visible change of the fit: "),
    ],
)
def test_null_directions_in_words(change: object, sentence: str) -> None:
    columns = np.column_stack(change(*COLUMNS.T))  # type: ignore[operator]
    found = identifiability(columns, ["a", "b", "c"], LOGARITHMIC)
    (said,) = found.sentences
    if sentence.startswith("only"):
        assert said in {sentence, sentence.replace("a·c", "c·a").replace("a/c", "c/a")}
    else:
        assert said.startswith(sentence)
    assert np.isinf(found.spread).sum() == 1


def test_a_linear_parameter_is_told_in_tenths_of_its_bounds() -> None:
    a, b, _ = COLUMNS.T
    found = identifiability(np.column_stack([a, b, a]), ["a", "b", "t_env"], np.array([True, True, False]))
    (said,) = found.sentences
    assert "tenths of its bounds" in said and "a ×" in said and "b ×" not in said


def test_a_parameter_that_takes_no_part_in_what_is_loose_keeps_its_error() -> None:
    a, b, _ = COLUMNS.T
    alone = identifiability(np.column_stack([b]), ["b"], np.array([True])).standard_errors[0]
    found = identifiability(np.column_stack([a, b, a]), ["a", "b", "c"], LOGARITHMIC)
    correlated = abs(a @ b) / np.linalg.norm(a) / np.linalg.norm(b)
    assert list(found.determined) == [False, True, False]
    assert np.isnan(found.standard_errors[[0, 2]]).all()
    assert found.standard_errors[1] == pytest.approx(alone / np.sqrt(1.0 - correlated**2), rel=1e-3)


def test_strong_correlations_are_those_of_determined_parameters() -> None:
    a, b = np.random.default_rng(3).standard_normal((2, 500))
    found = identifiability(10.0 * np.column_stack([a, a + 0.1 * b, np.zeros(500)]), ["a", "b", "none"], LOGARITHMIC)
    ((first, second, correlation),) = found.strong_correlations()
    assert (first, second) == ("a", "b")
    assert correlation == pytest.approx(-0.995, abs=0.003)
    assert not found.strong_correlations(threshold=0.9999)
    strict = identifiability(np.column_stack([a, b]), ["a", "b"], LOGARITHMIC[:2], undetermined=1e-3)
    assert not strict.determined.any()
