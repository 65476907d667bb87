# SPDX-License-Identifier: Apache-2.0
"""Control of a strip that the models were not made for: identified first, as on a bench, from noisy recordings."""

from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from comparison import campaign
from control_cases import MAX_POWER_W, MODES, PERIOD_S, controller
from independent_strip import CHAPTER_4, CHAPTER_5, LiveStrip, Strip

from lce_analysis.identification import fit
from lce_control.step_metrics import StepMetrics, step_metrics
from lce_control.tuning.closed_loop import run
from lce_model import Model, default_model

TRAINING = ("pulse-16", "stairs-1", "loops-1", "prbs-1")
HOLD_S = 60.0


@dataclass(frozen=True)
class Specimen:
    """A strip, the amplitude of its pulses [W], and the targets in turn [mm], the first from rest."""

    strip: Strip
    amplitude_w: float
    targets_mm: tuple[float, ...]


SPECIMENS = (
    Specimen(CHAPTER_4, 0.2, (1.0, 2.0, 1.2, 2.4, 1.5)),
    Specimen(CHAPTER_5, 0.4, (1.0, 3.0, 2.0, 2.5, 1.5)),
)


def identified(specimen: Specimen) -> Model:
    """The kinetic model fitted to four recordings."""
    with TemporaryDirectory() as folder:
        runs = campaign("known", specimen.strip, specimen.amplitude_w, (16.0,), Path(folder))
        start = default_model("lumped", "kinetic", ("natural_convection", "phase_kinetics"))
        return replace(fit(start, [runs[name] for name in TRAINING]).model, fit={})  # its record does not pickle


def step_figures(specimen: Specimen, model: Model, mode: str, seed: int) -> list[StepMetrics]:
    """The figures of each step in a mode of control that knows the model."""
    step, targets_m = controller(mode, model), [1e-3 * target for target in specimen.targets_mm]
    strip = LiveStrip(specimen.strip)
    loop = run(
        strip,
        lambda t, displacement, temperature: step(t, targets_m[int(t / HOLD_S)], displacement, temperature),
        HOLD_S * len(targets_m),
        seed=seed,
    )
    size = round(HOLD_S / PERIOD_S)
    pieces = [slice(k * size, (k + 1) * size) for k in range(len(targets_m))]
    return [
        step_metrics(loop.time_s[p] - loop.time_s[p][0], loop.displacement_m[p], target_m)
        for p, target_m in zip(pieces, targets_m, strict=True)
    ]


def full_power_s(specimen: Specimen) -> float:
    """Time in which full power brings the strip to 80 % of its first target [s]: nothing is faster."""
    strip, steps = LiveStrip(specimen.strip), 0
    while strip.displacement_m < 0.8e-3 * specimen.targets_mm[0]:
        strip.step(MAX_POWER_W, PERIOD_S)
        steps += 1
    return steps * PERIOD_S


def rows(seeds: int, workers: int) -> Iterator[list[str]]:
    """Specimen, mode, rise time of the first step beside full power, worst overshoot and RMSE of all."""
    for specimen in SPECIMENS:
        model, fastest_s = identified(specimen), full_power_s(specimen)
        for mode in MODES:
            with ProcessPoolExecutor(workers) as pool:
                jobs = [pool.submit(step_figures, specimen, model, mode, seed) for seed in range(seeds)]
            every = [job.result() for job in jobs]
            steps = [figures for one in every for figures in one]
            yield [
                specimen.strip.name,
                mode,
                f"{max(one[0].rise_time_s for one in every):.2f}",
                f"{fastest_s:.2f}",
                f"{max(f.overshoot for f in steps):.2%}",
                f"{max(f.rmse_after_30s for f in steps):.2%}",
            ]
