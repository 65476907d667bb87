# SPDX-License-Identifier: Apache-2.0
"""Phase transition on its way to equilibrium: Wu (2021), chapter 5, (5.1)–(5.9).

    dx = [w13 (1 - x) - w31 x] |dT|

heating:  w13 = Cf1 Δ32 e^(-E21/kT),              w31 = (Cr1 Δ21 + Cr2 Δ21²) e^(-E23/kT)
cooling:  w13 = (Cf1 Δ32 + Cf2 Δ32²) e^(-E21/kT), w31 = Cr1 Δ21 e^(-E23/kT)

Both branches advance with |dT| (as printed, with dT < 0 on cooling, the dominant term would lower x), the cooling
branch uses its own Cr1, and Q̄0 is the order at the reference temperature instead of 1;
docs/explanation/physics.md has the computation. A0, B, C have one value for heating (``_r``) and one for cooling
(``_f``). The model is rate-independent.

Below T* the isotropic well is gone and above T1 the nematic one: nothing returns to them (Δ = 0) and nothing holds the
molecules back (E = 0), so x runs to 1 and to 0 there. §5.1 also says that "x = 1" below T2 and "x = 0" above T1: a jump
of what is left at the boundary. ``spinodal`` is a rate that is added to w13 below T* and to w31 above T1: with 0 the
rates alone hold, a large one is the jump. Where an effect spreads T* over domains, each has its own x, and the order is
the mean of theirs.
"""

import math
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from lce_model.constants import BOLTZMANN
from lce_model.deformation.domains import DOMAINS, NODES, SHARES
from lce_model.deformation.vector_math import SUMS, exponential
from lce_model.landau import clearing_temperature, wells
from lce_model.terms import Parameter, Term

Floats = NDArray[np.float64]


SLOWLY = 0.3
"""Up to this integral of the rates over a step x hardly follows what it goes to."""


class Branch(NamedTuple):
    """The coefficients of a branch, as in (5.9)."""

    a0: float
    b: float
    c: float
    cf1: float
    cf2: float
    cr1: float
    cr2: float


@register_jitable(inline="always")
def _rates(s: float, temperature: float, branch: Branch) -> tuple[float, float]:
    """(w13, w31) [1/K] at the distance ``s`` = √(T1 - T) below T1."""
    # B² - 4 A C of (4.3) is 4 A0 C (T1 - T); at an extremum of F, (4.1) shrinks to Q³ (B/6 - C Q/4).
    b, c = branch.b, branch.c
    root = 2.0 * math.sqrt(branch.a0 * c) * s
    q2, q3 = max(b - root, 0.0) / (2.0 * c), (b + root) / (2.0 * c)
    barrier = q2 * q2 * q2 * (b / 6.0 - 0.25 * c * q2)
    depth = q3 * q3 * q3 * (b / 6.0 - 0.25 * c * q3)
    thermal = 1.0 / (BOLTZMANN * temperature)
    gap = q3 - q2
    w13 = (branch.cf1 + branch.cf2 * gap) * gap * exponential(-barrier * thermal)
    w31 = (branch.cr1 + branch.cr2 * q2) * q2 * exponential((depth - barrier) * thermal)
    return w13, w31


@register_jitable(inline="always")
def _relax_slowly(
    x: float,
    length: float,
    total: float,
    decay: float,
    k0: float,
    km: float,
    k1: float,
    e0: float,
    em: float,
    e1: float,
) -> float:
    """x after dx/ds = k (e - x) over ``length``, by a Magnus step; ``decay`` is e^-total, of the integral of k."""
    source = length * (k0 * e0 + 4.0 * km * em + k1 * e1) / 6.0
    twist = length * length * k0 * k1 * (e1 - e0) / 12.0
    share = (1.0 - decay) / total if total > 1e-9 else 1.0 - 0.5 * total
    return x * (1.0 - total * share) + (source + twist) * share


@register_jitable(inline="always")
def _relax_fast(
    x: float,
    length: float,
    total: float,
    decay: float,
    k0: float,
    km: float,
    k1: float,
    e0: float,
    em: float,
    e1: float,
) -> float:
    """The same where x follows e closely: exact for an e that is quadratic in the integral of k."""
    middle = length * (5.0 * k0 + 8.0 * km - k1) / 24.0
    middle = min(max(middle, 0.1 * total), 0.9 * total)
    slope = (em - e0) / middle
    bend = ((e1 - em) / (total - middle) - slope) / total
    slope -= bend * middle
    before = e0 - slope + 2.0 * bend
    after = e1 - (slope + 2.0 * bend * total) + 2.0 * bend
    return after + (x - before) * decay


