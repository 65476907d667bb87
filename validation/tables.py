# SPDX-License-Identifier: Apache-2.0
"""`make tables`: Tables 4.1–4.4, 5.1 and 5.2 of the dissertation as procedures, beside the printed numbers.

The measured data of the dissertation are not public, so the data come from the independent strip of this folder, which
shares no code and no equations with the models that are fitted. What can be compared is the procedure and the order
of the errors, not the numbers themselves. Writes docs/results/tables.md.
"""

import argparse
import math
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from independent_strip import CHAPTER_4, CHAPTER_5, Strip, measure, simulate, waves, write_csv
from tqdm import tqdm

from lce_analysis.comparison.metrics import nrmse, rms_error, rmse_printed, smape
from lce_analysis.identification import FitResult, fit
from lce_analysis.options import FitOptions
from lce_analysis.prediction import Drive, predict
from lce_data.channels import DISPLACEMENT
from lce_data.read_runs import read_run
from lce_data.run import Run
from lce_model import Model, default_model

PRINTED_41 = {30: (0.22, 0.10, 2.5), 40: (0.23, 0.10, 2.2), 50: (0.24, 0.11, 2.0)}
PRINTED_42 = {30: (5.58, 7.70, 1.91), 40: (5.71, 7.70, 2.16), 50: (5.81, 7.68, 2.40)}
PRINTED_43 = {25: (0.23, 0.10, 2.1), 35: (0.28, 0.12, 2.2)}
PRINTED_44 = {25: (5.71, 7.70, 2.22), 35: (5.51, 7.70, 2.46)}
PRINTED_51 = {
    16: (6.0, 0.30, 4.1), 17: (5.4, 0.27, 3.6), 18: (5.3, 0.28, 3.5),
    19: (5.4, 0.28, 3.4), 20: (5.6, 0.30, 3.6), 21: (5.6, 0.30, 3.6),
}  # fmt: skip
PRINTED_52 = {16: 7.4, 17: 7.1, 18: 9.3, 19: 8.4, 20: 9.0, 21: 9.3}
REST_S = 60.0
SHARED = ("equilibrium.a0", "equilibrium.b", "stretch_law.alpha")


@dataclass(frozen=True)
class Errors:
    """Misfit of λ, in percent: √(Σe²/N), (1/N)√Σe², SMAPE, NRMSE."""

    rms: float
    printed: float
    smape: float
    nrmse: float


def record(strip: Strip, amp: float, th: float, seed: int, folder: Path) -> Run:
    """A pulse of (4.20) on the independent strip, as a recorded run."""
    path = folder / f"amp{amp:g}-th{th:g}.csv"
    response = simulate(strip, *waves.pulse(amp, float(th), rest_s=REST_S))
    write_csv(path, measure(response, seed))
    return read_run(path)


def errors(model: Model, run: Run) -> Errors:
    """Misfit of λ = 1 - d/L0, the measured temperature driving the model as in the dissertation."""
    prediction = predict(model, run, "measured")
    length = model["strip.length"]
    modelled = 1.0 - prediction.at_samples[DISPLACEMENT] / length
    measured = 1.0 - run.series[DISPLACEMENT].value / length
    pair = modelled, measured
    return Errors(*(100.0 * f(*pair) for f in (rms_error, rmse_printed, smape, nrmse)))


class Tables:
    """The fits behind the tables, one step of the progress bar each."""

    def __init__(self, bar: "tqdm[None]") -> None:
        self.bar = bar

    def fitted(
        self,
        deformation: str,
        runs: Sequence[Run],
        held: dict[str, tuple[float, float]] | None = None,
        drive: Drive = "measured",
    ) -> FitResult:
        """A fit; to T–λ alone, the measured temperature as the input, unless ``drive`` says otherwise."""
        self.bar.set_description_str(f"{deformation}, {', '.join(r.name for r in runs)}")
        result = fit(default_model("lumped", deformation).hold(held or {}), runs, FitOptions(drive=drive))
        self.bar.update()
        return result


