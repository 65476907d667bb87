# SPDX-License-Identifier: Apache-2.0
"""Phase transition in time: one parameter set for both directions of the temperature and for every speed.

Domains, whose molecules turn together, sit in the nematic or in the isotropic well of the Landau–de Gennes energy and
jump over the barrier between them at a rate per *time*, with the barriers of (4.6) times the n_c molecules of a domain
and the widths of (4.12) as corrected, a1 = a3. This is (K1); equations (K…) are those of docs/explanation/kinetic.md.

    dx/dt = ν [(1 - x) w13 - x w31],   w13 = (y3 - y2)² e^(-n_c ΔE21/kT),   w31 = y2² e^(-n_c ΔE23/kT)

Domains differ in the middle and in the width of their loop, and in how warm their part of the strip is: the clamp cools
its end, which grows while the strip is warm. Those of one width and one place turn one after the other, nematic above
a *front* p of their T_c and isotropic below it, and the equation of x becomes one of the front
(docs/explanation/kinetic.md), with the slopes of the barriers at T_c. Where u = T - p > 0,

    dp/dt = κ w (1 - e^(-u/κ)),   w = e^((u - h)/κ + γ) per second,   κ = 2 (T1 - T*)/(27 ε)        (K4), (K6)

and where u < 0 the same with 3κ, 3h and the other sign; h, the half_width of the domains, stands for ν. It is solved in
closed form over a ramp of T. Nothing depends on the direction.
"""

import math
from statistics import NormalDist

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from lce_model.terms import Parameter, Term

Floats = NDArray[np.float64]

FRONTS, GENERATOR = 40, 17
"""A lattice (i, g i mod 40) over widths and places: one of those whose points lie farthest apart."""
COOLING = 3.0
"""The barrier of the isotropic well grows with T - T_c a third as fast as that of the nematic one falls."""
_GAMMA = 0.5772156649
"""Euler's constant: the mean of a Gumbel distribution lies γ of its widths from its mode."""
_REST_S = 3600.0
"""How long a strip has been at rest before it starts, cooled from above."""
_MOST = 30.0
"""A front gives way at the latest where it turns e^30 times a second, as often as a molecule tries."""
_ONE, _LOWEST, _MANTISSA = 0x3FF0000000000000, 0x3FE6A09E00000000, 0x000FFFFFFFFFFFFF
"""The bits of 1.0, of about 1/√2, and those of a double that hold its mantissa."""
_LN_2 = math.log(2.0)
_SUMS, _PRODUCTS = {"reassoc", "nsz"}, {"contract"}
"""Sums in any order, and products fused with them: what lets the compiler take several fronts at once. Not both in one
function: the last bit would depend on the other terms of the model, as it does even so on some processors."""


def _fronts() -> tuple[Floats, Floats, Floats]:
    """Of every front: normal deviate of ln h, distance from the clamp in lengths of the strip, share of the strip.

    No two share a width or a place; the places are denser towards the clamp, where it is colder.
    """
    roots = (np.arange(FRONTS) * GENERATOR % FRONTS + 0.5) / FRONTS
    shares = roots / roots.sum()
    deviates = np.array([NormalDist().inv_cdf(q) for q in np.cumsum(shares) - 0.5 * shares])
    deviates -= shares @ deviates
    return deviates / np.sqrt(shares @ deviates**2), roots**2, shares


_DEVIATES, _DISTANCES, _SHARES = _fronts()


@register_jitable(fastmath=_PRODUCTS)
def _boltzmann(a: float) -> float:
    """e^-a to 2e-5 for -25 < a < 25, to 2e-3 for -60 < a < 60, and next to 0 above; it becomes vector instructions."""
    a = min(a, 300.0) * (1.0 / 256.0)
    r = 1.0 - a * (1.0 - a * (0.5 - a * (1.0 / 6.0 - a * (1.0 / 24.0))))
    r *= r
    r *= r
    r *= r
    r *= r
    r *= r
    r *= r
    r *= r
    return r * r


@register_jitable(fastmath=_PRODUCTS)
def _logarithm(y: float) -> float:
    """ln y to 1e-9 for a normal y > 0, and 0 at 1; unlike log, it becomes vector instructions.

    y = 2^k m with 0.7 < m < 1.5, and ln m is a series in t = (m - 1)/(m + 1).
    """
    bits = np.float64(y).view(np.int64) + (_ONE - _LOWEST)
    k = (bits >> 52) - 1023
    m = np.int64((bits & _MANTISSA) + _LOWEST).view(np.float64)
    t = (m - 1.0) / (m + 1.0)
    return k * _LN_2 + 2.0 * t * (1.0 + t * t * (1 / 3 + t * t * (1 / 5 + t * t * (1 / 7 + t * t * (1 / 9)))))


