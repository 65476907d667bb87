# SPDX-License-Identifier: Apache-2.0
"""From sections to the text of one HTML file that opens anywhere, without a network."""

import base64
import hashlib
from collections.abc import Iterable, Sequence
from importlib.resources import files
from importlib.resources.abc import Traversable

from lce_report.blocks import Section
from lce_report.html.arrays import Arrays
from lce_report.html.fragment import Fragment
from lce_report.html.templates import templates


def render(title: str, answer: Sequence[str], sections: Sequence[Section], footer: Sequence[str] = ()) -> str:
    """A self-contained page: the answer in sentences, then the evidence, then where it came from.

    Parameters
    ----------
    title, answer : what the page begins with.
    sections : the evidence; arrays are in the units of their axes.
    footer : lines on data and software.

    Returns
    -------
    str
        The text of an HTML file, which asks the network for nothing. Any text may hold any characters: it is escaped,
        and no script runs but the two of the page.
    """
    from markupsafe import Markup

    static, uplot = files("lce_report") / "static", files("uplot") / "static"
    arrays = Arrays()
    page = Fragment(arrays)
    evidence = [{"heading": s.heading, "html": Markup("").join(map(page.block, s.blocks))} for s in sections]
    drawing = _text([uplot / "uPlot.iife.js"]).replace("</script", "<\\/script")
    script = _text([static / "figures.js", static / "page.js"])
    return templates().get_template("page.html").render(
        title=title,
        answer=answer,
        sections=evidence,
        footer=footer,
        style=Markup(_text([uplot / "uPlot.min.css", static / "figures.css", static / "page.css"])),
        figures=page.figures,
        numbers=arrays.packed(),
        hashes=Markup(f"{_hash(drawing)} {_hash(script)}"),
        uplot=Markup(drawing),
        script=Markup(script),
    )  # fmt: skip


def _hash(script: str) -> str:
    """A script as a Content-Security-Policy names it, so that no other one runs."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()}'"


def _text(parts: Iterable[Traversable]) -> str:
    return "".join(part.read_text(encoding="utf-8") for part in parts)
