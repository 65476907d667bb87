# SPDX-License-Identifier: Apache-2.0
"""The report of `lce add`: an effect added, and the error before and after."""

from collections.abc import Collection
from typing import Final

from lce_analysis.comparison.compare import Comparison
from lce_analysis.diagnosis import Addition
from lce_data.channels import SENSORS
from lce_model import Model
from lce_report.blocks import Block, Section, Table
from lce_report.figures.before_after import overlays
from lce_report.figures.errors import error_reductions
from lce_report.html.render import render
from lce_report.pages.footer import provenance

SIDES: Final = ("train", "test")


def render_addition(addition: Addition, before: Comparison, after: Comparison, held_out: Collection[str] = ()) -> str:
    """An added effect as one self-contained HTML file.

    Parameters
    ----------
    addition : the effect, and the record of the models tried.
    before, after : the models without and with it, beside the same runs.
    held_out : names of the runs that neither was fitted to.

    Returns
    -------
    str
        The text of the file.
    """
    evidence: list[Block] = [*error_reductions(before, after, held_out), models_tried(addition.model)]
    sections = [Section("The error, before and after", evidence), *overlays(before, after, held_out)]
    footer = provenance(addition.model, [compared.run for compared in after.runs])
    return render(f"{addition.effect} added", [addition.sentence], sections, footer)


def models_tried(model: Model) -> Table:
    """NRMSE of the models in the history of a model, on the runs learnt from and on those held out."""
    columns = [(side, channel) for side in SIDES for channel in SENSORS]
    rows = []
    for entry in model.fit["history"]:
        errors = [entry[side].get(f"{channel.name}_nrmse") for side, channel in columns]
        name = " + ".join([entry["thermal"], entry["deformation"], *entry["effects"]])
        rows.append((name, *("" if error is None else f"{error:.2%}" for error in errors), entry["verdict"]))
    head = ("model", *(f"{side} {channel.symbol}" for side, channel in columns), "verdict")
    return Table("Models tried (NRMSE)", head, rows)
