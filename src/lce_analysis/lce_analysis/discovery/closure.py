# SPDX-License-Identifier: Apache-2.0
"""A function refitted as a curve, and judged as an effect is: errors that were reached, data left out, one strength."""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_analysis.diagnosis.held_out import DataLeftOut, HeldOut
from lce_analysis.diagnosis.linearized_fit import LinearizedFit, linearised, refit
from lce_analysis.diagnosis.stage_problem import StageProblem
from lce_analysis.diagnosis.strength import Strengths, strengths
from lce_analysis.diagnosis.trial import Objection, on_data_left_out
from lce_analysis.discovery.closures import Examination, Examined
from lce_analysis.options import DiscoverOptions
from lce_analysis.unknown_function import Candidate, with_curve
from lce_data.progress import Progress

Floats = NDArray[np.float64]

LOOKED_AT: Final = 12
"""Functions with the strongest evidence that are compared with each other, for each that is refitted."""
FAIR: Final = 0.5
"""A function is refitted if it promises this share of the largest gain."""
ROOM: Final = 5.0
"""A knot of the curve may move by so many of its standard deviations, or of the size of the curve, in the refit."""
ITERATIONS: Final = 40
TOLERANCE: Final = 1e-5


@dataclass(frozen=True)
class Closure:
    """A function of one covariate at one place, refitted.

    examined : what the examination said of it.
    stage : the part of the model in which it was tried, without it.
    fit : the refit, its curve among the free parameters.
    gain : of the squared error, in units of the noise.
    alike : the functions that these data cannot tell from it, itself first.
    strengths : of the curve as it is, from all runs and from each; 1 is the curve itself.
    held_out : errors on data left out; None if it was not judged on them.
    objection : why it is not worth having, "" if nothing speaks against it.
    """

    examined: Examined
    stage: StageProblem
    fit: LinearizedFit
    gain: float
    alike: tuple[Candidate, ...]
    strengths: Strengths | None = None
    held_out: HeldOut | None = None
    objection: Objection = ""

    @property
    def candidate(self) -> Candidate:
        """Which function."""
        return self.examined.candidate

    @property
    def weights(self) -> Floats:
        """(K,) the curve at its knots, in the unit of its place."""
        return np.array([self.fit.problem.model[key] for key in self.candidate.weights])


def contenders(examination: Examination, options: DiscoverOptions) -> list[tuple[Examined, tuple[Candidate, ...]]]:
    """The strongest functions that differ from one another, each with those that look like it."""
    chosen: list[tuple[Examined, list[Candidate]]] = []
    effects: list[Floats] = []
    least = FAIR * max((e.gain for e in examination.examined), default=0.0)
    for one in examination.examined[: LOOKED_AT * options.refitted]:
        effect = one.weights @ examination.projected.without_free(examination.projected.directions(one.candidate))
        effect = effect / max(float(np.linalg.norm(effect)), 1e-300)
        same = [i for i, other in enumerate(effects) if effect @ other >= options.diagnosis.alias_correlation]
        if same and one.gain >= options.alike * chosen[same[0]][0].gain:
            chosen[same[0]][1].append(one.candidate)
        elif not same and len(chosen) < options.refitted and (one.gain >= least or not chosen):
            chosen.append((one, [one.candidate]))
            effects.append(effect)
    return [(one, tuple(alike)) for one, alike in chosen]


def refitted(
    examination: Examination,
    examined: Examined,
    alike: tuple[Candidate, ...],
    progress: Progress,
) -> Closure:
    """The model refitted with the curve, each of its knots free."""
    stage, candidate = examination.stage, examined.candidate
    base = stage.fit.problem
    weights, covariance = examined.seen
    room = ROOM * np.maximum(np.sqrt(np.diag(covariance)), float(np.max(np.abs(weights))))
    start = with_curve(base, candidate, weights.tolist(), room.tolist())
    fit = refit(start, candidate.label, progress, ITERATIONS, TOLERANCE)
    return Closure(examined, stage, fit, stage.fit.error - fit.error, alike)


def judged(closure: Closure, left_out: DataLeftOut, options: DiscoverOptions) -> Closure:
    """The same, with what speaks against it."""
    if closure.gain <= 0.0:
        return replace(closure, objection="null")
    found = one_strength(closure)
    held_out = left_out.errors(closure.stage, closure.fit.problem, closure.candidate.label)
    objection = on_data_left_out(closure.stage, held_out, options.diagnosis)
    if not objection and not _agrees(found, options):
        objection = "varies"
    return replace(closure, strengths=found, held_out=held_out, objection=objection)


def one_strength(closure: Closure) -> Strengths:
    """The strength of the curve as it is, a free parameter instead of its knots."""
    problem, candidate = closure.fit.problem, closure.candidate
    held = {problem.model.index(key) for key in candidate.weights}
    strength = problem.model.index(candidate.strength)
    problem = replace(problem, free=tuple(sorted({*problem.free, strength} - held)))
    return strengths(linearised(problem), problem.free.index(strength))


def curve_held(closure: Closure) -> LinearizedFit:
    """The refitted model, its curve no free parameter any more."""
    free = closure.stage.fit.problem.free
    kept = [closure.fit.problem.free.index(i) for i in free]
    kept += range(len(closure.fit.problem.free), closure.fit.jacobian.shape[1])
    return LinearizedFit(replace(closure.fit.problem, free=free), closure.fit.jacobian[:, kept], closure.fit.residual)


def _agrees(found: Strengths, options: DiscoverOptions) -> bool:
    """Do the runs want one strength of the curve, other than none?"""
    mean, limit = found.mean, options.diagnosis.agreement
    alike = abs(found.overall.value - mean.value) <= max(limit * mean.standard_error, options.diagnosis.alike)
    return alike and mean.value > limit * mean.standard_error
