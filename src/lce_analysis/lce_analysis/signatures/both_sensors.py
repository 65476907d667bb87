# SPDX-License-Identifier: Apache-2.0
"""Both sensors together: the displacement follows the temperature that the model did not predict.

Statistic: the share of the displacement's residual that the model's answer to the unpredicted temperature predicts,
with one factor from all other runs. The noise of two separate sensors cannot do that, so what is missing acts on the
strip itself through heat or light.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from lce_analysis.signatures.follows import THINNED, Member, chance, left_out
from lce_analysis.signatures.options import SignatureOptions
from lce_analysis.signatures.series import ResidualSeries, misfit
from lce_analysis.signatures.signature import Picture, Signature
from lce_data.channels import TEMPERATURE


def both_sensors(
    temperature: Sequence[ResidualSeries],
    displacement: Sequence[ResidualSeries],
    repeats: bool,
    options: SignatureOptions = SignatureOptions(),
) -> Signature | None:
    """A disturbance of heat or light that both sensors see; None if they do not.

    Parameters
    ----------
    temperature, displacement : all runs of both.
    repeats : does the residual of the temperature follow a covariate in runs left out?
    options : ``structured``, ``explained`` and ``false_alarm``.
    """
    known = [_by_model(s) for s in displacement if s.unpredicted is not None]
    if len(known) < 2 or misfit(temperature) <= options.explained:
        return None
    members = [_member(s) for s in known]
    curve = left_out(members)
    factor = float(curve.coefficients[0])
    if curve.share < options.structured or factor <= 0.0:
        return None
    p_value = chance([_member(s.thinned(THINNED)) for s in known], curve.share, options.shifts)
    if p_value > options.false_alarm:
        return None
    shown = max(known, key=lambda s: float(np.sum(_member(s)[0] ** 2)))
    again = (
        "and it comes again in other runs: physics of heat or light that the model lacks"
        if repeats
        else "and it does not come again in other runs: a disturbance of heat or light"
    )
    moved = np.zeros(0) if shown.unpredicted is None else shown.unpredicted
    return Signature(
        name="both_sensors",
        channel=TEMPERATURE,
        value=curve.share,
        unit="1",
        covariate=None,
        p_value=p_value,
        share=curve.share,
        words=f"both sensors see it: the displacement follows the temperature that was not predicted "
        f"({curve.share:.0%} of its residual in runs left out), {again}",
        advice="look for draughts, stray light and an unsteady laser"
        if not repeats
        else "look among the effects of light and heat first",
        picture=Picture(
            f"Residual of the displacement, and what the unpredicted temperature makes of it, {shown.run}",
            "time",
            "s",
            shown.time_s,
            "displacement",
            {"residual": shown.residual, "from the temperature": factor * moved},
            {},
        ),
        repeats=repeats,
    )


def _by_model(series: ResidualSeries) -> ResidualSeries:
    """The same series beside the model that was driven by its own temperature."""
    if not series.driven or series.unpredicted is None:
        return series
    return replace(series, modelled=series.modelled - series.unpredicted, driven=False)


def _member(series: ResidualSeries) -> Member:
    moved = np.zeros(series.time_s.size) if series.unpredicted is None else series.unpredicted
    return np.where(series.counted, moved, 0.0)[:, None] / series.noise, series.residual / series.noise