@register_jitable(fastmath=_PRODUCTS)
def _above(z: float) -> tuple[float, float]:
    """The share of a normal distribution above ``z``, and its mean; Abramowitz & Stegun 7.1.26, as erfc is a call.

    To 1e-6; the mean to 1e-3 up to z = 3.5, beyond which hardly a domain is left.
    """
    far = abs(z)
    t = 1.0 / (1.0 + 0.23164189 * far)
    p = t * (0.254829592 + t * (-0.284496736 + t * (1.421413741 + t * (-1.453152027 + t * 1.061405429))))
    density = _boltzmann(0.5 * far * far)
    tail = 0.5 * p * density
    above = z > 0.0
    share = tail if above else 1.0 - tail
    return share, (0.7978845608 if above else 0.3989422804 * density) / (p if above else share)


@register_jitable(fastmath=_SUMS)
def _sums(
    front: Floats, centre: Floats, here: Floats, spread: float, per_spread: float, per_span: float
) -> tuple[float, float]:
    """(Σ x y3, Σ y3); the divisions are made outside, or the compiler would make them in every turn of the loop."""
    nematic = possible = 0.0
    for i in range(FRONTS):
        x, mean = _above((front[i] - centre[i]) * per_spread)
        s2 = (centre[i] + spread * mean - here[i]) * per_span + 1.0 / 9.0
        y3 = _SHARES[i] * (1.0 + math.sqrt(max(s2, 0.0)))
        nematic += x * y3
        possible += y3
    return nematic, possible


@register_jitable
def _nematic(front: Floats, centre: Floats, here: Floats, spread: float, span: float) -> tuple[float, float]:
    """(K7): (Σ x y3, Σ y3), with y3 at the mean T_c of the nematic domains of a front; in K above ``t_ref``."""
    return _sums(front, centre, here, spread, 1.0 / spread, 1.0 / span)


@register_jitable
def _deficit(deficit: float, before: float, excess: float, dt: float, cold_end: float, cold_tau: float) -> float:
    """How much colder the clamp makes the mean of the strip, E [K], after the mean has gone to ``excess``.

    (K5): dE²/dt = 2/τ (c² θ² - E²), with θ = |excess| + E far from the clamp. It is the heat balance of a layer whose
    deficit falls off exponentially, solved for the mean of θ² over the step, with the E before it.
    """
    a, b = abs(before) + deficit, abs(excess) + deficit
    goal = cold_end * cold_end * (a * a + a * b + b * b) / 3.0
    return math.sqrt(goal + (deficit * deficit - goal) * math.exp(-2.0 * dt / cold_tau))


@register_jitable(fastmath=_SUMS)
def _profile(share: Floats, per_length: float) -> float:
    """Set how warm the fronts are, as shares of the excess far from the clamp; the mean of the strip."""
    mean = 0.0
    for i in range(FRONTS):
        share[i] = 1.0 - _boltzmann(_DISTANCES[i] * per_length)
        mean += _SHARES[i] * share[i]
    return mean


@register_jitable
def _warm(here: Floats, change: Floats, excess: float, deficit: float) -> None:
    """Set the temperatures ``here`` of the fronts so that their mean is ``excess``, and ``change`` since the last step.

    All in K above ``t_ref``.
    """
    scale = excess / _profile(change, (abs(excess) + deficit + 1e-9) / (deficit + 1e-9))
    for i in range(FRONTS):
        now = scale * change[i]
        change[i] = now - here[i]
        here[i] = now


@register_jitable(fastmath=_PRODUCTS)
def _move(front: Floats, here: Floats, change: Floats, delay: Floats, at_rest: Floats, dt: float, kappa: float) -> None:
    """Move the fronts p while their temperatures T go straight by ``change`` to ``here``; all in K above ``t_ref``.

    (K9) of docs/explanation/kinetic.md: p moves by σ κ_σ ln(e^(-w0 dt) + w0 dt e^v (1 - e^-a)/a). ``delay`` is h/κ - γ,
    and ``at_rest`` is w0 = e^-delay [1/s]. A step in which T crosses p counts for the side on which it ends. There are
    no branches in the loop, so that the compiler moves several fronts at once.
    """
    per_kappa = 1.0 / kappa
    for i in range(FRONTS):
        u = (here[i] - front[i]) * per_kappa
        # The barrier of the side that T is on.
        side = 1.0 if u >= 0.0 else -COOLING
        per_side = 1.0 if u >= 0.0 else -1.0 / COOLING
        v = u * per_side
        w0_dt = dt * at_rest[i]
        a = max(w0_dt + change[i] * per_kappa * per_side, -_MOST)
        mean = 1.0 - 0.5 * a if abs(a) < 1e-5 else (1.0 - _boltzmann(a)) / a
        beyond = max(v - delay[i] - _MOST, 0.0)
        gain = dt * _boltzmann(max(delay[i] - v, -_MOST)) * mean + _boltzmann(w0_dt) - 1.0
        front[i] += (beyond + _logarithm(1.0 + gain)) * kappa * side


@register_jitable
def _equilibrate(front: Floats, here: Floats, delay: Floats, kappa: float) -> None:
    """Put the fronts where they are after ``_REST_S`` at rest in a strip that was cooled from above: (K6) with σ = -1.

    With dT = 0 it is solved by e^-v = 1 - e^(-w0 t), starting from v → ∞.
    """
    for i in range(FRONTS):
        lasts = delay[i] - math.log(_REST_S)
        v = lasts if lasts > 30.0 else -math.log(-math.expm1(-math.exp(-lasts)))
        front[i] = here[i] + COOLING * kappa * v


