# SPDX-License-Identifier: Apache-2.0
"""The stages that every truth shares: light, heat, what follows the stretch, and the sensors.

A family's own are the order, which follows from the temperature, and the law of the stretch. Nothing of the product is
used; `effects` says which of the hidden things have a form of their own.

Light, history and sensors work on whole series at 100 Hz. Heat and order act on each other, so a family runs them
together with the steps of Runge-Kutta of fourth order at 1 ms (:func:`heat_step`).
"""

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.signal import lfilter

Floats = NDArray[np.float64]

SAMPLE_S = 0.01
DT, STEPS = 1e-3, 10
STEFAN_BOLTZMANN = 5.670374419e-8
FIN = 5


class Body(NamedTuple):
    """What all strips have; SI units.

    gain [K/W] and tau [s] of the heat balance, ambient temperature [K], deformation coefficient alpha, length [m];
    slow_s [s] is the time scale of whatever hides and is slow; reach_k [K] the rise that full power would hold.
    """

    gain: float
    tau: float
    ambient: float
    alpha: float
    length: float
    slow_s: float
    reach_k: float

    @property
    def top_w(self) -> float:
        """Full power of a campaign [W]."""
        return self.reach_k / self.gain


class Heat(NamedTuple):
    """Hidden strengths that act inside the loop of heat and order; 0 where nothing is hidden."""

    ambient_drift: float
    radiation: float
    natural_convection: float
    latent_heat: float
    clamp_conduction: float
    thermal_gradient: float
    photochemical_order: float
    order_dependent_absorption: float
    phase_kinetics: float

    @classmethod
    def of(cls, hidden: Mapping[str, float]) -> "Heat":
        """The entries of ``hidden`` that belong here."""
        return cls(*(hidden.get(name, 0.0) for name in cls._fields))


def random_body(rng: np.random.Generator, reach_k: float) -> Body:
    """A strip near those of the dissertation."""
    return Body(
        gain=rng.uniform(26.0, 36.0),
        tau=rng.uniform(14.0, 24.0),
        ambient=rng.uniform(296.0, 302.0),
        alpha=rng.uniform(1.6, 2.4),
        length=0.010,
        slow_s=float(np.exp(rng.uniform(math.log(10.0), math.log(40.0)))),
        reach_k=reach_k,
    )


