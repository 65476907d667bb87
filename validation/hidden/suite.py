# SPDX-License-Identifier: Apache-2.0
"""`make hidden`: does the diagnosis find what a strip hides, and does it keep quiet where nothing is hidden?

Every case is a strip of :mod:`strip` with random parameters, a campaign of runs, a model fitted to them as `lce fit`
does, and `lce_analysis.diagnosis` on the result. Finished cases are kept in --results (JSON lines), so that a suite
that was stopped goes on where it was. The table of gates has 95 % confidence intervals (Wilson).

Visible is what leaves, after the base model was fitted, at least half the sensor's noise in one of the two residuals:
judged from the noise that was put in, not from the diagnosis.
"""

import argparse
import json
import math
import sys
import time
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import binomtest
from tqdm import tqdm

sys.path.insert(0, str(Path(__file__).parent))

from strip import HIDDEN, OUTSIDE, STRENGTH, Body, measure

from lce_analysis.diagnosis import diagnose
from lce_analysis.experiment_design import design
from lce_analysis.identification import fit
from lce_analysis.options import DesignOptions, FitOptions
from lce_analysis.prediction import predict
from lce_data.channels import SENSORS
from lce_data.errors import LceError
from lce_data.noise import noise_floor
from lce_data.run import Run, Series
from lce_model import Model, default_model

Floats = NDArray[np.float64]
PAIRS = (
    ("creep", "ambient_drift"),
    ("laser_droop", "displacement_drift"),
    ("natural_convection", "phase_kinetics"),
    ("camera_lag", "elastic_softening"),
    ("radiation", "residual_strain"),
)
HELD_OUT = ("prbs", "pulse-22")
VISIBLE = 0.5


@dataclass(frozen=True)
class Case:
    """One strip: what it hides, how strongly ("weak", "clear"), and the seed of everything random."""

    hidden: tuple[str, ...]
    level: str
    seed: int

    @property
    def name(self) -> str:
        """Key of the results."""
        return f"{'+'.join(self.hidden) or 'nothing'}/{self.level}/{self.seed}"


def cases(seeds: int) -> list[Case]:
    """Null, every effect weak and clear, pairs, seed by seed, so that a part of the suite is a fair sample."""
    found = []
    for seed in range(seeds):
        found += [Case((), "clear", 10 * seed + k) for k in range(4)]
        found += [Case((name,), level, seed) for name in HIDDEN for level in ("clear", "weak")]
        found += [Case(pair, "clear", seed) for pair in PAIRS]
    return found


def waves(top_w: float) -> dict[str, Floats]:
    """The campaign: pulses of (4.20), a staircase, holds, repeated cycles, minor loops, PRBS; W at 100 Hz."""

    def pulse(heated: float) -> Floats:
        t = np.arange(0.0, heated, 0.01)
        return np.concatenate([0.3 * top_w * np.sin(math.pi / (2 * heated) * t) + 0.7 * top_w, np.zeros(6000)])

    def levels(values: list[float], seconds: float) -> Floats:
        return np.concatenate([np.full(round(100 * seconds), v * top_w) for v in values])

    bits = np.random.default_rng(7).integers(0, 2, 24)
    triangle = np.concatenate([np.linspace(0.3, 0.9, 1500), np.linspace(0.9, 0.3, 1500)]) * top_w
    inner = np.concatenate([np.linspace(0.45, 0.7, 1000), np.linspace(0.7, 0.45, 1000)]) * top_w
    return {
        "pulse-16": pulse(16.0),
        "pulse-22": pulse(22.0),
        "pulse-28": pulse(28.0),
        "stairs": levels([0.25, 0.5, 0.75, 1.0, 0.75, 0.5, 0.25, 0.0], 14.0),
        "holds": levels([0.8, 0.0, 0.5, 0.0], 25.0),
        "cycles": np.concatenate([np.tile(triangle, 3), np.zeros(3000)]),
        "minor": np.concatenate([np.full(2500, 0.6 * top_w), np.tile(inner, 2), np.zeros(3000)]),
        "prbs": np.concatenate([levels(list(0.35 + 0.6 * bits), 4.0), np.zeros(2000)]),
    }


