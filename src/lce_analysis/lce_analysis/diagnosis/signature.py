# SPDX-License-Identifier: Apache-2.0
"""What an effect would change in the series of a run, beside the residual that it should explain."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from lce_analysis.prediction import predict
from lce_data.channels import Channel
from lce_data.run import Run
from lce_model import Model
from lce_model.effects import find, library

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Signature:
    """An effect in one measured series, all (n,) at the times of the series.

    Attributes
    ----------
    time_s : times of the samples [s].
    residual : measured minus model without the effect [SI unit of the channel].
    change : model with the effect minus model without it, before any refit [SI unit of the channel].
    """

    time_s: Floats
    residual: Floats
    change: Floats


def effect_signature(model: Model, run: Run, effect: str, settings: Mapping[str, float]) -> Mapping[Channel, Signature]:
    """Simulate a run without and with an effect, all other parameters as they are.

    The whole library is added to the model at its null values: a diagnosis that examined all of it has compiled that
    model already.

    Parameters
    ----------
    model : without the effect, or with it at its null value.
    run : what the effect should explain.
    effect : a name of the library, or the path of an effect file.
    settings : TERM.PARAM to value of the effect's parameters, as :attr:`Score.settings_at_expected_strength`.

    Returns
    -------
    Mapping from Channel to Signature
        One for each measured channel that the model predicts.

    Raises
    ------
    LceError
        If the effect or a parameter does not exist, or the run does not hold what the model needs.

    Examples
    --------
    >>> found = effect_signature(model, run, "creep", {"creep.share": 0.1})  # doctest: +SKIP
    >>> found[DISPLACEMENT].change  # doctest: +SKIP
    """
    candidates = dict.fromkeys([*(e.reference for e in library().values()), find(effect).reference])
    whole = reduce(Model.add, [reference for reference in candidates if reference not in model.effects], model)
    without, with_it = predict(whole, run).at_samples, predict(whole.set(settings), run).at_samples
    return {
        channel: Signature(series.time_s, series.value - without[channel], with_it[channel] - without[channel])
        for channel, series in run.measured.items()
        if channel in without
    }
