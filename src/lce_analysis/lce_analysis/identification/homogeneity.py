# SPDX-License-Identifier: Apache-2.0
"""Are these runs of one strip under one laser? Each run is asked alone, before all of them share one parameter set."""

from collections.abc import Sequence
from statistics import median
from typing import Final

from lce_analysis.identification.identify import fit_each
from lce_analysis.prediction import excited
from lce_data.progress import Progress
from lce_data.run import Run
from lce_model import Model, default_model

APART: Final = 1.2
"""Factor between a run and the median of the others from which it is called another strip."""
KNOWN: Final = 0.05
"""Relative standard error from which a run does not know a parameter well enough to be asked."""
ASKED: Final = {"lumped.gain": "K/W", "lumped.tau": "s"}


def outlier_runs(runs: Sequence[Run], progress: Progress) -> tuple[str, ...]:
    """A sentence for each run whose lumped thermal model is not that of the others, empty where they agree.

    Of two runs that differ both are named: which one is the stranger nobody can tell.
    """
    asked = [r for r in runs if r.power is not None and r.temperature is not None and excited(r)]
    alone = [found.model for found in fit_each(default_model("lumped", "none"), asked, progress=progress)]
    sentences = []
    for i, run in enumerate(asked):
        others = [model for j, model in enumerate(alone) if j != i]
        if told := [text for key in ASKED if (text := _apart(alone[i], others, key))]:
            sentences.append(
                f"{run.name} alone has {' and '.join(told)}: is it of another strip, or does the model lack an effect?"
            )
    return tuple(sentences)


def _apart(model: Model, others: Sequence[Model], key: str) -> str:
    """The parameter of the model and of the others in words, where all know it and it differs; else empty."""
    known = [m[key] for m in others if _knows(m, key)]
    if not known or not _knows(model, key) or 1.0 / APART < model[key] / median(known) < APART:
        return ""
    return f"{key} = {model[key]:.3g} {ASKED[key]} (the other runs {median(known):.3g})"


def _knows(model: Model, key: str) -> bool:
    value = model.values[model.index(key)]
    return value.standard_error is not None and value.standard_error < KNOWN * value.value
