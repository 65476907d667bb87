# SPDX-License-Identifier: Apache-2.0
"""Optional inputs that effects read, such as the load: which runs lack them, and what would supply them."""

from collections.abc import Iterable, Sequence

import numpy as np

from lce_data.channels import AMBIENT, Channel
from lce_data.errors import LceError
from lce_data.run import Run
from lce_model import Model
from lce_model.effects import Effect
from lce_model.terms import Term, inputs_of


def check_inputs(run: Run, terms: Iterable[Term]) -> None:
    """Raise LceError if the run lacks an optional input that a term reads; names the run, the effect and the input."""
    for term in terms:
        for channel in inputs_of((term,)):
            if channel not in run.inputs:
                raise LceError(_missing(term, channel, (run,)))


def acting(model: Model) -> tuple[Term, ...]:
    """The terms of a model without the effects that are at their null value."""
    return tuple(t for t in model.terms if not isinstance(t, Effect) or model[t.strength_key] != t.null)


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


def _missing(term: Term, channel: Channel, runs: Sequence[Run]) -> str:
    names = ", ".join(run.name for run in runs)
    return (
        f"{names}: no {_word(channel)} was recorded, which {term.name} reads; record the topic {channel.topic}, "
        f"or give a column {channel.column}, or {channel.column} in the conditions"
    )


def _word(channel: Channel) -> str:
    return "room temperature" if channel is AMBIENT else channel.name
