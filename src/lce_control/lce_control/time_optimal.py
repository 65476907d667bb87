# SPDX-License-Identifier: Apache-2.0
"""The physical limit of position control: what the laser could do if everything about the strip were known."""

import math
from typing import Final

from lce_control.tuning.closed_loop import PERIOD_S, ClosedLoop, run
from lce_model import Model, Stepper

HALVINGS: Final = 13
"""Of the range of powers: 2 W to a quarter of a milliwatt."""
COASTING_S: Final = 0.1
LONGEST_COASTING: Final = 100
"""Steps of a strip that is followed in the dark, and how many."""


def fastest_power_w(
    strip: Stepper,
    target_m: float,
    period_s: float,
    max_power_w: float,
    hottest_k: float = math.inf,
    rate_m_s: float = 0.0,
) -> float:
    """The most power [W] that can be held for ``period_s`` [s] without an overshoot of the target [m] afterwards.

    The strip goes on contracting when it is dark again, and no controller can do more than switch off: what matters is
    the largest displacement of the time after, in the dark. Far below the target the answer is ``max_power_w``, above
    it zero, between them it is found by halving. The strip is not heated beyond ``hottest_k``. A target that moves at
    ``rate_m_s`` [m/s] is met where it will be.
    """

    def too_much(power_w: float) -> bool:
        then = strip.copy()
        then.step(power_w, period_s)
        return then.temperature_k > hottest_k or _coasts_beyond(then, target_m + rate_m_s * period_s, rate_m_s)

    if not too_much(max_power_w):
        return max_power_w
    lower, upper = 0.0, max_power_w
    for _ in range(HALVINGS):
        middle = 0.5 * (lower + upper)
        lower, upper = (lower, middle) if too_much(middle) else (middle, upper)
    return lower


def _coasts_beyond(strip: Stepper, target_m: float, rate_m_s: float) -> bool:
    """Whether a strip that is left in the dark is, or will be, beyond the target [m]."""
    over_m = strip.displacement_m - target_m
    for _ in range(LONGEST_COASTING):
        if over_m > 0.0:
            return True
        strip.step(0.0, COASTING_S)
        target_m += rate_m_s * COASTING_S
        before_m, over_m = over_m, strip.displacement_m - target_m
        if over_m <= before_m:
            return False
    return False


def bang_bang(
    strip: Model | Stepper, target_m: float, duration_s: float, max_power_w: float = 2.0, hottest_k: float = math.inf
) -> ClosedLoop:
    """The bound that no controller can beat on this strip: full power until the switching time, then what holds it.

    ``strip`` starts from rest, or, a Stepper, from where it is. No sensors: the strip itself is looked at.
    """
    if isinstance(strip, Model):
        strip = Stepper(strip)
        strip.step(0.0, 0.0)
    here = strip
    return run(
        here,
        lambda *_: fastest_power_w(here, target_m, PERIOD_S, max_power_w, hottest_k),
        duration_s,
        max_power_w=max_power_w,
    )
