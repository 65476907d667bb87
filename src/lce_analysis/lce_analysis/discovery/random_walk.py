# SPDX-License-Identifier: Apache-2.0
"""What does not repeat: a random walk on one parameter of the model, and whether anything explains its path.

A parameter that walks shows where the model lacks something, and when (Kristensen, Madsen & Jørgensen 2004). If the
same curve over the covariates of the runs explains the path in all of them, it repeats, and a law of it is worth
looking for. If nothing explains it and the walk leaves nothing but noise, it is a disturbance: of the light, of the
heat loss, of the ambient temperature, or of the zero of a sensor. A disturbance has no formula.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from lce_analysis.covariates import COVARIATES, covariates_on_grid, hats, quantile_knots
from lce_analysis.diagnosis.linearized_fit import LinearizedFit
from lce_analysis.diagnosis.misfit import share_of
from lce_analysis.diagnosis.stage_problem import StagedFit, carried
from lce_analysis.discovery.walk_pattern import Pattern, pattern
from lce_analysis.discovery.walk_responses import WALKING, WalkingParameter, WalkRun, walk_runs
from lce_analysis.discovery.walk_smoother import Smoothed, smooth, still_walks
from lce_analysis.identification.stages import thermal_stage
from lce_data.channels import DISPLACEMENT, TEMPERATURE, Channel
from lce_data.errors import LceError
from lce_data.progress import Progress, silent
from lce_model import Model
from lce_model.lag import lagged

Floats = NDArray[np.float64]
Kind = Literal["disturbance", "follows", "unclear"]

LAGS_S: Final = (3.0, 10.0, 30.0)
"""Time constants [s] of the slow memories that may explain a path, beside the covariates themselves."""
REMEMBERED: Final = ("power", "temperature", "displacement")
"""Covariates that may act late, beside whether the laser is on."""
BRANCHED: Final = ("temperature", "displacement", "order")
"""Covariates with a curve on each branch where all are taken together."""


@dataclass(frozen=True)
class WalkOptions:
    """When a random walk is reported, and as what.

    Parameters
    ----------
    explained : a sensor whose RMS error is within so many times its noise needs no walk.
    worth : a walk is reported if it takes this share of the squared error above the noise.
    min_likelihood_ratio : parameters whose walks are likelier than this share of the likeliest are not told apart.
    follows : the path follows a covariate if a curve over it, the same in all runs, explains this share of the walk.
    repeats : a path of which all covariates together explain this share is no disturbance.
    predictable : nor is one whose innovations are predictable by more than this share from those before.
    periodic : share of the walk that a wave of one period must take.
    knots : of a curve over a covariate.

    Raises
    ------
    LceError
        If a value cannot be used; it names the field.
    """

    explained: float = 1.2
    worth: float = 0.5
    min_likelihood_ratio: float = 20.0
    follows: float = 0.5
    repeats: float = 0.2
    predictable: float = 0.1
    periodic: float = 0.6
    knots: int = 9

    def __post_init__(self) -> None:
        for name in ("worth", "follows", "repeats", "predictable", "periodic"):
            if not 0.0 < getattr(self, name) <= 1.0:
                raise LceError(f"{name}: {getattr(self, name):g} must be within (0, 1]")
        for name in ("explained", "min_likelihood_ratio"):
            if not getattr(self, name) >= 1.0:
                raise LceError(f"{name}: {getattr(self, name):g} must be 1 or above")
        if self.knots < 2:
            raise LceError(f"knots: {self.knots} is not 2 or more")


@dataclass(frozen=True)
class WalkPath:
    """The smoothed path in one run: time_s (k,) [s], level and band (k,), the change and its standard deviation."""

    run: str
    time_s: Floats
    level: Floats
    band: Floats


@dataclass(frozen=True)
class Walk:
    """A parameter that walks, and what is known of its path.

    Attributes
    ----------
    parameter : which; light and heat loss walk as relative changes.
    alike : all parameters whose walk would do as well, the likeliest first; itself among them.
    channel : the sensor that shows it.
    paths : one per run.
    ln_gain : ln likelihood of the runs with the walk over that without.
    intensity : standard deviation that the walk gains in one second [unit/√s].
    share : of the squared error of the sensor above its noise, that the walk takes.
    p_value, predictable : of the innovations: Ljung–Box p, and the share that is predictable from those before.
    dependences : covariate to the share of the walk that a curve over it explains, the same in all runs, largest first.
    repeats : the same share for all covariates and some lagged ones together.
    pattern : how it goes on in time.
    kind : "follows" a covariate, a "disturbance" that nothing explains, or "unclear".
    """

    parameter: WalkingParameter
    alike: tuple[WalkingParameter, ...]
    channel: Channel
    paths: tuple[WalkPath, ...]
    ln_gain: float
    intensity: float
    share: float
    p_value: float
    predictable: float
    dependences: Mapping[str, float]
    repeats: float
    pattern: Pattern
    kind: Kind

    @property
    def words(self) -> str:
        """What walks and how, in a sentence."""
        name = f"the {self.parameter.words}"
        rivals = " or ".join(f"the {p.words}" for p in self.alike)
        if self.kind == "follows":
            best = next(iter(self.dependences))
            return f"{name} follows the {COVARIATES[best].words} ({self.dependences[best]:.0%} of its changes)"
        if self.kind == "unclear":
            return (
                f"{name} would have to change during the runs to explain {self.channel.name}, in part in the same way "
                f"each time ({self.repeats:.0%} of its changes)"
            )
        return f"a disturbance of {rivals}, {_pattern_words(self.pattern)}"


def _pattern_words(found: Pattern) -> str:
    seconds = f"{found.seconds:.2g} s" if found.seconds < 100.0 else f"{found.seconds:.0f} s"
    if found.kind == "period":
        return f"with a period of {seconds}"
    if found.kind == "steps":
        return f"in steps, {seconds} apart" if math.isfinite(found.seconds) else "in one step"
    return f"without a period, correlated over {seconds}" if found.seconds < 100.0 else "which drifts without a period"


def disturbances(fit: StagedFit, options: WalkOptions = WalkOptions(), progress: Progress = silent) -> tuple[Walk, ...]:
    """The parameters that would have to walk to explain what the model leaves, one for each sensor at most.

    The heat comes first. The zero of the distance sensor is examined only where the model explains the temperature, as
    the displacement follows whatever disturbs the heat.

    Parameters
    ----------
    fit : the model refitted to the runs, from :func:`lce_analysis.diagnosis.stage_problem.refit_stages`.
    options : when a walk is reported.
    progress : called before each sensor; may raise Cancelled.

    Returns
    -------
    tuple of Walk
        Empty where the model explains both sensors, or no walk takes enough of the error.
    """
    found = []
    if fit.heat and fit.mean_squares.get(TEMPERATURE, 0.0) > options.explained**2:
        progress("random walk", 0, 2, math.nan)
        found = _walks(fit, fit.heat[0].fit, TEMPERATURE, options)
    elif fit.deformation is not None and fit.mean_squares.get(DISPLACEMENT, 0.0) > options.explained**2:
        progress("random walk", 1, 2, math.nan)
        found = _walks(fit, fit.deformation.fit, DISPLACEMENT, options)
    progress("random walk", 2, 2, math.nan)
    return tuple(found)


def _walks(staged: StagedFit, fit: LinearizedFit, channel: Channel, options: WalkOptions) -> list[Walk]:
    """The likeliest walk that a sensor shows; none if it takes too little."""
    model = carried(thermal_stage(staged.model), fit.problem.model) if channel is TEMPERATURE else staged.model
    runs = walk_runs(fit, channel, model)
    walk, behind = smooth(runs, [p for p in WALKING[channel] if p in runs[0].responses])
    share = _share_taken(runs, walk)
    if share < options.worth:
        return []
    alike = tuple(p for p, gap in behind.items() if gap < math.log(options.min_likelihood_ratio))
    return [_judged(staged.model, fit, walk, alike, channel, share, options)]


def _share_taken(runs: Sequence[WalkRun], walk: Smoothed) -> float:
    """Share of the squared error above the noise, over all runs."""
    before = np.concatenate([run.residual for run in runs])
    parts = [run.residual - run.responses[walk.parameter] @ p for run, p in zip(runs, walk.levels, strict=True)]
    slopes = np.vstack([run.slopes for run in runs])
    after = np.concatenate(parts)
    after = after - slopes @ np.linalg.lstsq(slopes, after, rcond=1e-9)[0] if slopes.size else after
    return share_of(float(np.mean(before**2)), float(np.mean(after**2)))


def _judged(
    model: Model,
    fit: LinearizedFit,
    walk: Smoothed,
    alike: tuple[WalkingParameter, ...],
    channel: Channel,
    share: float,
    options: WalkOptions,
) -> Walk:
    covariates = _covariates(model, fit, walk)
    dependences = {name: _explained(walk, curves) for name, curves in _single(covariates, options).items()}
    together = _explained(walk, _together(covariates, options))
    dependences = dict(sorted(dependences.items(), key=lambda item: -item[1]))
    repeats = max(together, next(iter(dependences.values()), 0.0))
    p_value, predictable = walk.whiteness
    kind: Kind = "unclear"
    if next(iter(dependences.values()), 0.0) >= options.follows:
        kind = "follows"
    elif repeats < options.repeats and predictable < options.predictable:
        kind = "disturbance"
    paths = zip(walk.runs, walk.levels, walk.bands, strict=True)
    return Walk(
        parameter=walk.parameter,
        alike=alike,
        channel=channel,
        paths=tuple(WalkPath(run.name, run.middles_s, level, band) for run, level, band in paths),
        ln_gain=walk.ln_gain,
        intensity=walk.intensity,
        share=share,
        p_value=p_value,
        predictable=predictable,
        dependences=dependences,
        repeats=repeats,
        pattern=pattern(walk, options.periodic),
        kind=kind,
    )


def _covariates(model: Model, fit: LinearizedFit, walk: Smoothed) -> list[dict[str, Floats]]:
    """The covariates (k,) of each run in the middle of each interval, and their lagged values, of the whole model."""
    problem, found = fit.problem, []
    starts = problem.split(problem.first())[1]
    by_name = {run_input.run.name: i for i, run_input in enumerate(problem.inputs)}
    for run in walk.runs:
        i = by_name[run.name]
        run_input = problem.inputs[i]
        own = model.of_run(run_input.run.name, run_input.run.sha256)
        out = run_input.simulate(own, own.vector[None], starts[i : i + 1])[0]
        time = run_input.time_s - run_input.time_s[0]
        on_grid = covariates_on_grid(run_input, out)
        sampled = {name: np.interp(run.middles_s, time, x) for name, x in on_grid.items()}
        remembered: dict[str, Floats] = {name: sampled[name] for name in REMEMBERED if name in sampled}
        if "power" in sampled:
            remembered["lit"] = (sampled["power"] > 0.0).astype(np.float64)
        for name, values in remembered.items():
            for lag_s in LAGS_S:
                sampled[f"{name}, {lag_s:g} s before"] = lagged(run.middles_s, values, lag_s, True)
        found.append(sampled)
    return found


def _single(covariates: Sequence[Mapping[str, Floats]], options: WalkOptions) -> dict[str, list[Floats]]:
    """For each covariate, the basis (k, knots) of a curve over it in each run."""
    found = {}
    for name in (n for n in COVARIATES if all(n in c for c in covariates)):
        knots = quantile_knots(np.concatenate([c[name] for c in covariates]), options.knots)
        found[name] = [hats(c[name], knots) for c in covariates]
    return found


def _together(covariates: Sequence[Mapping[str, Floats]], options: WalkOptions) -> list[Floats]:
    """The bases of all covariates side by side, some of them on each branch."""
    columns: list[list[Floats]] = [[] for _ in covariates]
    for name in (n for n in covariates[0] if all(n in c for c in covariates)):
        knots = quantile_knots(np.concatenate([c[name] for c in covariates]), options.knots)
        for own, c in zip(columns, covariates, strict=True):
            basis = hats(c[name], knots)
            heating = c["branch"][:, None] > 0.0
            own += [basis * heating, basis * ~heating] if name in BRANCHED else [basis]
    return [np.hstack(own) for own in columns]


def _explained(walk: Smoothed, curves: Sequence[Floats]) -> float:
    """Share of the walk that a curve for all runs explains; 0 if there is only one run."""
    return 1.0 - still_walks(walk, curves) if len(walk.runs) > 1 else 0.0
