# SPDX-License-Identifier: Apache-2.0
"""A strip that hides something: the data on which the diagnosis is judged.

Nothing of ``lce_model`` is used. The heat balance is integrated by Runge–Kutta of fourth order at 1 ms, the equilibrium
branches are tabulated over the temperature from Boltzmann weights written here, and what is hidden has forms of its own
where physics allows: bleaching as a population of dye, latent heat as an enthalpy, clamps as a fin of five nodes, creep
of two retardation times, a camera of two poles, a transition that is spread over nine classes of domains.
"""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]

DT = 1e-3
BOLTZMANN, STEFAN_BOLTZMANN = 1.380649e-23, 5.670374419e-8
GRID_K = np.arange(240.0, 520.0, 0.01)
FIN = 5

HIDDEN = (
    "laser_saturation", "laser_droop", "order_dependent_absorption", "photobleaching", "ambient_drift", "radiation",
    "natural_convection", "latent_heat", "clamp_conduction", "thermal_gradient", "phase_kinetics",
    "transition_distribution", "photochemical_order", "thermal_expansion", "creep", "elastic_softening", "backlash",
    "residual_strain", "camera_lag", "emissivity_error", "displacement_drift",
    # not in the library of the product:
    "draught", "laser_hops", "sticking_guide",
)  # fmt: skip
OUTSIDE = HIDDEN[-3:]
INDEX = {name: i for i, name in enumerate(HIDDEN)}

STRENGTH: dict[str, tuple[float, float]] = {
    "laser_saturation": (0.02, 0.10),  # 1/W, curvature
    "laser_droop": (0.02, 0.08),
    "order_dependent_absorption": (0.03, 0.12),
    "photobleaching": (2e-4, 1e-3),  # 1/J
    "ambient_drift": (0.004, 0.015),  # K/s
    "radiation": (0.2, 0.7),
    "natural_convection": (0.2, 0.7),
    "latent_heat": (0.4, 2.0),  # J/g
    "clamp_conduction": (5e-5, 3e-4),  # W/K
    "thermal_gradient": (0.1, 0.5),  # s
    "phase_kinetics": (0.3, 1.5),  # s
    "transition_distribution": (1.0, 4.0),  # K
    "photochemical_order": (2.0, 8.0),  # K
    "thermal_expansion": (5e-5, 3e-4),  # 1/K
    "creep": (0.02, 0.12),
    "elastic_softening": (0.004, 0.02),
    "backlash": (1e-5, 5e-5),  # m
    "residual_strain": (0.001, 0.006),
    "camera_lag": (0.08, 0.4),  # s
    "emissivity_error": (0.01, 0.05),
    "displacement_drift": (1e-7, 8e-7),  # m/s
    "draught": (0.05, 0.25),  # relative change of the loss
    "laser_hops": (0.02, 0.08),  # relative change of the power
    "sticking_guide": (1e-5, 5e-5),  # m before it breaks away
}
"""Weak and clearly visible strength of everything that may be hidden."""


@dataclass(frozen=True)
class Body:
    """The strip without anything hidden; SI units."""

    gain: float
    tau: float
    ambient: float
    alpha: float
    length: float
    branches: Floats  # (2, 2, grid) on heating and cooling: share of nematic domains, and their order

    @classmethod
    def random(cls, rng: np.random.Generator) -> "Body":
        """A strip near the one of the dissertation's (4.21)."""
        shift = rng.uniform(-3.0, 3.0)
        heating = _branch(5.58e-22, 7.70e-20, 7.91e-20, 305.0 + shift, 10.60 / 1.68 * rng.uniform(0.8, 1.25))
        cooling = _branch(5.58e-22, 7.70e-20, 6.76e-20, 291.9 + shift, 3.53 / 0.93 * rng.uniform(0.8, 1.25))
        return cls(
            gain=rng.uniform(26.0, 36.0),
            tau=rng.uniform(14.0, 24.0),
            ambient=rng.uniform(296.0, 302.0),
            alpha=rng.uniform(1.6, 2.4),
            length=0.010,
            branches=np.ascontiguousarray([heating, cooling]),
        )


