# SPDX-License-Identifier: Apache-2.0
"""Do the error bands hold what they promise: how often 95 % bands of an unseen run hold the truth."""

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from lce_analysis.identification import fit
from lce_analysis.identification.uncertainty import band
from lce_analysis.options import FitOptions
from lce_data.channels import DISPLACEMENT
from lce_data.run import Run, Series
from lce_data.waveforms import SHAPES
from lce_model import Model, default_model, simulate

Floats = NDArray[np.float64]
MODELS = ("equilibrium", "kinetic")
TRAIN = (("pulse", {"th": 15.0, "rest": 45.0}), ("stairs", {"hold": 8.0, "steps": 4.0, "rest": 40.0}))
UNSEEN = ("cycles", {"period": 24.0, "count": 2.0, "rest": 30.0})
EVERY = 5
"""Of the waveform's samples: 20 Hz is enough, and five times as fast."""


def recorded(model: Model, shape: str, options: dict[str, float], random: np.random.Generator) -> tuple[Run, Floats]:
    """A run of the model with the noise of the sensors, and its true displacement."""
    power = SHAPES[shape].power_w({k: (v,) for k, v in options.items()})[::EVERY]
    times = np.arange(power.size) * 0.01 * EVERY
    out = simulate(model, times, power)
    warm = Series(times[::2], out.temperature_k[::2] + 0.06 * random.standard_normal(times[::2].size))
    moved = Series(times, out.displacement_m + 4e-6 * random.standard_normal(times.size))
    return Run.of(shape, Series(times, power), warm, moved), out.displacement_m


def covered(deformation: str, seed: int) -> tuple[float, float]:
    """(share of the samples whose truth is in the band, mean half-width [m]) of one fit to two runs."""
    gain = 45.0 if deformation == "kinetic" else 30.0
    truth = default_model("lumped", deformation).set({"lumped.gain": gain})
    random = np.random.default_rng(seed)
    result = fit(truth, [recorded(truth, *run, random)[0] for run in TRAIN], options=FitOptions(seed=seed))
    run, true_m = recorded(truth, *UNSEEN, random)
    found = band(result.problem, run)
    error_m = found.error[DISPLACEMENT]
    inside = np.abs(found.value[DISPLACEMENT] - true_m) <= error_m
    # Before the strip moves there is nothing to predict, and no error to be wrong about.
    moving = error_m > 1e-3 * error_m.max()
    return float(np.mean(inside[moving])), float(np.mean(error_m))


def measure(seeds: int) -> list[str]:
    """The share of samples in the band, over seeds, for each model."""
    text = [
        f"## Error bands of an unseen run, {seeds} seeds", "",
        "Fitted to a pulse and a staircase with sensor noise; predicted: minor loops. 95 % bands of the displacement.",
        "",
        "| model | samples inside the band | standard error | mean half-width µm |", "|---|---|---|---|",
    ]  # fmt: skip
    for deformation in MODELS:
        found = [covered(deformation, seed) for seed in tqdm(range(seeds), desc=deformation, unit="fit")]
        shares, widths = np.array(found).T
        spread = np.std(shares, ddof=1) / np.sqrt(seeds)
        text.append(f"| {deformation} | {np.mean(shares):.1%} | {spread:.1%} | {1e6 * np.mean(widths):.2f} |")
    return [*text, ""]