@register_jitable
def _relax(x: float, length: float, k0: float, km: float, k1: float, e0: float, em: float, e1: float) -> float:
    """Solve dx/ds = k (e - x) over ``length`` from values at its beginning, middle and end, fourth order."""
    total = length * (k0 + 4.0 * km + k1) / 6.0
    decay = exponential(-total)
    if total < SLOWLY:
        return _relax_slowly(x, length, total, decay, k0, km, k1, e0, em, e1)
    return _relax_fast(x, length, total, decay, k0, km, k1, e0, em, e1)


@register_jitable
def _in_pieces(s_from: float, s_to: float) -> bool:
    """Does a path all but reach T1? It has most of its change of s there."""
    return 4.0 * min(s_from, s_to) < max(s_from, s_to)


@register_jitable
def _within(x: float, t_from: float, t_to: float, t1: float, branch: Branch) -> float:
    """x after a path below T1 that does not cross T*, where the rates have a corner.

    The rates have a root of T1 - T in them, so the path is walked in s = √(T1 - T), in which they are smooth.
    """
    if t_from == t_to:
        return x
    s_from, s_to = math.sqrt(t1 - t_from), math.sqrt(t1 - t_to)
    pieces = 4 if _in_pieces(s_from, s_to) else 1
    ds = (s_to - s_from) / pieces
    f_0, r_0 = _rates(s_from, t_from, branch)
    for i in range(pieces):
        s0 = s_from + i * ds
        sm, s1 = s0 + 0.5 * ds, s0 + ds
        f_m, r_m = _rates(sm, t1 - sm * sm, branch)
        f_1, r_1 = _rates(s1, t1 - s1 * s1, branch)
        # High barriers underflow to a rate of zero: then nothing moves, and 0/0 must not say otherwise.
        k0, km, k1 = max(f_0 + r_0, 1e-300), max(f_m + r_m, 1e-300), max(f_1 + r_1, 1e-300)
        x = _relax(x, 2.0 * abs(ds), s0 * k0, sm * km, s1 * k1, f_0 / k0, f_m / km, f_1 / k1)
        f_0, r_0 = f_1, r_1
    return min(max(x, 0.0), 1.0)


@register_jitable
def _advance(x: float, t_from: float, t_to: float, t_star: float, branch: Branch, spinodal: float) -> float:
    """x after the path t_from → t_to, in pieces that end at T* and T1."""
    t1 = clearing_temperature(branch.a0, branch.b, branch.c, t_star)
    below_from, below_to = min(t_from, t1), min(t_to, t1)
    beyond = abs(t_to - t_from) - abs(below_to - below_from)
    q = 0.5 * branch.b / branch.c
    loss = math.exp(-((branch.cr1 + branch.cr2 * q) * q + spinodal) * beyond) if beyond > 0.0 else 1.0
    if t_to < t_from:
        x *= loss
    if (below_from - t_star) * (below_to - t_star) < 0.0:
        x = _within(x, below_from, t_star, t1, branch)
        below_from = t_star
    x = _within(x, below_from, below_to, t1, branch)
    if spinodal > 0.0:
        cold = abs(min(below_to, t_star) - min(below_from, t_star))
        x = 1.0 - (1.0 - x) * math.exp(-spinodal * cold)
    return x * loss if t_to > t_from else x


