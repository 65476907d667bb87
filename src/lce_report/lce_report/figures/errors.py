# SPDX-License-Identifier: Apache-2.0
"""Tables and bars of the error: how large, where it sits, and what a second model takes away from it."""

from collections.abc import Collection, Mapping, Sequence
from typing import Final

import numpy as np

from lce_analysis.comparison.compare import Comparison
from lce_analysis.comparison.conditions import BRANCHES, ErrorShares, Share, error_shares
from lce_data.channels import Channel
from lce_report.blocks import Bars, Grid, Group, Heat, Role, Table
from lce_report.figures.axes import difference_scale, title

MISFIT_HEAD: Final = (
    "run",
    "series",
    "RMS error",
    "sensor noise",
    "error / noise",
    "NRMSE",
    "autocorrelation outside ±1.96/√N",
)
DISSERTATION_HEAD: Final = ("run", "series", "RMSE (1/N)√Σe², (4.18) as printed", "SMAPE (4.23)", "NRMSE (4.24)")

ROLES: Final[Mapping[str, Role]] = {"as given": "quiet", "refitted": "before", "before": "before"}
"""Colours of the models by what they are called; one with more effects is after."""


def misfit(comparison: Comparison) -> Table:
    """Measures of the misfit, a row for each channel of each run."""
    rows = []
    for run in comparison.runs:
        for channel, compared in run.channels.items():
            m, scale, unit = compared.metrics, difference_scale(channel), channel.difference.symbol
            rows.append(
                (
                    run.run.name,
                    title(channel),
                    f"{m.rms * scale:.3g} {unit}",
                    f"{m.noise * scale:.2g} {unit}",
                    f"{m.over_noise:.2f}",
                    f"{m.nrmse:.2%}",
                    f"{compared.autocorrelation.outside:.0%}",
                )
            )
    return Table("", MISFIT_HEAD, rows)


def dissertation_measures(comparison: Comparison) -> Table:
    """The measures of Wu (2021), to be held beside its tables."""
    rows = []
    for run in comparison.runs:
        for channel, compared in run.channels.items():
            m = compared.metrics
            printed = f"{m.rmse_printed * difference_scale(channel):.3g} {channel.difference.symbol}"
            rows.append((run.run.name, title(channel), printed, f"{m.smape:.3%}", f"{m.nrmse:.2%}"))
    return Table("", DISSERTATION_HEAD, rows)


def where(channel: Channel, found: ErrorShares) -> Grid:
    """Where the squared error of a channel sits.

    Parameters
    ----------
    channel : of which the shares are.
    found : shares of the squared error and of the samples, as fractions of one.

    Returns
    -------
    Grid
        Shares by operating condition; by one condition alone, beside the share of the samples; by run and cycle.
    """
    heading = f"Squared error of {channel.symbol}"
    conditions = {
        f"{branch}, {'hold' if held else 'ramp'}": [s for s in found.conditions if (s.branch, s.held) == (branch, held)]
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
            _shares(channel, f"{heading} by operating condition", "", tuple(found.quarters), conditions, "condition"),
            Bars(f"{heading} beside the samples", "1", tuple(alone), (error, samples), ".0%", full=1.0),
            _shares(channel, f"{heading} by run and cycle", "cycle", [str(n) for n in cycles], by_run, "cycle"),
        ),
        (7, 6, 4),
    )


def _shares(
    channel: Channel, heading: str, corner: str, columns: Sequence[str], rows: Mapping[str, Sequence[Share]], by: str
) -> Heat:
    values = np.array([[s.error_share for s in row] for row in rows.values()])
    notes = [[_note(channel, s) for s in row] for row in rows.values()]
    return Heat(heading, corner, columns, tuple(rows), values, ".0%", notes=notes, pick=f"{channel.name} {by}")


def _note(channel: Channel, share: Share) -> str:
    if not share.sample_share:
        return ""
    rms = f"{share.rms * difference_scale(channel):.3g} {channel.difference.symbol}"
    return f"rms {rms}, {share.sample_share:.1%} of the samples"


def error_reductions(compared: Mapping[str, Comparison], held_out: Collection[str] = ()) -> tuple[Grid, ...]:
    """The rms residual of several models, by operating condition and by run.

    Parameters
    ----------
    compared : models beside the same runs, by what they are called; the first is the one given. All are judged in its
        operating conditions, so that neighbouring bars are of the same samples.
    held_out : names of the runs that no model was fitted to.

    Returns
    -------
    tuple of Grid
        One for each channel, in its unit of differences; the mark in the bars is the noise of the sensor.
    """
    first = next(iter(compared.values()))
    grids = []
    for channel in first.shares:
        shares = {label: _judged_alike(channel, first, comparison) for label, comparison in compared.items()}
        grids.append(_reduction(channel, shares, first, held_out))
    return tuple(grids)


def _judged_alike(channel: Channel, first: Comparison, other: Comparison) -> ErrorShares:
    """Shares of the residual of another model, in the operating conditions of the first."""
    members = []
    for old, new in zip(first.runs, other.runs, strict=True):
        was, now = old.channels.get(channel), new.channels.get(channel)
        if was is not None and now is not None:
            members.append((old.run.name, was.conditions, now.residual))
    return error_shares(members, first.options)


def _reduction(
    channel: Channel, shares: Mapping[str, ErrorShares], first: Comparison, held_out: Collection[str]
) -> Grid:
    scale = difference_scale(channel)
    noises = [run.channels[channel].metrics.noise for run in first.runs if channel in run.channels]
    noise = float(np.median(noises)) * scale

    def bars(by: str, names: Collection[str], members: Mapping[str, Collection[Share]]) -> Bars:
        groups = [
            Group(label, ROLES.get(label, "after"), np.array([s.rms for s in found]) * scale)
            for label, found in members.items()
        ]
        heading = f"rms residual of {title(channel)} {by}"
        return Bars(heading, channel.difference.symbol, [*names], groups, mark=noise)

    conditions = {label: {**s.quarters, **s.branches, **s.holds} for label, s in shares.items()}
    names = next(iter(conditions.values()))
    by_run = {label: s.runs.values() for label, s in shares.items()}
    runs = [f"{name} (held out)" if name in held_out else name for name in next(iter(shares.values())).runs]
    return Grid(
        (
            bars("by operating condition", names, {label: c.values() for label, c in conditions.items()}),
            bars("by run", runs, by_run),
        ),
        (1, 1),
    )
