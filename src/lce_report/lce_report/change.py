# SPDX-License-Identifier: Apache-2.0
"""Two models beside the same runs: where the error fell."""

from collections.abc import Collection

import numpy as np

from lce_analysis.comparison.compare import Comparison, Quantity
from lce_analysis.comparison.conditions import ErrorShares, error_shares
from lce_report.blocks import Bars, Grid, Group
from lce_report.run_section import NAMES, RESIDUAL


def falls(before: Comparison, after: Comparison, held_out: Collection[str] = ()) -> tuple[Grid, ...]:
    """The rms residual by regime and by run, before and after, for each quantity; the mark is the sensor noise.

    Both are counted in the regimes of the model before, so that a bar and its neighbour are the same samples.
    """
    return tuple(_fall(q, shares, _after(q, before, after), before, held_out) for q, shares in before.shares.items())


def _after(quantity: Quantity, before: Comparison, after: Comparison) -> ErrorShares:
    members = []
    for old, new in zip(before.runs, after.runs, strict=True):
        was, now = old.stage(quantity), new.stage(quantity)
        if was is not None and now is not None:
            members.append((old.run.name, was.regime, now.residual))
    return error_shares(members)


def _fall(
    quantity: Quantity, was: ErrorShares, now: ErrorShares, before: Comparison, held_out: Collection[str]
) -> Grid:
    axis, factor = RESIDUAL[quantity]
    noise = float(np.median([s.metrics.noise for c in before.runs if (s := c.stage(quantity)) is not None])) * factor

    def bars(what: str, names: Collection[str], old: Collection[float], new: Collection[float]) -> Bars:
        groups = (
            Group("before", "before", np.array([*old]) * factor),
            Group("after", "after", np.array([*new]) * factor),
        )
        return Bars(f"rms residual of {NAMES[quantity]} {what}", axis.unit, [*names], groups, mark=noise)

    old, new = ({**s.quarters, **s.branches, **s.holds} for s in (was, now))
    runs = [f"{name} (held out)" if name in held_out else name for name in was.runs]
    return Grid(
        (
            bars("by regime", old, [s.rms for s in old.values()], [s.rms for s in new.values()]),
            bars("by run", runs, [s.rms for s in was.runs.values()], [s.rms for s in now.runs.values()]),
        ),
        (1, 1),
    )