@register_jitable
def _advance_most(
    x: Floats, after: Floats, t_from: float, t_to: float, t_star: float, spread: float, branch: Branch, spinodal: float
) -> None:
    """Set ``after`` to the x of all domains after the path t_from → t_to, NaN where :func:`_advance` takes more pieces.

    It does what that does, without branches, so that the compiler advances several domains at once.
    """
    width = clearing_temperature(branch.a0, branch.b, branch.c, 0.0)
    q = 0.5 * branch.b / branch.c
    isotropic = (branch.cr1 + branch.cr2 * q) * q + spinodal
    falls = t_to < t_from
    for i in range(DOMAINS):
        star = t_star + spread * NODES[i]
        t1 = star + width
        below_from, below_to = min(t_from, t1), min(t_to, t1)
        loss = exponential(-isotropic * (abs(t_to - t_from) - abs(below_to - below_from)))
        s0, s1 = math.sqrt(t1 - below_from), math.sqrt(t1 - below_to)
        sm = s0 + 0.5 * (s1 - s0)
        f_0, r_0 = _rates(s0, t1 - s0 * s0, branch)
        f_m, r_m = _rates(sm, t1 - sm * sm, branch)
        f_1, r_1 = _rates(s1, t1 - s1 * s1, branch)
        k0, km, k1 = max(f_0 + r_0, 1e-300), max(f_m + r_m, 1e-300), max(f_1 + r_1, 1e-300)
        y = x[i] * (loss if falls else 1.0)
        e0, em, e1 = f_0 / k0, f_m / km, f_1 / k1
        k0, km, k1 = s0 * k0, sm * km, s1 * k1
        length = 2.0 * abs(s1 - s0)
        total = length * (k0 + 4.0 * km + k1) / 6.0
        decay = exponential(-total)
        slowly = _relax_slowly(y, length, total, decay, k0, km, k1, e0, em, e1)
        fast = _relax_fast(y, length, total, decay, k0, km, k1, e0, em, e1)
        y = min(max(slowly if total < SLOWLY else fast, 0.0), 1.0)
        cold = abs(min(below_to, star) - min(below_from, star))
        y = 1.0 - (1.0 - y) * exponential(-spinodal * cold)
        crosses = (below_from - star) * (below_to - star) < 0.0
        after[i] = math.nan if crosses or _in_pieces(s0, s1) else y * (1.0 if falls else loss)


@register_jitable
def _advance_all(
    x: Floats, after: Floats, t_from: float, t_to: float, t_star: float, spread: float, branch: Branch, spinodal: float
) -> None:
    """Advance all domains along the path t_from → t_to; ``after`` is room for what they become."""
    _advance_most(x, after, t_from, t_to, t_star, spread, branch, spinodal)
    for i in range(DOMAINS):
        if after[i] == after[i]:
            x[i] = after[i]
        else:
            x[i] = _advance(x[i], t_from, t_to, t_star + spread * NODES[i], branch, spinodal)


@register_jitable(fastmath=SUMS)
def _sums(excess: float, x: Floats, spread: float, b: float, four_ac: float) -> tuple[float, float]:
    """(Σ x Q3, Σ Q3) over the domains, in units of 1/2C, at T - T* of the mean T*."""
    order = possible = 0.0
    for i in range(DOMAINS):
        q3 = SHARES[i] * (b + math.sqrt(max(b * b - four_ac * (excess - spread * NODES[i]), 0.0)))
        order += x[i] * q3
        possible += q3
    return order, possible


@register_jitable
def _seen(
    temperature: float, x: Floats, a0: float, b: float, c: float, t_star: float, spread: float
) -> tuple[float, float]:
    """(x, Q3) of the strip: its order is the mean over the domains. Without a spread, the first stands for all."""
    if spread == 0.0:
        return x[0], wells(temperature, a0, b, c, t_star)[1]
    order, possible = _sums(temperature - t_star, x, spread, b, 4.0 * a0 * c)
    return order / possible, 0.5 * possible / c


def start(
    order_temperature: float,
    transition_spread: float,
    x: Floats,
    a0_r: float,
    b_r: float,
    c_r: float,
    t_star: float,
    t_ref: float,
) -> tuple[float, float, float]:
    """Annealed before the first heating: nematic wherever the heating branch allows it."""
    x[:] = 1.0
    reference = _seen(t_ref, x, a0_r, b_r, c_r, t_star, transition_spread)[1]
    for i in range(DOMAINS):
        clearing = clearing_temperature(a0_r, b_r, c_r, t_star + transition_spread * NODES[i])
        x[i] = 1.0 if order_temperature < clearing else 0.0
    fraction, q3 = _seen(order_temperature, x, a0_r, b_r, c_r, t_star, transition_spread)
    return fraction, q3, reference


