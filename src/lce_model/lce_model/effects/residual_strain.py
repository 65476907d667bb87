# SPDX-License-Identifier: Apache-2.0
"""The strip keeps a little of every movement: residual contraction or elongation that grows with the path.

dS = |dd| (1 - S/S_max), so S = S_max (1 - exp(-∫|dd|/S_max)), and d → d + r S. It saturates after a path of S_max, with
r S_max. A polymer is trained to contract more (r > 0); shape-memory wires grow longer (r < 0).

In the residual: an offset of d that grows with the number of cycles. displacement_drift grows with time.
"""

import math

from lce_model.effects import Effect
from lce_model.terms import Parameter


def start(displacement: float) -> tuple[float, float, float]:
    """Untrained."""
    return displacement, 0.0, displacement


def step(displacement: float, last: float, path: float, share: float, saturation: float) -> tuple[float, float, float]:
    """Displacement before, path ∫|dd| [m], and displacement with the residue [m]."""
    path = path + abs(displacement - last)
    return displacement, path, displacement - share * saturation * math.expm1(-path / saturation)


EFFECT = Effect(
    name="residual_strain",
    title="residual strain",
    meaning="every movement leaves a little contraction or elongation that stays",
    stage="strain",
    equation="d -> d + r S, dS = |dd| (1 - S/S_max)",
    parameters=(
        Parameter(
            "share",
            "1",
            0.0,
            -0.2,
            0.2,
            "residual contraction per path r",
            "training (arXiv 2605.11455), SMA drift",
            scale="asinh",
            knee=0.005,
        ),
        Parameter(
            "saturation",
            "m",
            0.05,
            1e-4,
            1e3,
            "path after which it saturates S_max",
            "a few to a hundred cycles of 0.1–10 mm",
            scale="log",
            usual=(1e-3, 10.0),
        ),
    ),
    states=("last", "path"),
    outputs=("displacement",),
    start=start,
    step=step,
    strength="share",
    typical=0.005,
    grid=(("saturation", (0.005, 0.05, 0.5)),),
)
