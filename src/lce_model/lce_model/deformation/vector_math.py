# SPDX-License-Identifier: Apache-2.0
"""Elementary functions that the compiler can take several at once: no calls, no branches."""

from typing import Final

import numpy as np
from numba.extending import register_jitable

SUMS: Final = {"reassoc", "nsz"}
"""For numba's ``fastmath``: sums in any order, so that they are taken several at once."""
_ONE, _ROUNDS = 0x3FF0000000000000, 1.5 * 2.0**52
"""The bits of 1.0; a number that rounds what is added to it to a whole number, which its last bits then hold."""
_PER_LN_2 = 1.0 / np.log(2.0)
_LN_2, _LN_2_REST = float.fromhex("0x1.62e42fefa0000p-1"), float.fromhex("0x1.cf79abc9e3b3ap-40")
"""The first 36 bits of ln 2, whose products with a whole number are exact, and the rest."""


@register_jitable
def exponential(a: float) -> float:
    """e^a to 1e-15 for a ≤ 700, and next to 0 below -700."""
    a = max(a, -700.0)
    rounded = a * _PER_LN_2 + _ROUNDS
    k = rounded - _ROUNDS
    r = (a - k * _LN_2) - k * _LN_2_REST
    p: float = 1.0 / 5040.0 + r * (
        1.0 / 40320.0 + r * (1.0 / 362880.0 + r * (1.0 / 3628800.0 + r * (1.0 / 39916800.0)))
    )
    p = 1.0 / 24.0 + r * (1.0 / 120.0 + r * (1.0 / 720.0 + r * p))
    p = 1.0 + r * (1.0 + r * (0.5 + r * (1.0 / 6.0 + r * p)))
    power: float = np.int64((np.float64(rounded).view(np.int64) << 52) + _ONE).view(np.float64)
    return p * power
