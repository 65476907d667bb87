# SPDX-License-Identifier: Apache-2.0
"""Domains that stand for a normal distribution of transition temperatures.

They lie as densely as the cube root of the normal density, where few of them lose least (Panter and Dite 1951), and
each stands for the mean of its part of the distribution.
"""

from statistics import NormalDist
from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

DOMAINS: Final = 16
_NORMAL = NormalDist()
_EDGES = np.array([np.sqrt(3.0) * _NORMAL.inv_cdf(i / DOMAINS) for i in range(1, DOMAINS)])
SHARES: Final[Floats] = np.diff([0.0, *map(_NORMAL.cdf, _EDGES), 1.0])
"""The share of the strip that each domain stands for."""
_MEANS = -np.diff([0.0, *map(_NORMAL.pdf, _EDGES), 0.0]) / SHARES
NODES: Final[Floats] = _MEANS / np.sqrt(SHARES @ _MEANS**2)
"""Where the domains lie, in standard deviations; theirs is exactly 1."""
