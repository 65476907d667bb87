# SPDX-License-Identifier: Apache-2.0
"""Are these runs of one strip under one laser? Each run is fitted alone, before all of them share one parameter set."""

from collections.abc import Sequence
from statistics import median
from typing import Final

from lce_analysis.identification.identify import fit_each
from lce_analysis.prediction import excited
from lce_data.progress import Progress
from lce_data.run import Run
from lce_model import Model, default_model

OUTLIER_FACTOR: Final = 1.2
"""Factor between a run and the median of the others from which it is called another strip."""
KNOWN: Final = 0.05
"""Relative standard error above which a run does not determine a parameter well enough to be compared."""
COMPARED: Final = {"lumped.gain": "K/W", "lumped.tau": "s"}


def outlier_runs(runs: Sequence[Run], progress: Progress) -> tuple[str, ...]:
    """A sentence for each run whose lumped thermal model is not that of the others, none if they agree.

    Of two runs that differ both are named: nobody can tell which one is the outlier.
    """
    comparable = [r for r in runs if r.power is not None and r.temperature is not None and excited(r)]
    own_models = [found.model for found in fit_each(default_model("lumped", "none"), comparable, progress=progress)]
    sentences = []
    for i, run in enumerate(comparable):
        others = [model for j, model in enumerate(own_models) if j != i]
        if differing := [text for key in COMPARED if (text := _difference(own_models[i], others, key))]:
            values = " and ".join(differing)
            sentences.append(
                f"{run.name} alone has {values}: is it of another strip, or does the model lack an effect?"
            )
    return tuple(sentences)


def _difference(model: Model, others: Sequence[Model], key: str) -> str:
    """The parameter of the model and of the others in words, if all determine it and it differs, else empty."""
    known = [m[key] for m in others if _determines(m, key)]
    if not known or not _determines(model, key) or 1.0 / OUTLIER_FACTOR < model[key] / median(known) < OUTLIER_FACTOR:
        return ""
    return f"{key} = {model[key]:.3g} {COMPARED[key]} (the other runs {median(known):.3g})"


def _determines(model: Model, key: str) -> bool:
    value = model.values[model.index(key)]
    return value.standard_error is not None and value.standard_error < KNOWN * value.value
