# SPDX-License-Identifier: Apache-2.0
"""Experiments in: a rosbag2 folder, an MCAP file or a CSV becomes a Run, in SI units."""

import csv
import hashlib
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np
import yaml
from numpy.typing import NDArray

from lce_data.bag.reader import Recorded, read_bag
from lce_data.channels import CHANNELS, POWER, Channel
from lce_data.errors import LceError
from lce_data.run import Run, Series

Floats = NDArray[np.float64]

COLUMNS: Final = ("time_s", *(channel.column for channel in CHANNELS))
FEWEST_SAMPLES: Final = 8


def read_runs(paths: Iterable[str | Path]) -> tuple[Run, ...]:
    """Read several runs; two of the same name are told apart by their folders."""
    runs = [read_run(p) for p in paths]
    names = [r.name for r in runs]
    return tuple(
        r if names.count(r.name) == 1 else replace(r, name=f"{r.path.resolve().parent.name}/{r.name}") for r in runs
    )


def read_run(path: str | Path) -> Run:
    """Read one run; LceError says in one line which file and row or topic is wrong, and what to do."""
    path = Path(path)
    if not path.exists():
        raise LceError(f"{path}: no such file or folder")
    if path.is_dir() or path.suffix == ".mcap":
        return _run(path, read_bag(path), _conditions(path))
    if path.suffix.lower() == ".csv":
        return _run(path, _read_csv(path), {})
    raise LceError(f"{path}: neither a rosbag2 folder, nor an .mcap file, nor a .csv file")


def _run(path: Path, recorded: Recorded, conditions: Mapping[str, Any]) -> Run:
    series = {channel: _series(path, *recorded[channel], channel) for channel in CHANNELS if channel in recorded}
    sensors = [channel for channel in series if channel is not POWER]
    if POWER not in series and len(sensors) < 2:
        raise LceError(f"{path}: no laser power, and not both temperature and displacement: nothing to relate")
    if not sensors:
        raise LceError(f"{path}: neither temperature nor displacement: nothing to compare a model with")
    for channel, values in series.items():
        _check_values(path, channel, values.value)
    zero_s = series[POWER].time_s[0] if POWER in series else min(s.time_s[0] for s in series.values())
    return Run(
        name=path.stem if path.is_file() else path.name,
        path=path,
        sha256=_digest(path),
        series={c: Series(s.time_s - zero_s, c.recorded.to_si(s.value)) for c, s in series.items()},
        conditions=conditions,
    )


def _series(path: Path, time: Floats, value: Floats, channel: Channel) -> Series:
    """The series as recorded."""
    if time.size < FEWEST_SAMPLES:
        raise LceError(
            f"{path}: {channel.name} has {time.size} samples; {FEWEST_SAMPLES} are the least that say anything"
        )
    bad = np.flatnonzero(~np.isfinite(value))
    if bad.size:
        raise LceError(f"{path}: {channel.name} is {value[bad[0]]} at {time[bad[0]] - time[0]:.3f} s")
    back = np.flatnonzero(np.diff(time) <= 0.0)
    if back.size:
        i = int(back[0])
        raise LceError(
            f"{path}: time of {channel.name} does not increase at its sample {i + 2}: "
            f"{time[i + 1] - time[0]:.6f} s after {time[i] - time[0]:.6f} s"
        )
    return Series(time, value)


def _check_values(path: Path, channel: Channel, value: Floats) -> None:
    """Raise LceError for values [recorded unit] that no bench gives: a unit was mistaken."""
    low, typical, high = float(value.min()), float(np.median(value)), float(value.max())
    unit = channel.recorded.symbol
    if low < channel.lowest:
        raise LceError(f"{path}: {channel.name} of {low:g} {unit}; {channel.hint}")
    if channel.unit == "K" and typical > channel.largest:
        raise LceError(f"{path}: {channel.name} around {typical:.0f} {unit}; {channel.hint}")
    if channel.unit != "K" and high > channel.largest:
        raise LceError(f"{path}: {channel.name} of {high:g} {unit}; {channel.hint}")


def _conditions(path: Path) -> dict[str, Any]:
    folder = path if path.is_dir() else path.parent
    for place in (folder / "experiment.yaml", folder.parent / f"{folder.name}.experiment.yaml"):
        if place.exists():
            try:
                content = yaml.safe_load(place.read_text(encoding="utf-8"))
            except yaml.YAMLError:
                raise LceError(f"{place}: not a YAML file") from None
            return dict(content) if isinstance(content, dict) else {}
    return {}


def _digest(path: Path) -> str:
    files = [path] if path.is_file() else sorted(p for p in path.iterdir() if p.suffix in (".mcap", ".db3"))
    digest = hashlib.sha256()
    for file in files:
        digest.update(file.read_bytes())
    return digest.hexdigest()


def _read_csv(path: Path) -> Recorded:
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = list(csv.reader(file))
    except OSError as error:
        raise LceError(f"{path}: cannot be read ({error.strerror})") from None
    except (UnicodeDecodeError, csv.Error):
        raise LceError(f"{path}: not a CSV text file") from None
    header = [cell.strip() for cell in rows[0]] if rows else []
    unknown = [name for name in header if name not in COLUMNS]
    if unknown or "time_s" not in header or len(set(header)) != len(header):
        raise LceError(f"{path}: header {','.join(header)!r}; expected time_s and of {','.join(COLUMNS[1:])}")
    wide = next((i for i, row in enumerate(rows) if len(row) > len(header)), None)
    if wide is not None:
        raise LceError(
            f"{path}, row {wide + 1}: {len(rows[wide])} cells under a header of {len(header)}; a decimal comma?"
        )
    columns = {name: _column(path, rows, header.index(name), name) for name in header}
    if np.isnan(columns["time_s"]).any():
        raise LceError(f"{path}, row {2 + int(np.argmax(np.isnan(columns['time_s'])))}: time_s is empty")
    back = np.flatnonzero(np.diff(columns["time_s"]) <= 0.0)
    if back.size:
        i = int(back[0])
        times = columns["time_s"]
        raise LceError(f"{path}, row {i + 3}: time does not increase: {times[i + 1]:g} s after {times[i]:g} s")
    present = {channel: columns[channel.column] for channel in CHANNELS if channel.column in columns}
    return {channel: _present(columns["time_s"], values) for channel, values in present.items()}


def _column(path: Path, rows: Sequence[Sequence[str]], index: int, name: str) -> Floats:
    """One column (n,), NaN where a cell is empty."""
    values = np.empty(len(rows) - 1)
    for i, row in enumerate(rows[1:]):
        cell = row[index].strip() if index < len(row) else ""
        try:
            values[i] = float(cell) if cell else math.nan
        except ValueError:
            raise LceError(f"{path}, row {i + 2}: {name} is {cell!r}, not a number") from None
        if cell and not math.isfinite(values[i]):
            raise LceError(f"{path}, row {i + 2}: {name} is {cell}")
    return values


def _present(time_s: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Times and values of the cells that are not empty."""
    there = ~np.isnan(values)
    return time_s[there], values[there]
