# SPDX-License-Identifier: Apache-2.0
"""What a user of the analysis may choose: a frozen class for each use case, each field with its unit and its reason."""

import math
from dataclasses import dataclass
from typing import Literal

from lce_data.errors import LceError

Drive = Literal["model", "measured"]
"""What drives the T→d stage: the model's own thermal state, or the measured temperature, smoothed."""


@dataclass(frozen=True)
class FitOptions:
    """How a model is identified; the defaults serve every model of the library.

    Parameters
    ----------
    drive : with "measured" the stages are identified one after the other only.
    seed : of the random starts and populations; the same seed gives the same result.
    random_guesses, starts : parameter sets tried at random, and how many of the best become starts of the least
        squares (§4.5 of Wu (2021)).
    evolutions : populations that the two-step strategy tries at most (step 3 of §5.3.2: begin again if a search
        went astray).
    same_minimum : two populations that end within this share of each other's error have found the same minimum,
        and are enough.
    refined : members of each population that are refined by least squares.
    reweighted : rounds of the joint fit, each with the misfit of the last as weights.
    negligible : the joint fit ends at a step that changes the sum of squares, in units of the misfit, by less:
        a fifth of a standard error.
    noise_level : RMS residual in units of the noise at which a search is over.
    """

    drive: Drive = "model"
    seed: int = 0
    random_guesses: int = 2000
    starts: int = 20
    evolutions: int = 6
    same_minimum: float = 0.02
    refined: int = 6
    reweighted: int = 3
    negligible: float = 0.05
    noise_level: float = 1.05

    def __post_init__(self) -> None:
        if self.drive not in ("model", "measured"):
            raise LceError(f"drive: {self.drive!r} is neither 'model' nor 'measured'")
        for name in ("random_guesses", "starts", "evolutions", "refined", "reweighted"):
            if getattr(self, name) < 1:
                raise LceError(f"{name}: {getattr(self, name)} is not 1 or more")


@dataclass(frozen=True)
class CompareOptions:
    """How a model is compared with runs, and from which sizes on a misfit is spoken of.

    Parameters
    ----------
    drive : what drives the T→d stage.
    at_noise, uncertain : a residual above the noise by no more than the share at_noise + uncertain/√N is noise: the
        ratio of white noise to its estimate from N samples scatters by 1.35/√N.
    even : the error is spread evenly if even the interval with most of it has less than so many times its samples'
        share.
    """

    drive: Drive = "model"
    at_noise: float = 0.05
    uncertain: float = 4.0
    even: float = 1.4


@dataclass(frozen=True)
class DiagnoseOptions:
    """When an effect counts as missing.

    Parameters
    ----------
    false_alarm : chance of a false addition to a complete model, over the whole library.
    refitted : candidates that are refitted in each step, so many by evidence and so many by predicted reduction.
    alias_correlation : |ρ| from which two effects are reported as a set.
    min_likelihood_ratio : ratio below which two refitted effects are reported as a set.
    min_visibility : an effect that the data ask for is not named below it: a small error of the base model's own form
        would do as well.
    max_effects : effects that are added at most.
    iterations : of a refit, at most; an effect that the free parameters nearly mask takes some thirty.
    structured : share of the residual's variance, predicted in a run that was left out, from which it is no noise.
    rough : a residual so many times larger than the sample-to-sample noise, and a hundredth of the range, is no
        sensor's noise.
    jumping : share of the energy of the innovations beyond six standard deviations, which noise all but never reaches.
    """

    false_alarm: float = 0.05
    refitted: int = 3
    alias_correlation: float = 0.95
    min_likelihood_ratio: float = 20.0
    min_visibility: float = 1e-4
    max_effects: int = 4
    iterations: int = 60
    structured: float = 0.15
    rough: float = 10.0
    jumping: float = 0.05


@dataclass(frozen=True)
class DesignOptions:
    """What the bench allows, and how long a waveform is searched for.

    Parameters
    ----------
    max_power_w : limit of the laser power [W].
    max_temperature_k : limit of the strip's temperature [K].
    duration_s : longest experiment [s], more than 20.
    seed : of the waveforms tried; the same seed gives the same result.
    random_waves, variations, confirmed : waveforms tried at random, variations of the best, and how many of them are
        confirmed by refitting the rival.
    iterations : of that refit, at most.
    """

    max_power_w: float = 2.0
    max_temperature_k: float = 383.15
    duration_s: float = 150.0
    seed: int = 0
    random_waves: int = 120
    variations: int = 40
    confirmed: int = 3
    iterations: int = 60

    def __post_init__(self) -> None:
        for name, value, low in (("power", self.max_power_w, 0.0), ("duration", self.duration_s, 20.0)):
            if not (math.isfinite(value) and value > low):
                raise LceError(f"design: a {name} of {value:g} leaves no experiment; more than {low:g} is needed")
