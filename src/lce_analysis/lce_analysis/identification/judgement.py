# SPDX-License-Identifier: Apache-2.0
"""Does a fit describe its data? If not, which built-in model would do better on data that were left out?

The measure is the NRMSE of a channel, √(Σe²/Σ(y - ȳ)²) over all runs, ȳ the mean of each run: the share of the spread
that is left. Left out is one run after the other, or, where runs are few, blocks of time.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Final

import numpy as np

from lce_analysis.identification.at_bounds import left
from lce_analysis.identification.identify import fit
from lce_analysis.identification.parallel import each
from lce_analysis.identification.result import FitResult
from lce_analysis.identification.stages import acts_on_temperature, thermal_stage
from lce_analysis.options import FitOptions
from lce_analysis.prediction import predict
from lce_data.channels import DISPLACEMENT, POWER, SENSORS, TEMPERATURE, Channel
from lce_data.errors import LceError
from lce_data.noise import sensor_noise
from lce_data.progress import Progress, silent
from lce_data.run import Run, Series
from lce_model import Model, default_model
from lce_model.effects import find

DESCRIBES: Final = 0.2
"""NRMSE above which a model does not describe a channel."""
ABOVE_NOISE: Final = 2.0
"""It does so anyway where the error is not so many times the noise."""
BETTER: Final = 0.9
"""A model does better if its error on data left out is less than this share of the present one's."""
EQUAL: Final = 0.95
"""Two models do equally well if their errors differ by less than this factor: then the simpler one is named."""
FOLDS: Final = {TEMPERATURE: 4, DISPLACEMENT: 2}
"""Parts of the data that are left out one after the other, at most; models of the displacement take longer."""
THERMAL: Final = {
    "lumped": ("lumped", ()),
    "lumped + second_mass": ("lumped", ("second_mass",)),
    "hammerstein_wiener": ("hammerstein_wiener", ()),
}
"""Built-in models of the temperature, of different structure: name to thermal stage and effects."""
DEFORMATION: Final = ("equilibrium", "kinetic", "prandtl_ishlinskii", "bouc_wen")
"""Built-in models of the displacement that are identified in seconds."""
SAMPLES: Final = 3000
"""Samples of each series of a run that are compared, at most."""
GUESSES: Final = 400
STARTS: Final = 4
"""Of a search that is to compare models, not to publish one."""


@dataclass(frozen=True)
class Rival:
    """A model and its NRMSE on data left out; infinite if it cannot be fitted to these runs."""

    name: str
    option: str
    held_out: float


@dataclass(frozen=True)
class ChannelJudgement:
    """A channel that the model does not describe.

    Attributes
    ----------
    channel : which.
    left : NRMSE of the fit.
    by : what was left out: "run by run" or "block by block".
    rivals : the model of the fit first, then built-in ones; empty if none were compared.
    """

    channel: Channel
    left: float
    by: str = ""
    rivals: tuple[Rival, ...] = ()

    @property
    def best(self) -> Rival | None:
        """The rival that does better on data left out, the first of those that do so equally; None if none does."""
        if not self.rivals:
            return None
        own, *others = self.rivals
        least = min((rival.held_out for rival in others), default=math.inf)
        best = next((rival for rival in others if rival.held_out <= least / EQUAL), own)
        return best if best.held_out < BETTER * own.held_out else None

    @property
    def sentences(self) -> tuple[str, ...]:
        """What is left of the spread, the errors of the rivals on data left out, and what to do."""
        name = self.channel.name
        told = [
            f"This model does not describe the {name}: {self.left:.0%} of its spread is left (NRMSE; above "
            f"{DESCRIBES:.0%} is too much)."
        ]
        if self.rivals:
            errors = ", ".join(f"{r.name} {_percent(r.held_out)}" for r in self.rivals)
            told.append(f"NRMSE of the {name} left out, {self.by}: {errors}.")
            told.append(self._advice)
        return tuple(told)

    @property
    def _advice(self) -> str:
        if self.best is None:
            return (
                "No built-in model does better: runs may differ from each other, or something changes on the way "
                "(lce diagnose)."
            )
        either = ", and does not describe it either" if self.best.held_out > DESCRIBES else ""
        return f"{self.best.name} does better{either}: {self.best.option}."

    def as_json(self) -> dict[str, Any]:
        """For the record of the fit."""
        return {
            "channel": self.channel.name,
            "nrmse": round(self.left, 6),
            "left_out": self.by,
            "held_out_nrmse": {r.name: _rounded(r.held_out) for r in self.rivals},
            "better": self.best.name if self.best else None,
        }


def poor_channels(result: FitResult) -> dict[Channel, float]:
    """NRMSE of the channels of which a fit leaves more than ``DESCRIBES``, and more than twice the noise."""
    runs = [run_input.run for run_input in result.problem.inputs]
    noise, problem = sensor_noise(runs, SENSORS), result.problem
    rms = {c: problem.series_rms(problem.first(), c) for c in SENSORS}
    return {c: x for c, x in left(problem).items() if x > DESCRIBES and rms[c] > ABOVE_NOISE * noise[c]}


