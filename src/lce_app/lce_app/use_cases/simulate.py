# SPDX-License-Identifier: Apache-2.0
"""Simulate a model without ROS: a waveform of the laser power in, a CSV run out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import lce_model
from lce_data.channels import POWER, SENSORS
from lce_data.errors import LceError
from lce_data.run_csv import write_run_csv
from lce_data.wave_file import read_wave
from lce_experiment import protocols

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Options:
    """What is changed of the model, and whether a file may be replaced.

    Parameters
    ----------
    settings : values by TERM.PARAM, in the units of the model; a parameter of an effect adds the effect.
    overwrite : replace a file that exists.
    """

    settings: Mapping[str, float] = field(default_factory=dict)
    overwrite: bool = False


@dataclass(frozen=True)
class Simulated:
    """The file that was written, and the model's account of the waveform."""

    file: Path
    trajectory: lce_model.Trajectory


DEFAULTS = Options()


def simulate(model_file: Path, wave: str, out: Path, options: Options = DEFAULTS) -> Simulated:
    """Simulate what the sensors would show of a waveform, and write it as a CSV run.

    Parameters
    ----------
    model_file : as `lce fit` writes it.
    wave : a CSV file with the columns ``time_s,power_w``, or a protocol. Each power is held until the next time; a
        wave with steps longer than 10 ms is resampled at 100 Hz.
    out : CSV file to write: ``time_s,power_w`` and a column for each channel that the model predicts.
    options : what is changed of the model.

    Returns
    -------
    Simulated
        The file and the trajectory.

    Raises
    ------
    LceError
        If ``out`` exists and may not be replaced, the model or the wave cannot be used, or a value is not finite.

    Examples
    --------
    >>> from pathlib import Path
    >>> simulate(Path("model.yaml"), "pulse:amp=0.4,th=20", Path("run.csv"))  # doctest: +SKIP
    """
    if out.exists() and not options.overwrite:
        raise LceError(f"{out}: exists already, and overwrite is not set")
    model = lce_model.load_model(model_file).configured(options.settings)
    time_s, power_w = _input(wave)
    trajectory = lce_model.simulate(model, time_s, power_w)
    shown = {POWER: power_w, **{channel: trajectory[channel] for channel in SENSORS if model.predicts(channel)}}
    for channel, values in shown.items():
        if not np.isfinite(values).all():
            raise LceError(f"{model_file}: {channel.column} is not finite under {wave}")
    write_run_csv(out, time_s, shown)
    return Simulated(out, trajectory)


def _input(text: str) -> tuple[Floats, Floats]:
    """Time [s] and power [W] of a wave file or a protocol, in steps of 10 ms at most."""
    if Path(text).suffix.lower() == ".csv":
        time_s, power_w = read_wave(Path(text))
        if time_s.size > 1 and np.diff(time_s).max() <= 1.001 / protocols.RATE_HZ:
            return time_s, power_w
    wave = protocols.one(text)
    return wave.time_s, wave.power_w
