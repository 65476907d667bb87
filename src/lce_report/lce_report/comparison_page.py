# SPDX-License-Identifier: Apache-2.0
"""A comparison as sections of a page: the misfit, where the error sits, every run, the model."""

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from lce_analysis.comparison.compare import Comparison, Quantity
from lce_analysis.comparison.conditions import BRANCHES, HOLD_SHARE, TURN_K, ErrorShares, Share
from lce_analysis.prediction import Drive
from lce_data import __version__
from lce_data.run import Run
from lce_model import Model
from lce_report.blocks import Bars, Grid, Group, Heat, Section, Table
from lce_report.page import render
from lce_report.run_section import NAMES, RESIDUAL, VALUE, run_section

REGIMES: Final = (
    f"Branches, holds and cycles are those of the model's temperature: held is a rate below {HOLD_SHARE:.0%} of the "
    f"run's fastest, and a cycle begins where heating begins again by more than {TURN_K:g} K. Point at a cell for the "
    "rms of the residual there."
)
DRIVES: Final[dict[Drive, str]] = {
    "model": "the model's own temperature drives its displacement",
    "measured": "the measured temperature, smoothed, drives the displacement",
}


def render_comparison(comparison: Comparison) -> str:
    """The page of `lce compare`."""
    runs = len(comparison.runs)
    title = f"The {model_name(comparison.model)} beside {runs} run{'s' if runs > 1 else ''}"
    footer = provenance(comparison.model, [c.run for c in comparison.runs], comparison.drive)
    return render(title, comparison.sentences, sections(comparison), footer)


def model_name(model: Model) -> str:
    """The model in words."""
    stages = " + ".join(name for name in (model.thermal, model.deformation) if name != "none")
    effects = f" with {', '.join(model.effect_names)}" if model.effects else ""
    return f"{stages} model{effects}"


def provenance(model: Model, runs: Sequence[Run], drive: Drive) -> tuple[str, ...]:
    """Lines for the foot of a page: model, drive, data and software."""
    data = "; ".join(f"{run.name} {run.sha256[:12]}" for run in runs)
    fitted = ", ".join(str(entry["name"]) for entry in model.fit.get("runs", ()))
    return (
        f"Model: {model_name(model)}{f', fitted to {fitted}' if fitted else ''}. Drive: {DRIVES[drive]}.",
        f"Data (SHA-256): {data}.",
        f"Written by lce {__version__}.",
    )


def sections(comparison: Comparison) -> tuple[Section, ...]:
    """What the page says after the answer."""
    return (
        Section("Misfit", (misfit(comparison),)),
        Section("Where the error sits", (*(where(q, s) for q, s in comparison.shares.items()), REGIMES)),
        *(run_section(run) for run in comparison.runs),
        Section("The model", (parameters(comparison.model),)),
    )


def misfit(comparison: Comparison) -> Table:
    """The measures of every run and series."""
    rows = []
    for run in comparison.runs:
        for stage in run.stages:
            m, (axis, factor) = stage.metrics, RESIDUAL[stage.quantity]
            rows.append(
                (
                    run.run.name,
                    NAMES[stage.quantity],
                    f"{m.rms * factor:.3g} {axis.unit}",
                    f"{m.noise * factor:.2g} {axis.unit}",
                    f"{m.over_noise:.2f}",
                    f"{m.nrmse:.2%}",
                    f"{m.smape:.3%}",
                    f"{m.rmse_printed * factor:.3g} {axis.unit}",
                    f"{stage.autocorrelation.outside:.0%}",
                )
            )
    head = (
        "run",
        "series",
        "RMS √(Σe²/N)",
        "sensor noise",
        "RMS / noise",
        "NRMSE (4.24)",
        "SMAPE (4.23)",
        "RMSE (1/N)√Σe², (4.18) as printed",
        "autocorrelation outside ±1.96/√N",
    )
    return Table("", head, rows)


def where(quantity: Quantity, found: ErrorShares) -> Grid:
    """Shares of the squared error: by regime, by one thing alone beside the share of the samples, by run and cycle."""
    title = f"Squared error of {VALUE[quantity][0].name}"
    regimes = {
        f"{branch}, {'hold' if held else 'ramp'}": [s for s in found.regimes if (s.branch, s.held) == (branch, held)]
        for branch in BRANCHES
        for held in (False, True)
    }
    alone = {**found.quarters, **found.branches, **found.holds}
    error = Group("error", "model", np.array([s.error_share for s in alone.values()]))
    samples = Group("samples", "quiet", np.array([s.sample_share for s in alone.values()]))
    cycles = sorted({n for by_cycle in found.cycles.values() for n in by_cycle})
    nothing = Share(float("nan"), 0.0, float("nan"))
    by_run = {run: [by_cycle.get(n, nothing) for n in cycles] for run, by_cycle in found.cycles.items()}
    return Grid(
        (
            _share_table(quantity, f"{title} by regime", "", tuple(found.quarters), regimes, "regime"),
            Bars(f"{title} beside the samples", "1", tuple(alone), (error, samples), ".0%", full=1.0),
            _share_table(quantity, f"{title} by run and cycle", "cycle", [str(n) for n in cycles], by_run, "cycle"),
        ),
        (6, 6, 5),
    )


def _share_table(
    quantity: Quantity, title: str, corner: str, columns: Sequence[str], rows: Mapping[str, Sequence[Share]], by: str
) -> Heat:
    values = np.array([[s.error_share for s in row] for row in rows.values()])
    notes = [[_note(quantity, s) for s in row] for row in rows.values()]
    return Heat(title, corner, columns, tuple(rows), values, ".0%", notes=notes, pick=f"{quantity} {by}")


def _note(quantity: Quantity, share: Share) -> str:
    axis, factor = RESIDUAL[quantity]
    return (
        f"rms {share.rms * factor:.3g} {axis.unit}, {share.sample_share:.1%} of the samples"
        if share.sample_share
        else ""
    )


def parameters(model: Model) -> Table:
    """The values of a model, and what the data of its fit say of them."""
    rows = []
    for v in model.values:
        known = {True: "yes", False: "no", None: "fixed" if v.fixed else "–"}[v.determined]
        error = "–" if v.standard_error is None else f"{v.standard_error:.2g}"
        rows.append((v.key, f"{v.value:.6g}", error, v.unit, known, v.parameter.description))
    return Table("", ("parameter", "value", "standard error", "unit", "determined", "what it is"), rows)