def record(name: str, body: Body, power: Floats, hidden: dict[str, float], seed: tuple[int, ...], slow_s: float) -> Run:
    """One run of the strip, as `lce_analysis` reads it."""
    rng = np.random.default_rng((*seed, zlib.crc32(name.encode())))
    camera, distance = measure(body, power, hidden, rng, slow_s)
    time_s = np.arange(power.size) / 100.0
    series = Series(time_s, power), Series(time_s[::10], camera), Series(time_s, distance)
    return Run.of(name, *series, sha256=name)


def judge(case: Case) -> dict[str, Any]:
    """Everything that the gates need to know of one case."""
    key = (case.seed, zlib.crc32("+".join(case.hidden).encode()), len(case.level))
    rng = np.random.default_rng(key)
    body = Body.random(rng)
    hidden = {n: STRENGTH[n][case.level == "clear"] * rng.uniform(0.8, 1.25) for n in case.hidden}
    slow_s = float(np.exp(rng.uniform(math.log(10.0), math.log(40.0))))
    top_w = 78.0 / body.gain
    runs = [record(name, body, power, hidden, key, slow_s) for name, power in waves(top_w).items()]
    train, test = [r for r in runs if r.name not in HELD_OUT], [r for r in runs if r.name in HELD_OUT]
    began = time.perf_counter()
    model = fit(default_model(), train, FitOptions(seed=case.seed)).model
    fitted = time.perf_counter()
    found = diagnose(model, train, test)
    record_ = found.as_json()
    seconds = time.perf_counter() - fitted
    result = {
        "case": case.name,
        "hidden": list(case.hidden),
        "level": case.level,
        "misfit": _misfit(model, train),
        "verdict": record_["verdict"],
        "added": record_["added"],
        "sets": [s["set"] for s in record_["steps"]],
        "top": record_["candidates"][0]["effect"],
        "held_out": _misfit(found.model, test),
        "fingerprint": record_["fingerprint"],
        "fit_s": round(fitted - began, 1),
        "diagnose_s": round(seconds, 1),
    }
    if len(case.hidden) == 1 and len(result["sets"]) == 1 and len(result["sets"][0]) > 1:
        result["resolved"] = _resolved(found.model, result["sets"][0], body, hidden, key, slow_s, top_w, model, train)
    return result


def _misfit(model: Model, runs: list[Run]) -> float:
    """What the worse sensor has beyond its noise, √(rms² - noise²), in units of it; negative where it has less."""
    worst = 0.0
    for channel in SENSORS:
        total, noise, size = 0.0, 0.0, 0
        for run in runs:
            series = run.series[channel]
            modelled = predict(model, run).at_samples[channel]
            total += float(np.sum((modelled - series.value) ** 2))
            noise += series.value.size * noise_floor(series) ** 2 / 0.83  # a fifth of it is slow, partly unseen
            size += series.value.size
        worst = max(worst, (total - noise) / noise)
    return math.copysign(math.sqrt(abs(worst)), worst)


def _resolved(
    model: Model, alias: list[str], body: Body, hidden: dict[str, float], key: tuple[int, ...], slow_s: float,
    top_w: float, base: Model, train: list[Run],
) -> bool:  # fmt: skip
    """Does the experiment that the tool asks for leave the hidden effect alone in its set?"""
    try:
        wanted = design(model, (alias[0], alias[1]), DesignOptions(top_w, 400.0, 150.0))
    except LceError:
        return False
    run = record("designed", body, wanted.power_w, hidden, key, slow_s)
    again = diagnose(base, [*train, run]).as_json()
    (name,) = hidden
    return bool(again["steps"]) and again["steps"][0]["added"] == name and again["steps"][0]["set"] == [name]


