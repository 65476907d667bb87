# SPDX-License-Identifier: Apache-2.0
"""A load stretches the strip elastically: d → d - k (F - F_ref).

k = L0/(E A), with the modulus E and the cross-section A. A negative compliance says that the load was recorded with the
other sign. Where the load is not known, it is F_ref.

In the residual: d goes with the load at every T. load_shift shows at the transition alone.
"""

import math

from lce_model.effects import Effect
from lce_model.terms import Parameter


def step(displacement: float, load: float, compliance: float, f_ref: float) -> float:
    """Displacement [m] with the elastic stretch."""
    return displacement if math.isnan(load) else displacement - compliance * (load - f_ref)


EFFECT = Effect(
    name="load_stretch",
    title="elastic stretch by the load",
    meaning="a load stretches the strip elastically",
    stage="strain",
    equation="d -> d - k (F - F_ref)",
    parameters=(
        Parameter(
            "compliance",
            "m/N",
            0.0,
            -0.2,
            0.2,
            "elastic stretch per load k",
            "L0/(E A): strip at 1 MPa 7 mm/N, 0.1 m of NiTi wire of 0.25 mm 0.04 mm/N, computed",
            scale="asinh",
            knee=1e-5,
        ),
        Parameter("f_ref", "N", 0.0, -100.0, 100.0, "load F_ref at which L0 was measured", "no load", fixed=True),
    ),
    outputs=("displacement",),
    step=step,
    strength="compliance",
    typical=5e-3,
    place=-1,
)