def _branch(a0: float, b: float, c: float, t_star: float, ratio: float) -> Floats:
    """Share of nematic domains and their order over GRID_K, one branch, (4.8)–(4.14) with the widths of the prose."""
    t = GRID_K
    inside = b * b - 4.0 * a0 * (t - t_star) * c
    root = np.sqrt(np.maximum(inside, 0.0))
    barrier, well = (b - root) / (2.0 * c), (b + root) / (2.0 * c)
    energy = 0.5 * a0 * (t - t_star) * well**2 - b * well**3 / 3.0 + 0.25 * c * well**4
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        odds = (ratio * barrier / (well - barrier)) ** 2 * np.exp(np.minimum(energy / (BOLTZMANN * t), 700.0))
    share = np.where(t <= t_star, 1.0, np.where(inside <= 0.0, 0.0, 1.0 / (1.0 + np.nan_to_num(odds, nan=np.inf))))
    return np.array([share, well])


@njit(cache=True)
def _between(values: Floats, temperature: float) -> float:
    x = (temperature - 240.0) * 100.0
    i = min(max(int(x), 0), values.size - 2)
    return values[i] + (x - i) * (values[i + 1] - values[i])


@njit(cache=True)
def _share(branch: Floats, temperature: float, spread: float) -> float:
    """Share of nematic domains; with a spread, that of nine transition temperatures of a normal distribution."""
    if spread == 0.0:
        return _between(branch[0], temperature)
    total = norm = 0.0
    for k in range(-4, 5):
        weight = math.exp(-0.5 * (0.6 * k) ** 2)
        there = temperature + 0.6 * k * spread
        total += weight * _between(branch[0], there) * _between(branch[1], there)
        norm += weight
    return total / norm / _between(branch[1], temperature)


@njit(cache=True)
def _light(power: float, s: Floats, warm: float, dye: float, order_loss: float, hop: float) -> float:
    light = power * (1.0 + hop)
    if s[0] > 0.0:
        light = light / (1.0 + 0.5 * s[0] * light)
    return light * (1.0 - s[1] * warm) * (1.0 + s[2] * order_loss) * dye


@njit(cache=True)
def _rate(
    t: float, light: float, ambient: float, fin0: float, gain: float, tau: float, s: Floats, wind: float
) -> float:
    """dT/dt [K/s] of the strip."""
    excess = t - ambient
    loss = excess / tau * (1.0 + wind)
    if s[6] > 0.0:
        loss = excess / tau * ((1.0 - s[6]) + s[6] * (abs(excess) / 40.0) ** 0.25)
    if s[5] > 0.0:
        loss += s[5] * STEFAN_BOLTZMANN * 3.6e-3 * (t**4 - ambient**4)
    if s[8] > 0.0:
        loss += s[8] / 0.030 * (t - fin0)
    rate = gain / tau * light - loss
    if s[7] > 0.0:  # enthalpy: the transition takes heat around 318 K
        z = (t - 318.0) / 6.0
        rate /= 1.0 + s[7] / 1.8 * math.exp(-0.5 * z * z) / (6.0 * math.sqrt(2.0 * math.pi))
    return rate


