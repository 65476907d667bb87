# SPDX-License-Identifier: Apache-2.0
"""Blocks of a report as plain values, and back: a job writes them, and the page draws them later.

What is read is checked against the types of the blocks. The page escapes their texts, so a file can bring no HTML.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeVar

import numpy as np
from msgspec import Struct, to_builtins

from lce_data.schema import checked
from lce_report.blocks import (
    Bars,
    Block,
    Details,
    Figure,
    Grid,
    Heat,
    Intervals,
    Lines,
    Loop,
    Section,
    Table,
)

Kind = TypeVar("Kind")


class KeptBlock(Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """One block: the field that is not None. ``cells`` are those of a grid, ``widths`` of its columns."""

    paragraph: str | None = None
    lines: Lines | None = None
    loop: Loop | None = None
    heat: Heat | None = None
    bars: Bars | None = None
    intervals: Intervals | None = None
    table: Table | None = None
    details: Details | None = None
    cells: tuple[tuple[KeptBlock, ...], ...] = ()
    widths: tuple[int, ...] = ()

    @property
    def figure(self) -> Figure | None:
        """The figure or table that it is; None if it is something else."""
        return self.lines or self.loop or self.heat or self.bars or self.intervals or self.table

    @property
    def block(self) -> Block:
        """The block of a report."""
        if self.cells:
            columns = [tuple(one.figure for one in cell if one.figure is not None) for cell in self.cells]
            return Grid(columns, self.widths)
        return self.details or self.figure or self.paragraph or ""


class KeptSection(Struct, frozen=True, forbid_unknown_fields=True):
    """A section of a report."""

    heading: str
    blocks: tuple[KeptBlock, ...]


def kept(section: Section) -> KeptSection:
    """A section as it is kept."""
    return KeptSection(section.heading, tuple(map(_kept, section.blocks)))


def blocks_of(section: KeptSection) -> Sequence[Block]:
    """What stands under the heading."""
    return [one.block for one in section.blocks]


def as_plain(record: Struct) -> Any:
    """A record as JSON can hold it; NaN becomes null."""
    return to_builtins(record, enc_hook=_plain_array)


def from_plain(content: object, kind: type[Kind]) -> Kind:
    """The record that ``as_plain`` made plain. Raises LceError if it is something else."""
    return checked("not what the workbench wrote", content, kind, _array)


def _kept(block: Block) -> KeptBlock:
    match block:
        case str():
            return KeptBlock(paragraph=block)
        case Lines():
            return KeptBlock(lines=block)
        case Loop():
            return KeptBlock(loop=block)
        case Heat():
            return KeptBlock(heat=block)
        case Bars():
            return KeptBlock(bars=block)
        case Intervals():
            return KeptBlock(intervals=block)
        case Table():
            return KeptBlock(table=block)
        case Details():
            return KeptBlock(details=block)
        case Grid():
            columns = [cell if isinstance(cell, tuple) else (cell,) for cell in block.figures]
            return KeptBlock(cells=tuple(tuple(map(_kept, cell)) for cell in columns), widths=tuple(block.widths))


def _plain_array(value: object) -> object:
    if not isinstance(value, np.ndarray):
        raise NotImplementedError(type(value))
    plain = value.astype(object)
    plain[~np.isfinite(value)] = None
    return plain.tolist()


def _array(kind: type, value: object) -> object:
    """An array of a list, in which null is NaN; msgspec asks for what it does not know."""
    return np.array(value, dtype=np.float64)
