# SPDX-License-Identifier: Apache-2.0
"""A run as a CSV file: ``time_s`` and a column for each channel, ``time_s,power_w,temperature_c,displacement_m``.

A cell is empty if the sensor has no sample at that time. Columns of channels that were not measured are left out.
Lines ``# key: value`` in front of the header, and a YAML file beside the CSV, tell the conditions of the run.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from lce_data.channels import CHANNELS, Channel, channel_of_column, in_order
from lce_data.columns import TableFormat, read_columns
from lce_data.errors import LceError
from lce_data.experiment_file import Experiment, beside_csv, content_of, experiment_of, write_beside_csv
from lce_data.files import write_atomically

Floats = NDArray[np.float64]

COLUMNS: Final = ("time_s", *(channel.column for channel in CHANNELS))
_ROWS_AT_ONCE: Final = 100_000


def write_run_csv(
    path: Path, time_s: Floats, values: Mapping[Channel, Floats], experiment: Experiment | None = None
) -> None:
    """Write a run.

    Parameters
    ----------
    time_s : (n,) [s], strictly increasing.
    values : (n,) of each channel [its SI unit], NaN where it has no sample.
    experiment : written beside it as a YAML file of the same stem; not written if None.

    Raises
    ------
    LceError
        If the time does not increase or a file cannot be written.
    """
    _check_time(path, time_s, 2)
    write_atomically(path, _lines(time_s, {channel: values[channel] for channel in in_order(values)}))
    if experiment is not None:
        write_beside_csv(path, experiment)


def read_run_csv(path: Path) -> dict[Channel, tuple[Floats, Floats]]:
    """Time [s] and value [recorded unit] of each channel of a run, (n,) each.

    Channels that have a sample in every row share one array of times.

    Raises
    ------
    LceError
        If the file is no such table; names the file, the row and the cell.
    """
    header, first_row, _ = _head(path)
    unknown = [name for name in header if name != "time_s" and channel_of_column(name) is None]
    if unknown or "time_s" not in header or len(set(header)) != len(header):
        raise LceError(
            f"{path}: header {','.join(header)!r}; expected time_s and of {','.join(COLUMNS[1:])}; "
            f"{_fault(header, unknown)}: lce import {path} --out runs/"
        )
    columns = read_columns(path, TableFormat(tuple(header), first_row))
    time_s = columns["time_s"]
    if np.isnan(time_s).any():
        raise LceError(f"{path}, row {first_row + int(np.argmax(np.isnan(time_s)))}: time_s is empty")
    _check_time(path, time_s, first_row)
    present = in_order(channel for name in columns if (channel := channel_of_column(name)) is not None)
    return {channel: _samples(time_s, columns[channel.column]) for channel in present}


def read_csv_experiment(path: Path) -> Experiment:
    """What the comment lines of a CSV and the YAML file beside it say of the run; the latter wins.

    Raises LceError that names the file, the key and the value.
    """
    beside = beside_csv(path)
    _, _, notes = _head(path)
    if not notes:
        return beside
    conditions = {**notes, **content_of(beside.conditions)}
    return experiment_of({**content_of(beside), "conditions": conditions}, path)


def note(line: str) -> dict[str, Any]:
    """The key and the value of a comment line ``# key: value``; nothing for any other line."""
    import yaml

    from lce_data.yaml_text import load

    key, colon, text = line.lstrip("# \t").partition(":")
    key, text = key.strip(), text.strip()
    if not (colon and key and text):
        return {}
    try:
        value = load(text)
    except yaml.YAMLError:
        value = text
    return {key: value if isinstance(value, str | int | float) else text}


def _head(path: Path) -> tuple[list[str], int, dict[str, Any]]:
    """The header, the line on which the first row stands, and the notes in front of the header."""
    notes: dict[str, Any] = {}
    try:
        with path.open(encoding="utf-8-sig") as file:
            for row, line in enumerate(file, start=1):
                if not line.startswith("#"):
                    return [cell.strip().strip('"') for cell in line.split(",")], row + 1, notes
                notes |= note(line)
    except OSError as error:
        raise LceError(f"{path}: {error.strerror}") from None
    except UnicodeDecodeError:
        raise LceError(
            f"{path}: not a text in UTF-8. To read another encoding: lce import {path} --out runs/"
        ) from None
    return [], 1, notes


def _fault(header: list[str], unknown: list[str]) -> str:
    """What is wrong with a header, up to where the command that may read it follows."""
    twice = next((name for name in header if header.count(name) > 1), None)
    if unknown:
        return f"{unknown[0]!r} is none of them. To read other names, units and separators"
    return f"{twice} stands twice. To pick columns" if twice else "there is no time_s. To name the column of the time"


def _lines(time_s: Floats, values: Mapping[Channel, Floats]) -> Iterator[str]:
    """The text of a CSV, many rows at once."""
    yield ",".join(["time_s", *(channel.column for channel in values)]) + "\n"
    for start in range(0, time_s.size, _ROWS_AT_ONCE):
        rows = slice(start, start + _ROWS_AT_ONCE)
        columns = [[f"{t:.12g}" for t in time_s[rows].tolist()]]
        for channel, value in values.items():
            recorded = channel.recorded.from_si(value[rows]).tolist()
            columns.append(["" if v != v else format(v, channel.csv_format) for v in recorded])  # NaN is no sample
        yield "".join(f"{','.join(cells)}\n" for cells in zip(*columns, strict=True))


def _check_time(path: Path, time_s: Floats, first_row: int) -> None:
    back = np.flatnonzero(np.diff(time_s) <= 0.0)
    if back.size:
        i = int(back[0])
        raise LceError(
            f"{path}, row {i + first_row + 1}: time does not increase: {time_s[i + 1]:g} s after {time_s[i]:g} s"
        )


def _samples(time_s: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Times and values of the cells that are not empty."""
    there = ~np.isnan(values)
    return (time_s, values) if there.all() else (time_s[there], values[there])