def judge(
    result: FitResult,
    runs: Sequence[Run],
    options: FitOptions = FitOptions(),
    progress: Progress = silent,
    compared: bool = True,
) -> tuple[ChannelJudgement, ...]:
    """Say which channels a fit does not describe, and which built-in models would do better.

    Parameters
    ----------
    result : of a fit to ``runs``.
    runs : the same.
    options : seed and drive of the fit.
    progress : called after each step; an exception that it raises passes through.
    compared : fit the built-in models, too; takes seconds to minutes.

    Returns
    -------
    tuple of ChannelJudgement
        Empty if the model describes its data. The displacement is compared only where the temperature is described.
    """
    poor = poor_channels(result)
    found = []
    for channel, share in poor.items():
        own = ChannelJudgement(channel, share)
        comparable = channel in (TEMPERATURE, DISPLACEMENT) and not (channel is DISPLACEMENT and TEMPERATURE in poor)
        found.append(_compared(own, result.model, runs, options, progress) if compared and comparable else own)
    return tuple(found)


def _compared(
    own: ChannelJudgement, model: Model, runs: Sequence[Run], options: FitOptions, progress: Progress
) -> ChannelJudgement:
    """The same with the errors of all rivals on data left out."""
    models = _thermal(model) if own.channel is TEMPERATURE else _deformation(model)
    usable = [_thinned(run) for run in runs if own.channel in run.series]
    folds = tuple(_folds(usable, own.channel))
    quick = replace(options, random_guesses=GUESSES, starts=STARTS)
    tasks = [partial(_errors, m, fold, own.channel, quick) for _, _, m in models for fold in folds]
    sums = np.array(list(each(tasks, "built-in models", progress))).reshape(len(models), len(folds), 2).sum(axis=1)
    errors = [math.sqrt(e / total) if total > 0.0 else math.nan for e, total in sums.tolist()]
    rivals = tuple(Rival(name, option, e) for (name, option, _), e in zip(models, errors, strict=True))
    return replace(own, by="block by block" if len(usable) == 1 else "run by run", rivals=rivals)


def _thermal(model: Model) -> list[tuple[str, str, Model]]:
    """Name, option and model of the temperature: that of the fit, and built-in ones of other structure."""
    own = thermal_stage(model)
    name = " + ".join((own.thermal, *own.effect_names))
    rivals = [
        (name, " ".join([f"--thermal {thermal}", *(f"--effect {e}" for e in effects)]), thermal, effects)
        for name, (thermal, effects) in THERMAL.items()
    ]
    others = [(n, option, default_model(thermal, "none", effects)) for n, option, thermal, effects in rivals]
    return [(name, "", own), *(r for r in others if r[0] != name)]


def _deformation(model: Model) -> list[tuple[str, str, Model]]:
    """Name, option and model of the displacement, driven by the measured temperature."""
    effects = tuple(e for e in model.effects if not acts_on_temperature(find(e)))
    own = default_model("none", model.deformation, effects)
    own = own.set({v.key: v.value for v in model.values if v.key in own})
    length = {"strip.length": model["strip.length"]}
    others = [d for d in DEFORMATION if d != model.deformation or effects]
    rivals = [(d, f"--deformation {d}", default_model("none", d).set(length)) for d in others]
    return [(" + ".join((own.deformation, *own.effect_names)), "", own), *rivals]


def _thinned(run: Run) -> Run:
    """The run with fewer samples where it has many; power and temperature are means over what they stand for."""
    for channel, series in run.series.items():
        every = math.ceil(series.value.size / SAMPLES)
        if every > 1:
            first = np.arange(0, series.value.size, every)
            counts = np.diff(np.append(first, series.value.size))
            # A power is held until the next sample; a sensor is read in the middle of what its mean stands for.
            time = series.time_s[first] if channel is POWER else np.add.reduceat(series.time_s, first) / counts
            run = run.with_series(channel, Series(time, np.add.reduceat(series.value, first) / counts))
    return run


@dataclass(frozen=True)
class _Fold:
    """Runs to fit, and runs with the samples to judge by."""

    train: tuple[Run, ...]
    test: tuple[Run, ...]
    judged: tuple[np.ndarray[Any, np.dtype[np.bool_]], ...]


def _folds(runs: Sequence[Run], channel: Channel) -> Iterator[_Fold]:
    """Each run left out, several at once where they are many; of a single run, blocks of time."""
    if len(runs) > 1:
        count = min(FOLDS[channel], len(runs))
        for i in range(count):
            test = tuple(runs[i::count])
            every = tuple(np.ones(run.series[channel].value.size, dtype=np.bool_) for run in test)
            yield _Fold(tuple(run for run in runs if run not in test), test, every)
        return
    for run in runs:
        series = run.series[channel]
        for part in np.array_split(np.arange(series.value.size), FOLDS[channel]):
            out = np.zeros(series.value.size, dtype=np.bool_)
            out[part] = True
            kept = Series(series.time_s[~out], series.value[~out])
            yield _Fold((run.with_series(channel, kept),), (run,), (out,))


def _errors(
    model: Model, fold: _Fold, channel: Channel, options: FitOptions, progress: Progress
) -> tuple[float, float]:
    """Squared error of the samples left out, and their squared distance from the mean of their run."""
    try:
        found = fit(model, fold.train, options, progress)
        if found.interrupted:
            raise KeyboardInterrupt
        error = spread = 0.0
        for run, judged in zip(fold.test, fold.judged, strict=True):
            value = run.series[channel].value
            said = predict(found.model, run).at_samples[channel]
            error += float(np.sum((said - value)[judged] ** 2))
            spread += float(np.sum((value - value.mean())[judged] ** 2))
    except LceError:
        return math.inf, 1.0
    return error, spread


def _rounded(share: float) -> float | None:
    return round(share, 6) if math.isfinite(share) else None


def _percent(share: float) -> str:
    return f"{share:.1%}" if math.isfinite(share) else "–"
