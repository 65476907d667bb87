# SPDX-License-Identifier: Apache-2.0
"""Optional inputs that effects read, such as the load: which runs lack them, what supplies them, and their noise."""

import math
from collections.abc import Iterable, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from lce_data.channels import AMBIENT, Channel
from lce_data.errors import LceError
from lce_data.run import Run, Series
from lce_model import Model
from lce_model.effects import Effect
from lce_model.terms import Term, inputs_of

Floats = NDArray[np.float64]

WINDOWS: Final = (513, 257, 129, 65, 33, 17)
"""Samples in which a cubic may stand for an input."""
NOISELESS: Final = 1e-5
"""Noise of an input that does no harm, as a share of its largest value."""
ONLY_NOISE: Final = 1.1
"""What smoothing takes away may be so many times the noise."""
PLAY: Final = 0.3
"""What is left of the noise, as a share of it."""
MAD_TO_RMS: Final = 1.4826
THIRD_DIFFERENCE_GAIN: Final = math.sqrt(20.0)
"""Standard deviation of the third differences of white noise over that of the noise."""


def check_inputs(run: Run, terms: Iterable[Term]) -> None:
    """Raise LceError if the run lacks an optional input that a term reads; names the run, the effect and the input."""
    for term in terms:
        for channel in inputs_of((term,)):
            if channel not in run.inputs:
                raise LceError(_missing(term, channel, (run,)))


def acting(model: Model) -> tuple[Term, ...]:
    """The terms of a model without the effects that are at their null value."""
    return tuple(t for t in model.terms if not isinstance(t, Effect) or _acts(t, model))


def _acts(effect: Effect, model: Model) -> bool:
    return any(model[f"{effect.name}.{name}"] != effect.parameter(name).default for name in effect.amplitudes)


def lacks(effect: Effect, runs: Sequence[Run]) -> str:
    """Why the runs say nothing of an effect that reads optional inputs, in a sentence; empty if they may.

    A run may lack what the effect reads. Where an input is one number throughout, an effect of the library is nothing
    but another value of a parameter of the strip, because it acts by the difference from a reference.
    """
    for channel in inputs_of((effect,)):
        without = [run for run in runs if channel not in run.inputs]
        if without:
            return _missing(effect, channel, without)
        values = np.concatenate([run.inputs[channel].value for run in runs])
        if not effect.path and np.ptp(values) == 0.0:
            value = f"{channel.display.from_si(float(values[0])):g} {channel.display.symbol}"
            return f"{effect.name} needs a {_word(channel)} that changes; it is {value} throughout"
    return ""


def differs_between_runs_only(effect: Effect, runs: Sequence[Run]) -> bool:
    """Does the effect read inputs, each of them one number in every run? Then no run by itself shows its strength."""
    read = [run.inputs[channel].value for channel in inputs_of((effect,)) for run in runs if channel in run.inputs]
    return bool(read) and all(np.ptp(value) == 0.0 for value in read)


def without_noise(series: Series) -> Floats:
    """Values (n,) of an optional input with less noise; as they are where there is hardly any.

    A load that jitters would turn the branch of a model at every sample. Local cubics (Savitzky and Golay) run over the
    most samples in which they leave no more than the noise; the median does not see a step of the load. What is left
    follows with a play, so that a load at rest rests.
    """
    value = series.value
    if value.size < WINDOWS[-1]:
        return value
    noise = MAD_TO_RMS * float(np.median(np.abs(np.diff(value, 3)))) / THIRD_DIFFERENCE_GAIN
    if noise <= NOISELESS * float(np.max(np.abs(value))):
        return value
    for window in (w for w in WINDOWS if w <= value.size):
        smooth = np.asarray(savgol_filter(value, window, 3))
        if MAD_TO_RMS * float(np.median(np.abs(value - smooth))) <= ONLY_NOISE * noise:
            return _with_play(smooth, PLAY * noise)
    return value


def _with_play(value: Floats, width: float) -> Floats:
    """The values (n,), followed only where they leave a band of ``width`` to either side of the last one."""
    followed, last = np.empty_like(value), float(value[0])
    for i, now in enumerate(value.tolist()):
        last = min(max(last, now - width), now + width)
        followed[i] = last
    return followed


def _missing(term: Term, channel: Channel, runs: Sequence[Run]) -> str:
    names = ", ".join(run.name for run in runs)
    return (
        f"{names}: no {_word(channel)} was recorded, which {term.name} reads; record the topic {channel.topic}, "
        f"or give a column {channel.column}, or {channel.column} in the conditions"
    )


def _word(channel: Channel) -> str:
    return "room temperature" if channel is AMBIENT else channel.name
