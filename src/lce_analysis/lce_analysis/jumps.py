# SPDX-License-Identifier: Apache-2.0
"""Jumps of a series, modelled or measured: on which side of one a sample is, is decided within a hundredth of a second.

The samples around it would outweigh all the rest, and say nothing but when exactly the strip jumped.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# Fixed numbers, not options: they decide what a fit counts; the tables of errors count every sample.
DISCONTINUITY: Final = 5.0
"""A step of a series that is this many times larger than all but 1 % of its steps may be a discontinuity."""
ALONE: Final = 3.0
"""It is one if it is this many times larger than the steps beside it: a fast motion takes several steps."""
LEFT_OUT_S: Final = 0.25
"""Samples nearer to a discontinuity than this [s] do not count."""


def discontinuities(time_s: Floats, values: Floats, noise: float) -> Floats:
    """Times [s] at which a series (n,) jumps by more than its sensor's noise."""
    if values.size < 2:
        return np.empty(0)
    moved = np.abs(np.diff(values))
    beside = np.maximum(np.concatenate([[0.0], moved[:-1]]), np.concatenate([moved[1:], [0.0]]))
    large = moved > DISCONTINUITY * np.quantile(moved, 0.99) + noise
    return np.asarray(time_s[1:][large & (moved > ALONE * beside)])


def away_from(jumps_s: Floats, time_s: Floats) -> NDArray[np.bool_]:
    """Which samples (n,) lie away from all jumps."""
    near = np.zeros(time_s.size, dtype=bool)
    for jump in jumps_s:
        near |= np.abs(time_s - jump) < LEFT_OUT_S
    return ~near