def chapter_4(tables: Tables, folder: Path) -> list[str]:
    """Tables 4.1–4.4, and one parameter set for all five runs."""
    first = {th: record(CHAPTER_4, 0.2, th, th, folder) for th in PRINTED_41}
    second = {th: record(CHAPTER_4, 0.25, th, th, folder) for th in PRINTED_43}
    single = {th: tables.fitted("equilibrium", [run]) for th, run in first.items()}
    ranges = {}
    for key in SHARED:
        found = [r.model[key] for r in single.values()]
        ranges[key] = 0.999 * min(found), 1.001 * max(found)
    held = {th: tables.fitted("equilibrium", [run], ranges) for th, run in second.items()}
    together = tables.fitted("equilibrium", [*first.values(), *second.values()])
    text = [
        "## Table 4.1: equilibrium model, Amp 0.2, one parameter set a run",
        "",
        *_error_table(PRINTED_41, {th: errors(single[th].model, first[th]) for th in first}),
        "## Table 4.2: its parameters",
        "",
        *_parameter_table(PRINTED_42, single),
        "## Table 4.3: Amp 0.25, A0, B and α held to the ranges of Table 4.2",
        "",
        *_error_table(PRINTED_43, {th: errors(held[th].model, second[th]) for th in second}),
        "## Table 4.4: its parameters",
        "",
        *_parameter_table(PRINTED_44, held),
        "## One equilibrium parameter set for all five runs",
        "",
        "| Amp, T_h | RMS λ % | SMAPE % | NRMSE % |",
        "|---|---|---|---|",
    ]
    for amp, runs in ((0.2, first), (0.25, second)):
        for th, run in runs.items():
            e = errors(together.model, run)
            text.append(f"| {amp:g}, {th} s | {e.rms:.3f} | {e.smape:.3f} | {e.nrmse:.2f} |")
    return [*text, ""]


def _error_table(printed: dict[int, tuple[float, float, float]], found: dict[int, Errors]) -> list[str]:
    lines = ["| T_h s | RMSE % printed → here | SMAPE % printed → here | NRMSE % printed → here |", "|---|---|---|---|"]
    for th, e in found.items():
        p = printed[th]
        lines.append(f"| {th} | {p[0]:.2f} → {e.rms:.3f} | {p[1]:.2f} → {e.smape:.3f} | {p[2]:.1f} → {e.nrmse:.2f} |")
    return [*lines, ""]


def _parameter_table(printed: dict[int, tuple[float, float, float]], found: dict[int, FitResult]) -> list[str]:
    lines = ["| T_h s | A0, 1e-22 J/K | B, 1e-20 J | α |", "|---|---|---|---|"]
    for th, result in found.items():
        p, m = printed[th], result.model
        a0, b, alpha = (_known(m, key, scale) for key, scale in zip(SHARED, (1e22, 1e20, 1.0), strict=True))
        lines.append(f"| {th} | {p[0]:.2f} → {a0} | {p[1]:.2f} → {b} | {p[2]:.2f} → {alpha} |")
    return [*lines, "", "(*n.d.*: the data of that run do not determine it.)", ""]


def _known(model: Model, key: str, scale: float) -> str:
    value = model.values[model.index(key)]
    if value.standard_error is None:
        return f"{value.value * scale:.2f} *n.d.*"
    return f"{value.value * scale:.2f} ± {value.standard_error * scale:.1g}"


