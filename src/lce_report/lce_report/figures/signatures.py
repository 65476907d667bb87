# SPDX-License-Identifier: Apache-2.0
"""A small picture of each signature of a residual, with its words and what to try next."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_analysis.signatures import Picture, Signature
from lce_data.channels import DISPLACEMENT, TEMPERATURE, Channel
from lce_report.blocks import Axis, Block, Curve, Form, Grid, Lines, Role
from lce_report.figures.axes import residual_axis, value_axis

Floats = NDArray[np.float64]

ROLES: Final[dict[str, Role]] = {"measured": "measured", "model": "model", "residual": "residual", "noise": "residual"}
"""Roles of curves and points by their labels; all others are what the signature found."""
END: Final = "end"
"""Label of the value at which a sensor is clipped; the readings stay visible through it."""
FOUND: Final[Role] = "after"
ROW: Final = 2
"""Pictures in a row."""


def signature_blocks(signatures: Sequence[Signature], advice: bool = True) -> list[Block]:
    """A sentence for each signature, with what to try if there is ``advice``, then their pictures."""
    if not signatures:
        return ["The residual has no signature of the catalogue: nothing is clipped, swings, jumps or lies far out."]
    sentences: list[Block] = [
        f"{one.words[0].upper()}{one.words[1:]}.{f' To try: {one.advice}.' if advice else ''}" for one in signatures
    ]
    figures = [signature_figure(one) for one in signatures]
    rows = [figures[i : i + ROW] for i in range(0, len(figures), ROW)]
    return [*sentences, *(Grid(row, (1,) * len(row)) for row in rows)]


def signature_figure(signature: Signature) -> Lines:
    """The picture of one signature."""
    picture, channel = signature.picture, signature.channel
    x, x_axis = _along(picture, channel)
    forms: tuple[tuple[Form, dict[str, Floats]], ...] = (("line", picture.curves), ("points", picture.points))
    drawn = [
        Curve(label, _in_unit(picture, channel, y), ROLES.get(label, FOUND), "dashed" if label == END else form)
        for form, curves in forms
        for label, y in curves.items()
    ]
    return Lines(picture.title, x_axis, _y_axis(picture, channel), x, drawn)


def _along(picture: Picture, channel: Channel) -> tuple[Floats, Axis]:
    """Values and axis along x: a reading or a temperature in its unit of display, all else as it is."""
    shown = TEMPERATURE if picture.x_name == TEMPERATURE.name else DISPLACEMENT
    if picture.x_name in (TEMPERATURE.name, DISPLACEMENT.name):
        return np.asarray(shown.display.from_si(picture.x)), value_axis(shown)
    return picture.x, Axis(picture.x_name, picture.x_unit, whole=picture.x_name == "run")


def _y_axis(picture: Picture, channel: Channel) -> Axis:
    return {
        "residual": residual_axis(channel),
        "readings": value_axis(channel),
        "spectrum": Axis("power over background", "1"),
        "noise": Axis("noise", channel.difference.symbol),
        "displacement": residual_axis(DISPLACEMENT),
    }[picture.shown]


def _in_unit(picture: Picture, channel: Channel, values: Floats) -> Floats:
    """Values [SI] in the unit of the y axis."""
    if picture.shown == "spectrum":
        return values
    if picture.shown == "readings":
        return np.asarray(channel.display.from_si(values))
    return values * (DISPLACEMENT if picture.shown == "displacement" else channel).difference.factor