@njit(cache=True)
def _run(
    power: Floats, body: Floats, branches: Floats, s: Floats, slow: float, phase: float, hops: Floats, out: Floats
) -> None:
    """Fill ``out`` (n, 2) with what ideal sensors show at every power sample (10 ms)."""
    gain, tau, ambient0, alpha, length = body[0], body[1], body[2], body[3], body[4]
    t = bulk = camera1 = camera2 = ambient0
    fin = np.full(FIN, ambient0)
    warm = bent = late1 = late2 = path = stuck = 0.0
    dye = 1.0
    direction, extreme = 0, ambient0
    nematic = _share(branches[0], ambient0, s[11])
    reference = order = nematic * _between(branches[0, 1], ambient0)
    held = last = 0.0
    d = 0.0
    for i in range(power.size):
        for k in range(10):
            time = (i * 10 + k) * DT
            ambient = ambient0 + s[4] * time
            p = power[i - 1] if i > 0 else 0.0
            wind = s[21] * math.sin(2.0 * math.pi * time / 11.0 + phase)
            light = _light(p, s, warm, dye, 1.0 - order / reference, s[22] * hops[i])
            k1 = _rate(t, light, ambient, fin[0], gain, tau, s, wind)
            k2 = _rate(t + 0.5 * DT * k1, light, ambient, fin[0], gain, tau, s, wind)
            k3 = _rate(t + 0.5 * DT * k2, light, ambient, fin[0], gain, tau, s, wind)
            k4 = _rate(t + DT * k3, light, ambient, fin[0], gain, tau, s, wind)
            if i > 0:
                t += DT / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
            if s[8] > 0.0:  # the clamp as a fin: strip → node 0 → … → surroundings; slowest mode 1.9 slow_s
                for j in range(FIN):
                    left = t if j == 0 else fin[j - 1]
                    right = ambient if j == FIN - 1 else fin[j + 1]
                    fin[j] += DT / (0.5 * slow) * (left - 2.0 * fin[j] + right)
            warm += DT / slow * ((1.0 if p > 0.0 else 0.0) - warm)
            dye -= DT * s[3] * light * dye
            bent += DT * (0.05 * light * (1.0 - bent) - bent / 8.0)
            bulk = t if s[9] == 0.0 else bulk + DT / s[9] * (t - bulk)
            felt = bulk + s[12] * bent
            if (felt - extreme) * (1 - 2 * direction) < 0.0:
                direction = 1 - direction
            extreme = felt
            now = _share(branches[direction], felt, s[11])
            nematic = now if s[10] == 0.0 else nematic + DT / s[10] * (now - nematic)
            order = nematic * _between(branches[direction, 1], felt)
            stretch = ((1.0 + alpha * order) / (1.0 + alpha * reference)) ** (1.0 / 3.0)
            stretch *= 1.0 + s[13] * (t - ambient0)
            stretch += s[15] * (math.exp((t - ambient0) / 80.0) - 1.0)
            raw = length * (1.0 - stretch)
            late1 += DT / slow * (raw - late1)
            late2 += DT / (3.0 * slow) * (raw - late2)
            d = raw + s[14] * (0.6 * late1 + 0.4 * late2 - raw)
            held = min(max(held, d - s[16]), d + s[16])
            d = held if s[16] > 0.0 else d
            path += abs(d - last)
            last = d
            d += s[17] * 0.05 * (1.0 - math.exp(-path / 0.05))
            if s[23] > 0.0:  # sticks until it is pulled by more than the breakaway, then jumps along
                if abs(d - stuck) > s[23]:
                    stuck = d
                d = stuck
            camera1 = t if s[18] == 0.0 else camera1 + DT / (0.7 * s[18]) * (t - camera1)
            camera2 = camera1 if s[18] == 0.0 else camera2 + DT / (0.3 * s[18]) * (camera1 - camera2)
        ambient = ambient0 + s[4] * i * 10 * DT
        out[i, 0] = camera2 - s[19] * (t - ambient)
        out[i, 1] = d + s[20] * i * 10 * DT


def measure(
    body: Body, power_w: Floats, hidden: dict[str, float], rng: np.random.Generator, slow_s: float
) -> tuple[Floats, Floats]:
    """Camera [K] at 10 Hz and distance [m] at 100 Hz, with noise: a white part, a correlated part, quantisation."""
    strengths = np.zeros(len(HIDDEN))
    for name, strength in hidden.items():
        strengths[INDEX[name]] = strength
    hops = np.repeat(rng.integers(0, 2, power_w.size // 400 + 1) * 2.0 - 1.0, 400)[: power_w.size]
    out = np.empty((power_w.size, 2))
    numbers = np.array([body.gain, body.tau, body.ambient, body.alpha, body.length])
    phase = rng.uniform(0.0, 2.0 * math.pi)
    _run(np.ascontiguousarray(power_w), numbers, body.branches, strengths, slow_s, phase, hops, out)
    camera = out[::10, 0] + _noise(rng, out[::10, 0].size, 0.06 * rng.uniform(0.7, 1.3), 0.6)
    distance = out[:, 1] + _noise(rng, out.shape[0], 4e-6 * rng.uniform(0.7, 1.3), 0.9)
    return np.round(camera / 0.01) * 0.01, np.round(distance / 1e-7) * 1e-7


def _noise(rng: np.random.Generator, size: int, rms: float, phi: float) -> Floats:
    """Four fifths of the variance white, one fifth autoregressive."""
    slow = np.empty(size)
    slow[0] = rng.standard_normal()
    kicks = math.sqrt(1.0 - phi * phi) * rng.standard_normal(size)
    for i in range(1, size):
        slow[i] = phi * slow[i - 1] + kicks[i]
    return rms * (math.sqrt(0.8) * rng.standard_normal(size) + math.sqrt(0.2) * slow)
