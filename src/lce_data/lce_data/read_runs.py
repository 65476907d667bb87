# SPDX-License-Identifier: Apache-2.0
"""Read experiments: a rosbag2 folder, an MCAP file or a CSV file becomes a Run in SI units."""

import hashlib
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_data.bag.reader import Recorded, read_bag_with_markers
from lce_data.channels import POWER, SENSORS, Channel, in_order
from lce_data.errors import LceError
from lce_data.experiment_file import Experiment, beside
from lce_data.files import check_regular, name_of
from lce_data.losses import without_unknown_power
from lce_data.marker import Marker
from lce_data.run import Run, Series
from lce_data.run_csv import read_csv_experiment, read_run_csv

Floats = NDArray[np.float64]

FEWEST_SAMPLES: Final = 8
"""Of the power and of a sensor; an optional input may be one number."""


def read_runs(paths: Iterable[str | Path]) -> tuple[Run, ...]:
    """Read several runs.

    Parameters
    ----------
    paths : rosbag2 folders, MCAP files or CSV files.

    Returns
    -------
    tuple[Run, ...]
        In the order given, as `told_apart` names them.

    Raises
    ------
    LceError
        As `read_run`, or if a run is given twice.

    Examples
    --------
    >>> runs = read_runs(["runs/pulse", "runs/stairs.csv"])  # doctest: +SKIP
    """
    runs = [read_run(p) for p in paths]
    places = Counter(run.path.resolve() for run in runs)
    for run in runs:
        if places[run.path.resolve()] > 1:
            raise LceError(f"{run.path}: is given twice")
    return told_apart(runs)


def told_apart(runs: Sequence[Run]) -> tuple[Run, ...]:
    """Runs of the same name get the names of their folders in front, as many as tell them apart.

    The same run may be there twice, as by a link.
    """
    places = [run.path.resolve() for run in runs]
    # A bag and a CSV of one name, beside each other, differ in what is behind it.
    distinct = {(place, run.name) for run, place in zip(runs, places, strict=True)}
    beside_it = Counter((place.parent, name) for place, name in distinct)
    plain = [p.name if beside_it[p.parent, run.name] > 1 else run.name for run, p in zip(runs, places, strict=True)]
    names, depth = plain, 0
    while len(set(names)) < len(set(zip(names, places, strict=True))):
        depth += 1
        names = [
            "/".join((*place.parts[1:-1][-depth:], name)) if plain.count(name) > 1 else name
            for name, place in zip(plain, places, strict=True)
        ]
    return tuple(replace(run, name=name) for run, name in zip(runs, names, strict=True))


def read_run(path: str | Path) -> Run:
    """Read one run.

    Parameters
    ----------
    path : a rosbag2 folder, an MCAP file or a CSV file.

    Returns
    -------
    Run
        Its series in SI units, and what ``experiment.yaml``, or for ``run.csv`` the file ``run.yaml``, says of it.

    Raises
    ------
    LceError
        If the run cannot be used; one line names the file, the row, key or topic, and what to do.

    Examples
    --------
    >>> run = read_run("runs/pulse")  # doctest: +SKIP
    """
    return usable(read_recording(path))


def read_recording(path: str | Path) -> Run:
    """Read what a file or folder holds, even if it is no run by itself: the laser power alone, or one sensor.

    Parameters
    ----------
    path : a rosbag2 folder, an MCAP file or a CSV file.

    Returns
    -------
    Run
        As `read_run`.

    Raises
    ------
    LceError
        If a channel cannot be used.
    """
    path = Path(path)
    if not path.exists():
        raise LceError(f"{path}: no such file or folder")
    for file in _files(path):
        if not file.is_dir():
            check_regular(file)
    if path.is_dir() or path.suffix == ".mcap":
        recorded, markers = read_bag_with_markers(path)
        return _recording(path, recorded, beside(path), markers)
    if path.suffix.lower() == ".csv":
        return _recording(path, read_run_csv(path), read_csv_experiment(path))
    raise LceError(f"{path}: neither a rosbag2 folder, nor an .mcap file, nor a .csv file")


def _files(path: Path) -> list[Path]:
    """What a folder holds, or the file itself. Raises LceError if the folder cannot be read."""
    try:
        return sorted(path.iterdir()) if path.is_dir() else [path]
    except OSError as error:
        raise LceError(f"{path}: cannot be read ({error.strerror})") from None


def run_from(path: Path, recorded: Recorded, experiment: Experiment, markers: Iterable[Marker] = ()) -> Run:
    """Make a run of what was recorded in a file or folder. Raises LceError if it cannot be used."""
    return usable(_recording(path, recorded, experiment, markers))


