# SPDX-License-Identifier: Apache-2.0
"""Are the numbers of a fit right? Data of the model itself plus sensor noise, many seeds.

Two bars: the residual is at the noise floor, within 5 %; what the fit calls determined lies within three of its
standard errors of the truth. Combinations of parameters are judged by the likelihood, all at once: the truth lies in
the region that holds 99.7 % of it (three standard errors); for a linear model that is the same.
"""

import math

import numpy as np
from scipy.stats import chi2
from tqdm import tqdm

from lce_analysis.identification import FitResult, fit
from lce_analysis.identification.transformation import Transformation
from lce_analysis.options import FitOptions
from lce_analysis.prediction import predict
from lce_data.channels import DISPLACEMENT, TEMPERATURE
from lce_data.run import Run, Series
from lce_model import Model, default_model, simulate

CAMERA_K, DISTANCE_M = 0.06, 4e-6
HEATED_S = (16, 17, 18, 19, 20, 21)
SECONDS = 60.0


def campaign(strip: Model, seed: int) -> list[Run]:
    """Six pulses of (4.20), 60 s each, camera at 10 Hz and distance at 100 Hz."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, SECONDS, 0.01)
    runs = []
    for heated in HEATED_S:
        pulse = 0.4 * np.sin(math.pi / (2 * heated) * time) + 1.5
        power = np.where(time < heated, pulse, 0.0)
        true = simulate(strip, time, power)
        seen = true.temperature_k[::10] + CAMERA_K * rng.standard_normal(time[::10].size)
        moved = true.displacement_m + DISTANCE_M * rng.standard_normal(time.size)
        series = Series(time, power), Series(time[::10], seen), Series(time, moved)
        runs.append(Run.of(f"pulse-{heated}", *series, sha256=f"{seed}-{heated}"))
    return runs


def over_noise(result: FitResult, runs: list[Run]) -> float:
    """RMS residual of the displacement over the noise that was put in."""
    squares = [
        np.mean((predict(result.model, run).at_samples[DISPLACEMENT] - run.series[DISPLACEMENT].value) ** 2)
        for run in runs
    ]
    return float(np.sqrt(np.mean(squares)) / DISTANCE_M)


def deviations(result: FitResult, truth: Model) -> list[float]:
    """Distance from the truth in standard errors, of the determined parameters."""
    report = result.identifiability
    assert report is not None
    index = [result.model.index(key) for key in report.keys]
    transformation = Transformation.of([result.model.values[i] for i in index])
    found, true = (
        np.array([scale.place(p) for scale, p in zip(transformation.scales, model.vector[index], strict=True)])
        for model in (result.model, truth)
    )
    off = (found - true) / transformation.natural_unit
    return [float(off[j] / report.standard_errors[j]) for j in np.flatnonzero(report.determined)]


def chi_squared(model: Model, runs: list[Run]) -> float:
    """Squared residual of both sensors in units of their noise."""
    total = 0.0
    for run in runs:
        found = predict(model, run)
        for channel, rms in ((TEMPERATURE, CAMERA_K), (DISPLACEMENT, DISTANCE_M)):
            total += float(np.sum((found.at_samples[channel] - run.series[channel].value) ** 2)) / rms**2
    return total


def holds_truth(result: FitResult, truth: Model, runs: list[Run]) -> bool:
    """Is the truth in the region that holds 99.7 % of the likelihood?"""
    free = sum(not v.fixed for v in truth.values)
    return chi_squared(truth, runs) - chi_squared(result.model, runs) <= chi2.ppf(0.9973, free)


def measure(seeds: int) -> list[str]:
    """The table, as lines of Markdown."""
    lines = [
        f"## Recovery: {seeds} seeds, six pulses of 60 s (T_h 16–21), data of the model itself plus sensor noise",
        "",
        "| model | residual over noise, range | seeds within 5 % | parameters in 3 s.e. | all combinations |",
        "|---|---|---|---|---|",
    ]
    with tqdm(total=2 * seeds, unit="fit", dynamic_ncols=True) as bar:
        for deformation in ("equilibrium", "dynamic"):
            truth = default_model("lumped", deformation)
            ratios: list[float] = []
            single: list[float] = []
            region: list[bool] = []
            for seed in range(seeds):
                bar.set_description_str(f"{deformation}, seed {seed}")
                runs = campaign(truth, seed)
                result = fit(default_model("lumped", deformation), runs, options=FitOptions(seed=seed))
                ratios.append(over_noise(result, runs))
                single += deviations(result, truth)
                region.append(holds_truth(result, truth, runs))
                bar.update()
            lines.append(
                f"| {deformation} | {min(ratios):.3f}–{max(ratios):.3f} | {_share([r <= 1.05 for r in ratios])} | "
                f"{_share([abs(x) <= 3.0 for x in single])} | {_share(region)} |"
            )
    return [*lines, ""]


def _share(found: list[bool]) -> str:
    return f"{sum(found)} of {len(found)} ({sum(found) / max(len(found), 1):.1%})"
