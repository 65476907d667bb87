# SPDX-License-Identifier: Apache-2.0
"""What the data say of every candidate effect at once, linearised at the present model."""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lce_analysis.diagnosis.linearized_fit import LinearizedFit, mean_squares
from lce_analysis.diagnosis.misfit import reduction_of
from lce_analysis.diagnosis.projection import Projection, p_value, project
from lce_analysis.diagnosis.whitening import whitened
from lce_model import Model
from lce_model.effects import SMALL, Effect
from lce_model.terms import Parameter

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Direction:
    """An effect at fixed values of its other parameters: one column of the score test.

    amplitude : the parameter that turns it on: its strength, or one that acts alone.
    settings : TERM.PARAM to value of the others.
    step_size : the change of the amplitude by which the column is measured, tiny where the effect is smooth, finite
        where it has no derivative at its null value.
    """

    effect: Effect
    amplitude: Parameter
    settings: Mapping[str, float]
    step_size: float

    def at(self, value: float) -> dict[str, float]:
        """TERM.PARAM to value of the settings, and of the amplitude at a value."""
        return {**self.settings, f"{self.effect.name}.{self.amplitude.name}": value}

    def row(self, model: Model) -> Floats:
        """Parameters of ``model``, which holds the effect at its null value, with the step_size."""
        return model.set(self.at(self.amplitude.default + self.step_size)).vector


def directions(effect: Effect, duration_s: float) -> list[Direction]:
    """Every value of the second parameters on the effect's grid, with every step_size; then what acts alone."""
    grid, strength = effect.grid_of(duration_s), effect.parameter(effect.strength)
    alone = [effect.parameter(name) for name in effect.acting_alone]
    return [
        *(
            Direction(effect, strength, {f"{effect.name}.{n}": x for n, x in zip(grid, point, strict=True)}, step_size)
            for point in itertools.product(*grid.values())
            for step_size in effect.step_sizes
        ),
        *(Direction(effect, p, {}, SMALL * (p.upper - p.default)) for p in alone),
    ]


@dataclass(frozen=True)
class Score:
    """The score test of one effect, at the direction that explains most.

    predicted_gain : of the squared error, in units of the noise, at the expected strength.
    predicted_reduction : the share of the error above the noise that would go, all sensors with the same weight.
    detectable : smallest strength, beyond the null value, whose evidence would reach the critical value, in whichever
        direction of the effect that is; of one without a slope, of the strengths that were tried.
    """

    effect: Effect
    direction: Direction
    index: int
    evidence: float
    p_value: float
    visibility: float
    expected_strength: float
    detectable: float
    predicted_gain: float
    predicted_reduction: float = 0.0

    @property
    def shown(self) -> bool:
        """Would these data show the effect at some strength within its bounds?"""
        spec = self.direction.amplitude
        return self.detectable <= max(spec.upper - spec.default, spec.default - spec.lower)

    @property
    def settings_at_expected_strength(self) -> Mapping[str, float]:
        """TERM.PARAM to value of every parameter of the effect, the expected strength clipped to its bounds."""
        spec = self.direction.amplitude
        return self.direction.at(min(max(self.expected_strength, spec.lower), spec.upper))


