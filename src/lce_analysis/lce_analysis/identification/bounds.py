# SPDX-License-Identifier: Apache-2.0
"""Bounds of a search that come from the data."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from lce_data.errors import LceError
from lce_data.run import Run
from lce_model import Model, Value
from lce_model.effects import Effect

BEYOND_K: Final = 100.0
"""A temperature of the model may lie so far outside those that were measured."""
ABSOLUTE_K: Final = 100.0
"""A parameter in K whose bounds begin above this is a temperature, and not a difference of two."""


def is_temperature(value: Value) -> bool:
    """Is the parameter an absolute temperature?"""
    return value.unit == "K" and value.parameter.lower > ABSOLUTE_K


def reaching(model: Model, runs: Sequence[Run]) -> Model:
    """The model with bounds that hold the temperatures of the runs, where a temperature has its default bounds.

    The defaults are those of a strip near 28 °C; a wire or an oven is hotter. The surroundings are near the coldest
    temperature measured. Bounds that somebody set stay.

    Parameters
    ----------
    model : what is to be fitted.
    runs : those without a temperature say nothing.

    Returns
    -------
    Model
        Its temperatures are searched between the default bounds, or as far as 100 K beyond what was measured.
    """
    measured = [run.temperature.value for run in runs if run.temperature is not None]
    if not measured:
        return model
    coldest = min(float(np.quantile(t, 0.01)) for t in measured)
    hottest = max(float(np.quantile(t, 0.99)) for t in measured)
    reach = {v.key: coldest if v.term == "ambient" else hottest for v in model.values}
    return replace(model, values=tuple(_reaching(v, coldest, reach[v.key]) for v in model.values))


def bounded(
    model: Model, candidates: Sequence[Effect], bounds: Mapping[str, tuple[float, float]]
) -> tuple[Model, tuple[Effect, ...]]:
    """The model and the effects that it may be given, their parameters TERM.PARAM with other bounds.

    Raises LceError if there is no such parameter, or it cannot have these bounds.
    """
    own = {key: ends for key, ends in bounds.items() if key in model}
    of_effects: dict[str, dict[str, tuple[float, float]]] = {}
    for key, ends in bounds.items():
        if key not in own:
            term, _, name = key.partition(".")
            of_effects.setdefault(term, {})[name] = ends
    known = [effect.name for effect in candidates]
    for term in of_effects:
        if term not in known:
            raise LceError(f"bounds of {term}: neither the model nor the effects have it")
    return model.hold(own), tuple(effect.bounded(of_effects.get(effect.name, {})) for effect in candidates)


def _reaching(value: Value, coldest: float, hottest: float) -> Value:
    default = value.parameter
    if not is_temperature(value) or (value.lower, value.upper) != (default.lower, default.upper):
        return value
    # A strip of the bench lies within the default bounds, and is searched as ever.
    lower = default.lower if coldest > default.lower else max(coldest - BEYOND_K, 1.0)
    upper = default.upper if hottest < default.upper else hottest + BEYOND_K
    return replace(value, lower=lower, upper=upper)
