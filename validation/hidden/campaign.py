# SPDX-License-Identifier: Apache-2.0
"""A case of the hidden suite, and the runs that were made on its strip.

Runs of a strip of one family that hides one effect, as the product reads them:

    from campaign import Case, campaign
    train, test = campaign(Case("chapter-5-continuous", ("radiation",), "clear", seed=0))
    model = fit(default_model("lumped", "dynamic"), train).model

(with `validation` and `validation/hidden` on the path). `ALL[case.family].base` names the deformation model.
"""

import math
import zlib
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from effects import STRENGTH
from families import ALL, Strip
from stages import Floats

from lce_data.channels import DISPLACEMENT, TEMPERATURE, Channel
from lce_data.run import Run, Series

CAMPAIGNS = {
    "full": (("pulse-16", "pulse-28", "stairs", "holds", "cycles", "minor"), ("prbs", "pulse-22")),
    "short": (("pulse-16", "stairs", "cycles"), ("prbs",)),
}
"""Runs to train on and runs held out, by their names in :func:`waves`."""


@dataclass(frozen=True)
class Case:
    """One strip: its family, what it hides, how strongly ("weak", "clear"), and the seed of everything random.

    library : "whole", or "without" where the product's library lacks what is hidden.
    campaign : of :data:`CAMPAIGNS`.
    """

    family: str
    hidden: tuple[str, ...]
    level: str
    seed: int
    library: str = "whole"
    campaign: str = "full"

    @property
    def name(self) -> str:
        """Key of the results."""
        words = [self.family, "+".join(self.hidden) or "nothing", self.level, str(self.seed)]
        words += [word for word in (self.library, self.campaign) if word not in ("whole", "full")]
        return "/".join(words)

    @cached_property
    def _key(self) -> tuple[int, ...]:
        return self.seed, *(zlib.crc32(text.encode()) for text in (self.family, "+".join(self.hidden), self.level))

    @cached_property
    def _drawn(self) -> tuple[Strip, dict[str, float]]:
        rng = np.random.default_rng(self._key)
        strip = ALL[self.family].random(rng)
        return strip, {n: STRENGTH[n][self.level == "clear"] * rng.uniform(0.8, 1.25) for n in self.hidden}

    @property
    def strip(self) -> Strip:
        """The specimen, the same each time."""
        return self._drawn[0]

    @property
    def strengths(self) -> dict[str, float]:
        """What is hidden, and how strongly."""
        return self._drawn[1]

    def rng(self, run: str) -> np.random.Generator:
        """Everything random in a run: weather first, then noise."""
        return np.random.default_rng((*self._key, zlib.crc32(run.encode())))

    def record(self, run: str, power_w: Floats) -> Run:
        """A run of the strip under a power (n,) [W] at 100 Hz."""
        camera, distance = self.strip.measure(power_w, self.strengths, self.rng(run))
        time_s = np.arange(power_w.size) / 100.0
        displacement = None if ALL[self.family].heat_only else Series(time_s, distance)
        series = Series(time_s, power_w), Series(time_s[::10], camera), displacement
        return Run.of(run, *series, sha256=f"{self.name}/{run}")

    def ideal(self, run: Run, hidden: bool = True) -> dict[Channel, Floats]:
        """What its sensors would have shown without noise in a run of :meth:`record`; without what is hidden if not."""
        assert run.power is not None
        camera, distance = self.strip.ideal(run.power.value, self.strengths if hidden else {}, self.rng(run.name))
        shown = {TEMPERATURE: camera, DISPLACEMENT: distance}
        return {channel: values for channel, values in shown.items() if channel in run.series}


def campaign(case: Case) -> tuple[list[Run], list[Run]]:
    """The runs of a case, to train on and held out."""
    powers = waves(case.strip.body.top_w)
    train, test = CAMPAIGNS[case.campaign]
    return [case.record(name, powers[name]) for name in train], [case.record(name, powers[name]) for name in test]


def waves(top_w: float) -> dict[str, Floats]:
    """Pulses of (4.20), a staircase, holds, repeated cycles, minor loops, random levels; W at 100 Hz."""

    def pulse(heated: float) -> Floats:
        t = np.arange(0.0, heated, 0.01)
        return np.concatenate([0.3 * top_w * np.sin(math.pi / (2 * heated) * t) + 0.7 * top_w, np.zeros(6000)])

    def levels(values: list[float], seconds: float) -> Floats:
        return np.concatenate([np.full(round(100 * seconds), v * top_w) for v in values])

    bits = np.random.default_rng(7).integers(0, 2, 24)
    triangle = np.concatenate([np.linspace(0.3, 0.9, 1500), np.linspace(0.9, 0.3, 1500)]) * top_w
    inner = np.concatenate([np.linspace(0.45, 0.7, 1000), np.linspace(0.7, 0.45, 1000)]) * top_w
    return {
        "pulse-16": pulse(16.0),
        "pulse-22": pulse(22.0),
        "pulse-28": pulse(28.0),
        "stairs": levels([0.25, 0.5, 0.75, 1.0, 0.75, 0.5, 0.25, 0.0], 14.0),
        "holds": levels([0.8, 0.0, 0.5, 0.0], 25.0),
        "cycles": np.concatenate([np.tile(triangle, 3), np.zeros(3000)]),
        "minor": np.concatenate([np.full(2500, 0.6 * top_w), np.tile(inner, 2), np.zeros(3000)]),
        "prbs": np.concatenate([levels(list(0.35 + 0.6 * bits), 4.0), np.zeros(2000)]),
    }
