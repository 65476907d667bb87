# SPDX-License-Identifier: Apache-2.0
"""Small pictures of loops, side by side, as an SVG for the documents; readable on light and dark pages."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

WIDTH, HEIGHT, MARGIN = 260, 210, 34


@dataclass(frozen=True)
class Picture:
    """A measured and a modelled curve over the same x, all (n,)."""

    title: str
    x: Floats
    measured: Floats
    modelled: Floats


def draw(pictures: Sequence[Picture], x_label: str, y_label: str, columns: int = 3) -> str:
    """All pictures on the same axes."""
    x_ticks = _ticks(min(p.x.min() for p in pictures), max(p.x.max() for p in pictures))
    ys = [y for p in pictures for y in (p.measured, p.modelled)]
    y_ticks = _ticks(min(y.min() for y in ys), max(y.max() for y in ys))
    rows = -(-len(pictures) // columns)
    body = [
        _panel(p, (i % columns) * WIDTH, (i // columns) * HEIGHT, x_ticks, y_ticks, x_label, y_label)
        for i, p in enumerate(pictures)
    ]
    style = (
        "text{font:11px sans-serif;fill:#777}.t{font-weight:bold}path{fill:none;stroke-width:1.4}"
        ".measured{stroke:#999;stroke-width:3}.modelled{stroke:#d55e00}.axis{stroke:#999;stroke-width:1}"
    )
    size = f'viewBox="0 0 {columns * WIDTH} {rows * HEIGHT}"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size}><style>{style}</style>\n' + "\n".join(body) + "\n</svg>\n"


def _ticks(low: float, high: float) -> Floats:
    """Four or so round values that span the range."""
    rough = (high - low) / 4.0
    power = 10.0 ** np.floor(np.log10(rough))
    step = power * min((1.0, 2.0, 5.0, 10.0), key=lambda m: abs(m * power - rough))
    return np.asarray(np.arange(np.floor(low / step), np.ceil(high / step) + 1.0) * step)


def _panel(p: Picture, left: float, top: float, x_ticks: Floats, y_ticks: Floats, x_label: str, y_label: str) -> str:
    def px(x: Floats) -> Floats:
        return left + MARGIN + (x - x_ticks[0]) / np.ptp(x_ticks) * (WIDTH - 1.5 * MARGIN)

    def py(y: Floats) -> Floats:
        return top + HEIGHT - MARGIN - (y - y_ticks[0]) / np.ptp(y_ticks) * (HEIGHT - 2.0 * MARGIN)

    def path(y: Floats, kind: str) -> str:
        thin = slice(None, None, max(p.x.size // 900, 1))
        points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(px(p.x)[thin], py(y)[thin], strict=True))
        return f'<path class="{kind}" d="M{points}"/>'

    right, bottom = px(x_ticks[-1:])[0], py(y_ticks[:1])[0]
    axes = f'<path class="axis" d="M{left + MARGIN},{py(y_ticks[-1:])[0]:.1f} V{bottom:.1f} H{right:.1f}"/>'
    marks = [
        f'<text x="{x:.1f}" y="{bottom + 13:.1f}" text-anchor="middle">{v:g}</text>'
        for v, x in zip(x_ticks, px(x_ticks), strict=True)
    ] + [
        f'<text x="{left + MARGIN - 4}" y="{y + 4:.1f}" text-anchor="end">{v:g}</text>'
        for v, y in zip(y_ticks, py(y_ticks), strict=True)
    ]
    names = (
        f'<text x="{right:.1f}" y="{bottom + 26:.1f}" text-anchor="end">{escape(x_label)}</text>'
        f'<text x="{left + 4}" y="{top + 14}">{escape(y_label)}</text>'
        f'<text class="t" x="{left + MARGIN + 14}" y="{top + 14}">{escape(p.title)}</text>'
    )
    return "\n".join([path(p.measured, "measured"), path(p.modelled, "modelled"), axes, *marks, names])
