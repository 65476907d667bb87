# SPDX-License-Identifier: Apache-2.0
"""The experiment that would tell two effects apart.

T-optimal discrimination (Atkinson and Fedorov 1975): of all admissible waveforms, the one with the largest whitened
distance between the two models that remains *after the rival is refitted*. Waveforms are those of
:mod:`lce_data.waveforms`, within the limits of power, temperature and duration. Each is judged linearised, by the
score test's projection; the best is then confirmed by refitting the rival for good.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lce_analysis.diagnosis.linearized_fit import linearised, refit
from lce_analysis.diagnosis.score import projected
from lce_analysis.diagnosis.trial import with_effect
from lce_analysis.experiment_design.waves import random_wave, varied_wave, wave_from_text, wave_text
from lce_analysis.identification.problem import Problem, observed_series
from lce_analysis.options import DesignOptions
from lce_analysis.prediction import simulation_input
from lce_data.channels import POWER, SENSORS, TEMPERATURE
from lce_data.errors import LceError
from lce_data.progress import CancelToken, Progress, silent, watched
from lce_data.run import Run, Series
from lce_data.waveforms import RATE_HZ, SHAPES
from lce_model import Model, simulate
from lce_model.effects import Effect
from lce_model.effects import find as find_effect

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Design:
    """A waveform and what it is worth.

    Attributes
    ----------
    protocol : the text by which `lce run` knows the shape.
    time_s : (n,) times [s], at 100 Hz.
    power_w : (n,) laser power [W]: the protocol, scaled to the limits.
    hottest_k : highest temperature [K] of the strip with either effect.
    separation : whitened distance √Σ((f_true - f_rival)/σ)² that remains after the rival is refitted, for the worse of
    the two ways round.
    """

    protocol: str
    time_s: Floats
    power_w: Floats
    hottest_k: float
    separation: float


@dataclass(frozen=True)
class _Rivals:
    """Two models that differ by an effect each; ``whole`` holds both effects at their null values."""

    whole: Model
    effects: tuple[Effect, Effect]
    strengths: tuple[Mapping[str, float], Mapping[str, float]]

    def true(self, which: int) -> Model:
        return self.whole.set(self.strengths[which])


def design(
    model: Model,
    between: tuple[str, str],
    options: DesignOptions = DesignOptions(),
    progress: Progress = silent,
    cancel: CancelToken | None = None,
) -> Design:
    """Find the waveform of the laser power that tells two effects apart best.

    Parameters
    ----------
    model : identified. An effect that it has keeps its strength; the other gets the one at which it changes the same
        series as much.
    between : the two effects, names of the library or paths of effect files.
    options : limits and sensors of the bench, and how long to search.
    progress : called after each waveform, with the best separation so far.
    cancel : stops between two waveforms and raises Cancelled.

    Returns
    -------
    Design
        The waveform, and how far apart the two effects are under it.

    Raises
    ------
    LceError
        If no waveform within the limits separates the two.

    Examples
    --------
    >>> import lce_analysis as lce
    >>> wave = lce.design(model, ("creep", "phase_kinetics"))  # doctest: +SKIP
    >>> print(wave.protocol, wave.separation)  # doctest: +SKIP
    """
    progress = watched(progress, cancel)
    rivals = _rivals(model, between)
    rng = np.random.default_rng(options.seed)
    total = options.random_waves + options.variations
    best: list[Design] = []
    for i in range(options.random_waves):
        best.append(_judged(rivals, options, *random_wave(rng, options)))
        best = _leading(best, options)
        progress("waveforms", i + 1, total, best[0].separation)
    for i in range(options.variations):
        kind, parts = wave_from_text(best[i % len(best)].protocol)
        best.append(_judged(rivals, options, kind, varied_wave(rng, kind, parts, options)))
        best = _leading(best, options)
        progress("variations", options.random_waves + i + 1, total, best[0].separation)
    confirmed = [replace(d, separation=_refitted(rivals, d, options, progress)) for d in best if d.separation > 0.0]
    if not confirmed:
        raise LceError(f"design: no waveform within the limits tells {between[0]} from {between[1]}")
    return max(confirmed, key=lambda d: d.separation)


def _leading(designs: list[Design], options: DesignOptions) -> list[Design]:
    return sorted(designs, key=lambda d: -d.separation)[: options.confirmed]


def _rivals(model: Model, between: tuple[str, str]) -> _Rivals:
    effects = (find_effect(between[0]), find_effect(between[1]))
    if effects[0].name == effects[1].name:
        raise LceError(f"design: {between[0]} and {between[1]} are one effect; name two")
    whole = model.varying({})  # the designed run is one of its own
    strengths: list[Mapping[str, float]] = []
    for effect in effects:
        if effect.reference in model.effects:
            own = {v.key: v.value for v in model.values if v.term == effect.name}
            whole = whole.set({f"{effect.name}.{name}": effect.parameter(name).default for name in effect.amplitudes})
        else:
            whole = whole.add(effect.reference)
            own = {effect.strength_key: effect.typical}
        strengths.append(own)
    return _Rivals(whole, effects, (strengths[0], strengths[1]))


def _judged(rivals: _Rivals, options: DesignOptions, kind: str, parts: Mapping[str, tuple[float, ...]]) -> Design:
    """The waveform scaled into the limits, and its linearised separation."""
    power = SHAPES[kind].power_w(parts)
    time = np.arange(power.size) / RATE_HZ
    truths = [rivals.true(k) for k in (0, 1)]
    power, hottest = _within(truths, time, power, options.max_temperature_k)
    worst = min(_distance(rivals, k, time, power, options) for k in (0, 1))
    return Design(wave_text(kind, parts), time, power, hottest, worst)


def _within(truths: list[Model], time: Floats, power: Floats, max_temperature_k: float) -> tuple[Floats, float]:
    """The power scaled down until neither model gets hotter than allowed."""
    hottest = -math.inf
    for _ in range(6):
        hottest = max(float(simulate(m, time, power).temperature_k.max()) for m in truths)
        ambient = max(m["ambient.t_env"] for m in truths)
        if hottest <= max_temperature_k:
            break
        power = power * max(0.0, 0.99 * (max_temperature_k - ambient) / (hottest - ambient))
    return power, hottest


def _problem(rivals: _Rivals, which: int, time: Floats, power: Floats, options: DesignOptions) -> Problem:
    """The rival's view of what the true model would show, without noise."""
    true = simulate(rivals.true(which), time, power)
    series = {POWER: Series(time, power)}
    for channel in SENSORS:
        if rivals.whole.predicts(channel):
            every = slice(None, None, options.camera_step if channel is TEMPERATURE else 1)
            series[channel] = Series(time[every], true[channel][every])
    inputs = [simulation_input(Run("designed", series), rivals.whole)]
    observed = observed_series(inputs, options.noise)
    extra = {e.name for e in rivals.effects}
    free = tuple(i for i, v in enumerate(rivals.whole.values) if not v.fixed and v.term not in extra)
    ambient = np.array([rivals.whole["ambient.t_env"]])
    return Problem(rivals.whole, inputs, free, ambient, observed, (), (0,))


def _distance(rivals: _Rivals, which: int, time: Floats, power: Floats, options: DesignOptions) -> float:
    """What remains of the true model's signature when the rival and the free parameters are projected out."""
    rival = rivals.effects[1 - which]
    fit = linearised(_problem(rivals, which, time, power, options))
    projection = projected(fit, [rival])
    return math.sqrt(max(0.0, projection.error - float(np.max(projection.reduction, initial=0.0))))


def _refitted(rivals: _Rivals, found: Design, options: DesignOptions, progress: Progress) -> float:
    """The separation with the rival refitted for good, the worse of both ways round."""
    errors = []
    for which in (0, 1):
        rival = rivals.effects[1 - which]
        problem = _problem(rivals, which, found.time_s, found.power_w, options)
        start = replace(problem, model=problem.model.set(rivals.strengths[1 - which]))
        label = f"{rival.name} refitted"
        errors.append(refit(with_effect(start, rival), label, progress, options.iterations).error)
    return math.sqrt(min(errors))
