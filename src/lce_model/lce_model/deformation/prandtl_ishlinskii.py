# SPDX-License-Identifier: Apache-2.0
"""Generalised Prandtl–Ishlinskii model: a baseline without physics.

A weighted sum of play operators on an envelope γ of the temperature (Al Janaideh, Rakheja & Su, IEEE/ASME Trans.
Mechatronics 16, 2011, 734):

    λ = 1 - reach Σ_j p_j z_j,   z_j = max(γ(T) - r_j, min(γ(T) + r_j, z_j before)),   j = 0 … PLAYS
    γ(T) = (1 + tanh((T - t_mid)/width))/2 + slope (T - t_mid),   r_j = j r/PLAYS,   p_j ∝ e^(-decay j/PLAYS)

with Σ p_j = 1, and λ = 1 at rest at ``t_ref``, cooled from above. Rate-independent; minor loops close.
"""

import math

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from lce_model.terms import Parameter, Term

Floats = NDArray[np.float64]

PLAYS = 8
"""Thresholds above zero; the first operator, of threshold zero, is the envelope itself."""


@register_jitable
def envelope(temperature: float, t_mid: float, width: float, slope: float) -> float:
    """γ(T) that PI and Bouc–Wen share: a step of height 1, and a slope."""
    return 0.5 + 0.5 * math.tanh((temperature - t_mid) / width) + slope * (temperature - t_mid)


@register_jitable
def _cooled(temperature: float, threshold: float, weight: Floats, t_mid: float, width: float, slope: float) -> float:
    """Σ p_j z_j of a strip that has come down to the temperature from far above."""
    total = envelope(temperature, t_mid, width, slope)
    for j in range(weight.size):
        total += weight[j] * threshold * j / PLAYS
    return total


def start(
    order_temperature: float,
    z: Floats,
    weight: Floats,
    reach: float,
    t_mid: float,
    width: float,
    slope: float,
    threshold: float,
    decay: float,
    t_ref: float,
) -> tuple[float, float]:
    """Cooled from above."""
    total = 0.0
    for j in range(weight.size):
        weight[j] = math.exp(-decay * j / PLAYS)
        total += weight[j]
    for j in range(weight.size):
        weight[j] /= total
        z[j] = envelope(order_temperature, t_mid, width, slope) + threshold * j / PLAYS
    rest = _cooled(t_ref, threshold, weight, t_mid, width, slope)
    return rest, 1.0 - reach * (_cooled(order_temperature, threshold, weight, t_mid, width, slope) - rest)


def step(
    order_temperature: float,
    z: Floats,
    weight: Floats,
    rest: float,
    reach: float,
    t_mid: float,
    width: float,
    slope: float,
    threshold: float,
) -> tuple[float, float]:
    """The plays moved, and λ."""
    pushed = envelope(order_temperature, t_mid, width, slope)
    total = 0.0
    for j in range(weight.size):
        r = threshold * j / PLAYS
        z[j] = max(pushed - r, min(pushed + r, z[j]))
        total += weight[j] * z[j]
    return rest, 1.0 - reach * (total - rest)


_PAPER = "Al Janaideh et al. 2011; value plausible"
_REACH = "contraction at the height 1 of the envelope"
ENVELOPE_PARAMETERS = (
    Parameter("reach", "1", 0.4, 1e-4, 5.0, _REACH, _PAPER, "log", usual=(0.01, 5.0)),
    Parameter("t_mid", "K", 327.0, 250.0, 450.0, "middle of the envelope", _PAPER),
    Parameter("width", "K", 12.0, 0.05, 500.0, "width of the envelope", _PAPER, "log", usual=(0.5, 100.0)),
    Parameter("slope", "1/K", 1e-3, 0.0, 0.02, "slope of the envelope far from its middle", _PAPER),
    Parameter("t_ref", "K", 301.15, 250.0, 400.0, "temperature at which λ = 1 at rest", _PAPER),
)

PRANDTL_ISHLINSKII = Term(
    name="prandtl_ishlinskii",
    stage="strain",
    equation="lambda = 1 - reach (sum_j p_j play_{r_j}[gamma(T)] - rest)",
    parameters=(
        *ENVELOPE_PARAMETERS,
        Parameter("threshold", "1", 0.4, 0.001, 10.0, "largest threshold r", _PAPER, "log", usual=(0.001, 1.0)),
        Parameter("decay", "1", 0.0, -10.0, 10.0, "how the weights fall with the threshold", _PAPER),
    ),
    states=("rest",),
    arrays=(("z", PLAYS + 1), ("weight", PLAYS + 1)),
    outputs=("stretch",),
    start=start,
    step=step,
)
