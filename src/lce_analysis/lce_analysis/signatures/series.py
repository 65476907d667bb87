# SPDX-License-Identifier: Apache-2.0
"""What signatures are looked for in: one measured series beside its model, with the covariates at its samples."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_analysis.covariates import covariates_on_grid
from lce_analysis.jumps import away_from, discontinuities
from lce_analysis.options import Drive
from lce_analysis.prediction import (
    COLUMN,
    MECHANICAL,
    STATE,
    SimulationInput,
    measured_drive,
    model_of_run,
    simulation_input,
    start_temperature,
)
from lce_data.channels import TEMPERATURE, Channel
from lce_data.noise import noise_floor
from lce_data.run import Run
from lce_model import Model

Floats = NDArray[np.float64]


SWITCH: Final = 0.02
"""A change of the power by more than this share of its range is a jump of it."""


@dataclass(frozen=True)
class ResidualSeries:
    """One sensor in one run; all arrays (n,), in SI units, at the times of the sensor.

    run : its name.
    measured, modelled : what the sensor showed, and what it should have shown.
    noise : RMS noise of the sensor.
    covariates : by the names of ``lce_analysis.covariates``, along the model's trajectory.
    counted : False near a jump of the model, where the side that a sample is on would decide.
    turning : True where the laser power jumps, or the temperature turns, that of the model or the measured one.
    unpredicted : of a displacement, what the model makes of the measured temperature less what it makes of its own
        [m]; None where that is not known.
    driven : did the measured temperature drive the model?
    """

    run: str
    channel: Channel
    time_s: Floats
    measured: Floats
    modelled: Floats
    noise: float
    covariates: Mapping[str, Floats] = field(default_factory=dict)
    counted: NDArray[np.bool_] = field(default_factory=lambda: np.empty(0, dtype=bool))
    turning: NDArray[np.bool_] = field(default_factory=lambda: np.empty(0, dtype=bool))
    unpredicted: Floats | None = None
    driven: bool = False

    def __post_init__(self) -> None:
        if self.counted.size == 0:
            object.__setattr__(self, "counted", np.ones(self.time_s.size, dtype=bool))
        if self.turning.size == 0:
            object.__setattr__(self, "turning", np.zeros(self.time_s.size, dtype=bool))

    @property
    def residual(self) -> Floats:
        """Measured minus modelled (n,), 0 where it does not count."""
        return np.where(self.counted, self.measured - self.modelled, 0.0)

    @property
    def step_s(self) -> float:
        """Median time from sample to sample [s]."""
        return float(np.median(np.diff(self.time_s)))

    def thinned(self, most: int) -> "ResidualSeries":
        """At most so many samples, evenly taken."""
        keep = slice(None, None, -(-self.time_s.size // most))
        return replace(
            self,
            time_s=self.time_s[keep],
            measured=self.measured[keep],
            modelled=self.modelled[keep],
            covariates={name: x[keep] for name, x in self.covariates.items()},
            counted=self.counted[keep],
            turning=self.turning[keep],
            unpredicted=None if self.unpredicted is None else self.unpredicted[keep],
        )


def residual_series(model: Model, runs: Sequence[Run], drive: Drive = "model") -> tuple[ResidualSeries, ...]:
    """Every measured series that the model predicts, beside the model.

    Parameters
    ----------
    model : with the values of single runs, where parameters vary from run to run.
    runs : what was measured.
    drive : what drives the deformation; the temperature is always that of the model itself.

    Raises
    ------
    LceError
        If a run lacks what the model needs.
    """
    return tuple(series for run in runs for series in _of_run(model_of_run(model, run), run, drive))


def _of_run(model: Model, run: Run, drive: Drive) -> list[ResidualSeries]:
    run_input = simulation_input(run, model)
    start_k = start_temperature(run_input, model)
    row, starts = model.vector[None], np.array([start_k])
    own = run_input.simulate(model, row, starts)[0]
    by_measured = None
    both = model.thermal != "none" and any(c in MECHANICAL and model.predicts(c) for c in run.measured)
    if both and run.temperature is not None and run.power is not None:
        by_measured = measured_drive(run_input, model, start_k).simulate(model, row, starts)[0]
    trajectories = _Trajectories(run_input, own, by_measured, drive)
    hidden = () if run.power is not None and not run_input.driven else (TEMPERATURE,)
    return [trajectories.beside(c) for c in run.measured if model.predicts(c) and c not in hidden]


@dataclass(frozen=True)
class _Trajectories:
    """What the kernel returned for a run (n, len(RECORDED)): driven by the model's temperature, and by the measured."""

    run_input: SimulationInput
    own: Floats
    by_measured: Floats | None
    drive: Drive

    def beside(self, channel: Channel) -> ResidualSeries:
        """One sensor beside the trajectory that it is compared with."""
        run_input, series = self.run_input, self.run_input.run.measured[channel]
        sampling, behind, noise = run_input.sampling[channel], channel in MECHANICAL, noise_floor(series)
        out, moved, driven = self.own, None, False
        if behind and self.by_measured is not None:
            place = STATE["displacement"]
            moved = np.asarray(sampling(self.by_measured[:, place] - self.own[:, place]))
            driven = self.drive == "measured"
            out = self.by_measured if driven else self.own
        known = {name: np.asarray(sampling(x)) for name, x in covariates_on_grid(run_input, out).items()}
        jumps = discontinuities(run_input.time_s, out[:, COLUMN[channel]], noise) if behind else np.empty(0)
        return ResidualSeries(
            run=run_input.run.name,
            channel=channel,
            time_s=series.time_s,
            measured=series.value,
            modelled=np.asarray(sampling(out[:, COLUMN[channel]])),
            noise=noise,
            covariates={**known, "branch": np.where(known["branch"] > 0.0, 1.0, -1.0)},
            counted=away_from(jumps, series.time_s),
            turning=_first_behind(series.time_s, run_input.time_s[self._turns]),
            unpredicted=moved,
            driven=driven,
        )

    @property
    def _turns(self) -> NDArray[np.bool_]:
        """Where on the grid (n,) the laser power jumps, or the temperature turns, modelled or measured."""
        power_w = self.run_input.power_w
        turns = np.abs(np.diff(power_w, prepend=power_w[0])) > SWITCH * max(float(np.ptp(power_w)), 1e-12)
        for out in (self.own, self.by_measured):
            if out is not None:
                direction, temperature = out[:, STATE["direction"]], out[:, STATE["temperature"]]
                known = np.isfinite(direction).all()
                branch = np.where((direction if known else np.gradient(temperature)) >= 0.0, 1.0, -1.0)
                turns |= np.diff(branch, prepend=branch[0]) != 0.0
        return np.asarray(turns)


def _first_behind(time_s: Floats, events_s: Floats) -> NDArray[np.bool_]:
    """Which samples (n,) are the first at or behind an event."""
    found = np.zeros(time_s.size, dtype=bool)
    place = np.searchsorted(time_s, events_s)
    found[place[place < time_s.size]] = True
    return found


def energy(series: Sequence[ResidualSeries]) -> float:
    """Sum of the squared residuals, in units of the noise of each series."""
    return float(sum(np.sum((s.residual / s.noise) ** 2) for s in series))


def misfit(series: Sequence[ResidualSeries]) -> float:
    """RMS residual over the noise, of the samples that count; 1 is nothing but noise."""
    count = sum(int(s.counted.sum()) for s in series)
    return float(np.sqrt(energy(series) / max(count, 1)))
