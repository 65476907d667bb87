# SPDX-License-Identifier: Apache-2.0
"""What was understood of a foreign file: a signal for each channel, and the run that is made of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from lce_data.channels import NAMED_INPUT, Unit, channel_named
from lce_data.errors import LceError
from lce_data.experiment_file import Experiment, experiment_of
from lce_data.files import name_of
from lce_data.importing.headers import SI_UNITS, TIME, si_unit
from lce_data.importing.units import MEANING, typed, unit_and_sign
from lce_data.read_runs import run_from
from lce_data.run import Run
from lce_data.run_csv import write_run_csv
from lce_data.suspicions import suspicions

Floats = NDArray[np.float64]

COLUMN, UNIT = "column", "unit"
HEAD: Final = ("column", "is", "unit", "range", "samples", "median step")


def is_bag(path: Path) -> bool:
    """Whether a file is read as a bag, and not as a table."""
    return path.is_dir() or path.suffix == ".mcap"


def _is_quantity(name: str) -> bool:
    try:
        si_unit(name)
    except KeyError:
        return False
    return True


@dataclass(frozen=True)
class Pick:
    """What the user said of a column: ``temperature=T1:degC``.

    Parameters
    ----------
    quantity : ``time`` or the name of a channel.
    source : the header or the number of the column, or the topic of a bag; empty if nothing holds the quantity.
    unit : as typed; empty if the header or the values tell it.
    """

    quantity: str
    source: str
    unit: str = ""

    @classmethod
    def parse(cls, text: str) -> Pick:
        """Read ``QUANTITY=SOURCE[:UNIT]``. Raises LceError for another form, quantity or unit."""
        quantity, equals, rest = text.partition("=")
        if not equals or not _is_quantity(quantity):
            known = ", ".join(SI_UNITS)
            raise LceError(f"{text!r}: expected QUANTITY=NAME[:UNIT] with one of {known}, or {NAMED_INPUT}NAME")
        source, colon, unit = rest.rpartition(":")
        if not colon:
            return cls(quantity, rest)
        unit_and_sign(si_unit(quantity), unit)
        return cls(quantity, source, unit)

    def __str__(self) -> str:
        return f"{self.quantity}={self.source}{f':{self.unit}' if self.unit else ''}"


@dataclass(frozen=True)
class Signal:
    """One quantity as understood.

    Parameters
    ----------
    quantity : ``time`` or the name of a channel.
    source : the column or topic that holds it.
    unit : of the values in the file; ``sign`` is −1 where the file counts the other way round.
    guessed : what no header and no user said: ``column``, ``unit``, both or nothing.
    time_s : (n,) since the first sample of the file.
    value : (n,) as in the file, NaN where there is no sample.
    """

    quantity: str
    source: str
    unit: Unit
    sign: float
    guessed: tuple[str, ...]
    time_s: Floats
    value: Floats

    @property
    def value_si(self) -> Floats:
        """The values (n,) in SI, their sign flipped if it is to be."""
        return self.unit.to_si(self.value if self.sign > 0 else -self.value)

    @property
    def pick(self) -> Pick:
        """What a user would have said to the same effect."""
        return Pick(self.quantity, self.source, f"{'-' if self.sign < 0 else ''}{typed(self.unit)}")

    def row(self) -> tuple[str, ...]:
        """A line of the table of what was understood, under `HEAD`; a question mark stands behind a guess."""
        there = np.isfinite(self.value)
        low, high = self.sign * np.array([np.min(self.value[there]), np.max(self.value[there])])
        step = float(np.median(np.diff(self.time_s[there]))) if there.sum() > 1 else 0.0
        unit = f"{'-' if self.sign < 0 else ''}{self.unit.symbol}{'?' if UNIT in self.guessed else ''}"
        return (
            self.source,
            f"{self.quantity}{'?' if COLUMN in self.guessed else ''}",
            unit,
            f"{min(low, high):.6g} … {max(low, high):.6g}",
            str(int(there.sum())),
            f"{step:.4g} s",
        )


@dataclass(frozen=True)
class Recording:
    """What was understood of one file.

    Parameters
    ----------
    signals : the time, if the file is a table, and what holds a channel.
    left_out : columns or topics that hold nothing else that is known, each with a remark.
    rows_changed : a sentence on rows of one time, which are put together.
    notes : conditions that the file itself tells.
    """

    path: Path
    signals: tuple[Signal, ...]
    left_out: tuple[str, ...] = ()
    rows_changed: tuple[str, ...] = ()
    notes: Mapping[str, Any] | None = None

    @property
    def guesses(self) -> tuple[Signal, ...]:
        """The signals of which something was guessed."""
        return tuple(signal for signal in self.signals if signal.guessed)

    @property
    def is_bag(self) -> bool:
        """Whether the file is a bag, of which topics are chosen, or a table."""
        return is_bag(self.path)

    @property
    def rows(self) -> list[tuple[str, ...]]:
        """The table of what was understood, under `HEAD`."""
        return [signal.row() for signal in self.signals]

    @cached_property
    def run(self) -> Run:
        """The run that is written. Raises LceError if it could not be used."""
        series = {}
        for signal in self.signals:
            if signal.quantity != TIME:
                channel = channel_named(signal.quantity)
                series[channel] = _samples(signal.time_s, channel.recorded.from_si(signal.value_si))
        return run_from(self.path, series, Experiment())

    @property
    def remarks(self) -> tuple[str, ...]:
        """What is done to the file without a question: rows put together, and units that stand for others."""
        said = ((s.source, MEANING.get((si_unit(s.quantity), s.unit.symbol))) for s in self.signals)
        meanings = (f"{source}: {meaning}" for source, meaning in said if meaning)
        return (*meanings, *self.rows_changed)

    def warnings(self) -> tuple[str, ...]:
        """What looks wrong, with the cure. Raises LceError if the run could not be used."""
        return suspicions(self.run)

    def check(
        self, folder: Path, conditions: Mapping[str, Any], overwrite: bool = False
    ) -> tuple[Path, Run, Experiment]:
        """The file that `write` would write, its run, and what is known of it. Raises LceError as `write` does."""
        run = self.run
        out = folder / f"{name_of(self.path)}.csv"
        if out.resolve() == self.path.resolve():
            raise LceError(f"{out} is the file that is read; choose another --out")
        for file in (out, out.with_suffix(".yaml")):
            if file.exists() and not overwrite:
                raise LceError(f"{file}: exists already; --force overwrites it")
        imported = {
            "file": self.path.name,
            "sha256": run.sha256,
            "columns": [str(signal.pick) for signal in self.signals],
        }
        conditions = {**(self.notes or {}), **conditions}
        return out, run, experiment_of({"conditions": conditions, "imported": imported}, out.with_suffix(".yaml"))

    def write(self, folder: Path, conditions: Mapping[str, Any], overwrite: bool = False) -> Path:
        """Write the run as NAME.csv, with NAME.yaml beside it, into a folder that is made if need be.

        Parameters
        ----------
        conditions : what is one number or word for the whole run; they go before those of the file.

        Raises
        ------
        LceError
            If the run could not be used, a condition is no number, or a file exists and may not be replaced.
        """
        out, run, about = self.check(folder, conditions, overwrite)
        time_s, values = run.aligned()
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise LceError(f"{folder}: cannot be made ({error.strerror})") from None
        write_run_csv(out, time_s, values, about)
        return out


def _samples(time_s: Floats, value: Floats) -> tuple[Floats, Floats]:
    """Times and values without those that are NaN."""
    there = np.isfinite(value)
    return (time_s, value) if there.all() else (time_s[there], value[there])
