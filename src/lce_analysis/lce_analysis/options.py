# SPDX-License-Identifier: Apache-2.0
"""What a user of the analysis may choose: a frozen class for each use case, each field with its unit and its reason."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from lce_data.channels import SENSORS, Channel
from lce_data.errors import LceError

Drive = Literal["model", "measured"]
"""What drives the T→d stage: the model's own thermal state, or the measured temperature, smoothed."""


@dataclass(frozen=True)
class FitOptions:
    """How a model is identified, and when its parameters count as known; the defaults serve every model of the library.

    Parameters
    ----------
    drive : with "measured" the stages are identified one after the other only.
    time_constants : of the lumped heat [s], from each of which its identification begins; without any, it begins at the
        values of the model.
    seed : of the random starts and populations; the same seed gives the same result.
    random_guesses, starts : parameter sets tried at random, and how many of the best become starts of the least
        squares (§4.5 of Wu (2021)).
    evolutions : populations that the two-step strategy tries at most (step 3 of §5.3.2: begin again if a search
        went astray).
    same_minimum : two populations that end within this share of each other's error have found the same minimum,
        and are enough.
    refined : members of each population that are refined by least squares.
    hops : steps away from the optimum of the dynamic model, each followed by a least squares.
    reweighted : rounds of the joint fit, each with the misfit of the last as weights; with 0 the stages are identified
        one after the other only.
    same_weights : the rounds end when no weight changes by this share or more.
    negligible : the last fit ends at a step that changes the sum of squares, in units of the misfit, by less:
        a fifth of a standard error.
    slow : it ends as well where five steps together change it by less.
    noise_level : RMS residual in units of the noise at which a search is over.
    moved : under constant power a series shows a step if it drifts by more than so many times its noise.
    undetermined : standard error, in natural units (e-folds, tenths of the bounds), above which the data do not
        determine a parameter.
    strong_correlation : |ρ| above which two parameters are reported as strongly correlated.
    differing : a parameter is reported as different from run to run if a value for each run would take this share of
        the squared error.
    profile_points : values that a profile likelihood tries on each side of the optimum, at most.
    bootstrap_block : length of the blocks of residuals that are resampled, in their correlation times.

    Raises
    ------
    LceError
        If a value cannot be used; it names the field.

    Examples
    --------
    >>> FitOptions(drive="measured", seed=1).starts
    20
    """

    drive: Drive = "model"
    time_constants: tuple[float, ...] = (5.0, 20.0, 80.0, 320.0)
    seed: int = 0
    random_guesses: int = 2000
    starts: int = 20
    evolutions: int = 6
    same_minimum: float = 0.02
    refined: int = 12
    hops: int = 8
    reweighted: int = 3
    negligible: float = 0.05
    slow: float = 1.0
    noise_level: float = 1.05
    same_weights: float = 0.05
    moved: float = 5.0
    undetermined: float = 0.5
    strong_correlation: float = 0.95
    differing: float = 0.5
    profile_points: int = 8
    bootstrap_block: float = 4.0

    def __post_init__(self) -> None:
        _check_drive(self.drive)
        if not all(math.isfinite(tau) and tau > 0.0 for tau in self.time_constants):
            raise LceError(f"time_constants: {self.time_constants} must be above 0")
        _check_counts(self, "random_guesses", "starts", "evolutions", "refined", "profile_points")
        _check_at_least(self, 0, "seed", "reweighted", "hops")
        _check_positive(self, "negligible", "noise_level", "moved", "undetermined", "bootstrap_block")
        _check_at_least(self, 0.0, "same_minimum", "same_weights", "slow")
        _check_share(self, "strong_correlation", "differing")


