# SPDX-License-Identifier: Apache-2.0
"""The physical limit of position control: what the laser could do if everything about the strip were known."""

import math

from lce_control.time_optimal import fastest_power_w
from lce_control.tuning.closed_loop import PERIOD_S, ClosedLoop, run
from lce_model import Model, Stepper


def bang_bang(
    strip: Model | Stepper, target_m: float, duration_s: float, max_power_w: float = 2.0, hottest_k: float = math.inf
) -> ClosedLoop:
    """Full power until the switching time, then what holds the target: no controller can be faster on this strip.

    No sensors: the state of the strip itself is used.

    Parameters
    ----------
    strip : a Model starts from rest, a Stepper from its present state.
    target_m : displacement that is wanted [m].
    duration_s : how long it is held [s].
    max_power_w : limit of the power [W].
    hottest_k : the strip is not heated beyond this temperature [K].

    Returns
    -------
    ClosedLoop
        The response, at 100 Hz.
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
