# SPDX-License-Identifier: Apache-2.0
"""Phase transition in time: one parameter set for both directions of the temperature and for every speed.

Domains, whose molecules turn together, sit in the nematic or in the isotropic well of the Landau–de Gennes energy and
jump over the barrier between them at a rate per *time*, with the barriers of (4.6) times the n_c molecules of a domain
and the widths of (4.12) as corrected, a1 = a3:

    dx/dt = ν [(1 - x) w13 - x w31],   w13 = (y3 - y2)² e^(-n_c ΔE21/kT),   w31 = y2² e^(-n_c ΔE23/kT)

Of A0, B, C and n_c only two combinations enter, T1 - T* and the barrier ε = n_c ΔE(T_c)/kT at the coexistence
temperature T_c. With s = √((T1 - T)/(T1 - T*)) and y = Q·2C/B (docs/kinetic.md):

    y2 = 1 - s,   y3 = 1 + s,   n_c ΔE23/kT = 27 ε s³,   n_c ΔE21/kT = 27/16 ε (1 - s)³ (1 + 3s)

The domains differ in T_c; a fixed number of them, of equal share, stands for all. Nothing depends on the direction.
"""

import math
from statistics import NormalDist

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from lce_model.terms import Parameter, Term

Floats = NDArray[np.float64]

DOMAINS = 48
_WIDER = 1.6
_NODES = np.array([NormalDist(0.0, _WIDER).inv_cdf((i + 0.5) / DOMAINS) for i in range(DOMAINS)])
_PARTS = np.exp(-0.5 * _NODES**2 * (1.0 - 1.0 / _WIDER**2))
_SHARES = _PARTS / _PARTS.sum()
"""Normal deviates of the domains, and their shares. Domains of equal share would be so far apart in the tails that
each shows as a step of the displacement."""
_STEP_K = 0.25
"""A larger change of the temperature is walked in pieces of this size at most."""


@register_jitable
def _boltzmann(a: float) -> float:
    """e^-a for a ≥ 0, to 1e-3 below a = 80; unlike exp, the compiler makes vector instructions of it."""
    a *= 1.0 / 256.0
    r = 1.0 / (1.0 + a * (1.0 + a * (0.5 + a * (1.0 / 6.0))))
    r *= r
    r *= r
    r *= r
    r *= r
    r *= r
    r *= r
    r *= r
    return r * r


@register_jitable
def _rates(s: float, barrier: float) -> tuple[float, float]:
    """(w13, w31) at the distance ``s`` below T1: 0 above T1, over 1 below T*, where the isotropic well is gone."""
    y2 = max(1.0 - s, 0.0)
    gap = 1.0 + s - y2
    w13 = gap * gap * _boltzmann(27.0 / 16.0 * barrier * y2 * y2 * y2 * (1.0 + 3.0 * s))
    return w13, y2 * y2 * _boltzmann(27.0 * barrier * s * s * s)


@register_jitable
def _settled(s: float, barrier: float) -> float:
    """x of a domain that was left at rest: detailed balance, (4.10)."""
    if s <= 0.0 or s >= 1.0:
        return 0.0 if s <= 0.0 else 1.0
    lift = barrier * (27.0 / 16.0 * (1.0 - s) ** 3 * (1.0 + 3.0 * s) - 27.0 * s**3)
    width = (1.0 - s) / (2.0 * s)
    return 1.0 / (1.0 + width * width * math.exp(min(max(lift, -700.0), 700.0)))


@register_jitable
def _clearing(z: float, t_c: float, span: float, spread: float, tail: float) -> float:
    """T1 of the domain at the normal deviate ``z``: T_c by Tukey's h distribution, and span/9 above it."""
    return t_c + spread * z * math.exp(0.5 * tail * z * z) + span / 9.0


