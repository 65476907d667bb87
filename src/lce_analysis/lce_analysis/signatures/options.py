# SPDX-License-Identifier: Apache-2.0
"""When a signature counts as seen: one frozen class, each field with its unit and its reason."""

from dataclasses import dataclass

from lce_data.errors import LceError


@dataclass(frozen=True)
class SignatureOptions:
    """Thresholds of the catalogue. The p-values of periods and steps count all the places where their test looked.

    Parameters
    ----------
    false_alarm : chance of a false signature of one kind in one sensor.
    least_share : a signature that accounts for less than this share of the residual's energy is not told.
    explained : a sensor whose RMS residual is within so many times its noise has no curve, drift or difference left.
    clip_flat : within a flat end the sensor may scatter by so many times its noise about one value.
    clip_excess : there the model has to pass the end by so many times the noise (root mean square).
    clip_kink : where a flat end begins, the measured slope has to break by this share of the slope before, and the
        slope of the model by less than half of that.
    clip_samples : samples that the flat ends must hold together.
    rounding : a sensor is called rounded from a step of so many times its noise.
    cycles : a period is looked for where a run holds at least so many of them.
    line : a line may stand out of the background of one run by no more than this in the sum over the runs, so that
        no single run decides; its factor is 1 in three runs or more.
    line_chance : chance of a false period in one sensor: a misfit that repeats itself within a run has lines, too.
    input_line : a run does not count at a frequency at which its own laser power has a line of so many times the
        background.
    step_size : a jump counts from so many robust standard deviations of what the residual does elsewhere.
    many_step_size : the same where there are ten or more.
    step_noise : and from so many times the noise of the sensor.
    step_s : span [s] before and after a jump over which the residual is taken for straight, at least ten samples.
    turn_s : no jump is looked for within so many seconds of a jump of the laser power or a turn of the temperature,
        where the error of any model is largest.
    outlier_size : a single reading is an outlier beyond so many robust standard deviations.
    fewest_outliers : of them.
    structured : the residual follows a covariate, or the other sensor, if a curve over it predicts this share of its
        energy in runs left out.
    drifting : the residual drifts if a straight line over time does so: less is a slow effect that looks like one.
    repeats : the residual of the temperature repeats itself, and is no disturbance, if a curve predicts this share.
    knots : of that curve.
    shifts : random shifts in time of the residual against the covariate; they give its p-value.
    differs : the runs differ if a level and a scale for each take this share of what no common curve takes.
    block_s : residuals further apart than this [s] are taken as independent.
    louder : the noise depends on the signal if it is so many times larger at one end of the signal's range.

    Raises
    ------
    LceError
        If a value is not above 0.

    Examples
    --------
    >>> SignatureOptions(structured=0.3).knots
    9
    """

    false_alarm: float = 0.01
    least_share: float = 0.03
    explained: float = 1.2
    clip_flat: float = 3.0
    clip_excess: float = 4.0
    clip_kink: float = 0.6
    clip_samples: int = 20
    rounding: float = 2.0
    cycles: float = 5.0
    line: float = 7.0
    line_chance: float = 1e-4
    input_line: float = 6.0
    step_size: float = 8.0
    many_step_size: float = 5.5
    step_noise: float = 4.0
    step_s: float = 0.5
    turn_s: float = 1.5
    outlier_size: float = 7.0
    fewest_outliers: int = 3
    structured: float = 0.15
    drifting: float = 0.5
    repeats: float = 0.3
    knots: int = 9
    shifts: int = 199
    differs: float = 0.3
    block_s: float = 10.0
    louder: float = 1.6

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not value > 0.0:
                raise LceError(f"{name}: {value:g} must be above 0")
