# SPDX-License-Identifier: Apache-2.0
"""From the mean order parameter to the displacement of the free end: (4.15), (4.16), (3.1), (6.8)."""

from dataclasses import replace

from lce_model.terms import Parameter, Term


def stretch(order: float, reference_order: float, alpha: float) -> float:
    """λ = ((1 + α Q̄)/(1 + α Q̄0))^(1/3) (4.16)."""
    return float(((1.0 + alpha * order) / (1.0 + alpha * reference_order)) ** (1.0 / 3.0))


def network_stretch(order: float, reference_order: float, alpha: float) -> float:
    """λ = (r(Q̄)/r(Q̄0))^(1/3), r = (1 + 2qQ)/(1 - qQ), q = α/(3 + α).

    r is the ratio of the step lengths along and across the director in a network of freely jointed chains whose order
    is q at Q = 1 (Warner & Terentjev, Liquid Crystal Elastomers, 2003, ch. 3). (4.16) is its first order in q. α keeps
    its meaning: r = 1 + α at Q = 1. No chain is ordered more than fully: qQ is cut at 0.99.
    """
    q = alpha / (3.0 + alpha)
    now, then = min(q * order, 0.99), min(q * reference_order, 0.99)
    return float(((1.0 + 2.0 * now) * (1.0 - then) / ((1.0 - now) * (1.0 + 2.0 * then))) ** (1.0 / 3.0))


def displacement(stretch: float, length: float, zero: float) -> float:
    """d = L0 (1 - λ) (6.8), with the zero of the distance sensor."""
    return length * (1.0 - stretch) + zero


STRETCH = Term(
    name="stretch_law",
    stage="strain",
    equation="lambda = ((1 + alpha Q)/(1 + alpha Q0))^(1/3)",
    parameters=(
        Parameter(
            "alpha",
            "1",
            1.91,
            1e-3,
            50.0,
            "deformation coefficient α",
            "(4.21), Amp 0.2, T_h 30 s",
            scale="log",
            usual=(0.05, 50.0),
        ),
    ),
    outputs=("stretch",),
    step=stretch,
)

NETWORK = replace(
    STRETCH,
    equation="lambda = (r(Q)/r(Q0))^(1/3), r = (1 + 2 q Q)/(1 - q Q), q = alpha/(3 + alpha)",
    step=network_stretch,
)

STRIP = Term(
    name="strip",
    stage="strain",
    equation="d = L0 (1 - lambda) + d0",
    parameters=(
        Parameter("length", "m", 0.010, 1e-4, 10.0, "length at rest L0", "1.0 cm, §3.2", fixed=True),
        Parameter(
            "zero", "m", 0.0, -0.1, 0.1, "zero d0 of the displacement", "sensor set to 0 at rest", "asinh", 1e-5, True
        ),
    ),
    outputs=("displacement",),
    step=displacement,
)