def usable(run: Run) -> Run:
    """The run. Raises LceError if its channels say nothing of each other, or one of them is too short."""
    sensors = run.measured
    if run.power is None and len(sensors) < 2:
        pair = f"not {'both' if len(SENSORS) == 2 else 'two of'} {' and '.join(s.name for s in SENSORS)}"
        raise LceError(f"{run.path}: no laser power, and {pair}: nothing to relate")
    if not sensors:
        none = f"neither {' nor '.join(s.name for s in SENSORS)}"
        raise LceError(f"{run.path}: {none}: nothing to compare a model with")
    for channel, series in run.series.items():
        _check_length(run.path, channel, series.time_s.size)
    _check_overlap(run)
    return run


def _check_overlap(run: Run) -> None:
    """Raise LceError if the laser power or a sensor has no time in common with the others."""
    first, *others = [channel for channel in run.series if channel is POWER or channel in SENSORS]
    (begin, end), name = _span(run, first), first.name
    for channel in others:
        from_s, to_s = _span(run, channel)
        if from_s > end or to_s < begin:
            raise LceError(
                f"{run.path}: {channel.name} was recorded from {from_s:.6g} to {to_s:.6g} s, {name} from {begin:.6g} "
                f"to {end:.6g} s: they have no time in common. Do two clocks stamp them? Set these and record again"
            )
        begin, end, name = min(begin, from_s), max(end, to_s), f"{name} and {channel.name}"


def _span(run: Run, channel: Channel) -> tuple[float, float]:
    """Time [s] of the first and of the last sample."""
    time_s = run.series[channel].time_s
    return float(time_s[0]), float(time_s[-1])


def _recording(path: Path, recorded: Recorded, experiment: Experiment, markers: Iterable[Marker] = ()) -> Run:
    """What was recorded, as far as each channel by itself can be used."""
    series = {channel: _series(path, *recorded[channel], channel) for channel in in_order(recorded)}
    if not series:
        raise LceError(f"{path}: no laser power and no sensor in it")
    for channel, values in series.items():
        _check_values(path, channel, values.value)
    first = [POWER] if POWER in series else [c for c in series if c in SENSORS] or list(series)
    zero_s = min(series[channel].time_s[0] for channel in first)
    times = {id(s.time_s): s.time_s for s in series.values()}  # channels of a CSV share theirs: shifted once
    since_zero = {key: time_s - zero_s if zero_s else time_s for key, time_s in times.items()}
    run = Run(
        name=name_of(path),
        path=path,
        sha256=_digest(path),
        series={c: Series(since_zero[id(s.time_s)], c.recorded.to_si(s.value)) for c, s in series.items()},
        experiment=experiment,
        markers=tuple(replace(marker, time_s=marker.time_s - zero_s) for marker in markers),
    )
    return without_unknown_power(run)


def _series(path: Path, time: Floats, value: Floats, channel: Channel) -> Series:
    """The series as recorded. Raises LceError if it is short, not finite, or its time does not increase."""
    _check_length(path, channel, time.size)
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


def _check_length(path: Path, channel: Channel, samples: int) -> None:
    fewest = 1 if channel.sets else FEWEST_SAMPLES
    if samples < fewest:
        raise LceError(f"{path}: {channel.name} has {samples} samples; {fewest} are the least that say anything")


def _check_values(path: Path, channel: Channel, value: Floats) -> None:
    """Raise LceError for values [recorded unit] that no bench gives, because a unit was mistaken."""
    low, median, high = float(value.min()), float(np.median(value)), float(value.max())
    unit = channel.recorded.symbol
    if low < channel.lowest:
        raise LceError(f"{path}: {channel.name} of {low:g} {unit}; {channel.hint}")
    lasting, among = float(np.quantile(value, 0.05)), channel.mistaken
    if median > channel.largest_median or (among and among[0] < lasting and high < among[1]):
        raise LceError(f"{path}: {channel.name} around {median:.0f} {unit}; {channel.hint}")
    if high > channel.largest:
        raise LceError(f"{path}: {channel.name} of {high:g} {unit}; {channel.hint}")


def _digest(path: Path) -> str:
    files = [path] if path.is_file() else sorted(p for p in path.iterdir() if p.suffix in (".mcap", ".db3"))
    digest = hashlib.sha256()
    for file in files:
        with file.open("rb") as opened:
            while block := opened.read(1 << 20):
                digest.update(block)
    return digest.hexdigest()
