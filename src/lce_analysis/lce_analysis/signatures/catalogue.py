# SPDX-License-Identifier: Apache-2.0
"""All signatures of the residuals of a model, strongest first."""

from collections.abc import Callable, Sequence
from typing import Final

from lce_analysis.signatures.both_sensors import both_sensors
from lce_analysis.signatures.clipped import clipped
from lce_analysis.signatures.differs_by_run import differs_by_run
from lce_analysis.signatures.drift import drift
from lce_analysis.signatures.follows import follows
from lce_analysis.signatures.options import SignatureOptions
from lce_analysis.signatures.outliers import outliers
from lce_analysis.signatures.period import period
from lce_analysis.signatures.rounded import rounded
from lce_analysis.signatures.series import ResidualSeries
from lce_analysis.signatures.signature import Signature
from lce_analysis.signatures.step import step
from lce_analysis.signatures.variance import variance
from lce_data.channels import DISPLACEMENT, SENSORS, TEMPERATURE

Test = Callable[[Sequence[ResidualSeries], SignatureOptions], Signature | None]

READINGS: Final[tuple[Test, ...]] = (clipped, rounded, outliers)
"""What is looked for in the readings of each sensor by itself."""
RESIDUAL: Final[tuple[Test, ...]] = (step, period, follows, differs_by_run)
"""What is looked for in its residual, unless the sensor is clipped."""
MOST: Final = 0.5
"""A clipped sensor leaves this share of the residual at its end."""


def signatures(
    series: Sequence[ResidualSeries], options: SignatureOptions = SignatureOptions()
) -> tuple[Signature, ...]:
    """Everything of the catalogue that residuals show.

    Parameters
    ----------
    series : the residuals of one model, from :func:`residual_series`.
    options : the thresholds.

    Returns
    -------
    tuple of Signature
        By the share of the residual that each accounts for, the largest first; empty if nothing is seen.

    Examples
    --------
    >>> for found in signatures(residual_series(model, runs)):  # doctest: +SKIP
    ...     print(found.words)
    """
    found: list[Signature] = []
    by_channel = {c: [s for s in series if s.channel is c] for c in SENSORS}
    for own in by_channel.values():
        if own:
            found += _of_sensor(own, options)
    found = _upstream(found)
    temperature, displacement = by_channel[TEMPERATURE], by_channel[DISPLACEMENT]
    if temperature and displacement:
        of_heat = [one for one in found if one.channel is TEMPERATURE]
        repeats = any(one.repeats and one.share >= options.repeats for one in of_heat)
        both = both_sensors(temperature, displacement, repeats, options)
        if both is not None:
            found = [both, *(found if repeats else _beside_disturbance(found))]
    return tuple(sorted(found, key=lambda one: -one.share))


def _of_sensor(series: Sequence[ResidualSeries], options: SignatureOptions) -> list[Signature]:
    found = [one for test in READINGS if (one := test(series, options)) is not None]
    if any(one.name == "clipped" and one.share >= MOST for one in found):
        return found  # the model was bent by the readings at the end of the range: its residual elsewhere says nothing
    louder = variance(series, options) if not any(one.name in ("clipped", "rounded") for one in found) else None
    found += [louder] if louder is not None else []
    found += [one for test in RESIDUAL if (one := test(series, options)) is not None]
    followed = next((one for one in found if one.name == "follows"), None)
    growing = drift(series, 0.0 if followed is None else followed.share, options)
    if growing is None:
        return found
    return [*(one for one in found if one.covariate != growing.covariate), growing]


def _beside_disturbance(found: Sequence[Signature]) -> list[Signature]:
    """Without what a disturbance of the heat brings along.

    No two runs have the same one, the displacement swings along, and where the temperature turns it jumps.
    """
    return [
        one
        for one in found
        if one.name != "differs_by_run" and not (one.name in ("step", "period") and one.channel is not TEMPERATURE)
    ]


def _upstream(found: Sequence[Signature]) -> list[Signature]:
    """Without a period of the displacement where the temperature, which drives it, has one, too."""
    heat = any(one.name == "period" and one.channel is TEMPERATURE for one in found)
    return [one for one in found if not (heat and one.name == "period" and one.channel is not TEMPERATURE)]
