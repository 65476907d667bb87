# SPDX-License-Identifier: Apache-2.0
"""Hammerstein–Wiener model of the P→T stage, (6.3)–(6.6): a linear block between two static curves.

    u = φ(P),   w = G(z⁻¹) u,   T = T_env + ψ(w)

φ and ψ run straight between 25 break points each, evenly spaced as in Table 6.1, from (0, 0) on: no light, no rise.
Their parameters are the slopes of the 24 pieces. All are positive, as more light makes no strip colder; the last goes
on beyond the last break point, and the first slope of φ is held, because ψ has a scale already.

With m = 2, n = 3, n_k = 1 the linear block is

    G = B/F z⁻¹,   B = b1 z⁻¹ (1 - e^(-T_s/τ_z) z⁻¹),   F = Π (1 - e^(-T_s/τ_i) z⁻¹), i = 1, 2, 3

and its static gain is 1. Heat conduction has real poles, so time constants say all that (6.6) can say of it, and no
value of theirs is unstable, as the printed (6.7) is.

**Sampling.** G advances once in T_s, whatever the steps of the simulation are: its input is the mean of φ(P) over the
sample that ended, so a power that changes within it counts for its share. Between samples w runs straight from one to
the next, which is known in time: n_k = 1 and the z⁻¹ of (6.6) put each input two samples before its output. The state
at the samples does not depend on the steps; a camera of 10 Hz reads it off where it looks.

A black box: effects of the light and of the surroundings act on it, those of the heat balance find nothing to act on.
"""

import math

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from lce_model.terms import Parameter, Term

Floats = NDArray[np.float64]

PIECES = 24
"""Straight pieces of a curve, between 25 break points."""


@register_jitable
def curve(value: float, top: float, slopes: Floats) -> float:
    """(6.3), (6.4): from (0, 0) on, straight between break points at 1/24, 2/24 … of ``top``."""
    wide = top / PIECES
    height = 0.0
    i = 0
    while i < PIECES - 1 and value > wide:
        height += wide * slopes[i]
        value -= wide
        i += 1
    return float(height + value * slopes[i])


@register_jitable
def inverse(height: float, top: float, slopes: Floats) -> float:
    """Where the curve has this height."""
    wide = top / PIECES
    value = 0.0
    i = 0
    while i < PIECES - 1 and height > wide * slopes[i]:
        height -= wide * slopes[i]
        value += wide
        i += 1
    return float(value + height / slopes[i])


def start(temperature: float, ambient: float, tau_1: float, w_max: float, psi: Floats) -> tuple[float, ...]:
    """At rest at the temperature given."""
    w = inverse(temperature - ambient, w_max, psi)
    return 0.0, 0.0, w, w, w, w, w, temperature, 1.0 / tau_1


def step(
    light: float,
    ambient: float,
    dt: float,
    clock: float,
    charge: float,
    y_1: float,
    y_2: float,
    y_3: float,
    present: float,
    coming: float,
    tau_1: float,
    tau_2: float,
    tau_3: float,
    tau_z: float,
    p_max: float,
    w_max: float,
    sample_time: float,
    phi: Floats,
    psi: Floats,
) -> tuple[float, ...]:
    """G as three sections of first order, the zero behind the last; they advance at the samples within the step."""
    u = curve(light, p_max, phi)
    # Steps are differences of times: a sample is over when it is over but for rounding.
    while clock + dt >= sample_time * (1.0 - 1e-6):
        part = sample_time - clock
        mean = (charge + u * part) / sample_time
        zero = math.exp(-sample_time / tau_z)
        before = y_3
        y_1 -= math.expm1(-sample_time / tau_1) * (mean - y_1)
        y_2 -= math.expm1(-sample_time / tau_2) * (y_1 - y_2)
        y_3 -= math.expm1(-sample_time / tau_3) * (y_2 - y_3)
        present, coming = coming, (y_3 - zero * before) / (1.0 - zero)
        dt = max(dt - part, 0.0)
        clock = charge = 0.0
    clock += dt
    charge += u * dt
    w = present + (coming - present) * clock / sample_time
    return clock, charge, y_1, y_2, y_3, present, coming, ambient + curve(w, w_max, psi), 1.0 / tau_1


def _time_constant(name: str, value: float, description: str) -> Parameter:
    return Parameter(
        name, "s", value, 0.005, 1e6, description, "of (6.6); values plausible", "log", usual=(0.005, 2000.0)
    )


def _slopes(name: str, unit: str, value: float, lower: float, upper: float, source: str) -> list[Parameter]:
    return [
        Parameter(
            f"{name}_{i}", unit, value, lower, upper, f"slope of piece {i} of {PIECES}", source, "log", fixed=held
        )
        for i, held in ((i, name == "phi" and i == 1) for i in range(1, PIECES + 1))
    ]


HAMMERSTEIN_WIENER = Term(
    name="hammerstein_wiener",
    stage="heat",
    equation="T = T_env + psi(G(z^-1) phi(P)), m = 2, n = 3, n_k = 1",
    parameters=(
        _time_constant("tau_1", 18.0, "slowest pole of G"),
        _time_constant("tau_2", 0.9, "second pole of G"),
        _time_constant("tau_3", 0.2, "third pole of G"),
        _time_constant("tau_z", 0.7, "zero of G"),
        Parameter("p_max", "W", 2.0, 1e-6, 1e6, "power at the last break point of φ", "laser", fixed=True),
        Parameter("w_max", "W", 2.0, 1e-6, 1e6, "w at the last break point of ψ", "as p_max", fixed=True),
        Parameter("sample_time", "s", 0.01, 0.001, 100.0, "T_s, period of the linear block", "§6.5.1", fixed=True),
        *_slopes("phi", "1", 1.0, 0.05, 20.0, "input curve φ (6.3)"),
        *_slopes("psi", "K/W", 30.0, 1e-4, 1e6, "output curve ψ (6.4)"),
    ),
    vectors=(("phi", PIECES), ("psi", PIECES)),
    outputs=("temperature", "loss_rate"),
    states=("clock", "charge", "y_1", "y_2", "y_3", "present", "coming"),
    start=start,
    step=step,
)
