# SPDX-License-Identifier: Apache-2.0
"""The report of `lce compare`: the misfit, where the error sits, every run, the model."""

from lce_analysis.comparison.compare import Comparison
from lce_analysis.comparison.predictive_check import PredictiveCheck
from lce_analysis.options import CompareOptions
from lce_model import Model
from lce_report.blocks import Details, Section, Table
from lce_report.figures.errors import dissertation_measures, misfit, where
from lce_report.figures.predictive_check import predictive_check_section
from lce_report.figures.run import run_section
from lce_report.html.render import render
from lce_report.pages.footer import model_name, provenance


def render_comparison(comparison: Comparison, check: PredictiveCheck | None = None) -> str:
    """A model beside runs as one self-contained HTML file.

    Parameters
    ----------
    comparison : misfit by run and channel, in °C or SI; the axes are in the display units of the channels.
    check : simulations with noise and uncertainty beside the same runs; no such section if None.

    Returns
    -------
    str
        The text of the file. The same comparison gives the same text.
    """
    runs = [compared.run for compared in comparison.runs]
    heading = f"The {model_name(comparison.model)} beside {len(runs)} run{'s' if len(runs) > 1 else ''}"
    sections = (
        Section(
            "Misfit",
            (misfit(comparison), Details("The dissertation's measures", (dissertation_measures(comparison),))),
        ),
        Section(
            "Where the error sits",
            (*(where(c, shares) for c, shares in comparison.shares.items()), _conditions(comparison.options)),
        ),
        *(() if check is None else (predictive_check_section(check),)),
        *(run_section(run) for run in comparison.runs),
        Section("The model", (parameters(comparison.model),)),
    )
    return render(heading, comparison.sentences, sections, provenance(comparison.model, runs, comparison.drive))


def _conditions(options: CompareOptions) -> str:
    """What the words of the tables mean."""
    return (
        "Branches, holds and cycles are those of the model's temperature: held is a rate below "
        f"{options.hold_share:.0%} of the run's fastest, and a cycle begins where heating begins again by more than "
        f"{options.turn_k:g} K. Point at a cell for the rms of the residual there."
    )


def parameters(model: Model) -> Table:
    """The values of a model, and what the data of its fit say of them."""
    rows = []
    for v in model.values:
        known = {True: "yes", False: "no", None: "fixed" if v.fixed else "–"}[v.determined]
        error = "–" if v.standard_error is None else f"{v.standard_error:.2g}"
        rows.append((v.key, f"{v.value:.6g}", error, v.unit, known, v.parameter.description))
    return Table("", ("parameter", "value", "standard error", "unit", "determined", "what it is"), rows)
