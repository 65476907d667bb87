# SPDX-License-Identifier: Apache-2.0
"""Truths "chapter-5-continuous" and "chapter-5-literal": the dynamic phase transition of Wu (2021), chapter 5.

The share x of nematic molecules follows

    dx = [w13 (1 - x) - w31 x] |dT|,   w13 = (Cf1 D + Cf2 D²) e^(-E21/kT),   w31 = (Cr1 Q2 + Cr2 Q2²) e^(-E23/kT)

with D = Q3 - Q2 and one set of coefficients on heating, another on cooling ((5.5)–(5.9); both advance with |dT|, the
order is that at 300 K at rest). Continuous: beyond T* and T1 one of the wells is gone, which leaves the rate out of it
without a barrier. Literal: x is 1 below T* and 0 above T1, as section 5.1 says, and jumps there.

The step is exponential with the rates at its middle, 1 ms long.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from stages import DT, STEPS, Body, Floats, Heat, heat_start, heat_step, lagged, random_body, stretched

BOLTZMANN = 1.380649e-23
REFERENCE_K = 300.0


class Branch(NamedTuple):
    """Coefficients of one direction: Landau–de Gennes [J/K, J, J], T* [K], rates [1/K]."""

    a0: float
    b: float
    c: float
    t_star: float
    cf1: float
    cf2: float
    cr1: float
    cr2: float

    @property
    def t_1(self) -> float:
        """The temperature [K] above which the nematic well is gone, (4.4)."""
        return self.t_star + self.b**2 / (4.0 * self.a0 * self.c)


class Dynamic(NamedTuple):
    """The strip without anything hidden."""

    body: Body
    heating: Branch
    cooling: Branch
    literal: bool

    @classmethod
    def random(cls, rng: np.random.Generator, literal: bool) -> "Dynamic":
        """A strip near the one of (5.10).

        A literal one has twice the Cf2 on cooling. The jump at T* is then a twentieth of the molecules instead of a
        sixth, so that a continuous model is wrong, but slightly.
        """
        t_star = 307.0 + rng.uniform(-2.0, 4.0)

        def vary(value: float, share: float) -> float:
            return value * math.exp(rng.uniform(-share, share))

        a0_r, b_r, c_r = vary(2.3e-22, 0.05), vary(3.5e-20, 0.03), vary(2.0e-20, 0.05)
        a0_f, b_f, c_f = vary(6.0e-22, 0.05), vary(4.5e-20, 0.03), vary(2.6e-20, 0.05)
        heating = Branch(a0_r, b_r, c_r, t_star, vary(0.7, 0.5), 0.0, vary(29.0, 0.3), 8.6e-5)
        cooling = Branch(a0_f, b_f, c_f, t_star, 5.0e-4, vary(0.6 if literal else 0.3, 0.3), vary(1100.0, 0.3), 0.0)
        body = random_body(rng, reach_k=1.25 * (heating.t_1 - 300.0))
        return cls(body, heating, cooling, literal)

    def run(self, light_w: Floats, gusts: Floats, hidden: dict[str, float]) -> tuple[Floats, Floats]:
        """Temperature [K] and stretch at each power sample."""
        spread = hidden.get("transition_distribution", 0.0)
        shifts = 0.2 * spread * np.arange(-16.0, 17.0) if spread > 0.0 else np.zeros(1)
        weights = np.exp(-0.5 * (shifts / spread) ** 2) if spread > 0.0 else np.ones(1)
        weights = weights / weights.sum()
        branches = self.heating, self.cooling
        temperature, order, reference = _run(
            light_w, gusts, self.body, Heat.of(hidden), *branches, self.literal, shifts, weights
        )
        return temperature, stretched(order, reference, self.body.alpha)


@njit(cache=True)
def wells(temperature: float, branch: Branch) -> tuple[float, float]:
    """Order at the barrier and in the nematic well, (4.3); they are one above T1, and the barrier is at 0 below T*."""
    slope = branch.a0 * (temperature - branch.t_star)
    root = math.sqrt(max(branch.b**2 - 4.0 * slope * branch.c, 0.0))
    return max(branch.b - root, 0.0) / (2.0 * branch.c), (branch.b + root) / (2.0 * branch.c)


@njit(cache=True)
def _energy(q: float, temperature: float, branch: Branch) -> float:
    """Free energy [J], (4.1)."""
    return q**2 * (0.5 * branch.a0 * (temperature - branch.t_star) - branch.b * q / 3.0 + 0.25 * branch.c * q**2)


@njit(cache=True)
def changed(x: float, temperature: float, change: float, branch: Branch, literal: bool, lower: float = 0.0) -> float:
    """x after the temperature, ``temperature`` in the middle, has gone by ``change``; T* may be ``lower`` [K]."""
    if literal and temperature + lower <= branch.t_star:
        return 1.0
    q2, q3 = wells(temperature + lower, branch)
    if literal and q3 <= q2:
        return 0.0
    barrier = _energy(q2, temperature + lower, branch)
    # Above T1 there is no barrier on the way out of a nematic well that is gone.
    depth = barrier - _energy(q3, temperature + lower, branch) if q3 > q2 else 0.0
    width, heat = q3 - q2, BOLTZMANN * temperature
    w13 = (branch.cf1 * width + branch.cf2 * width**2) * math.exp(-barrier / heat) if width > 0.0 else 0.0
    w31 = (branch.cr1 * q2 + branch.cr2 * q2**2) * math.exp(-depth / heat)
    total = w13 + w31
    if total <= 0.0:
        return x
    goal = w13 / total
    return goal + (x - goal) * math.exp(-total * abs(change))


@njit(cache=True)
def _mean_order(x: Floats, temperature: float, branch: Branch, shifts: Floats, weights: Floats) -> tuple[float, float]:
    """Mean order of the classes of molecules, and what it would be if all were nematic."""
    order = possible = 0.0
    for j in range(shifts.size):
        well = wells(temperature + shifts[j], branch)[1]
        order += weights[j] * x[j] * well
        possible += weights[j] * well
    return order, possible


@njit(cache=True)
def _run(
    light: Floats, gusts: Floats, body: Body, s: Heat, heating: Branch, cooling: Branch, literal: bool,
    shifts: Floats, weights: Floats,
) -> tuple[Floats, Floats, float]:  # fmt: skip
    temperature, orders = np.empty(light.size), np.empty(light.size)
    heat = heat_start(body)
    x = np.ones(shifts.size)
    reference = _mean_order(x, REFERENCE_K, heating, shifts, weights)[1]
    before, branch = body.ambient, heating
    order, possible = _mean_order(x, before, heating, shifts, weights)
    nematic = 1.0
    for i in range(light.size):
        temperature[i], orders[i] = heat[0], order
        for k in range(STEPS):
            felt = heat_step(heat, light[i], gusts[i], (i * STEPS + k) * DT, 1.0 - order / reference, body, s)
            if felt != before:
                branch = heating if felt > before else cooling
            middle = 0.5 * (felt + before)
            for j in range(shifts.size):
                x[j] = changed(x[j], middle, felt - before, branch, literal, shifts[j])
            before = felt
            order, possible = _mean_order(x, felt, branch, shifts, weights)
            nematic = lagged(order / possible, nematic, s)
            order = nematic * possible
    return temperature, orders, reference
