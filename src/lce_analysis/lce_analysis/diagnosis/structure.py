# SPDX-License-Identifier: Apache-2.0
"""What no effect of the library explains: does the rest still depend on anything?

Noise does not repeat itself: a curve of the residual over temperature, rate, power, time, displacement or cycle that is
fitted to all runs but one must predict that one too, or it is chance. What disturbs the strip itself without repeating
(a draught, an unsteady laser) is seen by both sensors at once: the displacement then follows the measured temperature
where it differs from the modelled one, which the noise of two separate sensors cannot do.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_analysis.covariates import COVARIATES, covariates_at, hats, quantile_knots
from lce_analysis.diagnosis.linearized_fit import LinearizedFit, spans
from lce_analysis.diagnosis.stage_problem import StagedFit
from lce_analysis.diagnosis.whitening import whitened
from lce_analysis.identification.problem import Problem
from lce_analysis.options import DiagnoseOptions
from lce_analysis.prediction import STATE, measured_drive
from lce_analysis.signatures import Signature
from lce_analysis.signatures.follows import left_out
from lce_data.channels import TEMPERATURE, Channel

Floats = NDArray[np.float64]

TOLD: Final = 4
"""Signatures that a sentence names, the strongest."""
MAD_OF_NORMAL: Final = 0.6745
"""Median of |x| of normal values with standard deviation 1."""
UNPREDICTED_HEAT: Final = "temperature not predicted"
"""The model's displacement driven by the measured temperature, less that driven by the modelled one."""


@dataclass(frozen=True)
class Dependence:
    """The residual of one sensor against one covariate.

    share : of the residual's variance, predicted for runs that were left out; 0 or less if it follows nothing.
    x, curve : (k,) the covariate and the mean residual over it, in the units of the covariate and the sensor.
    """

    channel: Channel
    covariate: str
    unit: str
    share: float
    x: Floats
    curve: Floats


@dataclass(frozen=True)
class _ResidualSeries:
    """The residual (n,) of one series, with the covariates (n,) at its samples and the run's number."""

    run: int
    residual: Floats
    covariates: dict[str, Floats]


SIMPLE: Final = ("rate", "power", "time", "displacement", "cycle")
"""Covariates that are looked at as they are; the temperature is looked at branch by branch."""
UNITS: Final = {
    "temperature while heating": "K",
    "temperature while cooling": "K",
    **{COVARIATES[name].words: COVARIATES[name].unit for name in SIMPLE},
    UNPREDICTED_HEAT: "m",
}


def left_over(
    fit: StagedFit, signatures: Sequence[Signature], options: DiagnoseOptions
) -> tuple[tuple[Dependence, ...], str]:
    """What the residual of a model still depends on, strongest first, and what is left, in words.

    signatures : those of the same residual, strongest first.
    """
    fits = [] if fit.deformation is None else [fit.deformation.fit]
    if fit.heat and (fit.deformation is None or fit.deformation.part == "deformation"):
        fits.append(fit.heat[0].fit)
    found = sorted((d for one in fits for d in dependences(one, options)), key=lambda d: -d.share)
    loud = [one for one in fits if any(x > options.explained**2 for x in one.mean_squares.values())]
    unlike = [text for one in loud for text in unlike_noise(one, options)]
    strong = [d for d in found if loud and d.share >= options.structured]
    return tuple(found), in_words(signatures, strong, unlike)


def dependences(fit: LinearizedFit, options: DiagnoseOptions) -> list[Dependence]:
    """Every sensor against every covariate, strongest first."""
    problem = fit.problem
    by_channel: dict[Channel, list[_ResidualSeries]] = {}
    parts = _parts(fit, in_si=True)
    for i in range(len(problem.inputs)):
        out = problem.simulated(i)
        for series, part in zip(problem.observed, parts, strict=True):
            if series.run == i:
                covariates = _covariates(problem, i, out, series.channel)
                by_channel.setdefault(series.channel, []).append(_ResidualSeries(i, part, covariates))
    found = [
        _dependence(channel, name, members, options.knots)
        for channel, members in by_channel.items()
        for name in UNITS
        if all(name in m.covariates for m in members)
    ]
    return sorted(found, key=lambda d: -d.share)


