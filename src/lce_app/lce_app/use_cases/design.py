# SPDX-License-Identifier: Apache-2.0
"""Design the experiment that tells two effects apart."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import lce_analysis.experiment_design as designing
from lce_analysis.experiment_design import Design
from lce_analysis.options import DesignOptions
from lce_app.use_cases.loading import load_model_and_effects
from lce_data.progress import CancelToken, Progress, silent
from lce_data.units import KELVIN
from lce_data.wave_file import write_wave


@dataclass(frozen=True)
class Options:
    """What the bench allows, and when two effects count as told apart.

    Parameters
    ----------
    search : limits of power [W], temperature [K] and duration [s], and how long to search.
    plain_separation : distance, in standard deviations of the sensor noise, above which a difference is plain: noise
        alone exceeds five of them once in two million.
    """

    search: DesignOptions = field(default_factory=DesignOptions)
    plain_separation: float = 5.0


@dataclass(frozen=True)
class Designed:
    """The waveform and what it is worth; ``plain`` says whether it separates the two effects."""

    design: Design
    plain: bool

    @property
    def sentences(self) -> tuple[str, ...]:
        """The waveform, what it is worth, and what to do if that is too little."""
        wave = self.design
        sentences = (
            f"{wave.protocol}, scaled to the limits: {wave.time_s[-1]:.0f} s, {wave.power_w.max():.2f} W and "
            f"{wave.hottest_k - KELVIN:.0f} °C at most.",
            f"After the rival is refitted, {wave.separation:.1f} standard deviations of the sensor noise remain "
            "between the two.",
        )
        advice = "That is too little to tell them apart: give more time, power or temperature."
        return sentences if self.plain else (*sentences, advice)


DEFAULTS = Options()


def design(
    model_file: Path,
    between: tuple[str, str],
    out: Path,
    options: Options = DEFAULTS,
    progress: Progress = silent,
    cancel: CancelToken | None = None,
) -> Designed:
    """Find the waveform that tells two effects apart best, and write it.

    Parameters
    ----------
    model_file : as `lce fit` writes it.
    between : the two effects, names of the library or paths of effect files.
    out : CSV file to write, with the columns ``time_s,power_w`` at 100 Hz.
    options : limits of the bench, and how long to search.
    progress : called after each waveform with the best separation so far.
    cancel : stops between two waveforms and raises Cancelled; nothing is written.

    Returns
    -------
    Designed
        The waveform, and whether it is good enough.

    Raises
    ------
    LceError
        If no waveform within the limits separates the two, or the model or an effect cannot be used.

    Examples
    --------
    >>> from pathlib import Path
    >>> found = design(Path("model.yaml"), ("creep", "phase_kinetics"), Path("wave.csv"))  # doctest: +SKIP
    >>> print(found.design.separation, found.plain)  # doctest: +SKIP
    """
    model, _ = load_model_and_effects(model_file, between)
    found = designing.design(model, between, options.search, progress, cancel)
    write_wave(out, found.time_s, found.power_w)
    return Designed(found, found.separation > options.plain_separation)
