# SPDX-License-Identifier: Apache-2.0
"""Several models over the same run: measured and modelled, with their residuals."""

from collections.abc import Collection, Mapping

from lce_analysis.comparison.compare import ChannelComparison, Comparison
from lce_report.blocks import Block, Curve, Lines, Section
from lce_report.figures.axes import TIME, difference_scale, displayed, residual_axis, title, value_axis
from lce_report.figures.errors import ROLES


def overlays(compared: Mapping[str, Comparison], held_out: Collection[str] = ()) -> tuple[Section, ...]:
    """A section for each run: every channel over time, in its display unit, and its residuals under all models.

    Parameters
    ----------
    compared : models beside the same runs, by what they are called.
    held_out : names of the runs that no model was fitted to.
    """
    sections = []
    for i, run in enumerate(next(iter(compared.values())).runs):
        figures: list[Block] = []
        for channel in run.channels:
            found = {label: comparison.runs[i].channels.get(channel) for label, comparison in compared.items()}
            there = {label: by_model for label, by_model in found.items() if by_model is not None}
            figures += _overlay(there, run.run.name)
        note = " (held out)" if run.run.name in held_out else ""
        sections.append(Section(f"{run.run.name}{note}", figures))
    return tuple(sections)


def _overlay(found: Mapping[str, ChannelComparison], run: str) -> tuple[Lines, Lines]:
    first = next(iter(found.values()))
    channel, time_s, scale = first.channel, first.time_s, difference_scale(first.channel)
    roles = {label: ROLES.get(label, "after") for label in found}
    values = [Curve("measured", displayed(channel, first.measured), "measured")] + [
        Curve(label, displayed(channel, c.modelled), roles[label], "line" if roles[label] == "after" else "dashed")
        for label, c in found.items()
    ]
    residuals = [Curve(label, c.residual * scale, roles[label]) for label, c in found.items()]
    return (
        Lines(title(channel), TIME, value_axis(channel), time_s, values, linked=run),
        Lines(f"residual of the {channel.name}", TIME, residual_axis(channel), time_s, residuals, linked=run),
    )
