# SPDX-License-Identifier: Apache-2.0
"""The cases of the hidden suite, in an order of which every first part is a fair sample."""

from collections.abc import Sequence

import numpy as np
from campaign import Case
from effects import OUTSIDE
from families import ALL, FAMILIES, Family

PAIRS = (
    ("creep", "ambient_drift"),
    ("laser_droop", "displacement_drift"),
    ("natural_convection", "phase_kinetics"),
    ("camera_lag", "elastic_softening"),
    ("radiation", "residual_strain"),
    ("laser_saturation", "thermal_expansion"),
)
NOTHING = 20
"""Cases with nothing hidden, for each seed."""
KINDS = ("nothing", "one", "two", "outside", "left out")


def kind(hidden: Sequence[str], library: str) -> str:
    """One of :data:`KINDS`."""
    if not hidden:
        return "nothing"
    if library == "without":
        return "left out"
    if any(name in OUTSIDE for name in hidden):
        return "outside"
    return "one" if len(hidden) == 1 else "two"


def cases(seeds: int, families: Sequence[str] = (), campaign: str = "full", first: int = 0) -> list[Case]:
    """All cases of some families, of the seeds from ``first`` on; of all with both sensors if none is named."""
    placed = []
    for family in (ALL[name] for name in families or FAMILIES):
        for kind_, members in _kinds(family, range(first, first + seeds), campaign).items():
            order = np.random.default_rng([first, KINDS.index(kind_), *family.name.encode()]).permutation(len(members))
            placed += [((place + 0.5) / len(members), members[i]) for place, i in enumerate(order)]
    return [case for _, case in sorted(placed, key=lambda p: (p[0], p[1].name))]


def _kinds(family: Family, seeds: Sequence[int], campaign: str) -> dict[str, list[Case]]:
    """Cases by kind. A slow family with effects of its own has few, and none with its library reduced."""
    few = bool(family.own) and not family.heat_only
    levels = ("clear",) if few else ("clear", "weak")
    known = [name for name in family.may_hide if name not in OUTSIDE]
    outside = [name for name in family.may_hide if name in OUTSIDE]
    pairs = [pair for pair in PAIRS if set(pair) <= set(known)]
    found: dict[str, list[Case]] = {name: [] for name in KINDS}

    def add(hidden: tuple[str, ...], level: str, seed: int, library: str = "whole") -> None:
        found[kind(hidden, library)].append(Case(family.name, hidden, level, seed, library, campaign))

    for seed in seeds:
        for k in range(4 if few else NOTHING):
            add((), "clear", NOTHING * seed + k)
        for level in levels:
            for name in (*known, *outside):
                add((name,), level, seed)
        for pair in pairs:
            add(pair, "clear", seed)
        for name in () if few else known:
            add((name,), "clear", seed, "without")
    return found
