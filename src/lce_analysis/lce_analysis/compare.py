# SPDX-License-Identifier: Apache-2.0
"""Where a model fails: model and measurement sample by sample, measures of the misfit, and where it sits."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.signal import correlate

from lce_analysis.experiment import Run, Series
from lce_analysis.noise import noise_floor
from lce_analysis.predict import Drive, Prediction, predict
from lce_analysis.regimes import Regime, Share, by_cycle, regime, shares, where_most
from lce_model import KELVIN, LceError, Model
from lce_model.metrics import nrmse, rms_error, rmse_printed, smape

Floats = NDArray[np.float64]
Quantity = Literal["temperature", "displacement"]

UNITS: Final = {"temperature": "°C", "displacement": "m"}
AT_NOISE: Final = 0.05
"""A residual above the noise by no more than this share, and what so few samples leave uncertain, is noise."""
LAGS: Final = 200


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
class Correlation:
    """Correlation of the residual with itself or with the input, at lags (s); inside ±band it is chance."""

    lag_s: Floats
    value: Floats
    band: float


@dataclass(frozen=True)
class Stage:
    """One measured series of a run beside the model: °C or m, all (n,)."""

    quantity: Quantity
    time_s: Floats
    measured: Floats
    modelled: Floats
    regime: Regime
    metrics: Metrics
    autocorrelation: Correlation
    input_correlation: Correlation

    @property
    def residual(self) -> Floats:
        """Measured minus modelled."""
        return self.measured - self.modelled

    @property
    def at_noise(self) -> bool:
        """Is the residual no larger than the noise of the sensor?"""
        return self.metrics.over_noise <= 1.0 + AT_NOISE + 3.0 / float(np.sqrt(self.measured.size))


@dataclass(frozen=True)
class RunComparison:
    """A run and what the model says of it."""

    run: Run
    prediction: Prediction
    stages: tuple[Stage, ...]


@dataclass(frozen=True)
class Comparison:
    """A model beside runs: misfit by run and stage, shares of the squared error by regime, and it in words."""

    model: Model
    runs: tuple[RunComparison, ...]
    shares: dict[Quantity, tuple[Share, ...]]
    cycle_shares: dict[Quantity, dict[int, float]]
    run_shares: dict[Quantity, dict[str, float]]
    sentences: tuple[str, ...]


def compare(model: Model, runs: Sequence[Run], drive: Drive = "model") -> Comparison:
    """Compare the model with every series of every run that it predicts; LceError where there is none."""
    compared = tuple(_run(model, run, drive) for run in runs)
    quantities: list[Quantity] = [
        q for q in ("temperature", "displacement") if any(s.quantity == q for c in compared for s in c.stages)
    ]
    if not quantities:
        raise LceError("none of the runs holds a series that this model predicts")
    found: dict[Quantity, tuple[Share, ...]] = {}
    cycles: dict[Quantity, dict[int, float]] = {}
    per_run: dict[Quantity, dict[str, float]] = {}
    for q in quantities:
        members = [(c.run.name, s) for c in compared for s in c.stages if s.quantity == q]
        regimes, residuals = [s.regime for _, s in members], [s.residual for _, s in members]
        found[q] = shares(regimes, residuals)
        cycles[q] = dict(by_cycle(regimes, residuals))
        total = sum(float(r @ r) for r in residuals) or 1.0
        per_run[q] = {name: float(s.residual @ s.residual) / total for name, s in members}
    sentences = tuple(_sentence(q, [s for c in compared for s in c.stages if s.quantity == q], found[q]) for q in quantities)
    return Comparison(model, compared, found, cycles, per_run, sentences)


def _run(model: Model, run: Run, drive: Drive) -> RunComparison:
    prediction = predict(model, run, drive)
    power = np.zeros_like(prediction.time_s)
    if run.power is not None:
        held = np.searchsorted(run.power.time_s, prediction.time_s + 1e-9, side="right") - 1
        power = run.power.value[np.maximum(held, 0)]
    length = model["strip.length"] if "strip.length" in model else None
    stages = []
    for quantity, series, modelled in (
        ("temperature", run.temperature, prediction.temperature_at_samples_k),
        ("displacement", run.displacement, prediction.displacement_at_samples_m),
    ):
        if series is not None and modelled is not None:
            stages.append(_stage(quantity, series, modelled, prediction, power, length))  # type: ignore[arg-type]
    return RunComparison(run, prediction, tuple(stages))


def _stage(
    quantity: Quantity, series: Series, modelled: Floats, prediction: Prediction, power_w: Floats, length_m: float | None
) -> Stage:
    offset = KELVIN if quantity == "temperature" else 0.0
    measured, modelled = series.value - offset, modelled - offset
    as_lambda = length_m if quantity == "displacement" else None
    metrics = Metrics(
        rms=rms_error(modelled, measured),
        rmse_printed=rmse_printed(modelled, measured),
        nrmse=nrmse(modelled, measured),
        smape=smape(1.0 - modelled / as_lambda, 1.0 - measured / as_lambda) if as_lambda else smape(modelled, measured),
        noise=noise_floor(series),
    )
    here = regime(prediction.time_s, prediction.temperature_k, power_w, series.time_s)
    step = float(np.median(np.diff(series.time_s)))
    residual = measured - modelled
    return Stage(
        quantity, series.time_s, measured, modelled, here, metrics,
        _correlation(residual, residual, step), _correlation(residual, here.power_w, step),
    )


def _correlation(a: Floats, b: Floats, step_s: float) -> Correlation:
    """Correlation coefficient of a with b earlier by each lag."""
    a, b = a - a.mean(), b - b.mean()
    n, lags = a.size, min(LAGS, a.size - 1)
    scale = float(np.sqrt((a @ a) * (b @ b))) or 1.0
    value = np.asarray(correlate(a, b, mode="full", method="fft")[n - 1 : n + lags] / scale, dtype=np.float64)
    return Correlation(np.arange(lags + 1, dtype=np.float64) * step_s, value, 1.96 / float(np.sqrt(n)))


def _sentence(quantity: Quantity, stages: Sequence[Stage], found: Sequence[Share]) -> str:
    name, symbol = ("temperature", "T") if quantity == "temperature" else ("displacement", "d")
    worst = max(s.metrics.over_noise for s in stages)
    if all(s.at_noise for s in stages):
        return f"The model explains the {name} down to the sensor noise ({_amount(quantity, stages[0].metrics.noise)} rms)."
    branch, low, high, share = where_most(found)
    return (
        f"{share:.0%} of the squared error of {symbol} sits on the {branch} branch between {low:.0f} and {high:.0f} °C; "
        f"the residual is up to {worst:.1f} × the sensor noise."
    )


def _amount(quantity: Quantity, value: float) -> str:
    return f"{value:.2g} K" if quantity == "temperature" else f"{value * 1e6:.2g} µm"


def as_json(comparison: Comparison) -> dict[str, Any]:
    """Plain numbers for a JSON file: SI and °C, every key always present, null where a stage was not compared."""
    return {
        "model": {
            "thermal": comparison.model.thermal,
            "deformation": comparison.model.deformation,
            "effects": list(comparison.model.effects),
        },
        "sentences": list(comparison.sentences),
        "runs": [
            {"name": c.run.name, "sha256": c.run.sha256}
            | {q: next((_metrics(s) for s in c.stages if s.quantity == q), None) for q in UNITS}
            for c in comparison.runs
        ],
        "error_shares": {
            q: {
                "regimes": [vars(s) for s in comparison.shares.get(q, ())],  # type: ignore[call-overload]
                "cycles": {str(n): v for n, v in comparison.cycle_shares.get(q, {}).items()},  # type: ignore[call-overload]
                "runs": comparison.run_shares.get(q, {}),  # type: ignore[call-overload]
            }
            for q in UNITS
        },
    }


def _metrics(stage: Stage) -> dict[str, float]:
    unit = "c" if stage.quantity == "temperature" else "m"
    m = stage.metrics
    return {
        f"rms_{unit}": m.rms, f"rmse_printed_{unit}": m.rmse_printed, "nrmse": m.nrmse, "smape": m.smape,
        f"noise_floor_{unit}": m.noise, "rms_over_noise": m.over_noise,
    }
