# SPDX-License-Identifier: Apache-2.0
"""Truth "relays": a continuous population of domains, each with its own switching temperatures (Preisach).

A domain turns isotropic at a rate of e^((T - up)/kappa) per second, and nematic again at e^((down - T)/(c kappa)): a relay
that heat helps over its barrier, sharp but for its kappa. Middles of the loops follow a normal distribution, their
half-widths a lognormal one, and the two are correlated. The order in a nematic domain falls with the temperature as
((T_H - T)/(T_H - T_a))^beta.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from scipy.stats import norm, qmc
from stages import DT, STEPS, Body, Floats, Heat, heat_start, heat_step, lagged, random_body

COUNT = 256
REST_S = 3600.0
SLOWEST = 1e-7
"""Rate [1/s] below which a domain stays as it is."""


class Relays(NamedTuple):
    """The strip without anything hidden; temperatures in K."""

    body: Body
    middle: float
    spread: float
    half_width: float
    width_spread: float
    correlation: float
    kappa: float
    softer: float
    clearing: float
    beta: float

    @classmethod
    def random(cls, rng: np.random.Generator) -> "Relays":
        """A strip whose loop lies between those of (4.22) and (5.10)."""
        return cls(
            random_body(rng, reach_k=78.0),
            middle=rng.uniform(317.0, 327.0),
            spread=rng.uniform(4.0, 7.0),
            half_width=rng.uniform(3.0, 6.0),
            width_spread=rng.uniform(0.2, 0.5),
            correlation=rng.uniform(-0.2, 0.2),
            kappa=rng.uniform(0.4, 1.0),
            softer=rng.uniform(2.0, 4.0),
            clearing=rng.uniform(375.0, 390.0),
            beta=rng.uniform(0.13, 0.25),
        )

    def population(self, more_spread: float = 0.0) -> tuple[Floats, Floats]:
        """Switching temperatures [K] of the domains, on heating and on cooling, (COUNT,) each."""
        share = qmc.Sobol(2, scramble=False).random_base2(int(math.log2(COUNT))) + 0.5 / COUNT
        width = norm.ppf(share[:, 1])
        own = norm.ppf(share[:, 0])
        deviate = self.correlation * width + math.sqrt(1.0 - self.correlation**2) * own
        middle = self.middle + math.hypot(self.spread, more_spread) * deviate
        half = self.half_width * np.exp(self.width_spread * width)
        return middle + half, middle - half

    def run(self, light_w: Floats, gusts: Floats, hidden: dict[str, float]) -> tuple[Floats, Floats, float]:
        """Temperature [K] and order at each power sample, and the order at rest."""
        up, down = self.population(hidden.get("transition_distribution", 0.0))
        return _run(light_w, gusts, self.body, Heat.of(hidden), up, down, self)


@njit(cache=True)
def turn(
    nematic: Floats, temperature: float, dt: float, up: Floats, down: Floats, kappa: float, softer: float
) -> float:
    """Turn the domains (n,) for a time [s] at a temperature [K]; the mean share that is nematic."""
    total = 0.0
    for i in range(up.size):
        leave = math.exp(min((temperature - up[i]) / kappa, 12.0))
        join = math.exp(min((down[i] - temperature) / (softer * kappa), 12.0))
        rate = leave + join
        if rate > SLOWEST:
            goal = join / rate
            nematic[i] = goal + (nematic[i] - goal) * math.exp(-rate * dt)
        total += nematic[i]
    return total / up.size


@njit(cache=True)
def _well(temperature: float, ambient: float, clearing: float, beta: float) -> float:
    return max((clearing - temperature) / (clearing - ambient), 0.0) ** beta


@njit(cache=True)
def _run(
    light: Floats, gusts: Floats, body: Body, s: Heat, up: Floats, down: Floats, own: Relays
) -> tuple[Floats, Floats, float]:
    temperature, orders = np.empty(light.size), np.empty(light.size)
    heat = heat_start(body)
    domains = np.ones(up.size)
    share = turn(domains, body.ambient, REST_S, up, down, own.kappa, own.softer)
    reference = order = share * _well(body.ambient, body.ambient, own.clearing, own.beta)
    for i in range(light.size):
        temperature[i], orders[i] = heat[0], order
        for k in range(STEPS):
            felt = heat_step(heat, light[i], gusts[i], (i * STEPS + k) * DT, 1.0 - order / reference, body, s)
            share = lagged(turn(domains, felt, DT, up, down, own.kappa, own.softer), share, s)
            order = share * _well(felt, body.ambient, own.clearing, own.beta)
    return temperature, orders, reference
