# SPDX-License-Identifier: Apache-2.0
"""What the data say of every candidate effect at once, linearised at the present model."""

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lce_analysis.diagnosis.linearized_fit import LinearizedFit, gram, in_noise, noise_of, raw, whitened
from lce_analysis.diagnosis.projection import Projection, p_value, project
from lce_analysis.diagnosis.whitening import Noise
from lce_data.channels import Channel
from lce_model import Model
from lce_model.effects import Effect

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Direction:
    """An effect at fixed values of its other parameters: one column of the score test.

    settings : TERM.PARAM to value of everything but the strength; step_size : the change of the strength by which the
    column is measured, tiny where the effect is smooth, finite where it has no derivative at its null value.
    """

    effect: Effect
    settings: Mapping[str, float]
    step_size: float

    def row(self, model: Model) -> Floats:
        """Parameters of ``model``, which holds the effect at its null value, with the step_size."""
        changes = dict(self.settings)
        changes[self.effect.strength_key] = self.effect.null + self.step_size
        return model.set(changes).vector


def directions(effect: Effect) -> list[Direction]:
    """Every value of the second parameters on the effect's grid, with every step_size."""
    names = [name for name, _ in effect.grid]
    return [
        Direction(effect, {f"{effect.name}.{n}": x for n, x in zip(names, point, strict=True)}, step_size)
        for point in itertools.product(*(values for _, values in effect.grid))
        for step_size in effect.step_sizes
    ]


@dataclass(frozen=True)
class Score:
    """The score test of one effect, at the direction that explains most.

    detectable : smallest strength, beyond the null value, whose evidence would reach the critical value.
    """

    effect: Effect
    direction: Direction
    index: int
    evidence: float
    p_value: float
    visibility: float
    expected_strength: float
    detectable: float
    predicted_reduction: float

    @property
    def shown(self) -> bool:
        """Would these data show the effect at some strength within its bounds?"""
        spec = self.effect.parameter(self.effect.strength)
        return self.detectable <= max(spec.upper - self.effect.null, self.effect.null - spec.lower)

    @property
    def settings_at_expected_strength(self) -> Mapping[str, float]:
        """TERM.PARAM to value of every parameter of the effect, the expected strength clipped to its bounds."""
        spec = self.effect.parameter(self.effect.strength)
        strength = min(max(self.expected_strength, spec.lower), spec.upper)
        return {**self.direction.settings, self.effect.strength_key: strength}


@dataclass(frozen=True)
class ScoreTestResult:
    """Every candidate beside a refitted model, whose full model holds all of them at their null values.

    white, plain : free parameters projected out of the directions, whitened by ``noise`` and in units of it.
    s2 : variance of the whitened residual that all directions together leave.
    critical_value : evidence from which chance is ruled out.
    """

    fit: LinearizedFit
    directions: tuple[Direction, ...]
    noise: Mapping[Channel, Noise]
    white: Projection
    plain: Projection
    s2: float
    critical_value: float

    @cached_property
    def scores(self) -> list[Score]:
        """One per effect, strongest evidence first."""
        return self._best_first(lambda score: score.evidence)

    @cached_property
    def by_reduction(self) -> list[Score]:
        """One per effect, the largest predicted reduction of the plain error first."""
        return self._best_first(lambda score: score.predicted_reduction)

    def _best_first(self, measure: Callable[[Score], float]) -> list[Score]:
        """The best direction of each effect by a measure, the best effect first."""
        best: dict[str, Score] = {}
        for j in range(len(self.directions)):
            score = self._score(j)
            before = best.get(score.effect.name)
            if before is None or measure(score) > measure(before):
                best[score.effect.name] = score
        return sorted(best.values(), key=lambda score: -measure(score))

    def _score(self, j: int) -> Score:
        d = self.directions[j]
        effect, spec = d.effect, d.effect.parameter(d.effect.strength)
        low, high = spec.lower - effect.null, spec.upper - effect.null
        change = float(np.clip(self.white.strength[j], low, high))
        evidence = max(0.0, self.white.reduction_at(j, change) / self.s2)
        count = sum(other.effect is effect for other in self.directions)
        reduction = self.plain.reduction_at(j, float(np.clip(self.plain.strength[j], low, high)))
        return Score(
            effect=effect,
            direction=d,
            index=j,
            evidence=evidence,
            p_value=p_value(evidence, effect.one_sided, count),
            visibility=float(self.white.visibility[j]),
            expected_strength=effect.null + change,
            detectable=float(np.sqrt(self.critical_value * self.s2 / norm))
            if (norm := self.white.after[j, j]) > 0.0
            else np.inf,
            predicted_reduction=max(0.0, reduction / self.plain.error),
        )

    def collinearity(self, score: Score, name: str) -> float:
        """Largest |ρ| between the direction of ``score`` and any of the effect ``name``."""
        row = self.white.collinearity[score.index]
        return max((float(row[j]) for j, d in enumerate(self.directions) if d.effect.name == name), default=0.0)


def score_test(
    fit: LinearizedFit,
    effects: Sequence[Effect],
    noise: Mapping[Channel, Noise],
    estimate: bool,
    critical_value: float = 0.0,
) -> ScoreTestResult:
    """Linearise the refitted model over the strength of every effect.

    ``fit.problem.model`` holds all the effects, at their null values. With ``estimate`` the noise given is only a
    first guess, and that of the richest fit replaces it: of what no combination of the effects explains.
    """
    problem = fit.problem
    columns = tuple(d for effect in effects for d in directions(effect))
    bare = replace(problem, observed=raw(problem.observed))
    response = bare.response(np.array([problem.model.vector, *(d.row(problem.model) for d in columns)]))
    slopes = (response[1:] - response[0]) / np.array([[d.step_size] for d in columns])
    table = np.vstack([fit.table[:-1], np.where(np.isfinite(slopes), slopes, 0.0), fit.table[-1:]])
    runs = len(problem.inputs)
    for _ in range(2 if estimate else 0):
        total = gram(table, whitened(problem.observed, noise), runs).sum(axis=0)
        solved = project(total, table.shape[0] - 1).solve[:, -1]
        noise = noise_of(table[-1] - solved @ table[:-1], problem.observed)
    white = gram(table, whitened(problem.observed, noise), runs).sum(axis=0)
    plain = gram(table, in_noise(problem.observed, noise), runs).sum(axis=0)
    size = sum(series.size for series in whitened(problem.observed, noise))
    return ScoreTestResult(
        fit=fit,
        directions=columns,
        noise=noise,
        white=project(white, fit.free),
        plain=project(plain, fit.free),
        s2=project(white, table.shape[0] - 1).error / size,
        critical_value=critical_value,
    )
