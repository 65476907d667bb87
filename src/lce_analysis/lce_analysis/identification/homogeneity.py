# SPDX-License-Identifier: Apache-2.0
"""Are these runs of one strip under one laser? Each run is fitted alone, before all of them share one parameter set."""

from collections.abc import Sequence
from statistics import median
from typing import Final

from lce_analysis.identification.identify import fit_each
from lce_analysis.options import FitOptions
from lce_analysis.prediction import excited
from lce_data.progress import Progress
from lce_data.run import Run
from lce_model import Model, default_model

COMPARED: Final = {"lumped.gain": "K/W", "lumped.tau": "s"}


def outlier_runs(runs: Sequence[Run], progress: Progress, options: FitOptions = FitOptions()) -> tuple[str, ...]:
    """A sentence for each run whose own lumped thermal model differs from the others'; empty if they agree.

    If two runs differ from each other, both are named: the data do not say which of them is the outlier.
    """
    comparable = [r for r in runs if r.power is not None and r.temperature is not None and excited(r, options)]
    own_models = [found.model for found in fit_each(default_model("lumped", "none"), comparable, progress=progress)]
    sentences = []
    for i, run in enumerate(comparable):
        others = [model for j, model in enumerate(own_models) if j != i]
        if differing := [text for key in COMPARED if (text := _difference(own_models[i], others, key, options))]:
            values = " and ".join(differing)
            sentences.append(
                f"{run.name} alone has {values}: is it of another strip, or does the model lack an effect?"
            )
    return tuple(sentences)


def _difference(model: Model, others: Sequence[Model], key: str, options: FitOptions) -> str:
    """The parameter of the model and of the others in words, if all determine it and it differs, else empty."""
    known = [m[key] for m in others if _determines(m, key, options)]
    if not known or not _determines(model, key, options):
        return ""
    if 1.0 / options.outlier_factor < model[key] / median(known) < options.outlier_factor:
        return ""
    return f"{key} = {model[key]:.3g} {COMPARED[key]} (the other runs {median(known):.3g})"


def _determines(model: Model, key: str, options: FitOptions) -> bool:
    value = model.values[model.index(key)]
    return value.standard_error is not None and value.standard_error < options.outlier_error * value.value
