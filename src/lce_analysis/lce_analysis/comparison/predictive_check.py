# SPDX-License-Identifier: Apache-2.0
"""Would the model have measured this? Simulations with its noise and its uncertainty, beside what was measured.

This is the visual predictive check of the pharmacometricians (Holford 2005), of residuals, for which their prediction
correction does the same (Bergstrand et al. 2011, doi:10.1208/s12248-011-9255-z): the model is simulated some hundred
times, each time with parameters that the noise in the data leaves possible and with noise of the sensors, and the
quantiles of the simulated residuals in each regime make a band in which the quantiles of the measured residual should
lie. Where a measured temperature drives the deformation, its error is not simulated.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from lce_analysis.comparison.conditions import (
    BRANCHES,
    ErrorShares,
    error_shares,
)
from lce_analysis.comparison.simulated_series import SimulatedSeries, simulated_series, variables_of
from lce_analysis.identification.standing import standing_problems
from lce_analysis.options import CompareOptions
from lce_data.channels import SENSORS, Channel
from lce_data.errors import LceError
from lce_data.progress import CancelToken, Progress, silent, watched
from lce_data.run import Run
from lce_model import Model

Floats = NDArray[np.float64]

LEVEL: Final = 0.9
"""Share of the simulations within a band."""
QUANTILES: Final = (0.05, 0.5, 0.95)
"""Of the residuals in a regime."""
BINS: Final = 8
"""Equal parts of the temperature range, on each branch."""
FEWEST: Final = 20
"""Samples without which a regime has no quantiles."""
SLACK: Final = 0.02
"""The noise of a sensor is known to some per cent, which moves the share inside by so much."""
FEWEST_DRAWS: Final = 20
"""A band of 90 % has its ends beyond the first and the last of fewer simulations."""


@dataclass(frozen=True)
class Regime:
    """A part of the temperature range on one branch, all runs together; residuals are measured minus model [SI].

    Attributes
    ----------
    branch : "heating" or "cooling".
    lower_c, upper_c : the part of the range [°C].
    samples : how many are in it.
    inside : share of the samples within their own band.
    observed : (3,) quantiles of the residual, of :data:`QUANTILES`.
    low, middle, high : (3,) where those quantiles lie in the simulations: 5 %, median, 95 %.
    """

    branch: str
    lower_c: float
    upper_c: float
    samples: int
    inside: float
    observed: Floats
    low: Floats
    middle: Floats
    high: Floats

    @property
    def outside(self) -> bool:
        """Does a quantile of the measured residual lie outside of its band?"""
        return bool(np.any((self.observed < self.low) | (self.observed > self.high)))


@dataclass(frozen=True)
class ChannelCheck:
    """One sensor, all runs together.

    Attributes
    ----------
    channel : what was measured.
    inside : share of the samples within the band of the simulations at that time.
    expected : between which shares 90 % of the simulations are.
    runs : share inside by run.
    regimes : those with enough samples, heating first, the coldest first.
    outside : where the samples outside sit, as shares of their number.
    """

    channel: Channel
    inside: float
    expected: tuple[float, float]
    runs: Mapping[str, float]
    regimes: tuple[Regime, ...]
    outside: ErrorShares

    @property
    def as_expected(self) -> bool:
        """Are as many samples inside as there would be if the model were right?"""
        return self.inside >= self.expected[0] - SLACK

    def sentence(self, options: CompareOptions = CompareOptions()) -> str:
        """The share inside, and where the others sit."""
        share = f"inside the {LEVEL:.0%} band: {self.inside:.0%} of the samples of the {self.channel.name}"
        low, high = self.expected
        if self.as_expected:
            return f"{share}; it would be {low:.1%} to {high:.1%} if the model were right"
        return f"{share}; outside {self._where(options)}{self._worst_run(options)}"

    def _where(self, options: CompareOptions) -> str:
        most = self.outside.most
        if most.error_share < options.even * most.sample_share:
            little = 1.0 - self.inside < 2.0 * (1.0 - LEVEL)
            return f"everywhere alike{'; noise that is larger than estimated would look the same' if little else ''}"
        branch = {None: "", "heating": "while heating ", "cooling": "while cooling "}[most.branch]
        held = {None: "", True: "at rest ", False: "on the move "}[most.held]
        return f"mostly {branch}{held}between {most.lower_c:.0f} and {most.upper_c:.0f} °C"

    def _worst_run(self, options: CompareOptions) -> str:
        name, inside = min(self.runs.items(), key=lambda item: item[1])
        alone = 1.0 - inside > options.even * (1.0 - self.inside) and len(self.runs) > 1
        return f"; fewest in {name}, {inside:.0%}" if alone else ""


@dataclass(frozen=True)
class PredictiveCheck:
    """Measured runs beside simulations of a model with its noise and its uncertainty.

    Attributes
    ----------
    draws : how many simulations.
    channels : by sensor, in their order.
    sentences : one for each sensor.
    """

    draws: int
    channels: Mapping[Channel, ChannelCheck]
    sentences: tuple[str, ...]


def predictive_check(
    model: Model,
    runs: Sequence[Run],
    fitted_to: Sequence[Run] = (),
    draws: int = 200,
    seed: int = 0,
    options: CompareOptions = CompareOptions(),
    progress: Progress = silent,
    cancel: CancelToken | None = None,
) -> PredictiveCheck:
    """Simulate a fitted model many times, with its uncertainty and its noise, and lay the bands over the data.

    Parameters
    ----------
    model : at its least squares.
    runs : what it is laid over.
    fitted_to : the runs that it was fitted to, which say how uncertain its parameters are; ``runs`` if none are given.
        What varies from run to run then keeps its values.
    draws : simulations, 20 or more.
    seed : of parameters and noise; the same seed gives the same result.
    options : what drives the deformation, and how regimes are told apart.
    progress : called after each part of the work.
    cancel : stops between two parts and raises Cancelled.

    Returns
    -------
    PredictiveCheck
        Share of samples inside, quantiles and bands by regime, and sentences.

    Raises
    ------
    LceError
        If there are too few draws, or no run holds a series that the model predicts.

    Examples
    --------
    >>> import lce_analysis as lce
    >>> found = lce.predictive_check(model, runs)  # doctest: +SKIP
    >>> print(found.sentences[0])  # doctest: +SKIP
    """
    if draws < FEWEST_DRAWS:
        raise LceError(f"predictive check: {draws} simulations are too few, {FEWEST_DRAWS} or more make a band")
    progress = watched(progress, cancel)
    members: dict[Channel, list[SimulatedSeries]] = {}
    standing = standing_problems(model, runs, options.drive)
    learnt = standing_problems(model, fitted_to, options.drive) if fitted_to else standing
    for problem, known in zip(standing, learnt, strict=True):
        if not problem.observed:
            continue
        progress("drawing parameters", 0, draws, float("nan"))
        variables = variables_of(problem, known, draws, seed)
        for found in simulated_series(problem, variables, seed, options, progress):
            members.setdefault(found.channel, []).append(found)
    if not members:
        raise LceError("none of the runs holds a series that this model predicts")
    channels = {c: _check(c, members[c], options) for c in SENSORS if c in members}
    return PredictiveCheck(draws, channels, tuple(_capitalised(c.sentence(options)) for c in channels.values()))


def _band(values: Floats) -> tuple[Floats, Floats]:
    """Ends of the band that holds the share LEVEL of what the values (draws, …) are drawn from."""
    low, high = np.quantile(values, [0.5 - 0.5 * LEVEL, 0.5 + 0.5 * LEVEL], axis=0, method="weibull")
    return low, high


def _inside(series: SimulatedSeries) -> tuple[Floats, Floats]:
    """Which samples lie within the band of the simulations: of the measured (k,), and share by draw (draws,)."""
    low, high = _band(series.simulated)
    within = (series.simulated >= low) & (series.simulated <= high)
    return ((series.measured >= low) & (series.measured <= high)).astype(np.float64), within.mean(axis=1)


def _check(channel: Channel, members: Sequence[SimulatedSeries], options: CompareOptions) -> ChannelCheck:
    inside, by_draw = zip(*(_inside(m) for m in members), strict=True)
    sizes = [m.measured.size for m in members]
    low, high = _band(np.average(by_draw, axis=0, weights=sizes))
    shares = error_shares([(m.run, m.conditions, 1.0 - here) for m, here in zip(members, inside, strict=True)], options)
    within = np.concatenate(inside)
    return ChannelCheck(
        channel=channel,
        inside=float(within.mean()),
        expected=(float(low), float(high)),
        runs={m.run: float(here.mean()) for m, here in zip(members, inside, strict=True)},
        regimes=tuple(_regimes(members, within)),
        outside=shares,
    )


def _regimes(members: Sequence[SimulatedSeries], inside: Floats) -> Iterator[Regime]:
    """Quantiles and their bands, part by part of the temperature range, on each branch."""
    temperature = np.concatenate([m.conditions.temperature_c for m in members])
    heating = np.concatenate([m.conditions.heating for m in members])
    measured = np.concatenate([m.measured for m in members])
    simulated = np.concatenate([m.simulated for m in members], axis=1)
    edges = np.linspace(float(temperature.min()), float(temperature.max()), BINS + 1)
    part = np.clip(np.searchsorted(edges, temperature, side="right") - 1, 0, BINS - 1)
    for branch in BRANCHES:
        for b in range(BINS):
            here = (part == b) & (heating == (branch == "heating"))
            if np.count_nonzero(here) < FEWEST:
                continue
            quantiles = np.quantile(simulated[:, here], QUANTILES, axis=1)
            low, high = _band(quantiles.T)
            yield Regime(
                branch=branch,
                lower_c=float(edges[b]),
                upper_c=float(edges[b + 1]),
                samples=int(np.count_nonzero(here)),
                inside=float(inside[here].mean()),
                observed=np.quantile(measured[here], QUANTILES),
                low=low,
                middle=np.median(quantiles, axis=1),
                high=high,
            )


def _capitalised(sentence: str) -> str:
    return f"{sentence[0].upper()}{sentence[1:]}."


def as_json(check: PredictiveCheck) -> dict[str, Any]:
    """Plain numbers for a JSON file: residuals in SI, temperatures in °C, shares as fractions."""
    return {
        "draws": check.draws,
        "level": LEVEL,
        "quantiles": list(QUANTILES),
        "sentences": list(check.sentences),
        **{c.name: _channel_json(check.channels[c]) if c in check.channels else None for c in SENSORS},
    }


def _channel_json(found: ChannelCheck) -> dict[str, Any]:
    regimes = [{k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in asdict(r).items()} for r in found.regimes]
    return {
        "inside": found.inside,
        "expected": list(found.expected),
        "as_expected": found.as_expected,
        "runs": dict(found.runs),
        "regimes": regimes,
    }
