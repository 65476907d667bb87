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
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_analysis.diagnosis.linearized_fit import linearised, settle
from lce_analysis.diagnosis.score_test import score_test
from lce_analysis.diagnosis.search import ITERATIONS, freed
from lce_analysis.diagnosis.whitening import Noise
from lce_analysis.identification.problem import Problem, observed_series
from lce_analysis.prediction import CAMERA, DISTANCE, simulation_input
from lce_data.errors import LceError
from lce_data.progress import Progress
from lce_data.run import Run, Series
from lce_data.waveforms import RATE_HZ, SHAPES
from lce_model import Model, simulate
from lce_model.effects import Effect
from lce_model.effects import find as find_effect

Floats = NDArray[np.float64]

CAMERA_STEP: Final = 10
"""Samples of the waveform per sample of the camera."""
SIGMA: Final = {CAMERA: 0.06, DISTANCE: 4e-6}
"""Noise of the sensors, K and m rms."""
NOISE: Final = {column: Noise(np.empty(0), sigma, sigma) for column, sigma in SIGMA.items()}
FILLED: Final = 0.99
"""Of the duration allowed: the parts of a waveform are rounded to samples."""
BROAD, LOCAL, CONFIRMED = 120, 40, 3
"""Random waveforms tried, variations of the best, and how many are confirmed by refitting the rival."""


@dataclass(frozen=True)
class Design:
    """A waveform and what it is worth.

    protocol : the text by which `lce run` knows the shape; power_w (n,) at 100 Hz is that, scaled to the limits.
    separation : whitened distance √Σ((f_true - f_rival)/σ)² that remains after the rival is refitted, for the worse of
    the two ways round.
    """

    protocol: str
    time_s: Floats
    power_w: Floats
    hottest_k: float
    separation: float


@dataclass(frozen=True)
class Limits:
    """What the bench allows: W, K, s."""

    power_w: float
    temperature_k: float
    duration_s: float

    def __post_init__(self) -> None:
        for name, value, low in (("power", self.power_w, 0.0), ("duration", self.duration_s, 20.0)):
            if not (math.isfinite(value) and value > low):
                raise LceError(f"design: a {name} of {value:g} leaves no experiment; more than {low:g} is needed")


@dataclass(frozen=True)
class _Rivals:
    """Two models that differ by an effect each; ``whole`` holds both effects at their null values."""

    whole: Model
    effects: tuple[Effect, Effect]
    strengths: tuple[Mapping[str, float], Mapping[str, float]]

    def true(self, which: int) -> Model:
        return self.whole.set(self.strengths[which])


def design(model: Model, between: tuple[str, str], limits: Limits, progress: Progress, seed: int = 0) -> Design:
    """The waveform that separates the two effects best; LceError where the limits leave none.

    An effect that ``model`` already has keeps its strength there; the other gets the one at which it changes the
    same series as much.
    """
    rivals = _rivals(model, between)
    rng = np.random.default_rng(seed)
    best: list[Design] = []
    for i in range(BROAD):
        best.append(_judged(rivals, limits, *_random(rng, limits)))
        best = sorted(best, key=lambda d: -d.separation)[:CONFIRMED]
        progress("waveforms", i + 1, BROAD + LOCAL, best[0].separation)
    for i in range(LOCAL):
        kind, options = _parsed(best[i % len(best)].protocol)
        best.append(_judged(rivals, limits, kind, _varied(rng, kind, options, limits)))
        best = sorted(best, key=lambda d: -d.separation)[:CONFIRMED]
        progress("variations", BROAD + i + 1, BROAD + LOCAL, best[0].separation)
    confirmed = [replace(d, separation=_refitted(rivals, d, progress)) for d in best if d.separation > 0.0]
    if not confirmed:
        raise LceError(f"design: no waveform within the limits tells {between[0]} from {between[1]}")
    return max(confirmed, key=lambda d: d.separation)


def _rivals(model: Model, between: tuple[str, str]) -> _Rivals:
    effects = (find_effect(between[0]), find_effect(between[1]))
    if effects[0].name == effects[1].name:
        raise LceError(f"design: {between[0]} and {between[1]} are one effect; name two")
    whole = model
    strengths: list[Mapping[str, float]] = []
    for effect in effects:
        if effect.reference in model.effects:
            own = {v.key: v.value for v in model.values if v.term == effect.name}
            whole = whole.set({effect.strength_key: effect.null})
        else:
            whole = whole.add(effect.reference)
            own = {effect.strength_key: effect.typical}
        strengths.append(own)
    return _Rivals(whole, effects, (strengths[0], strengths[1]))


def _judged(rivals: _Rivals, limits: Limits, kind: str, options: Mapping[str, tuple[float, ...]]) -> Design:
    """The waveform scaled into the limits, and its linearised separation."""
    power = SHAPES[kind].power_w(options)
    time = np.arange(power.size) / RATE_HZ
    truths = [rivals.true(k) for k in (0, 1)]
    power, hottest = _within(truths, time, power, limits)
    worst = min(_distance(rivals, k, time, power) for k in (0, 1))
    text = ",".join(f"{key}={'/'.join(f'{x:.4g}' for x in values)}" for key, values in options.items())
    return Design(f"{kind}:{text}", time, power, hottest, worst)