@dataclass(frozen=True)
class CompareOptions:
    """How a model is compared with runs, and how large a misfit must be to be reported.

    Parameters
    ----------
    drive : what drives the T→d stage.
    at_noise, uncertain : a residual above the noise by no more than the share at_noise + uncertain/√N is noise: the
        ratio of white noise to its estimate from N samples scatters by 1.35/√N.
    even : the error counts as spread evenly if the interval that holds most of it has less than this many times the
        error that its share of the samples would give.
    turn_k : a turn of the temperature by less [K] does not begin another cycle: the noise of the camera is smaller.
    hold_share : the temperature is held where it changes by less than this share of the run's fastest rate.
    still_k_s : a rate [K/s] so slow is a hold in any run.
    most : the interval with most of the error is the smallest that holds this share of it.
    intervals : equal parts of the temperature range of which that interval is made.
    simpler : a description with more conditions must need less than this part of the samples to replace a simpler one.
    longest_lag_s : longest lag [s] of the correlations.
    bins, map_bins : equal parts of its range over which the residual is averaged, in profiles and in the map.
    fewest : samples without which such a part has no mean.

    Raises
    ------
    LceError
        If a value cannot be used; it names the field.

    Examples
    --------
    >>> CompareOptions(drive="measured", turn_k=3.0).most
    0.5
    """

    drive: Drive = "model"
    at_noise: float = 0.05
    uncertain: float = 4.0
    even: float = 1.4
    turn_k: float = 2.0
    hold_share: float = 0.05
    still_k_s: float = 1e-3
    most: float = 0.5
    intervals: int = 16
    simpler: float = 0.75
    longest_lag_s: float = 20.0
    bins: int = 40
    map_bins: int = 16
    fewest: int = 3

    def __post_init__(self) -> None:
        _check_drive(self.drive)
        _check_counts(self, "intervals", "bins", "map_bins", "fewest")
        _check_at_least(self, 0.0, "at_noise", "uncertain", "turn_k", "still_k_s")
        _check_at_least(self, 1.0, "even")
        _check_share(self, "hold_share", "most", "simpler")
        _check_positive(self, "longest_lag_s")


