# SPDX-License-Identifier: Apache-2.0
"""The truth families: strips that hide something, behind one shape.

    rng = np.random.default_rng(0)
    strip = FAMILIES["relays"].random(rng)
    camera_k, distance_m = strip.measure(power_w, {"creep": 0.1}, rng)      # power (n,) at 100 Hz, held

Nothing here imports the product.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from chapter5 import Dynamic
from effects import HEAT, HISTORY, LIGHT, SENSORS, STRENGTH
from equilibrium import Equilibrium
from independent import OWN, Distributed
from noise import AUTOREGRESSIVE, MIXED, Noise
from relays import Relays
from stages import Body, Floats, camera, displaced, distance, light, wind


class Core(Protocol):
    """A family's own physics: how temperature and stretch follow from light."""

    @property
    def body(self) -> Body:
        """What all strips have."""
        ...

    def run(self, light_w: Floats, gusts: Floats, hidden: dict[str, float]) -> tuple[Floats, Floats]:
        """Temperature [K] and stretch at each power sample."""
        ...


@dataclass(frozen=True)
class Strip:
    """One specimen and its two sensors."""

    core: Core | Distributed
    noise: tuple[Noise, Noise]

    @property
    def body(self) -> Body:
        """What all strips have; ``body.top_w`` is full power."""
        return self.core.body

    def ideal(self, power_w: Floats, hidden: Mapping[str, float], rng: np.random.Generator) -> tuple[Floats, Floats]:
        """What sensors without noise show: camera [K] at 10 Hz, distance [m] at 100 Hz.

        Parameters
        ----------
        power_w : (n,) [W] at 100 Hz, held to the next sample.
        hidden : name to strength, as in ``effects.STRENGTH``.
        rng : of draughts, gusts, hops and the like; the same draws whatever is hidden.
        """
        given, strengths = np.ascontiguousarray(power_w, dtype=np.float64), dict(hidden)
        reaching = light(given, strengths, self.body.slow_s, rng)
        gusts = wind(given.size, strengths, rng)
        if isinstance(self.core, Distributed):
            temperature, displacement = self.core.respond(reaching, strengths)
        else:
            temperature, stretch = self.core.run(reaching, gusts, strengths)
            displacement = displaced(stretch, temperature, self.body, strengths)
        return camera(temperature, self.body, strengths)[::10], distance(displacement, strengths, rng)

    def measure(self, power_w: Floats, hidden: Mapping[str, float], rng: np.random.Generator) -> tuple[Floats, Floats]:
        """What the sensors show, with noise; as :meth:`ideal`."""
        shown = self.ideal(power_w, hidden, rng)
        first, second = (noise.spoil(values, rng) for noise, values in zip(self.noise, shown, strict=True))
        return first, second


@dataclass(frozen=True)
class Family:
    """A kind of strip, and the base model that is fitted to it.

    name : in cases and reports.
    core : draws a specimen.
    noise : of camera and distance.
    base : deformation model that is fitted beside the thermal model "lumped"; "none" where only the camera looks on.
    exact : does the base hold the very equations of the truth?
    may_hide : names of ``effects.STRENGTH`` that can be hidden in it.
    own : effects that the truth has anyway and the base lacks.
    """

    name: str
    core: Callable[[np.random.Generator], Core | Distributed]
    noise: tuple[Noise, Noise]
    base: str
    exact: bool
    may_hide: tuple[str, ...] = tuple(STRENGTH)
    own: tuple[str, ...] = ()

    def random(self, rng: np.random.Generator) -> Strip:
        """A specimen."""
        return Strip(self.core(rng), self.noise)

    @property
    def heat_only(self) -> bool:
        """Is the displacement not measured?"""
        return self.base == "none"

    def heat(self) -> "Family":
        """The same strips with the camera alone; `lumped` holds the equations of all heat but that of the slab."""
        shown = (*LIGHT, *HEAT, "camera_lag", "temperature_clip", "emissivity_error")
        hidden = tuple(name for name in self.may_hide if name in shown)
        return replace(self, name=f"{self.name}-heat", base="none", exact=not self.own, may_hide=hidden)


SPREAD_ANYWAY = tuple(name for name in STRENGTH if name != "transition_distribution")
"""What hides in a strip whose transition is spread anyway."""

FAMILIES = {
    family.name: family
    for family in (
        Family("equilibrium", Equilibrium.random, MIXED, "equilibrium", exact=True),
        Family("equilibrium-by-dynamic", Equilibrium.random, MIXED, "dynamic", exact=False),
        Family(
            "chapter-5-continuous",
            lambda rng: Dynamic.random(rng, literal=False),
            AUTOREGRESSIVE,
            "dynamic",
            exact=True,
        ),
        Family(
            "chapter-5-literal",
            lambda rng: Dynamic.random(rng, literal=True),
            AUTOREGRESSIVE,
            "dynamic",
            exact=True,
        ),
        Family(
            "relays",
            Relays.random,
            MIXED,
            "kinetic",
            exact=False,
            may_hide=SPREAD_ANYWAY,
        ),
        Family(
            "skewed-relays",
            Relays.random_skewed,
            MIXED,
            "kinetic",
            exact=False,
            may_hide=SPREAD_ANYWAY,
        ),
        Family(
            "independent",
            Distributed.random,
            MIXED,
            "kinetic",
            exact=False,
            may_hide=tuple(n for n in STRENGTH if n in (*LIGHT, *HISTORY, *SENSORS) and n != "emissivity_error"),
            own=OWN,
        ),
    )
}
"""By name: those of `make hidden`, with both sensors."""

HEAT_FAMILIES = {
    family.name: family
    for family in (FAMILIES[name].heat() for name in ("equilibrium", "chapter-5-continuous", "relays", "independent"))
}
"""By name: those of `make hidden-heat`. A case takes seconds, where one with both sensors takes minutes."""

ALL = FAMILIES | HEAT_FAMILIES
"""By name."""
