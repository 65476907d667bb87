# SPDX-License-Identifier: Apache-2.0
"""Truth "independent": the distributed strip of `validation/independent_strip`, as it is.

What may be hidden is what happens outside of it: to the light, to the displacement behind it, and in the sensors (but
for an error of the emissivity, which the gain of the base takes). Its own physics has effects that a lumped base lacks
(:data:`OWN`). To name one of them is no false addition, and "nothing hidden" is not nothing here: neither the gates of
that kind nor the false additions a case count this family.
"""

from typing import NamedTuple

import numpy as np
from independent_strip import Strip, absorbed_share, simulate
from stages import SAMPLE_S, Body, Floats, history

OWN = (
    "radiation", "natural_convection", "latent_heat", "thermal_gradient", "clamp_conduction", "phase_kinetics",
)  # fmt: skip
REACH_K = 78.0


class Distributed(NamedTuple):
    """The strip, and what the stages outside of it ask for."""

    body: Body
    strip: Strip

    @classmethod
    def random(cls, rng: np.random.Generator) -> "Distributed":
        """A strip from wide ranges around the two specimens."""
        strip = Strip.random(int(rng.integers(1_000_000)))
        loss_w_per_k = 18.0 * 2.0 * strip.length_m * strip.width_m
        top_k = strip.haller_temperature_k - strip.ambient_k
        body = Body(
            gain=absorbed_share(strip) / loss_w_per_k,
            tau=float("nan"),
            ambient=strip.ambient_k,
            alpha=float("nan"),
            length=strip.length_m,
            slow_s=float(np.exp(rng.uniform(np.log(10.0), np.log(40.0)))),
            reach_k=min(max(1.3 * top_k, 60.0), 110.0),
        )
        return cls(body, strip)

    def respond(self, light_w: Floats, hidden: dict[str, float]) -> tuple[Floats, Floats]:
        """Temperature of the lit face [K] and displacement [m] at each power sample."""
        response = simulate(self.strip, np.arange(light_w.size) * SAMPLE_S, light_w)
        return response.surface_temperature_k, history(response.displacement_m, hidden, self.body.slow_s)
