# SPDX-License-Identifier: Apache-2.0
"""Whether a strip can reach a target."""

from __future__ import annotations

import numpy as np

from lce_data.errors import LceError
from lce_model import Model, simulate
from lce_model.inverse import HOTTEST_K, InverseChart, OutOfReach

_STEADY_S = 600.0
"""Time after which a strip under constant power is as hot as it gets [s]."""


def check_reach(strip: Model, target_m: float, max_power_w: float) -> None:
    """Raise OutOfReach for a target [m] that no branch of the strip has, or for which the laser is too weak."""
    if strip.deformation == "none":
        raise LceError("a strip without a deformation stage has no displacement to control")
    time_s = np.arange(0.0, _STEADY_S, 0.1)
    hottest_k = float(simulate(strip, time_s, np.full_like(time_s, max_power_w)).temperature_k.max())
    lower_m, upper_m = InverseChart(strip, hottest_k=min(hottest_k, HOTTEST_K)).reach_m("middle")
    if not max(lower_m, 0.0) < target_m <= upper_m:
        raise OutOfReach(target_m, max(lower_m, 0.0), upper_m)
