# SPDX-License-Identifier: Apache-2.0
"""The most power that does not overshoot: the decision of the time-optimal control of a strip whose state is known."""

import math
from typing import Final

from lce_model import Stepper

HALVINGS: Final = 13
"""How often the range of powers is halved: from 2 W down to a quarter of a milliwatt."""
COASTING_S: Final = 0.1
"""Length of the steps in which a strip without light is simulated [s]."""
LONGEST_COASTING: Final = 100
"""Largest number of such steps."""


def fastest_power_w(
    strip: Stepper,
    target_m: float,
    period_s: float,
    max_power_w: float,
    hottest_k: float = math.inf,
    rate_m_s: float = 0.0,
) -> float:
    """The most power that can be held for a while without an overshoot of the target afterwards.

    A strip goes on contracting when the laser is off, and no controller can do more than switch it off. What matters
    is therefore the largest displacement in the dark afterwards. Far below the target the answer is ``max_power_w``,
    above it zero, between them it is found by halving.

    Parameters
    ----------
    strip : the strip in its present state; it is left as it is.
    target_m : displacement that is wanted [m].
    period_s : for how long the power is held [s].
    max_power_w : limit of the power [W].
    hottest_k : the strip is not heated beyond this temperature [K].
    rate_m_s : rate of a target that moves [m/s]; such a target is met where it will be.

    Returns
    -------
    float
        Power [W], from 0 to ``max_power_w``.
    """

    def too_much(power_w: float) -> bool:
        then = strip.copy()
        then.step(power_w, period_s)
        return not then.temperature_k <= hottest_k or _coasts_beyond(then, target_m + rate_m_s * period_s, rate_m_s)

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
        if not over_m <= 0.0:  # NaN, too, calls for no light
            return True
        strip.step(0.0, COASTING_S)
        target_m += rate_m_s * COASTING_S
        before_m, over_m = over_m, strip.displacement_m - target_m
        if over_m <= before_m:
            return False
    return False
