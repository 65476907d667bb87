# SPDX-License-Identifier: Apache-2.0
"""Bouc–Wen model: a baseline without physics, one differential equation for the hysteresis.

The hysteretic variable h follows an envelope γ of the temperature (that of the Prandtl–Ishlinskii baseline; without
one the model has no saturation), with exponent n = 1 (Ismail, Ikhouane & Rodellar, Arch. Comput. Methods Eng. 16,
2009, 161):

    dh = dγ - β |dγ| h - shape β dγ |h|,   λ = 1 - reach (γ - share h - rest)

Rate-independent. A few lines of our own, as the libraries found are for structures (OpenSees) or for demonstration.
"""

import math

from numba.extending import register_jitable

from lce_model.deformation.prandtl_ishlinskii import ENVELOPE_PARAMETERS, envelope
from lce_model.terms import Parameter, Term


@register_jitable
def _follow(h: float, change: float, beta: float, shape: float) -> float:
    """h after the envelope has changed; linear on each side of h = 0, hence exact."""
    sign = 1.0 if change > 0.0 else -1.0
    h, length = sign * h, abs(change)
    if h < 0.0:
        rate = beta * (1.0 - shape)
        crossing = math.log1p(-rate * h) / rate if rate > 1e-12 else -h
        if length <= crossing:
            ahead = -math.expm1(-rate * length) / rate if rate > 1e-12 else length
            return sign * (h * math.exp(-rate * length) + ahead)
        h, length = 0.0, length - crossing
    rate = beta * (1.0 + shape)
    ahead = -math.expm1(-rate * length) / rate if rate > 1e-12 else length
    return sign * (h * math.exp(-rate * length) + ahead)


def start(
    order_temperature: float,
    reach: float,
    t_mid: float,
    width: float,
    slope: float,
    t_ref: float,
    beta: float,
    shape: float,
    share: float,
) -> tuple[float, float, float, float]:
    """Cooled from above: h has gone to its limit."""
    pushed = envelope(order_temperature, t_mid, width, slope)
    h = _follow(0.0, -10.0, beta, shape)
    rest = envelope(t_ref, t_mid, width, slope) - share * h
    return pushed, h, rest, 1.0 - reach * (pushed - share * h - rest)


def step(
    order_temperature: float,
    before: float,
    h: float,
    rest: float,
    reach: float,
    t_mid: float,
    width: float,
    slope: float,
    beta: float,
    shape: float,
    share: float,
) -> tuple[float, float, float, float]:
    """γ, h and λ."""
    pushed = envelope(order_temperature, t_mid, width, slope)
    if pushed != before:
        h = _follow(h, pushed - before, beta, shape)
    return pushed, h, rest, 1.0 - reach * (pushed - share * h - rest)


_SURVEY = "Ismail et al. 2009; value plausible"

BOUC_WEN = Term(
    name="bouc_wen",
    stage="strain",
    equation="dh = dgamma - beta |dgamma| h - shape beta dgamma |h|, lambda = 1 - reach (gamma - share h - rest)",
    parameters=(
        *ENVELOPE_PARAMETERS,
        Parameter("beta", "1", 5.0, 0.1, 500.0, "how fast h saturates β", _SURVEY, "log"),
        Parameter("shape", "1", 0.0, -0.99, 0.99, "difference of loading and unloading γ/β", _SURVEY),
        Parameter("share", "1", 0.8, 0.0, 1.0, "share of h", _SURVEY),
    ),
    states=("before", "h", "rest"),
    outputs=("stretch",),
    start=start,
    step=step,
)
