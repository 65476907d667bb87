# SPDX-License-Identifier: Apache-2.0
"""Truth "relays": a continuous population of domains, each with its own switching temperatures (Preisach).

A domain turns isotropic at ``middle + half_width`` and nematic again at ``middle - half_width``. Half-widths follow a
lognormal distribution, of which WIDTHS equal shares are taken. Within each the middles follow a normal distribution,
whose mean moves with the half-width. The relays of one half-width turn one after the other, so their state is one
number, the middle p of the last that turned (a play): nematic are those above it,

    p <- min(max(p, T - half_width), T + half_width).

The order in a nematic domain falls with the temperature as ((T_H - T)/(T_H - T_a))^beta. The population is
rate-independent and closes its minor loops (return-point memory).

The base that is fitted to it, `kinetic`, shares the stretch of the network and the normal distribution of the middles;
it has one half-width, and a rate. A spread of the transition is no hidden effect here: the base holds it exactly.

Truth "skewed-relays" is further from that base, and from every other one of the product: the middles m follow Gumbel's
distribution, which has a long tail towards hot; a domain's half-width is larger by ``widening`` (m - mean) than that of
its class; and the strip shortens in proportion to the order that is lost.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from scipy.stats import norm
from stages import (
    DT,
    STEPS,
    Body,
    Floats,
    Heat,
    heat_start,
    heat_step,
    lagged,
    linearly_stretched,
    network_stretched,
    random_body,
)

WIDTHS = 32
EULER = 0.5772156649015329


class Relays(NamedTuple):
    """The strip without anything hidden; temperatures in K."""

    body: Body
    middle: float
    spread: float
    half_width: float
    width_spread: float
    correlation: float
    clearing: float
    beta: float
    widening: float = 0.0
    skewed: bool = False

    @classmethod
    def random(cls, rng: np.random.Generator) -> "Relays":
        """A strip whose loop lies between those of (4.22) and (5.10)."""
        return cls(
            random_body(rng, reach_k=78.0),
            middle=rng.uniform(317.0, 327.0),
            spread=rng.uniform(4.0, 7.0),
            half_width=rng.uniform(3.0, 6.0),
            width_spread=rng.uniform(0.2, 0.5),
            correlation=rng.uniform(-0.03, 0.08),
            clearing=rng.uniform(375.0, 390.0),
            beta=rng.uniform(0.13, 0.25),
        )

    @classmethod
    def random_skewed(cls, rng: np.random.Generator) -> "Relays":
        """A strip of "skewed-relays"."""
        return cls.random(rng)._replace(widening=rng.uniform(0.04, 0.12), skewed=True)

    def population(self, more_spread: float = 0.0) -> tuple[Floats, Floats, float]:
        """Half-widths and mean middles [K] of the relays, (WIDTHS,) each, and the spread [K] of the middles."""
        deviates = norm.ppf((np.arange(WIDTHS) + 0.5) / WIDTHS)
        spread = math.hypot(self.spread, more_spread)
        half_widths = self.half_width * np.exp(self.width_spread * deviates)
        middles = self.middle + self.correlation * spread * deviates
        return half_widths, middles, spread * math.sqrt(1.0 - self.correlation**2)

    def run(self, light_w: Floats, gusts: Floats, hidden: dict[str, float]) -> tuple[Floats, Floats]:
        """Temperature [K] and stretch at each power sample."""
        population = self.population(hidden.get("transition_distribution", 0.0))
        temperature, order, reference = _run(
            light_w,
            gusts,
            self.body,
            Heat.of(hidden),
            *population,
            self.widening,
            self.skewed,
            self.clearing,
            self.beta,
        )
        stretch = linearly_stretched if self.skewed else network_stretched
        return temperature, stretch(order, reference, self.body.alpha)


@njit(cache=True)
def turn(
    last: Floats, temperature: float, half_widths: Floats, middles: Floats, spread: float,
    widening: float = 0.0, skewed: bool = False,
) -> float:  # fmt: skip
    """Turn the relays at a temperature [K], ``last`` (WIDTHS,) being the middles of the last that turned.

    Returns the share that is nematic.
    """
    total = 0.0
    for i in range(last.size):
        at_mean = half_widths[i] - widening * middles[i]  # the half-width is this and widening times the middle
        hot, cold = (temperature - at_mean) / (1.0 + widening), (temperature + at_mean) / (1.0 - widening)
        last[i] = min(max(last[i], hot), cold)
        deviate = (last[i] - middles[i]) / spread
        total += 1.0 - _gumbel(deviate) if skewed else 0.5 * math.erfc(deviate / math.sqrt(2.0))
    return total / last.size


@njit(cache=True)
def _gumbel(deviate: float) -> float:
    """Distribution function of Gumbel's law with mean 0 and standard deviation 1."""
    return math.exp(-math.exp(-(deviate * math.pi / math.sqrt(6.0) + EULER)))


@njit(cache=True)
def _well(temperature: float, ambient: float, clearing: float, beta: float) -> float:
    return float(max((clearing - temperature) / (clearing - ambient), 0.0) ** beta)


@njit(cache=True)
def _run(
    light: Floats, gusts: Floats, body: Body, s: Heat, half_widths: Floats, middles: Floats, spread: float,
    widening: float, skewed: bool, clearing: float, beta: float,
) -> tuple[Floats, Floats, float]:  # fmt: skip
    temperature, orders = np.empty(light.size), np.empty(light.size)
    heat = heat_start(body)
    last = np.full(half_widths.size, np.inf)  # cooled from above
    share = turn(last, body.ambient, half_widths, middles, spread, widening, skewed)
    reference = order = share * _well(body.ambient, body.ambient, clearing, beta)
    for i in range(light.size):
        temperature[i], orders[i] = heat[0], order
        for k in range(STEPS):
            felt = heat_step(heat, light[i], gusts[i], (i * STEPS + k) * DT, 1.0 - order / reference, body, s)
            share = lagged(turn(last, felt, half_widths, middles, spread, widening, skewed), share, s)
            order = share * _well(felt, body.ambient, clearing, beta)
    return temperature, orders, reference