def chapter_5(tables: Tables, folder: Path) -> list[str]:
    """Tables 5.1 and 5.2, and one parameter set of each model for all six runs."""
    runs = {th: record(CHAPTER_5, 0.4, th, th, folder) for th in PRINTED_51}
    found: dict[str, dict[int, Errors]] = {}
    for name in ("dynamic", "equilibrium"):
        found[name] = {th: errors(tables.fitted(name, [run]).model, run) for th, run in runs.items()}
        together = tables.fitted(name, list(runs.values())).model
        found[f"{name}, one set"] = {th: errors(together, run) for th, run in runs.items()}
    text = [
        "## Table 5.1: dynamic model, Amp 0.4, one parameter set a run",
        "",
        "| T_h s | RMSE (1/N)√Σe², 1e-3 % printed → here | SMAPE % printed → here | NRMSE % printed → here |",
        "|---|---|---|---|",
    ]
    for th, e in found["dynamic"].items():
        p = PRINTED_51[th]
        text.append(
            f"| {th} | {p[0]:.1f} → {e.printed * 1e3:.1f} | {p[1]:.2f} → {e.smape:.3f} | {p[2]:.1f} → {e.nrmse:.2f} |"
        )
    text += [
        "",
        "## Table 5.2: dynamic against equilibrium, and both with one parameter set for all six runs",
        "",
        "| T_h s | printed: dynamic, equilibrium (RMSE 1e-3 %) | here, NRMSE %: dynamic | equilibrium "
        "| dynamic, one set | equilibrium, one set |",
        "|---|---|---|---|---|---|",
    ]
    columns = ("dynamic", "equilibrium", "dynamic, one set", "equilibrium, one set")
    for th in runs:
        cells = " | ".join(f"{found[c][th].nrmse:.2f}" for c in columns)
        text.append(f"| {th} | {PRINTED_51[th][0]:.1f}, {PRINTED_52[th]:.1f} | {cells} |")
    means = " | ".join(f"{_mean(e.nrmse for e in found[c].values()):.2f}" for c in columns)
    return [*text, f"| rms mean | | {means} |", ""]


def joint(tables: Tables, folder: Path) -> list[str]:
    """Both stages identified together from the laser power, one parameter set for all runs of a specimen."""
    text = [
        "## Joint fits P → T → d, one parameter set for all runs of a specimen", "",
        "The input is the laser power alone; the temperature is predicted too.", "",
        "| specimen, model | NRMSE of d %, all runs | NRMSE of T % | dissertation: T → λ, NRMSE %, a set a run |",
        "|---|---|---|---|",
    ]  # fmt: skip
    for name, printed, pulses in (
        ("chapter 4", "2.0–2.5", [*((0.2, th) for th in PRINTED_41), *((0.25, th) for th in PRINTED_43)]),
        ("chapter 5", "3.4–4.1", [(0.4, th) for th in PRINTED_51]),
    ):
        runs = [read_run(folder / f"amp{amp:g}-th{th:g}.csv") for amp, th in pulses]
        for deformation in ("equilibrium", "dynamic"):
            entries = tables.fitted(deformation, runs, drive="model").model.fit["runs"]
            d, t = ([100.0 * e[f"{q}_nrmse"] for e in entries] for q in ("displacement", "temperature"))
            text.append(
                f"| {name}, {deformation} | {min(d):.2f}–{max(d):.2f} | {min(t):.1f}–{max(t):.1f} | {printed} |"
            )
    return [*text, ""]


def _mean(values: Iterable[float]) -> float:
    return math.sqrt(float(np.mean(np.square(list(values)))))


HEAD = """# The dissertation's tables as procedures

Written by `make tables`. Left of each arrow is what the dissertation prints for its own, unpublished measurements;
right of it what the same procedure gives on the independent strip of `validation/independent_strip`, a distributed
simulation with sensor noise (10 Hz camera, 0.06 K rms; 100 Hz distance sensor, 4 µm rms) that shares no code and no
equations with the models. Only the order of the numbers can be compared. The models are identified from λ over the
measured temperature (smoothed), as in the dissertation. RMSE in Tables 4.1 and 4.3 is √(Σe²/N), in Table 5.1 the
printed (1/N)√Σe².
"""


def main() -> int:
    """Run the procedures and write the document."""
    parser = argparse.ArgumentParser(description="the dissertation's tables as procedures")
    parser.add_argument("--out", type=Path, default=Path(__file__).parents[1] / "docs" / "results" / "tables.md")
    args = parser.parse_args()
    with TemporaryDirectory() as folder, tqdm(total=24, unit="fit", dynamic_ncols=True) as bar:
        tables = Tables(bar)
        parts = [part(tables, Path(folder)) for part in (chapter_4, chapter_5, joint)]
        text = "\n".join([HEAD, *(line for part in parts for line in part)])
    args.out.write_text(text, encoding="utf-8")
    print(args.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