def light(power_w: Floats, hidden: Mapping[str, float], slow_s: float, rng: np.random.Generator) -> Floats:
    """Light [W] that reaches the strip at each power sample."""
    weather = rng.spawn(1)[0]  # of its own, so that every other draw stays what it was without it
    modes = np.repeat(rng.integers(0, 2, power_w.size // 400 + 1) * 2.0 - 1.0, 400)[: power_w.size]
    given = power_w * (1.0 + hidden.get("laser_hops", 0.0) * modes)
    given = given / (1.0 + 0.5 * hidden.get("laser_saturation", 0.0) * given)
    warm = _follow((power_w > 0.0).astype(np.float64), slow_s, 0.0)
    given = given * (1.0 - hidden.get("laser_droop", 0.0) * warm)
    dose = np.concatenate([[0.0], np.cumsum(given)[:-1]]) * SAMPLE_S
    # Bleached dye absorbs nothing, so the light counts for the dye that is left: dη/dt = -k P η.
    given = given * np.exp(-hidden.get("photobleaching", 0.0) * dose)
    slipped = np.arange(power_w.size) >= weather.uniform(0.3, 0.7) * power_w.size
    given = given * (1.0 - hidden.get("slipping_beam", 0.0) * slipped)
    return np.asarray(given + hidden.get("stray_light", 0.0) * _clouds(power_w.size, weather))


def _clouds(size: int, rng: np.random.Generator) -> Floats:
    """A light that comes and goes: two slow waves without a common period, never negative, 1 in the mean."""
    time = np.arange(size) * SAMPLE_S
    first, second = (np.sin(2.0 * math.pi * (time / s + rng.uniform())) for s in (61.0, 37.0))
    return np.asarray(1.0 + 0.6 * first + 0.4 * second)


def wind(size: int, hidden: Mapping[str, float], rng: np.random.Generator) -> Floats:
    """Relative change of the loss at each power sample: a draught with a period, gusts without one."""
    time, phase = np.arange(size) * SAMPLE_S, rng.uniform(0.0, 2.0 * math.pi)
    memory = math.exp(-SAMPLE_S / 5.0)
    kicks = rng.standard_normal(size) * math.sqrt(1.0 - memory * memory)
    gusts = np.asarray(lfilter([1.0], [1.0, -memory], kicks))
    sine = np.sin(2.0 * math.pi * time / 11.0 + phase)
    return hidden.get("draught", 0.0) * sine + hidden.get("gusts", 0.0) * np.maximum(gusts, -2.5)


@njit(cache=True)
def heat_start(body: Body) -> Floats:
    """At rest: temperature [K], its bulk, share of bent isomers, and the nodes of the fin."""
    state = np.full(3 + FIN, body.ambient)
    state[2] = 0.0
    return state


@njit(cache=True)
def _rate(t: float, warming: float, ambient: float, fin0: float, body: Body, s: Heat, gust: float) -> float:
    """dT/dt [K/s] of the strip; ``warming`` is that of the light."""
    excess = t - ambient
    loss = excess / body.tau * (1.0 + gust)
    if s.natural_convection > 0.0:
        loss *= (1.0 - s.natural_convection) + s.natural_convection * (abs(excess) / 40.0) ** 0.25
    if s.radiation > 0.0:
        loss += s.radiation * STEFAN_BOLTZMANN * 3.6e-3 * (t**4 - ambient**4)
    if s.clamp_conduction > 0.0:
        loss += s.clamp_conduction / 0.030 * (t - fin0)
    rate = warming - loss
    if s.latent_heat > 0.0:  # the share that has turned is logistic in the temperature, around 318 K
        rate /= 1.0 + s.latent_heat / 1.8 / (4.0 * 3.5 * math.cosh((t - 318.0) / (2.0 * 3.5)) ** 2)
    return rate


@njit(cache=True)
def heat_step(state: Floats, power: float, gust: float, time: float, lost: float, body: Body, s: Heat) -> float:
    """Advance the heat by DT; the temperature [K] that the order follows.

    ``lost`` is the share of the order that is gone, which changes the absorption.
    """
    t = state[0]
    absorbed = power * (1.0 + s.order_dependent_absorption * lost)
    ambient = body.ambient + s.ambient_drift * (time + 0.5 * DT)
    warming = body.gain / body.tau * absorbed
    k1 = _rate(t, warming, ambient, state[3], body, s, gust)
    k2 = _rate(t + 0.5 * DT * k1, warming, ambient, state[3], body, s, gust)
    k3 = _rate(t + 0.5 * DT * k2, warming, ambient, state[3], body, s, gust)
    k4 = _rate(t + DT * k3, warming, ambient, state[3], body, s, gust)
    t += DT / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    state[0] = t
    if s.clamp_conduction > 0.0:  # strip → node 0 → … → surroundings; the slowest mode takes 1.9 slow_s
        for j in range(FIN):
            left = t if j == 0 else state[2 + j]
            right = ambient if j == FIN - 1 else state[4 + j]
            state[3 + j] += DT / (0.5 * body.slow_s) * (left - 2.0 * state[3 + j] + right)
    state[1] = t if s.thermal_gradient == 0.0 else state[1] + DT / s.thermal_gradient * (t - state[1])
    state[2] += DT * (0.06 * absorbed * (1.0 - state[2]) - state[2] / (0.3 * body.slow_s))
    return float(state[1] + s.photochemical_order * state[2])


@njit(cache=True)
def lagged(now: float, before: float, s: Heat) -> float:
    """The share of nematic domains, which follows late if the transition takes time."""
    return now if s.phase_kinetics == 0.0 else before + DT / s.phase_kinetics * (now - before)


def stretched(order: Floats, reference: float, alpha: float) -> Floats:
    """Stretch of the strip by (4.16) of Wu (2021), 1 at the reference order."""
    return np.asarray(((1.0 + alpha * order) / (1.0 + alpha * reference)) ** (1.0 / 3.0))


def network_stretched(order: Floats, reference: float, alpha: float) -> Floats:
    """Stretch of a network of freely jointed chains, whose step lengths are 1 + 2Q along the director and 1 - Q across.

    Q is in proportion to the order, such that the ratio of the two is 1 + alpha at the reference.
    """
    q = alpha / (3.0 + alpha) * order / reference
    ratio = (1.0 + 2.0 * q) / (1.0 - q)
    return np.asarray((ratio / (1.0 + alpha)) ** (1.0 / 3.0))


def linearly_stretched(order: Floats, reference: float, alpha: float) -> Floats:
    """Stretch that falls in proportion to the order: 1 at the reference, that of an isotropic network without order."""
    return np.asarray(1.0 - (1.0 - (1.0 + alpha) ** (-1.0 / 3.0)) * (1.0 - order / reference))


def displaced(stretch: Floats, temperature_k: Floats, body: Body, hidden: Mapping[str, float]) -> Floats:
    """Displacement [m] from the stretch, (6.8) of Wu (2021), with what hides in the network and behind it."""
    warmer = temperature_k - body.ambient
    stretch = stretch * (1.0 + hidden.get("thermal_expansion", 0.0) * warmer)
    stretch = stretch + hidden.get("elastic_softening", 0.0) * np.expm1(warmer / 65.0)
    return history(body.length * (1.0 - stretch), hidden, body.slow_s)


def history(displacement_m: Floats, hidden: Mapping[str, float], slow_s: float) -> Floats:
    """Displacement [m] behind creep, backlash, strain that does not return, and a guide that sticks."""
    d = displacement_m
    late = 0.6 * _follow(d, slow_s, d[0]) + 0.4 * _follow(d, 3.0 * slow_s, d[0])
    d = d + hidden.get("creep", 0.0) * (late - d)
    d = _play(d, hidden.get("backlash", 0.0))
    path = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(d)))])
    d = d + hidden.get("residual_strain", 0.0) * 0.04 * (1.0 - np.exp(-path / 0.04))
    return _stick(d, hidden.get("sticking_guide", 0.0))