def start(
    order_temperature: float,
    transition_spread: float,
    x: Floats,
    top: Floats,
    w13: Floats,
    w31: Floats,
    t_c: float,
    half_width: float,
    span: float,
    barrier: float,
    spread: float,
    tail: float,
    t_ref: float,
) -> tuple[float, float, float, float, float, float]:
    """Left at rest for long: every domain in equilibrium. ``top`` is T1 of the domains, in spans."""
    reference = nematic = possible = 0.0
    spread = math.hypot(spread, transition_spread)
    for i in range(x.size):
        clearing = _clearing(_NODES[i], t_c, span, spread, tail)
        s = math.sqrt(max((clearing - t_ref) / span, 0.0))
        reference += _SHARES[i] * _settled(s, barrier) * (1.0 + s)
        top[i] = clearing / span
        s = math.sqrt(max(top[i] - order_temperature / span, 0.0))
        w13[i], w31[i] = _rates(s, barrier)
        x[i] = _settled(s, barrier)
        nematic += _SHARES[i] * x[i] * (1.0 + s)
        possible += _SHARES[i] * (1.0 + s)
    # The attempt rate at which w31 is 1/s where it is to be.
    turning = _rates(math.sqrt(max(1.0 / 9.0 - half_width / span, 0.0)), barrier)[1]
    reference = max(reference, 1e-6 * possible)
    return order_temperature, 1.0 / turning, reference, nematic / possible, possible / reference, 1.0


@register_jitable(fastmath={"reassoc", "contract", "nsz"})
def _turn(
    x: Floats, top: Floats, w13: Floats, w31: Floats, reduced: float, wait: float, barrier: float
) -> tuple[float, float]:
    """Move the domains to the temperature ``reduced`` [spans]; (Σ x y3, Σ y3). ``wait`` is half the time, in 1/ν.

    Exact for rates that are constant over the piece; the mean of those at its ends stands for them. Free of branches,
    so that several domains go at once.
    """
    nematic = possible = 0.0
    for i in range(x.size):
        s = math.sqrt(max(top[i] - reduced, 0.0))
        f, r = _rates(s, barrier)
        forth, both = w13[i] + f, w13[i] + f + w31[i] + r
        w13[i], w31[i] = f, r
        x[i] += (forth / (both + 1e-300) - x[i]) * (1.0 - _boltzmann(wait * both))
        nematic += _SHARES[i] * x[i] * (1.0 + s)
        possible += _SHARES[i] * (1.0 + s)
    return nematic, possible


def step(
    order_temperature: float,
    dt: float,
    x: Floats,
    top: Floats,
    w13: Floats,
    w31: Floats,
    before: float,
    rate: float,
    reference: float,
    span: float,
    barrier: float,
) -> tuple[float, float, float, float, float, float]:
    """x and Q3, both over all domains, in units of the order at rest at ``t_ref``."""
    pieces = 1 + int(abs(order_temperature - before) / _STEP_K)
    wait = 0.5 * rate * dt / pieces
    nematic = possible = 1.0
    for j in range(1, pieces + 1):
        reduced = (before + (order_temperature - before) * j / pieces) / span
        nematic, possible = _turn(x, top, w13, w31, reduced, wait, barrier)
    return order_temperature, rate, reference, nematic / possible, possible / reference, 1.0


_SOURCE = "plausible: a loop between those of (4.22) and (5.10)"

KINETIC = Term(
    name="kinetic",
    stage="order",
    equation="dx/dt = nu [(1-x) w13 - x w31] in every domain, rates over n_c times the Landau-de Gennes barriers",
    parameters=(
        Parameter("t_c", "K", 325.0, 250.0, 450.0, "coexistence temperature T3 of the median domain", _SOURCE),
        Parameter(
            "half_width", "K", 6.0, 0.05, 40.0, "how far above t_c a nematic domain turns at 1/s", _SOURCE, "log"
        ),
        Parameter("span", "K", 120.0, 5.0, 1000.0, "range of two wells, T1 - T*", _SOURCE, "log"),
        Parameter("barrier", "1", 12.0, 0.5, 300.0, "barrier n_c ΔE/kT at t_c", _SOURCE, "log"),
        Parameter("spread", "K", 6.0, 0.1, 40.0, "spread of t_c over the domains", _SOURCE, "log"),
        Parameter("tail", "1", 0.1, 0.0, 0.6, "weight of its tails, Tukey's h; 0 is the normal distribution", _SOURCE),
        Parameter("t_ref", "K", 301.15, 250.0, 400.0, "temperature at which λ = 1 at rest", _SOURCE),
    ),
    states=("before", "rate", "reference"),
    arrays=(("x", DOMAINS), ("top", DOMAINS), ("w13", DOMAINS), ("w31", DOMAINS)),
    outputs=("fraction", "well_order", "reference_order"),
    start=start,
    step=step,
)