def gates(results: list[dict[str, Any]]) -> Iterator[tuple[str, list[bool], float]]:
    """Each gate: its name, whether each case passes, and the share that has to."""
    single = [r for r in results if len(r["hidden"]) == 1 and r["hidden"][0] not in OUTSIDE]
    seen = [r for r in single if r["misfit"] >= VISIBLE]
    masked = [r for r in single if r["misfit"] < VISIBLE]

    def of(members: list[dict[str, Any]], test: Callable[[dict[str, Any]], bool]) -> list[bool]:
        return [test(r) for r in members]

    yield "null data: nothing added", of([r for r in results if not r["hidden"]], lambda r: not r["added"]), 0.95
    yield "visible effect: named first", of(seen, lambda r: r["added"][:1] == r["hidden"]), 0.90
    yield "visible effect: in the reported set", of(seen, lambda r: any(r["hidden"][0] in s for s in r["sets"])), 0.95
    right = [r for r in seen if r["added"][:1] == r["hidden"]]
    yield "held-out error after adding within 1.3 × noise", of(right, lambda r: r["held_out"] <= math.sqrt(0.69)), 0.95
    yield (
        "masked effect: no wrong name",
        of(masked, lambda r: not r["added"] or any(r["hidden"][0] in s for s in r["sets"])),
        0.95,
    )
    outside = [r for r in results if r["hidden"] and r["hidden"][0] in OUTSIDE and r["misfit"] >= VISIBLE]
    yield "outside the library: unexplained", of(outside, lambda r: r["verdict"] == "unexplained"), 0.80
    pairs = [r for r in results if len(r["hidden"]) == 2]
    yield "two effects: both found", of(pairs, lambda r: set(r["hidden"]) <= {x for s in r["sets"] for x in s}), 0.80
    yield (
        "alias set: resolved by the designed experiment",
        of([r for r in single if "resolved" in r], lambda r: r["resolved"]),
        0.80,
    )


def table(results: list[dict[str, Any]]) -> str:
    """The gates, and the cases that missed one, as Markdown."""
    lines = ["| gate | bar | passed | share | 95 % interval |", "|---|---|---|---|---|"]
    for name, passed, bar in gates(results):
        if not passed:
            lines.append(f"| {name} | ≥ {bar:.0%} | no case | | |")
            continue
        interval = binomtest(sum(passed), len(passed)).proportion_ci(method="wilson")
        share, (low, high) = sum(passed) / len(passed), interval
        lines.append(f"| {name} | ≥ {bar:.0%} | {sum(passed)} of {len(passed)} | {share:.0%} | {low:.0%}–{high:.0%} |")
    times = [r["diagnose_s"] for r in results]
    lines += ["", f"{len(results)} cases, `diagnose` {np.median(times):.0f} s (median) to {max(times):.0f} s each."]
    lines += ["", "| case | misfit / noise | verdict | sets | held out / noise |", "|---|---|---|---|---|"]
    for r in sorted(results, key=lambda r: r["case"]):
        sets = "; ".join(", ".join(s) for s in r["sets"])
        lines.append(f"| {r['case']} | {r['misfit']:.2f} | {r['verdict']} | {sets} | {r['held_out']:.2f} |")
    return "\n".join(lines)


HEAD = """# Hidden effects

Written by `make hidden HIDDEN="--seeds {seeds}"`: strips of `validation/hidden/strip.py`, which shares no code with the
product, each with something hidden; the model that is diagnosed is `lumped` + `equilibrium`. The misfit is what the
fitted model leaves beyond the sensor noise, as √(rms² - noise²)/noise of the worse sensor.
"""


def main() -> int:
    """Run what is not done yet, within the time given; print and write the table."""
    parser = argparse.ArgumentParser(description="diagnosis on strips with hidden effects")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--minutes", type=float, default=150.0, help="stop beginning new cases after this time")
    parser.add_argument("--only", default="", help="cases whose name holds this text")
    parser.add_argument("--results", type=Path, default=Path("hidden-results.jsonl"))
    parser.add_argument("--out", type=Path, help="write the table, as docs/hidden.md")
    args = parser.parse_args()
    done = [json.loads(line) for line in args.results.read_text().splitlines()] if args.results.exists() else []
    known = {r["case"] for r in done}
    chosen = [c for c in cases(args.seeds) if args.only in c.name]
    end = time.monotonic() + 60.0 * args.minutes
    with tqdm(total=len(chosen), unit="case", dynamic_ncols=True) as bar, args.results.open("a") as log:
        for case in chosen:
            if case.name not in known and time.monotonic() < end:
                bar.set_description_str(case.name)
                done.append(judge(case))
                log.write(json.dumps(done[-1]) + "\n")
                log.flush()
            bar.update()
    names = {c.name for c in chosen}
    text = f"{HEAD.format(seeds=args.seeds)}\n{table([r for r in done if r['case'] in names])}\n"
    print(text)
    if args.out:
        args.out.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
