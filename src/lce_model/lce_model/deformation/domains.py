# SPDX-License-Identifier: Apache-2.0
"""Domains that stand for a normal distribution of transition temperatures."""

from statistics import NormalDist
from typing import Final

import numpy as np
from numpy.typing import NDArray

DOMAINS: Final = 16
_QUANTILES = np.array([NormalDist().inv_cdf((i + 0.5) / DOMAINS) for i in range(DOMAINS)])
NODES: Final[NDArray[np.float64]] = _QUANTILES / np.std(_QUANTILES)
"""Where the domains lie, each for an equal share of the strip, in standard deviations; theirs is exactly 1."""
