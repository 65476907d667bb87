# SPDX-License-Identifier: Apache-2.0
"""The one metric of the diagnosis: squared errors in units of the noise of the sensor that measured.

Models are fitted in it, judged by it, and it is what tables show. The noise of a series comes from the series alone
(:func:`lce_data.noise.noise_floor`), so `lce compare` prints the same numbers for the same model.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_analysis.jumps import away_from, discontinuities
from lce_analysis.options import Drive
from lce_analysis.prediction import MECHANICAL, predict, says_nothing
from lce_data.channels import SENSORS, Channel
from lce_data.noise import noise_floor
from lce_data.run import Run
from lce_model import Model

Floats = NDArray[np.float64]

NOISE: Final = 1.0
"""Mean square of a residual that is nothing but noise."""


@dataclass(frozen=True)
class Misfit:
    """Squared errors by channel and run; a channel that no run measured is absent.

    total : (runs,) sum of squares in units of the noise.
    samples : (runs,) how many.
    """

    total: Mapping[Channel, Floats]
    samples: Mapping[Channel, Floats]

    def mean_square(self, channel: Channel) -> float:
        """Over all runs together; 1 is nothing but noise."""
        return float(self.total[channel].sum() / self.samples[channel].sum())

    @property
    def rms(self) -> dict[Channel, float]:
        """RMS error of each channel over all runs together, in units of the noise."""
        return {channel: float(np.sqrt(self.mean_square(channel))) for channel in self.total}

    def above_noise(self, channel: Channel) -> float:
        """Mean square beyond the noise, at least 0."""
        return max(self.mean_square(channel) - NOISE, 0.0)

    def __add__(self, other: "Misfit") -> "Misfit":
        """Those of other runs, behind these."""
        both = dict.fromkeys([*self.total, *other.total])
        none = np.empty(0)
        return Misfit(
            {c: np.concatenate([self.total.get(c, none), other.total.get(c, none)]) for c in both},
            {c: np.concatenate([self.samples.get(c, none), other.samples.get(c, none)]) for c in both},
        )


@dataclass(frozen=True)
class JudgedRuns:
    """Runs, with the RMS noise [SI] of each of their series."""

    runs: tuple[Run, ...]
    noise: tuple[Mapping[Channel, float], ...]

    @classmethod
    def of(cls, runs: Sequence[Run]) -> "JudgedRuns":
        """Estimate the noise of every series."""
        return cls(tuple(runs), tuple({c: noise_floor(series) for c, series in run.measured.items()} for run in runs))

    def only(self, i: int) -> "JudgedRuns":
        """One of them."""
        return JudgedRuns((self.runs[i],), (self.noise[i],))

    def misfit(self, model: Model, drive: Drive = "model", channels: Sequence[Channel] = SENSORS) -> Misfit:
        """Simulate every run with the model. Raises LceError if a run lacks what the model needs."""
        return self._misfits([model], drive, channels)[0][0]

    def away_from_jumps(self, model: Model, drive: Drive) -> Misfit:
        """Errors of a model on the samples away from its jumps and those of the displacement."""
        return self._misfits([model], drive, SENSORS)[0][1]

    def pair(self, first: Model, second: Model, drive: Drive, channels: Sequence[Channel]) -> "Pair":
        """Errors of two models, on every sample and on those away from the jumps of both.

        Which side of a jump a sample is on is decided within a hundredth of a second, and would outweigh all the rest.
        """
        (before, judged_before), (after, judged_after) = self._misfits([first, second], drive, channels)
        return Pair(before, after, judged_before, judged_after)

    def _misfits(
        self, models: Sequence[Model], drive: Drive, channels: Sequence[Channel]
    ) -> list[tuple[Misfit, Misfit]]:
        """Errors of each model: on every sample, and on those away from the jumps of all."""
        rows: list[tuple[Channel, NDArray[np.bool_], list[Floats]]] = []
        for run, noise in zip(self.runs, self.noise, strict=True):
            if says_nothing(run, models[0]):
                continue
            predictions = [predict(model, run, drive).at_samples for model in models]
            for channel in (c for c in predictions[0] if c in channels):
                series, modelled = run.series[channel], [p[channel] for p in predictions]
                away = np.ones(series.value.size, dtype=bool)
                if channel in MECHANICAL:
                    jumps = [discontinuities(series.time_s, x, noise[channel]) for x in (series.value, *modelled)]
                    away = away_from(np.concatenate(jumps), series.time_s)
                rows.append((channel, away, [(m - series.value) / noise[channel] for m in modelled]))
        every = [(channel, np.ones_like(away), residuals) for channel, away, residuals in rows]
        return [(_summed(every, k), _summed(rows, k)) for k in range(len(models))]


def _summed(rows: Sequence[tuple[Channel, NDArray[np.bool_], Sequence[Floats]]], k: int) -> Misfit:
    """Errors of the model number ``k``, of the samples that count."""
    total: dict[Channel, list[float]] = {}
    samples: dict[Channel, list[float]] = {}
    for channel, counted, residuals in rows:
        total.setdefault(channel, []).append(float(np.sum(residuals[k][counted] ** 2)))
        samples.setdefault(channel, []).append(float(counted.sum()))
    return Misfit({c: np.array(x) for c, x in total.items()}, {c: np.array(x) for c, x in samples.items()})


@dataclass(frozen=True)
class Pair:
    """Errors without and with an effect.

    before, after : on every sample (of blocks left out, away from jumps); tables and sentences show these.
    judged_before, judged_after : away from the jumps of both models; these decide.
    """

    before: Misfit
    after: Misfit
    judged_before: Misfit
    judged_after: Misfit

    def __add__(self, other: "Pair") -> "Pair":
        """Those of other runs, behind these."""
        return Pair(
            self.before + other.before,
            self.after + other.after,
            self.judged_before + other.judged_before,
            self.judged_after + other.judged_after,
        )


def share_removed(before: Misfit, after: Misfit, channel: Channel) -> float:
    """Share of a channel's squared error above the noise that went: :func:`share_of` its mean squares."""
    return share_of(before.mean_square(channel), after.mean_square(channel))


def share_of(before: float, after: float) -> float:
    """Share of a mean squared error above the noise that went; 0 where nothing was above it.

    A model that comes below the noise as estimated shows that the noise is no larger than what it leaves.
    """
    above = before - min(NOISE, after)
    return (before - after) / above if above > 0.0 else 0.0


def reduction_of(before: Mapping[Channel, float], after: Mapping[Channel, float]) -> float:
    """Share of the mean squared error above the noise that went, over all channels with the same weight."""
    above = sum(max(x - NOISE, 0.0) for x in before.values())
    return 1.0 - sum(max(after[c] - NOISE, 0.0) for c in before) / above if above > 0.0 else 0.0


def reduction(before: Misfit, after: Misfit, channels: Sequence[Channel]) -> float:
    """The same of two misfits, over the channels that both have."""
    shared = [c for c in channels if c in before.total and c in after.total]
    return reduction_of({c: before.mean_square(c) for c in shared}, {c: after.mean_square(c) for c in shared})
