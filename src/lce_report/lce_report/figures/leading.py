# SPDX-License-Identifier: Apache-2.0
"""The leading candidates of a diagnosis: what each explains of the residual, and its strength run by run."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lce_analysis.diagnosis.linearized_fit import spans
from lce_analysis.diagnosis.strength import Estimate
from lce_data.channels import channel_named
from lce_model.terms import Parameter
from lce_report.blocks import Block, Curve, Figure, Grid, Intervals, Lines
from lce_report.figures.axes import TIME, residual_axis
from lce_report.tables import NOTHING, estimate, leading, outcome

if TYPE_CHECKING:
    from lce_analysis.diagnosis import Diagnosis
    from lce_analysis.diagnosis.linearized_fit import LinearizedFit
    from lce_analysis.diagnosis.ranking import Candidate
    from lce_analysis.diagnosis.trial import Trial
    from lce_analysis.identification.problem import ObservedSeries
    from lce_data.channels import Channel
    from lce_data.run import Floats

SAMPLES: Final = 2000
"""Samples of a picture, at most: it is small."""


@dataclass(frozen=True)
class Picture:
    """What a refit with the effect changes in a series, beside the residual before; all (n,) in units of differences.

    sensor, run : name of the channel, and of the run in which the change is largest.
    residual : measured minus model refitted without the effect.
    change : model refitted with the effect minus model refitted without it; NaN where no sample counted.
    """

    sensor: str
    run: str
    time_s: Sequence[float]
    residual: Sequence[float | None]
    change: Sequence[float | None]


@dataclass(frozen=True)
class StrengthByRun:
    """Strength of an effect, with its standard error, in each run; None where a run says nothing of it.

    name : TERM.PARAM; null : value at which the effect is absent; common : from all runs together.
    """

    name: str
    unit: str
    null: float
    runs: Sequence[str]
    by_run: Sequence[tuple[float, float] | None]
    common: tuple[float, float] | None = None


@dataclass(frozen=True)
class LeadingCandidate:
    """A candidate that is shown in detail."""

    effect: str
    meaning: str
    outcome: str
    picture: Picture
    strength: StrengthByRun | None


def leading_candidates(found: Diagnosis) -> tuple[LeadingCandidate, ...]:
    """What was added, then the best of what was tried."""
    return tuple(_leading(c, c.trial, found.runs) for c in leading(found) if c.trial is not None)


def strength_by_run(
    effect: str, amplitude: Parameter, by_run: Mapping[str, Estimate | None], common: Estimate | None = None
) -> StrengthByRun:
    """The strengths of an effect as plain values; ``amplitude`` is the parameter that is reported as its strength."""
    return StrengthByRun(
        name=f"{effect}.{amplitude.name}",
        unit=amplitude.unit,
        null=amplitude.default,
        runs=list(by_run),
        by_run=[_pair(e) for e in by_run.values()],
        common=_pair(common),
    )


def candidate_blocks(candidate: LeadingCandidate) -> tuple[Block, ...]:
    """A paragraph, and the picture beside the strengths."""
    about = f"{candidate.effect} ({candidate.outcome}): {candidate.meaning}."
    return about, candidate_grid(candidate)


def candidate_grid(candidate: LeadingCandidate) -> Grid:
    """The picture beside the strengths."""
    cells: list[Figure] = [picture_lines(candidate.effect, candidate.picture)]
    if candidate.strength is not None:
        cells.append(strength_intervals(candidate.strength))
    return Grid(cells, (3, 2)[: len(cells)])


def picture_lines(effect: str, picture: Picture) -> Lines:
    """The residual, and what a refit with the effect would take from it."""
    axis = residual_axis(channel_named(picture.sensor))
    curves = (
        Curve("measured − model without it", np.array(picture.residual, dtype=np.float64), "measured"),
        Curve(f"what the refit with {effect} changes", np.array(picture.change, dtype=np.float64), "after"),
    )
    title = f"{axis.name} of {picture.run}, and {effect}"
    return Lines(title, TIME, axis, np.array(picture.time_s), curves, linked=picture.run, height=190)


def strength_intervals(found: StrengthByRun) -> Intervals:
    """A dot with its standard error for each run; the line is the null value, the dashed one all runs together."""
    values = np.array([np.nan if e is None else e[0] for e in found.by_run])
    errors = np.array([np.nan if e is None else e[1] for e in found.by_run])
    texts = [NOTHING if e is None else estimate(*e) for e in found.by_run]
    common = "" if found.common is None else "; dashed: all runs"
    return Intervals(
        title=f"{found.name} by run, ± standard error; line: no effect{common}",
        unit=found.unit,
        labels=found.runs,
        values=values,
        errors=errors,
        texts=texts,
        null=found.null,
        common=None if found.common is None else found.common[0],
    )


def _leading(c: Candidate, trial: Trial, runs: Sequence[str]) -> LeadingCandidate:
    strength = None
    if trial.strengths is not None:
        by_run = dict(zip(runs, trial.strengths.by_run, strict=True))
        strength = strength_by_run(c.effect.name, c.amplitude, by_run, trial.strengths.overall)
    return LeadingCandidate(
        effect=c.effect.name,
        meaning=c.effect.meaning.removesuffix("."),
        outcome=outcome(c.standing, c.reason),
        picture=_picture(trial, runs),
        strength=strength,
    )


def _picture(trial: Trial, runs: Sequence[str]) -> Picture:
    """The series in which the refit changes most, in units of the sensor's noise."""
    without, with_it = _residuals(trial.stage.fit), _residuals(trial.fit)
    changes = {key: with_it[key][1] - without[key][1] for key in without}
    key = max(changes, key=lambda one: float(np.nansum(changes[one] ** 2)) / changes[one].size)
    series, residual = without[key]
    keep = slice(None, None, -(-series.size // SAMPLES))
    time_s = series.sampling(trial.stage.fit.problem.inputs[series.run].time_s)[-series.size :]

    def shown(values: np.ndarray) -> list[float | None]:
        differences = values / series.weight * series.channel.difference.factor
        return [float(f"{x:.5g}") if there else None for x, there in zip(differences[keep], counted[keep], strict=True)]

    counted = np.isfinite(changes[key])
    return Picture(
        sensor=series.channel.name,
        run=runs[series.run],
        time_s=[round(t, 4) for t in time_s[keep].tolist()],
        residual=shown(-residual),
        change=shown(changes[key]),
    )


def _residuals(fit: LinearizedFit) -> dict[tuple[int, Channel], tuple[ObservedSeries, Floats]]:
    """Each series of a fit by run and sensor, with its residual (n,) in units of the noise; NaN where none counted.

    The fits of a trial may have other sensors: that with the effect also one which the effect keeps from being bent.
    """
    observed = fit.problem.observed
    residuals = [fit.residual[i:j] for i, j in spans(observed)]
    for k, series in enumerate(observed):
        if series.keep is not None:
            residuals[k] = np.where(series.keep[-series.size :] > 0.0, residuals[k], np.nan)
    return {(s.run, s.channel): (s, residual) for s, residual in zip(observed, residuals, strict=True)}


def _pair(found: Estimate | None) -> tuple[float, float] | None:
    """None as well where the error has no bound: the run says nothing, and JSON knows no infinity."""
    if found is None or not math.isfinite(found.standard_error):
        return None
    return found.value, found.standard_error