def _within(truths: list[Model], time: Floats, power: Floats, limits: Limits) -> tuple[Floats, float]:
    """The power scaled down until neither model gets hotter than allowed."""
    hottest = -math.inf
    for _ in range(6):
        hottest = max(float(simulate(m, time, power).temperature_k.max()) for m in truths)
        ambient = max(m["ambient.t_env"] for m in truths)
        if hottest <= limits.temperature_k:
            break
        power = power * max(0.0, 0.99 * (limits.temperature_k - ambient) / (hottest - ambient))
    return power, hottest


def _problem(rivals: _Rivals, which: int, time: Floats, power: Floats) -> Problem:
    """The rival's view of what the true model would show, without noise."""
    true = simulate(rivals.true(which), time, power)
    camera = slice(None, None, CAMERA_STEP)
    run = Run.of(
        "designed",
        power=Series(time, power),
        temperature=Series(time[camera], true.measured_temperature_k[camera]),
        displacement=None if rivals.whole.deformation == "none" else Series(time, true.measured_displacement_m),
    )
    inputs = [simulation_input(run, rivals.whole)]
    observed = observed_series(inputs, SIGMA[CAMERA], SIGMA[DISTANCE])
    extra = {e.name for e in rivals.effects}
    free = tuple(i for i, v in enumerate(rivals.whole.values) if not v.fixed and v.term not in extra)
    ambient = np.array([rivals.whole["ambient.t_env"]])
    return Problem(rivals.whole, inputs, free, ambient, observed, (), (0,))


def _distance(rivals: _Rivals, which: int, time: Floats, power: Floats) -> float:
    """What remains of the true model's signature when the rival and the free parameters are projected out."""
    rival = rivals.effects[1 - which]
    seen = score_test(linearised(_problem(rivals, which, time, power)), [rival], NOISE, estimate=False).plain
    return math.sqrt(max(0.0, seen.error - float(np.max(seen.fall, initial=0.0))))


def _refitted(rivals: _Rivals, found: Design, progress: Progress) -> float:
    """The separation with the rival refitted for good, the worse of both ways round."""
    errors = []
    for which in (0, 1):
        rival = rivals.effects[1 - which]
        problem = _problem(rivals, which, found.time_s, found.power_w)
        start = replace(problem, model=problem.model.set(rivals.strengths[1 - which]))
        settled = settle(freed(start, rival), NOISE, f"{rival.name} refitted", progress, ITERATIONS)
        errors.append(settled.plain_error(NOISE))
    return math.sqrt(min(errors))


def _random(rng: np.random.Generator, limits: Limits) -> tuple[str, dict[str, tuple[float, ...]]]:
    """A waveform of a random kind that fills a good part of the time allowed."""
    kind = str(rng.choice(["stairs", "hold", "cycles", "ramp", "prbs", "pulse"]))
    whole = FILLED * limits.duration_s * rng.uniform(0.6, 1.0)
    low, high = np.sort(rng.uniform(0.05, 1.0, 2)) * limits.power_w
    rest = whole * rng.uniform(0.1, 0.4)
    busy = whole - rest
    if kind == "stairs":
        steps = int(rng.integers(2, 7))
        options = {"low": low, "high": high, "steps": steps, "hold": busy / (2 * steps - 1), "rest": rest}
    elif kind == "hold":
        count = int(rng.integers(1, 4))
        levels = tuple(rng.uniform(0.2, 1.0, count) * limits.power_w)
        return kind, {"power": levels, "hold": (busy / count,), "rest": (rest / count,)}
    elif kind == "cycles":
        count = int(rng.integers(1, 9))
        start = busy * 0.1
        options = {"low": low, "high": high, "period": (busy - start) / count, "count": count, "start": start}
        options["rest"] = rest
    elif kind == "ramp":
        up, hold, down = rng.dirichlet([1.0, 0.5, 1.0]) * busy
        options = {"high": high, "up": max(up, 0.5), "hold": hold, "down": max(down, 0.5), "rest": rest}
    elif kind == "prbs":
        order = int(rng.choice([3, 4, 5]))
        options = {"low": low, "high": high, "bit": busy / (2**order - 1), "order": order}
        options |= {"seed": int(rng.integers(0, 100)), "rest": rest}
    else:
        options = {"amp": high - low, "th": busy, "offset": low, "rest": rest}
    return kind, {key: (float(value),) for key, value in options.items()}


def _varied(
    rng: np.random.Generator, kind: str, options: Mapping[str, tuple[float, ...]], limits: Limits
) -> dict[str, tuple[float, ...]]:
    """The options, each number changed by about a tenth, the whole within the limits."""
    shape = SHAPES[kind]
    changed: dict[str, tuple[float, ...]] = {}
    for key, values in options.items():
        spec = shape.options[key]
        if spec.whole:
            changed[key] = values
            continue
        top = limits.power_w if spec.unit == "W" else spec.upper
        changed[key] = tuple(float(np.clip(x * rng.lognormal(0.0, 0.1), spec.lower, top)) for x in values)
    long = shape.duration_s(changed) / (FILLED * limits.duration_s)
    if long > 1.0:
        changed = {k: tuple(x / long for x in v) if shape.options[k].unit == "s" else v for k, v in changed.items()}
    return changed


def _parsed(protocol: str) -> tuple[str, dict[str, tuple[float, ...]]]:
    kind, _, rest = protocol.partition(":")
    pairs = (item.partition("=") for item in rest.split(","))
    return kind, {key: tuple(float(x) for x in text.split("/")) for key, _, text in pairs}
