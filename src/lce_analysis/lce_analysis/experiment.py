# SPDX-License-Identifier: Apache-2.0
"""Experiments in: a rosbag2 folder, an MCAP file or a CSV becomes a Run, in SI units and kelvin."""

import csv
import hashlib
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
import yaml
from numpy.typing import NDArray

from lce_analysis.bag import Recorded, read_bag
from lce_model import KELVIN, LceError

Floats = NDArray[np.float64]

COLUMNS: Final = ("time_s", "power_w", "temperature_c", "displacement_m")
FEWEST_SAMPLES: Final = 8
HOTTEST_C: Final = 200.0
LONGEST_M: Final = 0.1


@dataclass(frozen=True)
class Series:
    """One measured quantity: time [s] and value, both (n,), finite, time strictly increasing."""

    time_s: Floats
    value: Floats


@dataclass(frozen=True)
class Run:
    """One experiment. Time zero is the first sample of the laser power (of anything, where there is none).

    power [W] is held from sample to sample; temperature [K] and displacement [m] are None where not measured.
    sha256 identifies the data; conditions is what ``experiment.yaml`` tells, empty for a CSV.
    """

    name: str
    path: Path
    sha256: str
    power: Series | None
    temperature: Series | None
    displacement: Series | None
    conditions: Mapping[str, Any]

    @property
    def strip_length_m(self) -> float | None:
        """Length of the strip, where the recording tells it."""
        told = self.conditions.get("conditions")
        return told.get("strip_length_m") if isinstance(told, Mapping) else None


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
    power = _series(path, recorded.power, "power")
    temperature = _series(path, recorded.temperature, "temperature")
    displacement = _series(path, recorded.displacement, "displacement")
    if power is None and (temperature is None or displacement is None):
        raise LceError(f"{path}: no laser power, and not both temperature and displacement: nothing to relate")
    if temperature is None and displacement is None:
        raise LceError(f"{path}: neither temperature nor displacement: nothing to compare a model with")
    _check_values(path, power, temperature, displacement)
    zero = power.time_s[0] if power else min(s.time_s[0] for s in (temperature, displacement) if s)
    return Run(
        name=path.stem if path.is_file() else path.name,
        path=path,
        sha256=_digest(path),
        power=_shifted(power, zero, 0.0),
        temperature=_shifted(temperature, zero, KELVIN),
        displacement=_shifted(displacement, zero, 0.0),
        conditions=conditions,
    )


def _series(path: Path, pair: tuple[Floats, Floats] | None, name: str) -> Series | None:
    if pair is None:
        return None
    time, value = pair
    if time.size < FEWEST_SAMPLES:
        raise LceError(f"{path}: {name} has {time.size} samples; {FEWEST_SAMPLES} are the least that say anything")
    bad = np.flatnonzero(~np.isfinite(value))
    if bad.size:
        raise LceError(f"{path}: {name} is {value[bad[0]]} at {time[bad[0]] - time[0]:.3f} s")
    back = np.flatnonzero(np.diff(time) <= 0.0)
    if back.size:
        i = int(back[0])
        raise LceError(
            f"{path}: time of {name} does not increase at its sample {i + 2}: "
            f"{time[i + 1] - time[0]:.6f} s after {time[i] - time[0]:.6f} s"
        )
    return Series(time, value)


def _check_values(path: Path, power: Series | None, temperature: Series | None, displacement: Series | None) -> None:
    if power is not None and float(power.value.min()) < 0.0:
        raise LceError(f"{path}: laser power of {power.value.min():g} W; a laser gives 0 W or more")
    if temperature is not None and float(np.median(temperature.value)) > HOTTEST_C:
        raise LceError(
            f"{path}: temperature around {np.median(temperature.value):.0f} °C; is it in kelvin? Subtract {KELVIN}"
        )
    if displacement is not None and float(np.abs(displacement.value).max()) > LONGEST_M:
        raise LceError(
            f"{path}: displacement of {np.abs(displacement.value).max():g} m; is it in millimetres? Divide by 1000"
        )


def _shifted(series: Series | None, zero_s: float, offset: float) -> Series | None:
    return None if series is None else Series(series.time_s - zero_s, series.value + offset)


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
    return Recorded(*(_present(columns, name) for name in COLUMNS[1:]))


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


def _present(columns: Mapping[str, Floats], name: str) -> tuple[Floats, Floats] | None:
    if name not in columns:
        return None
    there = ~np.isnan(columns[name])
    return columns["time_s"][there], columns[name][there]
