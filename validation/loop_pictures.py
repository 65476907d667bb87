# SPDX-License-Identifier: Apache-2.0
"""Small pictures of curves, side by side, as an SVG for the documents."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

COLUMNS = 3


@dataclass(frozen=True)
class Picture:
    """A curve (n,) and its reference (n,) over the same x (n,)."""

    title: str
    x: Floats
    reference: Floats
    curve: Floats


def draw(pictures: Sequence[Picture], labels: tuple[str, str, str, str], path: Path) -> None:
    """All pictures on the same axes, written as SVG: the same data, the same file.

    ``labels``: of x, of y, of the reference and of the curve.
    """
    rows = -(-len(pictures) // COLUMNS)
    with mpl.rc_context({"svg.hashsalt": "loops", "svg.fonttype": "none", "font.size": 8, "path.simplify": True}):
        figure, axes = plt.subplots(
            rows, COLUMNS, sharex=True, sharey=True, squeeze=False, figsize=(8.0, 2.4 * rows), layout="constrained"
        )
        for axis, picture in zip(axes.flat, pictures, strict=False):
            axis.plot(picture.x, picture.reference, color="0.6", linewidth=2.0, label=labels[2])
            axis.plot(picture.x, picture.curve, color="#d55e00", linewidth=0.8, label=labels[3])
            axis.set_title(picture.title, fontsize=8)
            axis.spines[["top", "right"]].set_visible(False)
        for axis in list(axes.flat)[len(pictures) :]:
            axis.set_visible(False)
        axes.flat[0].legend(frameon=False)
        figure.supxlabel(labels[0])
        figure.supylabel(labels[1])
        figure.savefig(path, metadata={"Date": None})
        plt.close(figure)
