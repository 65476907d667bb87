# SPDX-License-Identifier: Apache-2.0
"""Where a model fails: model and measurement sample by sample, measures of the misfit, and where it sits.

Everything a page draws is here as plain arrays; nothing here draws.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from lce_analysis.comparison.conditions import ErrorShares, Regime, error_shares, regime
from lce_analysis.comparison.metrics import nrmse, rms_error, rmse_printed, smape
from lce_analysis.comparison.residuals import (
    Correlation,
    Profile,
    ResidualMap,
    autocorrelation,
    cross_correlation,
    profile,
    residual_map,
)
from lce_analysis.prediction import Drive, Prediction, predict
from lce_data.errors import LceError
from lce_data.noise import noise_floor
from lce_data.run import Run, Series
from lce_data.units import KELVIN
from lce_model import Model

Floats = NDArray[np.float64]
Quantity = Literal["temperature", "displacement"]

QUANTITIES: Final[tuple[Quantity, ...]] = ("temperature", "displacement")
AT_NOISE: Final = 0.05
UNCERTAIN: Final = 4.0
"""A residual above the noise by no more than the share AT_NOISE + UNCERTAIN/√N is noise: the ratio of white noise to
its estimate from N samples scatters by 1.35/√N."""
EVEN: Final = 1.4
"""The error is spread evenly where even the stretch with most of it has less than so many times its samples' share."""


