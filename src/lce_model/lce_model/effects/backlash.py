# SPDX-License-Identifier: Apache-2.0
"""Play of half-width b between strip and load: the load does not move until the play is used up.

In the residual: a flat spot at every reversal of d. Like transition_distribution.
"""

from lce_model.effects import Effect
from lce_model.terms import Parameter


def start(displacement: float) -> tuple[float, float]:
    """In the middle of the play."""
    return displacement, displacement


def step(displacement: float, held: float, width: float) -> tuple[float, float]:
    """The play operator [m]."""
    held = min(max(held, displacement - width), displacement + width)
    return held, held


EFFECT = Effect(
    name="backlash",
    title="backlash",
    meaning="play between strip and load: the load moves once the play is used up",
    stage="strain",
    equation="d_b = min(max(d_b, d - b), d + b)",
    parameters=(Parameter("width", "m", 0.0, 0.0, 3e-4, "half-width of the play b", "plausible, no source found"),),
    states=("held",),
    outputs=("displacement",),
    start=start,
    step=step,
    strength="width",
    typical=5e-5,
    place=1,
    step_sizes=(1e-5, 5e-5, 2e-4),
)