def _covariates(problem: Problem, run: int, out: Floats, channel: Channel) -> dict[str, Floats]:
    series = next(s for s in problem.observed if s.run == run and s.channel is channel)
    known = covariates_at(problem, series, out)
    rising, warm = known["branch"] > 0.0, known["temperature"]
    found = {
        "temperature while heating": np.where(rising, warm, np.nan),
        "temperature while cooling": np.where(rising, np.nan, warm),
        **{COVARIATES[name].words: known[name] for name in SIMPLE if name in known},
    }
    if (
        channel is not TEMPERATURE
        and problem.inputs[run].run.temperature is not None
        and not problem.inputs[run].driven
    ):
        model, start = problem.model_of(run), np.array([problem.split(problem.first())[1][run]])
        driven = measured_drive(problem.inputs[run], model, float(start[0]))
        moved = (
            driven.simulate(model, model.vector[None], start)[0, :, STATE["displacement"]]
            - out[:, STATE["displacement"]]
        )
        at_samples = np.asarray(series.sampling(moved))
        found[UNPREDICTED_HEAT] = at_samples if series.keep is None else at_samples * series.keep
    return found


def _dependence(channel: Channel, name: str, members: Sequence[_ResidualSeries], count: int) -> Dependence:
    values = np.concatenate([m.covariates[name] for m in members])
    linear = name == UNPREDICTED_HEAT
    knots = np.zeros(1) if linear else quantile_knots(values, count)
    basis = [np.nan_to_num(m.covariates[name])[:, None] if linear else hats(m.covariates[name], knots) for m in members]
    found = left_out([(b, m.residual) for b, m in zip(basis, members, strict=True)])
    return Dependence(channel, name, UNITS[name], found.share, knots, found.coefficients)


def _parts(fit: LinearizedFit, in_si: bool) -> list[Floats]:
    """Measured minus model of each series (n,), in its SI unit or in units of its noise; 0 where it does not count."""
    observed = fit.problem.observed
    return [
        -fit.residual[begin:end] / (series.weight if in_si else 1.0)
        for (begin, end), series in zip(spans(observed), observed, strict=True)
    ]


def unlike_noise(fit: LinearizedFit, options: DiagnoseOptions) -> list[str]:
    """What sets a residual apart from the noise of any sensor, in words: its size, or its jumps."""
    observed, parts = fit.problem.observed, _parts(fit, in_si=False)
    found = []
    for channel, mean_square in fit.mean_squares.items():
        own = [series for series in observed if series.channel is channel]
        rms = float(np.sqrt(mean_square))
        if rms > options.explained:
            found.append(f"{channel.name} is left with {rms:.1f} times the noise of its sensor")
        residual = np.concatenate(
            [part for series, part in zip(observed, parts, strict=True) if series.channel is channel]
        )
        white = whitened(residual[None], residual, own)[0]
        spread = float(np.median(np.abs(white))) / MAD_OF_NORMAL
        jumps = white[np.abs(white) > options.jump_size * spread]
        share = float(np.sum(jumps**2) / max(float(np.sum(white**2)), 1e-300))
        if share > options.jumping:
            found.append(f"{channel.name} jumps ({share:.0%} of what is new from sample to sample)")
    return found


def in_words(signatures: Sequence[Signature], strong: Sequence[Dependence], unlike: Sequence[str]) -> str:
    """What is left, as a sentence; empty if it is noise.

    Signatures come first. Dependences above the threshold follow if there is no signature, then what is unlike noise.
    """
    told = [one.words for one in signatures[:TOLD]]
    words = ["no effect of the library explains enough of what is left to be named", *told]
    if strong and not told:
        listed = "; ".join(f"{d.channel.name} against {d.covariate} ({d.share:.0%} of the rest)" for d in strong[:4])
        words.append(f"in runs left out it still follows {listed}")
    return "; ".join([*words, *unlike]) if told or strong or unlike else ""