def camera(temperature_k: Floats, body: Body, hidden: Mapping[str, float]) -> Floats:
    """What an ideal camera shows [K] at each sample of 10 ms."""
    lag = hidden.get("camera_lag", 0.0)
    shown = temperature_k
    for share in (0.7, 0.3) if lag > 0.0 else ():
        shown = _follow(shown, share * lag, shown[0])
    ambient = body.ambient + hidden.get("ambient_drift", 0.0) * np.arange(shown.size) * SAMPLE_S
    shown = shown - hidden.get("emissivity_error", 0.0) * (temperature_k - ambient)
    clipped = hidden.get("temperature_clip", 0.0)
    return np.minimum(shown, body.ambient + body.reach_k * (1.0 - clipped)) if clipped > 0.0 else shown


def distance(displacement_m: Floats, hidden: Mapping[str, float], rng: np.random.Generator) -> Floats:
    """What an ideal distance sensor shows [m] at each sample of 10 ms; the weight on the strip may sway."""
    time = np.arange(displacement_m.size) * SAMPLE_S
    phase = rng.spawn(1)[0].uniform(0.0, 2.0 * math.pi)
    swaying = np.sin(2.0 * math.pi * time / 1.1 + phase)
    drift = hidden.get("displacement_drift", 0.0) * time
    return displacement_m + drift + hidden.get("swaying_weight", 0.0) * swaying


def _follow(values: Floats, tau_s: float, start: float) -> Floats:
    """First-order lag of values (n,) at 10 ms that are straight in between."""
    decay = math.exp(-SAMPLE_S / tau_s)
    mean = tau_s / SAMPLE_S * (1.0 - decay)
    weights = [1.0 - mean, mean - decay]  # of the value now, and of the one before
    state = [start - weights[0] * values[0]]
    return np.asarray(lfilter(weights, [1.0, -decay], values, zi=state)[0])


@njit(cache=True)
def _play(values: Floats, width: float) -> Floats:
    out = np.empty_like(values)
    held = values[0]
    for i in range(values.size):
        held = min(max(held, values[i] - width), values[i] + width)
        out[i] = held
    return out


@njit(cache=True)
def _stick(values: Floats, breakaway: float) -> Floats:
    """Stay until pulled by more than ``breakaway``, then jump along."""
    out = np.empty_like(values)
    stuck = values[0]
    for i in range(values.size):
        if abs(values[i] - stuck) >= breakaway:
            stuck = values[i]
        out[i] = stuck
    return out