@dataclass(frozen=True)
class DiagnoseOptions:
    """When an effect counts as missing. Errors are mean squares in units of the sensor's noise: 1 is nothing but noise.

    Parameters
    ----------
    false_alarm : chance of a false addition to a complete model, over the whole library.
    promise : an effect is refitted if the score test promises this share of what would be worth having.
    far : a part of the model is searched on while an effect takes, or promises, this share of what is above the noise
        of a sensor; where the measured temperature drives the deformation, the share ``most``. What differs from run to
        run has to promise that share, and another minimum of the base to take it.
    refitted : candidates that are refitted in each step, those that promise most.
    contenders : of these, how many are refitted to the end and judged on data left out.
    worth_noise, worth_share : an effect is worth having if on data left out it lowers the error of a sensor by more
        than ``worth_noise``, a shift of a quarter of its noise, and by more than the share ``worth_share`` of what is
        above the noise.
    worse : on data left out no error of a sensor of its stage may rise by more than this share, and of no other sensor
        by more than ``bent``, or, behind the heat, by more than half of what the temperature gains if that is more. A
        temperature that the effect does nothing to does not speak.
    agreement : the mean strength of the runs must differ from the null value by so many of its standard errors, which
        include the spread from run to run, and the strength of all runs together by so many of its own.
    alike : the two may differ by this share of the mean, or by so many of the larger of their standard errors.
    most, nearly_all, near : the last effect of a part of the model must take away the share ``most`` of what was left
        above the noise in a sensor, and the share ``nearly_all`` if the RMS error is then still beyond ``near`` times
        the noise; from ``explained`` to ``near`` the share rises in proportion. What takes less stands in for something
        that neither the library nor the base model holds. Where the measured temperature has to drive the deformation,
        it must take ``nearly_all`` and leave no more than ``near``. Beside what differs from run to run, ``explained``
        takes the place of ``near``.
    inflated, concentrated : an effect of the heat only resembles what is missing if what is left makes the squared
        standard error of its strength more than ``inflated`` times what noise alone would. Where the temperature is not
        explained, but within ``near`` times its noise, also more than ``concentrated`` times what an error of that size
        would that lies anywhere in the runs and keeps its sign for a block of 10 s.
    bent : the temperature may be explained worse, by this share, together with the displacement than alone. Where the
        heat alone leaves it beyond ``near`` times its noise, the two are not fitted together.
    explained : a sensor whose RMS error is within so many times its noise is explained.
    compared_from, other_begins, other_base : where the RMS error of the displacement is beyond ``compared_from`` times
        its noise, the other base models are identified. Those are searched for effects that without any leave at most
        ``other_begins`` times the squared error of the best, and of the present one before it got effects of the
        deformation: what is missing may look like the wrong form. If there is one, the equilibrium model is searched as
        well. If in the end one leaves at most the share ``other_base`` of what is above the noise, or no more with
        fewer effects (up to ``worth_noise``), no effect of the deformation is named beside the present one.
    alias_correlation : |ρ| from which two effects look alike.
    alias_evidence : an effect that looks alike and was not refitted joins the set if it promised more than this share.
    min_likelihood_ratio : ratio below which two refitted effects are reported as a set.
    min_visibility : an effect is not named below this visibility: a small error in the form of the base model could
        explain the data as well.
    max_effects : effects that are added at most to each part of the model, the heat and the deformation.
    iterations : most steps of a refit; one with the dynamic model may need a hundred.
    structured : the residual follows a covariate if a curve over it predicts this share of its variance in a run that
        was left out.
    knots : of that curve.
    jumping, jump_size : the residual jumps if innovations of more than ``jump_size`` standard deviations, which noise
        hardly ever reaches, hold more than the share ``jumping`` of the energy.

    Raises
    ------
    LceError
        If a value cannot be used; it names the field.

    Examples
    --------
    >>> DiagnoseOptions(false_alarm=0.01, max_effects=2).refitted
    6
    """

    false_alarm: float = 0.05
    promise: float = 0.1
    far: float = 0.25
    refitted: int = 6
    contenders: int = 3
    worth_noise: float = 0.05
    worth_share: float = 0.05
    worse: float = 0.02
    agreement: float = 2.0
    alike: float = 0.5
    most: float = 0.55
    nearly_all: float = 0.9
    near: float = 2.0
    inflated: float = 30.0
    concentrated: float = 1.7
    bent: float = 0.2
    explained: float = 1.2
    compared_from: float = 1.1
    other_begins: float = 2.0
    other_base: float = 0.5
    alias_correlation: float = 0.95
    alias_evidence: float = 0.5
    min_likelihood_ratio: float = 20.0
    min_visibility: float = 1e-4
    max_effects: int = 4
    iterations: int = 200
    structured: float = 0.15
    knots: int = 9
    jumping: float = 0.05
    jump_size: float = 6.0

    def __post_init__(self) -> None:
        _check_counts(self, "refitted", "contenders", "max_effects", "iterations", "knots")
        _check_share(
            self,
            "false_alarm",
            "promise",
            "far",
            "worth_share",
            "most",
            "nearly_all",
            "structured",
            "jumping",
            "other_base",
        )
        _check_share(self, "alias_correlation")
        _check_at_least(self, 0.0, "worth_noise", "worse", "alike", "bent", "min_visibility", "alias_evidence")
        _check_at_least(
            self, 1.0, "min_likelihood_ratio", "near", "inflated", "explained", "compared_from", "other_begins"
        )
        _check_positive(self, "agreement", "concentrated", "jump_size")