@register_jitable
def _kappa(span: float, barrier: float) -> float:
    """κ [K] of (K4): the rate on heating grows e-fold over it."""
    return 2.0 / 27.0 * span / barrier


def start(
    order_temperature: float,
    transition_spread: float,
    front: Floats,
    centre: Floats,
    here: Floats,
    change: Floats,
    delay: Floats,
    at_rest: Floats,
    t_c: float,
    half_width: float,
    span: float,
    barrier: float,
    spread: float,
    width_spread: float,
    cold_end: float,
    t_ref: float,
) -> tuple[float, float, float, float, float, float]:
    """Cooled from above, and at rest since. ``centre`` is the mean T_c of the domains of each front."""
    spread = math.hypot(spread, transition_spread)
    kappa = _kappa(span, barrier)
    for i in range(FRONTS):
        width = half_width * math.exp(width_spread * _DEVIATES[i])
        centre[i] = t_c - t_ref + width - half_width
        delay[i] = width / kappa - _GAMMA
        at_rest[i] = math.exp(-min(delay[i], 700.0))
        here[i] = 0.0
    _equilibrate(front, here, delay, kappa)
    reference, possible = _nematic(front, centre, here, spread, span)
    reference = max(reference, 1e-6 * possible)
    excess = order_temperature - t_ref
    deficit = abs(excess) * cold_end / (1.0 - cold_end)
    _warm(here, change, excess, deficit)
    _equilibrate(front, here, delay, kappa)
    nematic, possible = _nematic(front, centre, here, spread, span)
    return excess, deficit, reference, nematic / possible, possible / reference, 1.0


def step(
    order_temperature: float,
    transition_spread: float,
    dt: float,
    front: Floats,
    centre: Floats,
    here: Floats,
    change: Floats,
    delay: Floats,
    at_rest: Floats,
    before: float,
    deficit: float,
    reference: float,
    span: float,
    barrier: float,
    spread: float,
    cold_end: float,
    cold_tau: float,
    t_ref: float,
) -> tuple[float, float, float, float, float, float]:
    """Share x, weighted by y3, and mean y3 in units of the order at rest at ``t_ref``."""
    excess = order_temperature - t_ref
    deficit = _deficit(deficit, before, excess, dt, cold_end, cold_tau)
    _warm(here, change, excess, deficit)
    _move(front, here, change, delay, at_rest, dt, _kappa(span, barrier))
    nematic, possible = _nematic(front, centre, here, math.hypot(spread, transition_spread), span)
    return excess, deficit, reference, nematic / possible, possible / reference, 1.0


_SOURCE = "plausible: a loop between those of (4.22) and (5.10)"
_FIN = "computed for a perfect clamp: 0.13–0.17"
_TAU = "m c / (h A) of a 0.3 mm strip: 16–28 s"

KINETIC = Term(
    name="kinetic",
    stage="order",
    equation="dx/dt = nu [(1-x) w13 - x w31] in every domain, rates over n_c times the Landau-de Gennes barriers",
    parameters=(
        Parameter("t_c", "K", 325.0, 250.0, 450.0, "coexistence temperature T3 of the median domain", _SOURCE),
        Parameter(
            "half_width",
            "K",
            4.0,
            0.01,
            200.0,
            "how far above t_c the median domain turns at 1/s",
            _SOURCE,
            "log",
            usual=(0.05, 40.0),
        ),
        # Without a rate the barriers are high, and as good as linear: both ends lie far out.
        Parameter("span", "K", 120.0, 5.0, 1e4, "range of two wells, T1 - T*", _SOURCE, "log", usual=(5.0, 1000.0)),
        Parameter("barrier", "1", 18.0, 0.5, 1e5, "barrier n_c ΔE/kT at t_c", _SOURCE, "log", usual=(0.5, 1000.0)),
        Parameter(
            "spread",
            "K",
            6.0,
            0.01,
            200.0,
            "spread of the middles of the domains' loops",
            _SOURCE,
            "log",
            usual=(0.1, 40.0),
        ),
        Parameter("width_spread", "1", 0.4, 0.0, 1.0, "spread of the logarithm of their half_width", _SOURCE),
        Parameter("cold_end", "1", 0.13, 0.0, 0.5, "length that the clamp cools in the end, in strip lengths", _FIN),
        Parameter(
            "cold_tau",
            "s",
            18.0,
            0.1,
            1e5,
            "how long that takes, τ of the heat balance",
            _TAU,
            "log",
            usual=(1.0, 1000.0),
        ),
        Parameter("t_ref", "K", 301.15, 250.0, 400.0, "temperature at rest, of the clamp, too; λ = 1", _SOURCE),
    ),
    states=("before", "deficit", "reference"),
    arrays=(
        ("front", FRONTS),
        ("centre", FRONTS),
        ("here", FRONTS),
        ("change", FRONTS),
        ("delay", FRONTS),
        ("at_rest", FRONTS),
    ),
    outputs=("fraction", "well_order", "reference_order"),
    start=start,
    step=step,
)
