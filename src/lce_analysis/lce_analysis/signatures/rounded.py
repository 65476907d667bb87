# SPDX-License-Identifier: Apache-2.0
"""A rounded sensor: every reading is a multiple of one step, and that step is larger than the noise.

Statistic: the step over the noise of the series, in which its rounding error is counted. A sensor that rounds finely
looks like any other.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_analysis.signatures.options import SignatureOptions
from lce_analysis.signatures.series import ResidualSeries, energy
from lce_analysis.signatures.signature import Picture, Signature, amount

Floats = NDArray[np.float64]

OFF: Final = 0.02
"""A reading is a multiple of the step if it is within this share of it."""
REPEATED: Final = 0.2
"""Share of readings that repeat the one before; fewer, and no rounding is seen in the series."""


def rounded(series: Sequence[ResidualSeries], options: SignatureOptions = SignatureOptions()) -> Signature | None:
    """The step to which one sensor is rounded; None if its noise hides it.

    Parameters
    ----------
    series : of one sensor, all runs.
    options : ``rounding``.
    """
    steps = [rounding_step(s.measured) for s in series]
    coarse = [(s, q) for s, q in zip(series, steps, strict=True) if q > options.rounding * s.noise]
    if not coarse or len(coarse) < 0.5 * len(series):
        return None
    channel, step = series[0].channel, float(np.median([q for _, q in coarse]))
    share = sum(s.counted.sum() * q**2 / 12.0 / s.noise**2 for s, q in coarse) / max(energy(series), 1e-300)
    shown = max((s for s, _ in coarse), key=lambda s: s.time_s.size)
    part = slice(*_liveliest(shown.measured))
    return Signature(
        name="rounded",
        channel=channel,
        value=step,
        unit=channel.unit,
        covariate=None,
        p_value=0.0,
        share=min(float(share), 1.0),
        words=f"the readings of the {channel.name} are rounded to {amount(channel, step)}",
        advice="record more digits, or a smaller range of the sensor; no effect of the strip looks like this",
        picture=Picture(
            f"Readings in steps of {amount(channel, step)}, {shown.run}",
            "time",
            "s",
            shown.time_s[part],
            "readings",
            {"model": shown.modelled[part]},
            {"measured": shown.measured[part]},
        ),
    )


def rounding_step(values: Floats) -> float:
    """The step of which all differences of values (n,) are multiples; 0 if there is none or readings hardly repeat."""
    moved = np.abs(np.diff(values))
    tiny = 1e-9 * max(float(np.ptp(values)), 1e-12)
    changes = moved[moved > tiny]
    if changes.size < 8 or 1.0 - changes.size / moved.size < REPEATED:
        return 0.0
    step = float(np.min(changes))
    multiples = changes / step
    off = np.abs(multiples - np.round(multiples)) / np.maximum(np.sqrt(np.round(multiples)), 1.0)
    return step if float(np.mean(off < OFF)) > 0.98 else 0.0


def _liveliest(values: Floats, span: int = 200) -> tuple[int, int]:
    """Where within (n,) a stretch of samples moves, but least: there steps show."""
    if values.size <= span:
        return 0, values.size
    starts = np.arange(0, values.size - span, span // 2)
    moved = np.array([len(np.unique(values[i : i + span])) for i in starts])
    i = int(starts[np.argmin(np.abs(moved - 8))])
    return i, i + span
