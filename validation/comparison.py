# SPDX-License-Identifier: Apache-2.0
"""`make comparison`: the deformation models beside each other, on the runs that they were fitted to and on others.

Data come from the independent strip of this folder, which shares no code with the models, and from the dissertation's
chapter 5 model itself. Writes docs/results/comparison.md and docs/results/comparison.svg.
"""

import argparse
import math
import sys
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from independent_strip import CHAPTER_4, CHAPTER_5, Strip, measure, simulate, waves, write_csv
from loop_pictures import Picture, draw
from tqdm import tqdm

from lce_analysis.comparison.metrics import nrmse
from lce_analysis.identification import fit, fit_each
from lce_analysis.options import FitOptions
from lce_analysis.prediction import Drive, predict
from lce_data.channels import DISPLACEMENT
from lce_data.read_runs import read_run
from lce_data.run import Run, Series
from lce_model import Model, default_model
from lce_model import simulate as simulate_model

MODELS = ("equilibrium", "dynamic", "kinetic", "prandtl_ishlinskii", "bouc_wen")
LOSS, GLOW, LATE = "natural_convection", "radiation", "phase_kinetics"
"""Effects of the library, added to the models that say so: what the lumped heat balance lacks most, what any warm
surface does, and the time that a domain takes once it is over the barrier."""
FULL = f"kinetic + {LOSS} + {GLOW} + {LATE}"
DRAWN_EVERY = 20
"""Samples from one point of a picture to the next: 0.2 s."""
KINDS = {"pulse": "other T_h", "stairs": "staircase", "loops": "minor loops", "prbs": "PRBS"}
REST_S = 60.0
LOOPS_1 = (0.0, 1.0, 0.0, 0.0, 0.9, 0.1, 0.1, 0.8, 0.3, 0.7)
LOOPS_2 = (0.0, 0.8, 0.0, 0.0, 1.0, 0.0, 0.0, 0.8, 0.1, 0.7, 0.0, 1.0)
INSIDE_W = {CHAPTER_4.name: 1.4, CHAPTER_5.name: 1.0}
"""Corners of the power, in units of what leads to the middle of the heating branch: turns inside the loop on both
branches, at different depths."""


def campaign(name: str, strip: Strip, amplitude_w: float, heated_s: Sequence[float], folder: Path) -> dict[str, Run]:
    """Runs of every kind on one specimen of the independent strip, as its sensors see them."""
    top = 1.5 + amplitude_w
    signals = {f"pulse-{th:g}": waves.pulse(amplitude_w, th, rest_s=REST_S) for th in heated_s}
    up = [0.4, 0.8, 1.1, 1.4, top]
    signals["stairs-1"] = waves.staircase([*up, *up[-2::-1]], 12.0, rest_s=REST_S)
    signals["stairs-2"] = waves.staircase([0.6, 1.0, 1.3, 1.6, 1.2, 0.9, 0.5], 16.0, rest_s=REST_S)
    for run, ramp_s, corners in (("loops-1", 20.0, LOOPS_1), ("loops-2", 16.0, LOOPS_2)):
        signals[run] = waves.zigzag([INSIDE_W[strip.name] * c for c in corners], ramp_s, rest_s=REST_S)
    signals["prbs-1"] = waves.prbs(0.5, top, 4.0, 30, seed=1, rest_s=REST_S)
    runs = {}
    for seed, (kind, signal) in enumerate(signals.items()):
        path = write_csv(folder / f"{name}-{kind}.csv", measure(simulate(strip, *signal), seed))
        runs[kind] = read_run(path)
    return runs


def of_chapter_5(runs: Mapping[str, Run]) -> dict[str, Run]:
    """The same inputs given to the published dynamic model, (5.10), with the noise of the sensors."""
    model, made = default_model("lumped", "dynamic"), {}
    for seed, (kind, run) in enumerate(runs.items()):
        assert run.power is not None and run.temperature is not None
        out, random = simulate_model(model, run.power.time_s, run.power.value), np.random.default_rng(seed)
        times = run.temperature.time_s
        warm = np.interp(times, out.time_s, out.temperature_k) + 0.06 * random.standard_normal(times.size)
        moved = Series(out.time_s, out.displacement_m + 4e-6 * random.standard_normal(out.time_s.size))
        made[kind] = Run.of(kind, run.power, Series(times, warm), moved, f"chapter 5 model {kind}")
    return made


@dataclass(frozen=True)
class Row:
    """A model fitted to some of the runs: its errors (NRMSE of d, %) on all of them, by run."""

    label: str
    model: Model
    train: tuple[str, ...]
    errors: Mapping[str, float]
    fit_s: float

    def mean(self, of: Iterable[str]) -> float:
        """Root mean square error over runs."""
        return math.sqrt(float(np.mean([self.errors[k] ** 2 for k in of])))

    @property
    def unseen(self) -> float:
        """Over all runs that it was not fitted to."""
        return self.mean(k for k in self.errors if k not in self.train)


