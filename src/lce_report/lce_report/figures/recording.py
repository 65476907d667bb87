# SPDX-License-Identifier: Apache-2.0
"""A foreign recording as it was understood: a table with the ranges, what looks wrong, and a figure of each channel."""

from __future__ import annotations

from collections.abc import Sequence

from lce_data.channels import POWER
from lce_data.errors import LceError
from lce_data.importing.recording import HEAD, Recording
from lce_report.blocks import Block, Curve, Lines, Table
from lce_report.figures.axes import TIME, title, value_axis


def recording_table(recording: Recording) -> Table:
    """What was understood of a file; a question mark stands behind what is guessed."""
    return Table("", HEAD, recording.rows)


def recording_figures(recording: Recording) -> Sequence[Block]:
    """What is left out, what looks wrong, and each channel over time."""
    blocks: list[Block] = [f"Left out: {', '.join(recording.left_out)}."] if recording.left_out else []
    try:
        run, warnings = recording.run, recording.warnings()
    except LceError as error:
        return [*blocks, f"Cannot be imported so: {error}"]
    blocks += [f"{remark}." for remark in recording.remarks]
    blocks += [f"Warning: {warning}" for warning in warnings]
    for channel, series in run.series.items():
        shown = channel.display.from_si(series.value)
        driven = channel is POWER
        curve = Curve(channel.symbol, shown, "input" if driven else "measured", "step" if driven else "line")
        blocks.append(Lines(title(channel), TIME, value_axis(channel), series.time_s, (curve,), recording.path.name))
    return blocks
