# SPDX-License-Identifier: Apache-2.0
"""Two models over the same run: measured, before and after, with their residuals."""

from collections.abc import Collection

from lce_analysis.comparison.compare import ChannelComparison, Comparison
from lce_report.blocks import Block, Curve, Lines, Section
from lce_report.figures.axes import TIME, difference_scale, displayed, residual_axis, title, value_axis


def overlays(before: Comparison, after: Comparison, held_out: Collection[str] = ()) -> tuple[Section, ...]:
    """A section for each run: every channel over time, in its display unit, and its residuals under both models."""
    sections = []
    for old, new in zip(before.runs, after.runs, strict=True):
        figures: list[Block] = []
        for channel, compared in old.channels.items():
            if channel in new.channels:
                figures += _overlay(compared, new.channels[channel], old.run.name)
        note = " (held out)" if old.run.name in held_out else ""
        sections.append(Section(f"{old.run.name}{note}", figures))
    return tuple(sections)


def _overlay(before: ChannelComparison, after: ChannelComparison, run: str) -> tuple[Lines, Lines]:
    channel, time_s, scale = before.channel, before.time_s, difference_scale(before.channel)
    values = (
        Curve("measured", displayed(channel, before.measured), "measured"),
        Curve("before", displayed(channel, before.modelled), "before", "dashed"),
        Curve("after", displayed(channel, after.modelled), "after"),
    )
    residuals = (
        Curve("before", before.residual * scale, "before"),
        Curve("after", after.residual * scale, "after"),
    )
    return (
        Lines(title(channel), TIME, value_axis(channel), time_s, values, linked=run),
        Lines(f"residual of the {channel.name}", TIME, residual_axis(channel), time_s, residuals, linked=run),
    )