def error(model: Model, run: Run, drive: Drive) -> float:
    """NRMSE of the displacement of a run, %."""
    return 100.0 * nrmse(predict(model, run, drive).at_samples[DISPLACEMENT], run.series[DISPLACEMENT].value)


def fitted(
    bar: "tqdm[None]", runs: Mapping[str, Run], train: Sequence[str], models: Iterable[str], drive: Drive = "model"
) -> list[Row]:
    """Each model fitted to the runs of ``train`` with one parameter set; "+" joins effects to its name."""
    rows = []
    for label in models:
        bar.set_description_str(f"{label}, {len(train)} runs, T {'measured' if drive == 'measured' else 'predicted'}")
        deformation, *effects = label.split(" + ")
        begin = time.perf_counter()
        start = default_model("lumped", deformation, tuple(effects))
        model = fit(start, [runs[k] for k in train], FitOptions(drive=drive)).model
        seconds = time.perf_counter() - begin
        rows.append(Row(label, model, tuple(train), {k: error(model, r, drive) for k, r in runs.items()}, seconds))
        bar.update()
    return rows


def table(rows: Sequence[Row]) -> list[str]:
    """Errors by kind of run."""
    first = rows[0]
    unseen = [k for k in first.errors if k not in first.train]
    kinds = [k for k in KINDS if any(u.startswith(k) for u in unseen)]
    text = [
        f"| model | free parameters | training | {' | '.join(KINDS[k] for k in kinds)} | **all unseen** | fit s |",
        "|---" * (len(kinds) + 5) + "|",
    ]
    for row in rows:
        cells = [row.mean(row.train), *(row.mean(u for u in unseen if u.startswith(k)) for k in kinds)]
        free = sum(not v.fixed for v in row.model.values)
        numbers = " | ".join(f"{c:.2f}" for c in cells)
        text.append(f"| {row.label} | {free} | {numbers} | **{row.unseen:.2f}** | {row.fit_s:.0f} |")
    return [*text, ""]


def verdict(rows: Sequence[Row]) -> list[str]:
    """The bar of the project, read off the last row, whatever the others reach: the model with the most effects."""
    named, dynamic = rows[-1], next(r for r in rows if r.label == "dynamic")
    return [
        f"The bar is 2.0 % on unseen runs, and half of `dynamic`. {named.label}: {named.unseen:.2f} %, "
        f"{named.unseen / dynamic.unseen:.2f} of `dynamic`: "
        f"{'met' if named.unseen <= min(2.0, 0.5 * dynamic.unseen) else 'not met'}.",
        "",
    ]


def refitted(bar: "tqdm[None]", runs: Mapping[str, Run], keys: Sequence[str], together: Sequence[Row]) -> list[str]:
    """A parameter set for each run against one for all, on the same pulses."""
    text = ["| model | one set a run | one set for all |", "|---|---|---|"]
    for row in together:
        bar.set_description_str(f"{row.label}, one set a run")
        chosen = [runs[k] for k in keys]
        own = fit_each(default_model("lumped", row.label), chosen, FitOptions(drive="measured"))
        errors = [error(result.model, run, "measured") for result, run in zip(own, chosen, strict=True)]
        text.append(f"| {row.label} | {math.sqrt(np.mean(np.square(errors))):.2f} | {row.mean(keys):.2f} |")
        bar.update()
    return [*text, ""]


def simulation_times() -> list[str]:
    """Milliseconds for 60 s at 100 Hz, P → T → d."""
    times = np.arange(6000) * 0.01
    power = np.where(times < 20.0, 1.7, 0.0)
    text = ["| model | parameters of T → d | 60 s at 100 Hz, ms |", "|---|---|---|"]
    for name in MODELS:
        model = default_model("lumped", name).set({"lumped.gain": 60.0})
        durations = []
        for _ in range(30):
            begin = time.perf_counter()
            simulate_model(model, times, power)
            durations.append(time.perf_counter() - begin)
        free = sum(not v.fixed for v in default_model("none", name).values)
        text.append(f"| {name} | {free} | {1e3 * min(durations):.2f} |")
    return [*text, ""]


def pictures(rows: Sequence[Row], run: Run) -> list[Picture]:
    """Loops d over T of an unseen run: measured, and as each model predicts it from the measured temperature."""
    assert run.displacement is not None
    found = []
    for row in rows:
        p = predict(row.model, run, "measured")
        measured = np.interp(p.time_s, run.displacement.time_s, run.displacement.value)
        title = f"{row.label}: {row.errors[run.name.removeprefix('c5-')]:.1f} %"
        drawn = slice(None, None, DRAWN_EVERY)
        loops = (p.temperature_k - 273.15, 1e3 * measured, 1e3 * p.displacement_m)
        found.append(Picture(title, *(curve[drawn] for curve in loops)))
    return found


