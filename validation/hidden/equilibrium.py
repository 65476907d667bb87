# SPDX-License-Identifier: Apache-2.0
"""Truth "equilibrium": the strip of Wu (2021), chapter 4, its phases in equilibrium on two branches.

The branches are tabulated over the temperature from Boltzmann weights written here. A transition that is spread over
domains is spread over nine classes of them.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from stages import DT, STEPS, Body, Floats, Heat, heat_start, heat_step, lagged, random_body, stretched

BOLTZMANN = 1.380649e-23
GRID_K = np.arange(240.0, 520.0, 0.01)


class Equilibrium(NamedTuple):
    """The strip without anything hidden."""

    body: Body
    branches: Floats  # (2, 2, grid) on heating and cooling: share of nematic domains, and their order

    @classmethod
    def random(cls, rng: np.random.Generator) -> "Equilibrium":
        """A strip near the one of (4.21)."""
        shift = rng.uniform(-3.0, 3.0)
        a0, b, c = np.array([5.58e-22, 7.70e-20, 7.91e-20]) * rng.uniform(0.93, 1.07, 3)
        apart, of_cooling = rng.uniform(-0.5, 0.5), 6.76 / 7.91 * rng.uniform(0.99, 1.01)
        heating = _branch(a0, b, c, 305.0 + shift, 10.60 / 1.68 * rng.uniform(0.8, 1.25))
        cooling = _branch(a0, b, c * of_cooling, 291.9 + shift + apart, 3.53 / 0.93 * rng.uniform(0.8, 1.25))
        return cls(random_body(rng, reach_k=78.0), np.ascontiguousarray([heating, cooling]))

    def run(self, light_w: Floats, gusts: Floats, hidden: dict[str, float]) -> tuple[Floats, Floats]:
        """Temperature [K] and stretch at each power sample."""
        spread = hidden.get("transition_distribution", 0.0)
        temperature, order, reference = _run(light_w, gusts, self.body, Heat.of(hidden), self.branches, spread)
        return temperature, stretched(order, reference, self.body.alpha)


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
def _run(
    light: Floats, gusts: Floats, body: Body, s: Heat, branches: Floats, spread: float
) -> tuple[Floats, Floats, float]:
    temperature, orders = np.empty(light.size), np.empty(light.size)
    heat = heat_start(body)
    direction, extreme = 0, body.ambient
    nematic = _share(branches[0], body.ambient, spread)
    reference = order = nematic * _between(branches[0, 1], body.ambient)
    for i in range(light.size):
        temperature[i], orders[i] = heat[0], order
        for k in range(STEPS):
            felt = heat_step(heat, light[i], gusts[i], (i * STEPS + k) * DT, 1.0 - order / reference, body, s)
            if (felt - extreme) * (1 - 2 * direction) < 0.0:
                direction = 1 - direction
            extreme = felt
            nematic = lagged(_share(branches[direction], felt, spread), nematic, s)
            order = nematic * _between(branches[direction, 1], felt)
    return temperature, orders, reference
