# SPDX-License-Identifier: Apache-2.0
"""A parameter that would have to walk: its smoothed path in each run, with its band."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lce_report.blocks import Axis, Block, Curve, Grid, Lines
from lce_report.figures.axes import TIME

if TYPE_CHECKING:
    from lce_analysis.discovery.random_walk import Walk, WalkPath

SCALES: Final = {"1": (100.0, "%"), "m": (1e6, "µm"), "K": (1.0, "K")}
"""From the unit of a walk to that of the picture."""
BAND: Final = 2.0
"""Standard deviations that the band holds on either side."""


def random_walk(walk: Walk) -> list[Block]:
    """What walks, in a sentence, and its path over time in each run."""
    scale, unit = SCALES[walk.parameter.unit]
    top = scale * max(float(np.max(np.abs(path.level) + BAND * path.band)) for path in walk.paths)
    axis = Axis("change", unit)
    return [
        f"{walk.words[0].upper()}{walk.words[1:]}. The band holds {BAND:g} standard deviations; it is wide where the "
        f"{walk.channel.name} says little of the {walk.parameter.words}.",
        Grid([_path(path, axis, scale, top) for path in walk.paths], (1, 1)),
    ]


def _path(path: WalkPath, axis: Axis, scale: float, top: float) -> Lines:
    level, width = scale * path.level, scale * BAND * path.band
    low, high = np.maximum(level - width, -top), np.minimum(level + width, top)
    return Lines(path.run, TIME, axis, path.time_s, [Curve("smoothed", level, "model", low=low, high=high)])