@dataclass(frozen=True)
class ScoreTestResult:
    """Every candidate beside a refitted model, whose full model holds all of them at their null values.

    table : (free + directions + 1, N) slopes of the free variables and of the directions, and the residual.
    white, plain : free parameters projected out of the directions, whitened and in units of the sensors' noise.
    s2 : variance of the whitened residual that all directions together leave.
    critical_value : evidence from which chance is ruled out.
    """

    fit: LinearizedFit
    directions: tuple[Direction, ...]
    table: Floats
    white: Projection
    plain: Projection
    s2: float
    critical_value: float

    @cached_property
    def scores(self) -> list[Score]:
        """One per effect, the largest predicted reduction of the error first."""
        of_effect: dict[str, list[Score]] = {}
        for j, direction in enumerate(self.directions):
            of_effect.setdefault(direction.effect.name, []).append(self._score(j))
        found = sorted(map(_best, of_effect.values()), key=lambda score: -score.predicted_gain)
        return [replace(score, predicted_reduction=self._share(score)) for score in found]

    def _share(self, score: Score) -> float:
        """Share of the error above the noise that would go at the expected strength, if all were linear."""
        strength = score.expected_strength - score.direction.amplitude.default
        free, j = self.fit.free, score.index
        shift = self.plain.solve[:, -1] - strength * self.plain.solve[:, j]
        rest = self.table[-1] - strength * self.table[free + j] - shift @ self.table[:free]
        observed = self.fit.problem.observed
        return reduction_of(self.fit.mean_squares, mean_squares(rest, observed))

    def _score(self, j: int) -> Score:
        d = self.directions[j]
        effect, spec = d.effect, d.amplitude
        low, high = spec.lower - spec.default, spec.upper - spec.default
        change = float(np.clip(self.plain.strength[j], low, high))
        white_change = float(np.clip(self.white.strength[j], low, high))
        # Where the free parameters and the directions explain everything, no noise is left to compare with.
        evidence = max(0.0, self.white.reduction_at(j, white_change) / self.s2) if self.s2 > 0.0 else 0.0
        count = sum(other.effect is effect for other in self.directions)
        return Score(
            effect=effect,
            direction=d,
            index=j,
            evidence=evidence,
            p_value=p_value(evidence, spec.lower >= spec.default, count),
            visibility=float(self.white.visibility[j]),
            expected_strength=spec.default + change,
            detectable=self._detectable(j),
            predicted_gain=max(0.0, self.plain.reduction_at(j, change)),
        )

    def _detectable(self, j: int) -> float:
        """Smallest change of the strength in a direction that would be seen, its own step where it has no slope."""
        d, norm = self.directions[j], self.white.after[j, j]
        if norm <= 0.0:
            return np.inf
        linear = float(np.sqrt(self.critical_value * self.s2 / norm))
        if len(d.effect.step_sizes) == 1 or d.amplitude.name != d.effect.strength:
            return linear
        return abs(d.step_size) if linear <= abs(d.step_size) else np.inf

    def collinearity(self, score: Score, name: str) -> float:
        """Largest |ρ| between the direction of ``score`` and any of the effect ``name``."""
        row = self.plain.collinearity[score.index]
        return max((float(row[j]) for j, d in enumerate(self.directions) if d.effect.name == name), default=0.0)


def _best(scores: Sequence[Score]) -> Score:
    """The score in the direction that explains most, of all directions of one effect."""
    best = max(scores, key=lambda score: score.predicted_gain)
    alike = (score for score in scores if score.direction.amplitude is best.direction.amplitude)
    return replace(best, detectable=min(score.detectable for score in alike))


def score_test(fit: LinearizedFit, effects: Sequence[Effect], critical_value: float) -> ScoreTestResult:
    """Linearise the refitted model over the strength of every effect; nothing is refitted.

    ``fit.problem.model`` holds all the effects, at their null values. The evidence is whitened by the noise of the
    richest fit: of what no combination of the effects explains.
    """
    columns, table = _table(fit, effects)
    gram = table @ table.T
    solved = project(gram, table.shape[0] - 1).solve[:, -1]
    white = whitened(table, table[-1] - solved @ table[:-1], fit.problem.observed)
    white_gram = white @ white.T
    return ScoreTestResult(
        fit=fit,
        directions=columns,
        table=table,
        white=project(white_gram, fit.free),
        plain=project(gram, fit.free),
        s2=project(white_gram, table.shape[0] - 1).error / white.shape[1],
        critical_value=critical_value,
    )


def projected(fit: LinearizedFit, effects: Sequence[Effect]) -> Projection:
    """What the free parameters leave of every direction of the effects, in units of the sensors' noise."""
    _, table = _table(fit, effects)
    return project(table @ table.T, fit.free)


def _table(fit: LinearizedFit, effects: Sequence[Effect]) -> tuple[tuple[Direction, ...], Floats]:
    """Directions, and rows (free + directions + 1, N): slopes of the free variables, of the effects, the residual."""
    problem = fit.problem
    duration = max(float(i.time_s[-1] - i.time_s[0]) for i in problem.inputs)
    columns = tuple(d for effect in effects for d in directions(effect, duration))
    response = problem.response(np.array([problem.model.vector, *(d.row(problem.model) for d in columns)]))
    slopes = (response[1:] - response[0]) / np.array([[d.step_size] for d in columns])
    return columns, np.vstack([fit.movable.T, np.where(np.isfinite(slopes), slopes, 0.0), -fit.residual])