HEAD = """# The deformation models compared

Written by `make comparison`. Errors are NRMSE of the displacement (4.24) in percent, root mean square over runs; one
parameter set for all runs of a table unless it says otherwise. Data: the independent strip of
`validation/independent_strip` (distributed temperatures, noise of 0.06 K at 10 Hz and 4 µm at 100 Hz), which shares no
code with the models
([what `kinetic` has in common with it](../explanation/kinetic.md#how-far-the-independent-strip-judges-it)), and the
chapter 5 model itself. Unseen runs: another T_h or two, a staircase or two, one or two runs of minor loops that turn
at different depths of both branches, a PRBS. Fit times are those of the machine that wrote this.

`equilibrium` and `dynamic` are the dissertation's, `kinetic` is [ours](../explanation/kinetic.md), `prandtl_ishlinskii`
(generalised, weighted plays) and `bouc_wen` are hysteresis models without physics.
"""


def document(bar: "tqdm[None]", folder: Path) -> tuple[str, list[Picture]]:
    """All fits, tables and pictures."""
    heated = (16.0, 18.0, 19.0, 20.0, 22.0, 25.0, 28.0)
    c5 = campaign("c5", CHAPTER_5, 0.4, heated, folder)
    c4 = campaign("c4", CHAPTER_4, 0.2, (25.0, 30.0, 35.0, 40.0, 50.0), folder)
    pulses = ("pulse-16", "pulse-19", "pulse-22", "pulse-25", "pulse-28")
    rich = ("pulse-16", "pulse-20", "pulse-25", "pulse-28", "stairs-1", "loops-1")
    with_loss = (*MODELS, f"dynamic + {LOSS}", f"kinetic + {LOSS}", f"kinetic + {LOSS} + {LATE}", FULL)
    few = fitted(bar, c5, pulses, with_loss)
    many = fitted(bar, c5, rich, with_loss)
    driven = fitted(bar, c5, rich, (*MODELS, f"kinetic + {LATE}"), "measured")
    driven_few = fitted(bar, c5, pulses, MODELS, "measured")
    other = fitted(bar, c4, ("pulse-25", "pulse-35", "pulse-50", "stairs-1", "loops-1"), (*MODELS[:3], FULL))
    published = fitted(bar, of_chapter_5(c5), pulses, MODELS)
    text = [
        HEAD,
        "## Size and speed", "", *simulation_times(),
        "## P → T → d, fitted to pulses alone", "",
        "Five pulses as in the dissertation (Amp 0.4, T_h 16, 19, 22, 25, 28 s); laser power is the only input.", "",
        *table(few), *verdict(few),
        "## P → T → d, fitted to pulses, a staircase and minor loops", "", *table(many), *verdict(many),
        f"`+ {LOSS}`, `+ {GLOW}`: the lumped heat balance with a loss that grows with the temperature, two of the "
        "[effects](../reference/effects.md). With a constant loss the thermal stage limits every deformation model. "
        f"`+ {LATE}`: the domains take time to turn once they are over the barrier, another effect.", "",
        "## T → d alone, driven by the measured temperature", "",
        "The camera's 10 Hz, smoothed. Fitted to pulses, a staircase and minor loops:", "",
        *table(driven), *verdict(driven),
        "Fitted to pulses alone:", "", *table(driven_few),
        "## One set a run against one for all", "",
        "The five pulses, T → d alone.", "", *refitted(bar, c5, pulses, driven_few),
        "## The other specimen: chapter 4", "", *table(other),
        "## Data of the chapter 5 model itself", "",
        "The published model (5.10) with sensor noise as the truth, fitted to pulses alone.", "", *table(published),
        "## Minor loops", "",
        "An unseen run of minor loops, T → d (fitted to pulses, a staircase and other minor loops). The dissertation's "
        "models jump where the temperature turns. The kinetic one does not.", "",
        "![Loops d over T, measured and modelled](comparison.svg)", "",
    ]  # fmt: skip
    return "\n".join(text), pictures(driven, c5["loops-2"])


def main() -> int:
    """Run the comparison and write the documents."""
    parser = argparse.ArgumentParser(description="the deformation models compared")
    parser.add_argument("--out", type=Path, default=Path(__file__).parents[1] / "docs" / "results" / "comparison.md")
    args = parser.parse_args()
    with TemporaryDirectory() as folder, tqdm(total=43, unit="fit", dynamic_ncols=True) as bar:
        text, loops = document(bar, Path(folder))
    args.out.write_text(text, encoding="utf-8")
    draw(loops, ("T in °C", "d in mm", "measured", "modelled"), args.out.with_suffix(".svg"))
    print(args.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
