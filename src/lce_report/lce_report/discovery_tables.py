# SPDX-License-Identifier: Apache-2.0
"""The tables of a discovery: the command prints them, the report and the page draw them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from lce_analysis.diagnosis.ranking import REASON
from lce_data.channels import SENSORS
from lce_report.blocks import Table
from lce_report.tables import NOTHING, WITHOUT_WITH, error_columns, estimate, left_out, percent, without_with

if TYPE_CHECKING:
    from lce_analysis.discovery import Closure, Discovery


@dataclass(frozen=True)
class DiscoveryTables:
    """What reports show of a discovery beside its sentences.

    errors : of the model as given, refitted, and with what was found.
    formulas : that describe what was found; None if there are none.
    tried : the functions that were refitted; None if none was.
    """

    errors: Table
    formulas: Table | None
    tried: Table | None


def discovery_tables(found: Discovery) -> DiscoveryTables:
    """Lay out a discovery."""
    return DiscoveryTables(
        errors=error_columns(found, ["what was found"] if found.found else []),
        formulas=_formulas(found) if any(one.formulas for one in found.found) else None,
        tried=_tried(found) if found.tried else None,
    )


def _formulas(found: Discovery) -> Table:
    rows = [
        (
            one.name,
            formula.form.name,
            formula.expression,
            ", ".join(f"{name} = {estimate(value, math.nan if e is None else e)}" for name, value, e in formula.values),
            percent(formula.gain / one.closure.stage.fit.error),
        )
        for one in found.found
        for formula in one.formulas
    ]
    head = ("function", "form", "formula", "numbers, ± standard error, SI", "went")
    return Table("Formulas that describe what was found as well as the data can tell, the simplest first", head, rows)


def _tried(found: Discovery) -> Table:
    sensors = [s for s in SENSORS if any(c.held_out and s in c.held_out.before.total for c in found.tried)]
    accepted = {one.closure.candidate.label for one in found.found}
    rows = [
        (
            closure.candidate.label,
            f"{closure.examined.ln_evidence:.4g}",
            percent(closure.examined.gain / closure.stage.fit.error),
            percent(closure.gain / closure.stage.fit.error),
            left_out(closure.held_out) if closure.held_out else NOTHING,
            *(without_with(closure.held_out, s) if closure.held_out else NOTHING for s in sensors),
            _outcome(closure, closure.candidate.label in accepted),
        )
        for closure in found.tried
    ]
    changes = (f"{s.symbol} without → with" for s in sensors)
    head = ("place × covariate", "ln evidence", "promised", "went", "judged on", *changes, "outcome")
    return Table(f"The functions that were refitted ({WITHOUT_WITH}; shares of the squared error)", head, rows)


def _outcome(closure: Closure, accepted: bool) -> str:
    return "found" if accepted else REASON[closure.objection or "less"]
