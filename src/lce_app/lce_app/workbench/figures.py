# SPDX-License-Identifier: Apache-2.0
"""Blocks of the report on the page: the same HTML, the same script, every sample, and cells that can be picked."""

from __future__ import annotations

import base64
import json
import secrets
import struct
from collections.abc import Callable, Mapping, Sequence
from importlib.resources import files
from typing import TYPE_CHECKING

from nicegui import app, ui

from lce_data.errors import LceError

if TYPE_CHECKING:
    from lce_data.run import Floats
    from lce_report import Block, paper

Blocks = Callable[[], "Sequence[Block]"]

_shown: dict[str, Blocks] = {}
HEAD = """<link rel="stylesheet" href="/static/uPlot.css"><link rel="stylesheet" href="/static/figures.css">
<link rel="stylesheet" href="/static/workbench.css"><script src="/static/uPlot.js"></script>
<script src="/static/figures.js"></script>"""


def serve_scripts() -> None:
    """The report's script and style, uPlot, and the style of the page."""
    uplot, report, here = files("uplot") / "static", files("lce_report") / "static", files(__package__)
    for name, file in (
        ("uPlot.js", uplot / "uPlot.iife.js"),
        ("uPlot.css", uplot / "uPlot.min.css"),
        ("figures.js", report / "figures.js"),
        ("figures.css", report / "figures.css"),
        ("workbench.css", here / "workbench.css"),
    ):
        app.add_static_file(local_file=str(file), url_path=f"/static/{name}", max_cache_age=0)


def packed(key: str) -> bytes | None:
    """What the page fetches: the length of a JSON text, the text {html, figures}, and the numbers, float32."""
    if key not in _shown:
        return None
    from lce_report import Fragment, Samples

    numbers = Samples()
    page = Fragment(numbers)
    try:
        html = "".join(page.block(block) for block in _shown[key]())
    except LceError as error:
        html = page.block(str(error))
    text = json.dumps({"html": html, "figures": page.figures}).encode()
    text += b" " * (-len(text) % 4)
    return struct.pack("<I", len(text)) + text + numbers.packed()


def on_paper(key: str, number: int, kind: paper.Format, x: paper.Limits | None) -> bytes | None:
    """A figure of the page as SVG or PDF, by its place among those that are drawn as curves; None if it has gone."""
    from lce_report import paper

    if key not in _shown:
        return None
    try:
        return paper.written(paper.curves_of(_shown[key]())[number], kind, x)
    except (LceError, IndexError):
        return None


class Figures(ui.element, component="figures.js"):
    """Blocks drawn on the page. They are computed when the page fetches them, in a thread of the server's.

    on_pick(what, row, column) is called when a cell is clicked; on_mark(begin, end) when an interval of x was dragged
    over while ``marking``.
    """

    def __init__(
        self,
        blocks: Blocks,
        on_pick: Callable[[str, int, int], None] | None = None,
        on_mark: Callable[[float, float], None] | None = None,
    ) -> None:
        super().__init__()
        self._key, self._version = secrets.token_urlsafe(12), 0
        _shown[self._key] = blocks
        self._props["url"] = f"/figures/{self._key}"
        if on_pick is not None:
            self.on("pick", lambda event: on_pick(event.args["pick"], event.args["row"], event.args["column"]))
        if on_mark is not None:
            self.on("mark", lambda event: on_mark(float(event.args["begin"]), float(event.args["end"])))

    def _handle_delete(self) -> None:
        _shown.pop(self._key, None)
        super()._handle_delete()

    def reload(self) -> None:
        """Compute and draw the blocks anew."""
        self._version += 1
        self._props["url"] = f"/figures/{self._key}?{self._version}"

    def light(self, spans: dict[str, list[tuple[float, float]]]) -> None:
        """Light samples up, now and when they are drawn anew: by linked name, intervals of the linked x."""
        self._props["lit"] = spans

    def marking(self, on: bool) -> None:
        """Whether dragging over a figure marks an interval, or zooms."""
        self._props["marking"] = on

    def replace(self, curves: dict[str, Floats]) -> None:
        """Give curves new values (n,), by label; n is that of the figure."""
        self.run_method("replace", {k: base64.b64encode(v.astype("<f4").tobytes()).decode() for k, v in curves.items()})

    def extend(self, columns: Mapping[str, Sequence[Sequence[float | None]]], keep: float | None = None) -> None:
        """Append samples to figures, by title: x and each curve; what is further back than ``keep`` in x is dropped."""
        self.run_method("extend", columns, keep)