@dataclass(frozen=True)
class Metrics:
    """Measures of misfit of one series, in its unit (K for a temperature difference) or as fractions.

    rms is √(Σe²/N); rmse_printed is (4.18) as printed, (1/N)√Σe²; nrmse is (4.24); smape is (4.23), of the temperature
    in °C, and of λ = 1 - d/L0 for the displacement, as in the dissertation. noise is the sensor's.
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
class Stage:
    """One measured series of a run beside the model: °C or m, all (n,).

    input_correlation is with what drives the stage: the power for the temperature, the temperature for the
    displacement. profiles are over "temperature" [°C], "rate" [K/s] and "power" [W].
    """

    quantity: Quantity
    time_s: Floats
    measured: Floats
    modelled: Floats
    regime: Regime
    metrics: Metrics
    autocorrelation: Correlation
    input_correlation: Correlation
    profiles: Mapping[str, Profile]
    map: ResidualMap

    @property
    def residual(self) -> Floats:
        """Measured minus modelled."""
        return self.measured - self.modelled

    @property
    def at_noise(self) -> bool:
        """Is the residual no larger than the noise of the sensor?"""
        return self.metrics.over_noise <= 1.0 + AT_NOISE + UNCERTAIN / float(np.sqrt(self.measured.size))


@dataclass(frozen=True)
class RunComparison:
    """A run and what the model says of it."""

    run: Run
    prediction: Prediction
    stages: tuple[Stage, ...]

    def stage(self, quantity: Quantity) -> Stage | None:
        """The stage of one quantity, None where it was not measured or is not modelled."""
        return next((s for s in self.stages if s.quantity == quantity), None)


@dataclass(frozen=True)
class Comparison:
    """A model beside runs: misfit by run and stage, shares of the squared error by regime, and it in words.

    shares and sentences have one for each quantity, that with the largest residual in units of its noise first.
    """

    model: Model
    drive: Drive
    runs: tuple[RunComparison, ...]
    shares: Mapping[Quantity, ErrorShares]
    sentences: tuple[str, ...]


def compare(model: Model, runs: Sequence[Run], drive: Drive = "model") -> Comparison:
    """Compare the model with every series of every run that it predicts; LceError where there is none."""
    compared = tuple(_run(model, run, drive) for run in runs)
    stages: dict[Quantity, list[tuple[str, Stage]]] = {
        q: [(c.run.name, stage) for c in compared if (stage := c.stage(q)) is not None] for q in QUANTITIES
    }
    if not any(stages.values()):
        raise LceError("none of the runs holds a series that this model predicts")
    worst_first = sorted(
        (q for q in stages if stages[q]), key=lambda q: max(s.metrics.over_noise for _, s in stages[q]), reverse=True
    )
    found = {q: error_shares([(name, s.regime, s.residual) for name, s in stages[q]]) for q in worst_first}
    return Comparison(model, drive, compared, found, tuple(_sentence(q, stages[q], found[q]) for q in worst_first))


def _run(model: Model, run: Run, drive: Drive) -> RunComparison:
    prediction = predict(model, run, drive)
    power = np.zeros_like(prediction.time_s)
    if run.power is not None:
        held = np.searchsorted(run.power.time_s, prediction.time_s + 1e-9, side="right") - 1
        power = run.power.value[np.maximum(held, 0)]
    course = regime(prediction.time_s, prediction.temperature_k, power)
    modelled = prediction.temperature_at_samples_k, prediction.displacement_at_samples_m
    stages = []
    for quantity, series, model_says in zip(QUANTITIES, (run.temperature, run.displacement), modelled, strict=True):
        if series is not None and model_says is not None:
            try:
                stages.append(_stage(model, quantity, series, model_says, course))
            except LceError as error:
                raise LceError(f"{run.name}: {quantity}: {error}") from None
    return RunComparison(run, prediction, tuple(stages))


def _stage(model: Model, quantity: Quantity, series: Series, modelled: Floats, course: Regime) -> Stage:
    offset = KELVIN if quantity == "temperature" else 0.0
    measured, modelled = series.value - offset, modelled - offset
    residual = measured - modelled
    here = course.at(series.time_s)
    step = float(np.median(np.diff(series.time_s)))
    drive = here.power_w if quantity == "temperature" else here.temperature_c
    return Stage(
        quantity,
        series.time_s,
        measured,
        modelled,
        here,
        _metrics(model, quantity, measured, modelled, noise_floor(series)),
        autocorrelation(residual, step),
        cross_correlation(residual, drive, step),
        {
            name: profile(values, here.heating, residual)
            for name, values in (("temperature", here.temperature_c), ("rate", here.rate_k_s), ("power", here.power_w))
        },
        residual_map(here, residual),
    )


def _metrics(model: Model, quantity: Quantity, measured: Floats, modelled: Floats, noise: float) -> Metrics:
    ratio = smape(modelled, measured)
    if quantity == "displacement" and "strip.length" in model:
        length = model["strip.length"]
        ratio = smape(1.0 - modelled / length, 1.0 - measured / length)
    return Metrics(
        rms_error(modelled, measured), rmse_printed(modelled, measured), nrmse(modelled, measured), ratio, noise
    )


def _sentence(quantity: Quantity, stages: Sequence[tuple[str, Stage]], found: ErrorShares) -> str:
    symbol = "T" if quantity == "temperature" else "d"
    name, worst = max(stages, key=lambda item: item[1].metrics.over_noise)
    if all(s.at_noise for _, s in stages):
        noise = _amount(quantity, worst.metrics.noise)
        return f"The model explains the {quantity} down to the sensor noise ({noise} rms)."
    worst_run = f"at worst ({name})" if len(stages) > 1 else "in all"
    rms, over = _amount(quantity, worst.metrics.rms), worst.metrics.over_noise
    size = f"{worst_run} the residual is {rms} rms, {over:.3g} × the noise"
    most = found.most
    if most.error_share < EVEN * most.sample_share:
        everywhere = f"The squared error of {symbol} is spread evenly over temperatures, branches, holds and ramps"
        return f"{everywhere}{_one_run(found)}; {size}."
    branch = "both branches" if most.branch is None else f"the {most.branch} branch"
    held = {None: "", True: ", while the temperature is held,", False: ", while it ramps,"}[most.held]
    return (
        f"{most.error_share:.0%} of the squared error of {symbol} sits on {branch}{held} between {most.lower_c:.0f} "
        f"and {most.upper_c:.0f} °C, in {most.sample_share:.0%} of the samples{_one_run(found)}; {size}."
    )


def _one_run(found: ErrorShares) -> str:
    """Words for a run that holds most of the error, and more of it than its share."""
    name, share = max(found.runs.items(), key=lambda item: item[1].error_share)
    much = len(found.runs) > 1 and share.error_share > max(0.5, EVEN * share.sample_share)
    return f"; {name} alone holds {share.error_share:.0%} of it" if much else ""


def _amount(quantity: Quantity, value: float) -> str:
    return f"{value:.2g} K" if quantity == "temperature" else f"{value * 1e6:.3g} µm"


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
            {"name": c.run.name, "sha256": c.run.sha256} | {q: _stage_json(c.stage(q)) for q in QUANTITIES}
            for c in comparison.runs
        ],
        "error_shares": {
            q: _plain(asdict(comparison.shares[q])) if q in comparison.shares else None for q in QUANTITIES
        },
    }


def _stage_json(stage: Stage | None) -> dict[str, Any] | None:
    if stage is None:
        return None
    unit = "c" if stage.quantity == "temperature" else "m"
    m = stage.metrics
    correlations = {"autocorrelation": stage.autocorrelation, "input_correlation": stage.input_correlation}
    return {
        f"rms_{unit}": m.rms,
        f"rmse_printed_{unit}": m.rmse_printed,
        "nrmse": m.nrmse,
        "smape": m.smape,
        f"noise_floor_{unit}": m.noise,
        "rms_over_noise": m.over_noise,
        **{name: _plain(asdict(c) | {"outside": c.outside}) for name, c in correlations.items()},
        "profiles": _plain({name: asdict(p) for name, p in stage.profiles.items()}),
        "map": _plain(asdict(stage.map)),
        "series": _plain({"measured": stage.measured, "modelled": stage.modelled, **asdict(stage.regime)}),
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
