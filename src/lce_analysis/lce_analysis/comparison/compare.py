# SPDX-License-Identifier: Apache-2.0
"""Where a model fails: model and measurement sample by sample, measures of the misfit, and where it sits.

Everything a page draws is here as plain arrays; nothing here draws.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lce_analysis.comparison.conditions import ErrorShares, OperatingConditions, error_shares, operating_conditions
from lce_analysis.comparison.metrics import nrmse, rms_error, rmse_printed, smape
from lce_analysis.comparison.residuals import (
    Correlation,
    ResidualMap,
    ResidualProfile,
    autocorrelation,
    cross_correlation,
    residual_map,
    residual_profile,
)
from lce_analysis.options import CompareOptions, Drive
from lce_analysis.prediction import Prediction, predict
from lce_data.channels import DISPLACEMENT, POWER, SENSORS, Channel
from lce_data.errors import LceError
from lce_data.noise import noise_floor
from lce_data.progress import CancelToken, Progress, silent, watched
from lce_data.run import Run, Series
from lce_model import Model

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Metrics:
    """Measures of misfit of one series, in its unit (K for a temperature difference) or as fractions.

    Equation numbers are those of Wu (2021).

    Attributes
    ----------
    rms : √(Σe²/N).
    rmse_printed : (4.18) as printed, (1/N)√Σe².
    nrmse : (4.24), as a fraction.
    smape : (4.23), as a fraction: of the temperature in °C, and of λ = 1 - d/L0 for the displacement.
    noise : RMS noise of the sensor, estimated from the series.
    """

    rms: float
    rmse_printed: float
    nrmse: float
    smape: float
    noise: float

    @property
    def over_noise(self) -> float:
        """RMS error in units of the noise."""
        return self.rms / self.noise


@dataclass(frozen=True)
class ChannelComparison:
    """One measured series of a run beside the model, all (n,), in the recorded unit of its channel (°C, m).

    Attributes
    ----------
    channel : what was measured.
    time_s : times of the samples [s].
    measured, modelled : values at those times.
    conditions : what the strip was doing at those times.
    metrics : measures of the misfit.
    autocorrelation : of the residual with itself.
    input_correlation : of the residual with what drives the channel: the power for the temperature, the temperature for
        all others.
    profiles : mean residual over "temperature" [°C], "rate" [K/s] and "power" [W].
    map : mean residual over temperature, cycle and branch.
    """

    channel: Channel
    time_s: Floats
    measured: Floats
    modelled: Floats
    conditions: OperatingConditions
    metrics: Metrics
    autocorrelation: Correlation
    input_correlation: Correlation
    profiles: Mapping[str, ResidualProfile]
    map: ResidualMap

    @property
    def residual(self) -> Floats:
        """Measured minus modelled."""
        return self.measured - self.modelled

    def at_noise(self, options: CompareOptions = CompareOptions()) -> bool:
        """Is the residual no larger than the noise of the sensor?"""
        scatter = options.uncertain / float(np.sqrt(self.measured.size))
        return self.metrics.over_noise <= 1.0 + options.at_noise + scatter


@dataclass(frozen=True)
class RunComparison:
    """A run and what the model says of it.

    Attributes
    ----------
    run : what was measured.
    prediction : the strip and its sensors, as the model has them [SI].
    channels : measured beside modelled, for each channel that was measured and that the model predicts.
    """

    run: Run
    prediction: Prediction
    channels: Mapping[Channel, ChannelComparison]


@dataclass(frozen=True)
class Comparison:
    """A model beside runs: misfit by run and channel, shares of the squared error by condition, and sentences.

    Attributes
    ----------
    model : the model.
    options : how it was compared.
    runs : one for each run, with its misfit by channel.
    shares : where the squared error sits, by channel; that with the largest residual in units of its noise comes first.
    sentences : one for each channel, in the same order.
    """

    model: Model
    options: CompareOptions
    runs: tuple[RunComparison, ...]
    shares: Mapping[Channel, ErrorShares]
    sentences: tuple[str, ...]

    @property
    def drive(self) -> Drive:
        """What drove the T→d stage."""
        return self.options.drive


def compare(
    model: Model,
    runs: Sequence[Run],
    options: CompareOptions = CompareOptions(),
    progress: Progress = silent,
    cancel: CancelToken | None = None,
) -> Comparison:
    """Compare a model with every series of every run that it predicts.

    Parameters
    ----------
    model, runs : what is compared.
    options : what drives the deformation, and when a misfit counts.
    progress : called before each run.
    cancel : stops between two runs and raises Cancelled.

    Returns
    -------
    Comparison
        Misfit by run and channel, where it sits, and sentences; its arrays are in SI or °C.

    Raises
    ------
    LceError
        If no run holds a series that the model predicts, or a run lacks an input that the model needs.

    Examples
    --------
    >>> import lce_analysis as lce
    >>> found = lce.compare(model, lce.read_runs(["runs/prbs"]))  # doctest: +SKIP
    >>> print(found.sentences[0])  # doctest: +SKIP
    """
    progress, compared = watched(progress, cancel), []
    for i, run in enumerate(runs):
        progress(f"comparing {run.name}", i, len(runs), float("nan"))
        compared.append(_run(model, run, options))
    members: dict[Channel, list[tuple[str, ChannelComparison]]] = {}
    for channel in SENSORS:
        if found := [(c.run.name, c.channels[channel]) for c in compared if channel in c.channels]:
            members[channel] = found
    if not members:
        raise LceError("none of the runs holds a series that this model predicts")
    worst_first = sorted(members, key=lambda c: max(m.metrics.over_noise for _, m in members[c]), reverse=True)
    shares = {
        c: error_shares([(name, m.conditions, m.residual) for name, m in members[c]], options) for c in worst_first
    }
    sentences = tuple(_sentence(c, members[c], shares[c], options) for c in worst_first)
    return Comparison(model, options, tuple(compared), shares, sentences)


def _run(model: Model, run: Run, options: CompareOptions) -> RunComparison:
    prediction = predict(model, run, options.drive)
    power = np.zeros_like(prediction.time_s)
    if run.power is not None:
        held = np.searchsorted(run.power.time_s, prediction.time_s + 1e-9, side="right") - 1
        power = run.power.value[np.maximum(held, 0)]
    course = operating_conditions(prediction.time_s, prediction.temperature_k, power, options)
    channels = {}
    for channel, modelled in prediction.at_samples.items():
        try:
            channels[channel] = _channel(model, channel, run.series[channel], modelled, course, options)
        except LceError as error:
            raise LceError(f"{run.name}: {channel.name}: {error}") from None
    return RunComparison(run, prediction, channels)


def _channel(
    model: Model,
    channel: Channel,
    series: Series,
    modelled_si: Floats,
    course: OperatingConditions,
    options: CompareOptions,
) -> ChannelComparison:
    measured, modelled = channel.recorded.from_si(series.value), channel.recorded.from_si(modelled_si)
    residual = measured - modelled
    here = course.at(series.time_s)
    step = float(np.median(np.diff(series.time_s)))
    drive = here.power_w if channel.driven_by is POWER else here.temperature_c
    return ChannelComparison(
        channel,
        series.time_s,
        measured,
        modelled,
        here,
        _metrics(model, channel, measured, modelled, noise_floor(series)),
        autocorrelation(residual, step, options),
        cross_correlation(residual, drive, step, options),
        {
            name: residual_profile(values, here.heating, residual, options)
            for name, values in (("temperature", here.temperature_c), ("rate", here.rate_k_s), ("power", here.power_w))
        },
        residual_map(here, residual, options),
    )


def _metrics(model: Model, channel: Channel, measured: Floats, modelled: Floats, noise: float) -> Metrics:
    ratio = smape(modelled, measured)
    if channel is DISPLACEMENT and "strip.length" in model:
        length = model["strip.length"]
        ratio = smape(1.0 - modelled / length, 1.0 - measured / length)
    return Metrics(
        rms_error(modelled, measured), rmse_printed(modelled, measured), nrmse(modelled, measured), ratio, noise
    )


def _sentence(
    channel: Channel, members: Sequence[tuple[str, ChannelComparison]], found: ErrorShares, options: CompareOptions
) -> str:
    symbol = channel.symbol
    name, worst = max(members, key=lambda item: item[1].metrics.over_noise)
    if all(m.at_noise(options) for _, m in members):
        noise = _amount(channel, worst.metrics.noise)
        return f"The model explains the {channel.name} down to the sensor noise ({noise} rms)."
    worst_run = f"at worst ({name})" if len(members) > 1 else "in all"
    rms, over = _amount(channel, worst.metrics.rms), worst.metrics.over_noise
    size = f"{worst_run} the residual is {rms} rms, {over:.3g} × the noise"
    most = found.most
    if most.error_share < options.even * most.sample_share:
        everywhere = f"The squared error of {symbol} is spread evenly over temperatures, branches, holds and ramps"
        return f"{everywhere}{_one_run(found, options)}; {size}."
    branch = "both branches" if most.branch is None else f"the {most.branch} branch"
    held = {None: "", True: ", while the temperature is held,", False: ", while it ramps,"}[most.held]
    return (
        f"{most.error_share:.0%} of the squared error of {symbol} sits on {branch}{held} between {most.lower_c:.0f} "
        f"and {most.upper_c:.0f} °C, in {most.sample_share:.0%} of the samples{_one_run(found, options)}; {size}."
    )


def _one_run(found: ErrorShares, options: CompareOptions) -> str:
    """Words for a run that holds most of the error, and more of it than its share."""
    name, share = max(found.runs.items(), key=lambda item: item[1].error_share)
    much = len(found.runs) > 1 and share.error_share > max(options.most, options.even * share.sample_share)
    return f"; {name} alone holds {share.error_share:.0%} of it" if much else ""


def _amount(channel: Channel, value: float) -> str:
    """A difference [recorded unit] as people say it: 0.21 K, 8.53 µm."""
    return f"{value * channel.difference.factor:.{channel.digits}g} {channel.difference.symbol}"


def as_json(comparison: Comparison) -> dict[str, Any]:
    """Plain numbers for a JSON file: SI and °C, every key always present, null where there is nothing.

    Series and correlations are lists rounded to six digits.
    """
    return {
        "model": {
            "thermal": comparison.model.thermal,
            "deformation": comparison.model.deformation,
            "effects": list(comparison.model.effect_names),
        },
        "drive": comparison.drive,
        "sentences": list(comparison.sentences),
        "runs": [
            {"name": c.run.name, "sha256": c.run.sha256}
            | {channel.name: _channel_json(c.channels.get(channel)) for channel in SENSORS}
            for c in comparison.runs
        ],
        "error_shares": {channel.name: _shares_json(comparison.shares.get(channel)) for channel in SENSORS},
    }


def _shares_json(shares: ErrorShares | None) -> dict[str, Any] | None:
    if shares is None:
        return None
    content = asdict(shares)
    return {"regimes": _plain(content.pop("conditions")), **_plain(content)}


def _channel_json(compared: ChannelComparison | None) -> dict[str, Any] | None:
    if compared is None:
        return None
    unit, m = compared.channel.suffix, compared.metrics
    correlations = {"autocorrelation": compared.autocorrelation, "input_correlation": compared.input_correlation}
    return {
        f"rms_{unit}": m.rms,
        f"rmse_printed_{unit}": m.rmse_printed,
        "nrmse": m.nrmse,
        "smape": m.smape,
        f"noise_floor_{unit}": m.noise,
        "rms_over_noise": m.over_noise,
        **{name: _plain(asdict(c) | {"outside": c.outside}) for name, c in correlations.items()},
        "profiles": _plain({name: asdict(p) for name, p in compared.profiles.items()}),
        "map": _plain(asdict(compared.map)),
        "series": _plain({"measured": compared.measured, "modelled": compared.modelled, **asdict(compared.conditions)}),
    }


def _plain(value: Any) -> Any:
    """Arrays as lists, NaN as null, keys as text: what JSON can say."""
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if isinstance(value, np.ndarray):
        if value.dtype.kind != "f":
            return value.astype(int).tolist()
        return [_plain(v) for v in value] if value.ndim > 1 else [_number(v) for v in value.tolist()]
    return _number(value) if isinstance(value, float) else value


def _number(value: float) -> float | None:
    return float(f"{value:.6g}") if np.isfinite(value) else None
