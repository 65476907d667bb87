# SPDX-License-Identifier: Apache-2.0
"""An effect must not live on what its sensor or a disturbance did: its gain is counted once more without that.

Where the readings are clipped or lie far out, the samples are left out; where the residual swings with a period of its
own, that sine is taken out of every run. An effect that loses most of its gain there explains the disturbance, not the
strip. The effect of the library that *is* the end of a sensor's range may keep it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from lce_analysis.diagnosis.looking_back import take_back_refuted
from lce_analysis.options import DiagnoseOptions
from lce_analysis.signatures import ResidualSeries, Signature, residual_series, signatures
from lce_analysis.signatures.outliers import far_out
from lce_analysis.signatures.signature import DISTURBANCES, OF_SENSOR
from lce_data.channels import Channel

if TYPE_CHECKING:
    from lce_analysis.diagnosis.search import Search
    from lce_analysis.diagnosis.stage_problem import StagedFit

Floats = NDArray[np.float64]
Series = Sequence[ResidualSeries]

LARGE: Final = 0.2
"""A signature that accounts for less of a sensor's residual than this is beside the point."""


def outside(found: Sequence[Signature], least: float = LARGE) -> list[Signature]:
    """The signatures of a sensor or of a disturbance that account for much of the residual."""
    return [one for one in found if one.outside and one.share >= least]


def lives_on(
    effect: str,
    found: Sequence[Signature],
    before: Series,
    after: Series,
    options: DiagnoseOptions = DiagnoseOptions(),
) -> bool:
    """Does an effect lose most of its gain without what is outside of the strip?

    Parameters
    ----------
    effect : its name.
    found : the signatures of the residual before it was added.
    before, after : the residuals without and with it, of the same sensors and runs.
    options : ``most`` is the share of its gain that it may lose.
    """
    own = [
        one for one in outside(found) if effect != f"{one.channel.name}_clip" and one.name in OF_SENSOR | DISTURBANCES
    ]
    if not own:
        return False
    without = [_without(one, before) for one in own]
    gain = _gain(before, after, [])
    return gain > 0.0 and _gain(before, after, without) < (1.0 - options.most) * gain


def signatures_left(search: Search) -> tuple[Signature, ...]:
    """The signatures of the final residual, once every effect that lives on a disturbance is taken back.

    They are looked for in the residual before each effect first: what is added later must not hide a draught.
    """

    def beside(fit: StagedFit) -> tuple[ResidualSeries, ...]:
        return residual_series(search.whole(fit.model), search.data.judged.runs, search.present.drive)

    found = len(search.steps)
    for step in reversed(search.steps):
        before, after = beside(step.without), beside(step.with_it)
        if lives_on(step.trial.effect.name, signatures(before), before, after, search.options):
            search.drop(step, "disturbed")
            search.finish()
    if len(search.steps) < found:
        take_back_refuted(search)
    return signatures(beside(search.present))


Change = tuple[Channel, Callable[[ResidualSeries, Floats], Floats]]
"""What is done to the residual (n,) of one sensor."""


def _without(signature: Signature, before: Series) -> Change:
    """Take a signature out of a residual."""
    end = signature.channel.recorded.to_si(signature.value)
    noise = {s.run: s.noise for s in before if s.channel is signature.channel}

    def not_clipped(series: ResidualSeries, residual: Floats) -> Floats:
        return np.where(np.abs(series.measured - end) < 4.0 * noise[series.run], 0.0, residual)

    def not_far_out(series: ResidualSeries, residual: Floats) -> Floats:
        return np.where(far_out(series, 6.0), 0.0, residual)

    def not_swinging(series: ResidualSeries, residual: Floats) -> Floats:
        turn = 2.0 * np.pi * series.time_s / signature.value
        # The amplitude of a draught follows the excess temperature, so it may change along the run.
        place = (series.time_s - series.time_s[0]) / max(float(np.ptp(series.time_s)), 1e-300)
        waves = [shape * wave for shape in (1.0, place, place**2) for wave in (np.sin(turn), np.cos(turn))]
        basis = np.column_stack(waves)
        return np.asarray(residual - basis @ np.linalg.lstsq(basis, residual, rcond=None)[0])

    def same(series: ResidualSeries, residual: Floats) -> Floats:
        return residual

    changes = {"clipped": not_clipped, "outliers": not_far_out, "period": not_swinging}
    return signature.channel, changes.get(signature.name, same)


def _gain(before: Series, after: Series, changes: Sequence[Change]) -> float:
    """Squared error in units of the noise that goes from one model to the other."""

    def error(series: ResidualSeries) -> float:
        residual = series.residual
        for channel, change in changes:
            residual = change(series, residual) if channel is series.channel else residual
        return float(np.sum((residual / series.noise) ** 2))

    return sum(error(a) - error(b) for a, b in zip(before, after, strict=True))