def step(
    path_from: float,
    path_to: float,
    direction: float,
    order_temperature: float,
    transition_spread: float,
    x: Floats,
    after: Floats,
    reference_order: float,
    a0_r: float,
    b_r: float,
    c_r: float,
    a0_f: float,
    b_f: float,
    c_f: float,
    t_star: float,
    cr1_r: float,
    cr2_r: float,
    cf1_r: float,
    cr1_f: float,
    cf1_f: float,
    cf2_f: float,
    spinodal: float,
) -> tuple[float, float, float]:
    """(x, Q3, Q̄0) after the temperature path of this step."""
    heating = Branch(a0_r, b_r, c_r, cf1_r, 0.0, cr1_r, cr2_r)
    cooling = Branch(a0_f, b_f, c_f, cf1_f, cf2_f, cr1_f, 0.0)
    branch = heating if direction > 0.0 else cooling
    if transition_spread > 0.0:
        _advance_all(x, after, path_from, path_to, t_star, transition_spread, branch, spinodal)
    else:
        x[0] = _advance(x[0], path_from, path_to, t_star, branch, spinodal)
    fraction, q3 = _seen(order_temperature, x, branch.a0, branch.b, branch.c, t_star, transition_spread)
    return fraction, q3, reference_order


_SOURCE = "(5.10), Amp 0.4, T_h 20 s"
_KNEE = 0.01
"""Rate [1/K] below which a coefficient hardly matters: it moves a tenth of the molecules over 10 K."""
_BEYOND = 1.0
"""The same for the rate added beyond T* and T1: a smaller one is lost beside the others."""

DYNAMIC = Term(
    name="dynamic",
    stage="order",
    equation="dx = [w13 (1-x) - w31 x] |dT|, rates over the Landau-de Gennes barriers by branch",
    parameters=(
        Parameter("a0_r", "J/K", 2.3e-22, 5e-23, 3e-21, "slope A0, heating", _SOURCE, "log"),
        Parameter("b_r", "J", 3.5e-20, 8e-21, 2e-19, "cubic coefficient B, heating", _SOURCE, "log"),
        Parameter("c_r", "J", 2.0e-20, 4e-21, 2e-19, "quartic coefficient C, heating", _SOURCE, "log"),
        Parameter("a0_f", "J/K", 6.0e-22, 5e-23, 3e-21, "slope A0, cooling", _SOURCE, "log"),
        Parameter("b_f", "J", 4.5e-20, 8e-21, 2e-19, "cubic coefficient B, cooling", _SOURCE, "log"),
        Parameter("c_f", "J", 2.6e-20, 4e-21, 2e-19, "quartic coefficient C, cooling", _SOURCE, "log"),
        Parameter("t_star", "K", 307.0, 280.0, 400.0, "supercooling temperature T*", _SOURCE),
        Parameter("cr1_r", "1/K", 29.0, 0.0, 1e4, "nematic → isotropic, first order, heating", _SOURCE, "asinh", _KNEE),
        Parameter(
            "cr2_r", "1/K", 8.6e-5, 0.0, 1e4, "nematic → isotropic, second order, heating", _SOURCE, "asinh", _KNEE
        ),
        Parameter("cf1_r", "1/K", 0.7, 0.0, 1e3, "isotropic → nematic, first order, heating", _SOURCE, "asinh", _KNEE),
        Parameter(
            "cr1_f", "1/K", 1100.0, 0.0, 1e4, "nematic → isotropic, first order, cooling", _SOURCE, "asinh", _KNEE
        ),
        Parameter(
            "cf1_f", "1/K", 5.0e-4, 0.0, 1e3, "isotropic → nematic, first order, cooling", _SOURCE, "asinh", _KNEE
        ),
        Parameter("cf2_f", "1/K", 0.3, 0.0, 1e3, "isotropic → nematic, second order, cooling", _SOURCE, "asinh", _KNEE),
        Parameter(
            "spinodal", "1/K", 0.0, 0.0, 1e4, "rate added where a well is gone, beyond T*, T1", "§5.1", "asinh", _BEYOND
        ),
        Parameter(
            "t_ref",
            "K",
            300.0,
            250.0,
            400.0,
            "temperature at which λ = 1 on the heating branch",
            "§5.4: T from 300 K",
            fixed=True,
        ),
    ),
    arrays=(("x", DOMAINS), ("after", DOMAINS)),
    outputs=("fraction", "well_order", "reference_order"),
    start=start,
    step=step,
)