@dataclass(frozen=True)
class DiscoverOptions:
    """How an unknown function is searched for, where no effect of the library explains what is left.

    Parameters
    ----------
    diagnosis : when something is worth having, as for an effect.
    false_alarm : chance that anything is found where nothing is missing.
    lags_s : time constants [s] of the lags that are tried.
    refitted : functions that are refitted, those with the strongest evidence.
    alike : functions whose promised gain is at least this share of the best one's, and whose effect on the sensors has
        a correlation of ``diagnosis.alias_correlation`` with it, cannot be told apart.
    forms : formulas that are refitted, those that promise most.

    Raises
    ------
    LceError
        If a value cannot be used; it names the field.

    Examples
    --------
    >>> DiscoverOptions(refitted=5).forms
    8
    """

    diagnosis: DiagnoseOptions = field(default_factory=DiagnoseOptions)
    false_alarm: float = 0.05
    lags_s: tuple[float, ...] = (0.5, 1.0, 2.0, 4.0, 8.0, 15.0, 30.0, 60.0)
    refitted: int = 3
    alike: float = 0.95
    forms: int = 8

    def __post_init__(self) -> None:
        _check_counts(self, "refitted", "forms")
        _check_share(self, "false_alarm", "alike")
        if not self.lags_s or min(self.lags_s) <= 0.0:
            raise LceError(f"lags_s: {self.lags_s} must be times above 0 s")


@dataclass(frozen=True)
class DesignOptions:
    """What the bench allows, how its sensors measure, and how long a waveform is searched for.

    Parameters
    ----------
    max_power_w : limit of the laser power [W].
    max_temperature_k : limit of the strip's temperature [K].
    duration_s : longest experiment [s], more than 20.
    seed : of the waveforms tried; the same seed gives the same result.
    random_waves, variations, confirmed : waveforms tried at random, variations of the best, and how many of them are
        confirmed by refitting the rival.
    iterations : of that refit, at most.
    camera_step : samples of the waveform, at 100 Hz, for each sample of the camera; the other sensors sample each.
    noise : standard deviation of each sensor's white noise [SI unit of its channel], that of the bench's sensors if
        not given.

    Raises
    ------
    LceError
        If a value cannot be used; it names the field.

    Examples
    --------
    >>> DesignOptions(max_power_w=1.5, duration_s=60.0).camera_step
    10
    """

    max_power_w: float = 2.0
    max_temperature_k: float = 383.15
    duration_s: float = 150.0
    seed: int = 0
    random_waves: int = 120
    variations: int = 40
    confirmed: int = 3
    iterations: int = 60
    camera_step: int = 10
    noise: Mapping[Channel, float] = field(default_factory=lambda: {channel: channel.noise for channel in SENSORS})

    def __post_init__(self) -> None:
        for name, value, low in (("power", self.max_power_w, 0.0), ("duration", self.duration_s, 20.0)):
            if not (math.isfinite(value) and value > low):
                raise LceError(f"design: a {name} of {value:g} leaves no experiment; more than {low:g} is needed")
        _check_positive(self, "max_temperature_k")
        _check_at_least(self, 0, "seed", "variations")
        _check_counts(self, "random_waves", "confirmed", "iterations", "camera_step")
        for channel in SENSORS:
            sigma = self.noise.get(channel, math.nan)
            if not (math.isfinite(sigma) and sigma > 0.0):
                raise LceError(f"noise: {sigma:g} {channel.unit} of the {channel.name} must be above 0")


Options = FitOptions | CompareOptions | DiagnoseOptions | DiscoverOptions | DesignOptions


def _check_drive(drive: str) -> None:
    if drive not in ("model", "measured"):
        raise LceError(f"drive: {drive!r} is neither 'model' nor 'measured'")


def _check_counts(options: Options, *names: str) -> None:
    for name in names:
        if getattr(options, name) < 1:
            raise LceError(f"{name}: {getattr(options, name)} is not 1 or more")


def _check_positive(options: Options, *names: str) -> None:
    for name in names:
        value = getattr(options, name)
        if not (math.isfinite(value) and value > 0.0):
            raise LceError(f"{name}: {value:g} must be above 0")


def _check_at_least(options: Options, low: float, *names: str) -> None:
    for name in names:
        value = getattr(options, name)
        if not (math.isfinite(value) and value >= low):
            raise LceError(f"{name}: {value:g} must be {low:g} or above")


def _check_share(options: Options, *names: str) -> None:
    for name in names:
        value = getattr(options, name)
        if not 0.0 < value <= 1.0:
            raise LceError(f"{name}: {value:g} must be within (0, 1]")
