# SPDX-License-Identifier: Apache-2.0
"""`make control`: the modes of control beside each other and beside the bang-bang limit, as in Tables 6.2 and 6.3.

The controllers of the nodes are closed over the simulated strip with the noise of its sensors, without ROS; one run
goes through the real nodes as well. Writes docs/results/control_comparison.md and docs/pictures/control.svg.
"""

import argparse
import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from textwrap import fill

import control_independent
import numpy as np
from control_cases import MODES, PERIOD_S, Case, known, play, play_all, steps, trajectory
from loop_pictures import Picture, draw
from tqdm import tqdm

from lce_app.cli.main import main as lce
from lce_control.step_metrics import StepMetrics, step_metrics
from lce_control.tuning.closed_loop import ClosedLoop
from lce_data.topics import TARGET
from lce_experiment.positioning.outcome import read_series

ROOT = Path(__file__).resolve().parents[1]
PAGE, PICTURE = ROOT / "docs" / "results" / "control_comparison.md", ROOT / "docs" / "pictures" / "control.svg"
TARGETS_MM = (1.0, 1.5, 2.0, 2.5, 3.0)
PRINTED = {  # target [mm]: σ double, σ single [%] of Table 6.2; rise double, single [s] of Table 6.3
    1.0: (1.59, 2.52, 5.12, 20.97),
    1.5: (1.74, 2.31, 4.23, 19.88),
    2.0: (2.15, 2.76, 4.15, 17.12),
    2.5: (1.81, 2.18, 4.87, 16.08),
    3.0: (1.94, 2.55, 4.96, 14.95),
}
FROM_REST = [steps(f"{target:g} mm", (target,)) for target in TARGETS_MM]
DOWN = steps("steps down", (2.5, 1.5, 2.0, 1.0, 3.0, 0.8))
MINOR = steps("minor loops", (1.5, 1.8, 1.2, 1.6, 1.4, 1.7))
START_S = 20.0
TRAJECTORIES = [
    trajectory("ramp up, 25 µm/s", lambda t: 1e-3 + 25e-6 * np.clip(t - START_S, 0.0, 40.0), 60.0),
    trajectory("ramp down, 25 µm/s", lambda t: 2e-3 - 25e-6 * np.clip(t - START_S, 0.0, 40.0), 60.0),
    *(
        trajectory(
            f"sine of {hertz:g} Hz, ±0.3 mm",
            lambda t, hertz=hertz: 1.5e-3 + 0.3e-3 * np.sin(2.0 * np.pi * hertz * np.clip(t - START_S, 0.0, None)),
            START_S + 2.0 / hertz,
        )
        for hertz in (0.01, 0.03, 0.1)
    ),
]
GAIN, TAU, T_ENV, ALPHA = (known()[key] for key in ("lumped.gain", "lumped.tau", "ambient.t_env", "stretch_law.alpha"))
AT_S, HELD_M = 30.0, 2e-3
DRAUGHT = {"lumped.gain": 0.75 * GAIN, "lumped.tau": 0.75 * TAU}
DISTURBANCES = [
    steps(name, (1e3 * HELD_M,), 90.0, changes=changes)
    for name, changes in {
        "ambient −5 K": ((AT_S, {"ambient.t_env": T_ENV - 5.0}),),
        "20 % less power": ((AT_S, {"lumped.gain": 0.8 * GAIN}),),
        "load: α 2.2 → 2.0": ((AT_S, {"stretch_law.alpha": ALPHA - 0.2}),),
        "draught of 5 s, a third more loss": ((AT_S, DRAUGHT), (AT_S + 5.0, {})),
    }.items()
]


def unlike() -> list[Case]:
    """Strips with one parameter 10 % off; of a temperature, 10 % of what it lies above the surroundings."""
    cases = []
    for value in known().values:
        if value.fixed or value.key in ("ambient.t_env", "kinetic.t_ref"):
            continue
        zero = T_ENV if value.unit == "K" and value.name == "t_c" else 0.0
        for factor in (0.9, 1.1):
            settings = {value.key: zero + factor * (value.value - zero)}
            cases += [
                steps(f"{value.key} {factor - 1:+.0%} {target:g}", (target,), settings=settings)
                for target in (1.0, 2.5)
            ]
    return cases


class Results:
    """Every run that was played, by case, mode and seed."""

    def __init__(self, workers: int) -> None:
        self._workers = workers
        self.loops: dict[tuple[str, str, int], ClosedLoop] = {}

    def play(self, cases: Sequence[Case], modes: Sequence[str], seeds: int) -> None:
        """Add the runs; the limit has no noise and needs no second seed."""
        jobs = [
            (case, mode, seed) for case in cases for mode in modes for seed in range(1 if mode == "limit" else seeds)
        ]
        played = tqdm(play_all(jobs, self._workers), f"{cases[0].name} …", len(jobs), unit="run")
        for (case, mode, seed), loop in zip(jobs, played, strict=True):
            self.loops[case.name, mode, seed] = loop

    def of(self, case: Case, mode: str) -> list[ClosedLoop]:
        """The runs of a case in a mode, one for each seed."""
        return [loop for (name, m, _), loop in self.loops.items() if (name, m) == (case.name, mode)]

    def figures(self, case: Case, mode: str) -> list[list[StepMetrics]]:
        """The figures of every step, for each seed."""
        return [_figures(case, loop) for loop in self.of(case, mode)]

    def worst(self, cases: Sequence[Case], mode: str, name: str, first: int = 0) -> float:
        """The largest figure ``name`` of all cases, seeds and steps from the ``first`` on; inf if one is NaN."""
        found = [getattr(f, name) for c in cases for steps in self.figures(c, mode) for f in steps[first:]]
        return math.inf if any(math.isnan(x) for x in found) else max(found)


def _figures(case: Case, loop: ClosedLoop) -> list[StepMetrics]:
    edges = [*(round(t / PERIOD_S) for t, _ in case.targets), loop.time_s.size]
    pieces = [slice(a, b) for a, b in pairwise(edges)]
    return [
        step_metrics(loop.time_s[piece] - loop.time_s[piece][0], loop.displacement_m[piece], target_m)
        for piece, (_, target_m) in zip(pieces, case.targets, strict=True)
    ]


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """A table in Markdown."""
    lines = (f"| {' | '.join(row)} |" for row in (head, ["---"] * len(head), *rows))
    return [*lines, ""]


def seconds(value: float) -> str:
    """A time [s] as text, or "never"."""
    return f"{value:.2f}" if math.isfinite(value) else "never"


def from_rest(results: Results) -> list[str]:
    """Tables 6.2 and 6.3: mean over the seeds."""
    rise, rmse, over = [], [], []

    def mean(case: Case, mode: str, name: str) -> float:
        return float(np.mean([getattr(f[0], name) for f in results.figures(case, mode)]))

    for case, target in zip(FROM_REST, TARGETS_MM, strict=True):
        printed = PRINTED[target]
        rise.append([f"{target:g}", *(seconds(mean(case, m, "rise_time_s")) for m in (*MODES, "limit")),
                     f"{printed[3]:.2f}", f"{printed[2]:.2f}"])  # fmt: skip
        rmse.append([f"{target:g}", *(f"{mean(case, m, 'rmse_after_30s'):.2%}" for m in MODES),
                     f"{printed[1]:.2f} %", f"{printed[0]:.2f} %"])  # fmt: skip
        over.append([f"{target:g}", *(f"{mean(case, m, 'overshoot'):.2%}" for m in MODES),
                     *(seconds(mean(case, m, "settling_time_s")) for m in (*MODES, "limit"))])  # fmt: skip
    theirs = ["single, dissertation", "double, dissertation"]
    return [
        "## Steps from rest",
        "",
        "Rise time to 80 % [s] (Table 6.3):",
        "",
        *table(["target [mm]", *MODES, "limit", *theirs], rise),
        "RMSE after 30 s, of the target (Table 6.2):",
        "",
        *table(["target [mm]", *MODES, *theirs], rmse),
        "Overshoot, of the target, and settling within 2 % [s]:",
        "",
        *table(
            ["target [mm]", *(f"overshoot {m}" for m in MODES), *(f"settling {m}" for m in (*MODES, "limit"))], over
        ),
    ]


def bars(results: Results) -> list[str]:
    """The project's bars, by the worst of all targets and seeds."""

    def row(what: str, value: float, bar: float, form: Callable[[float], str], higher: bool = False) -> list[str]:
        met = value >= bar if higher else value <= bar
        return [what, form(value), f"{'≥' if higher else '≤'} {form(bar)}", "met" if met else "**not met**"]

    def times(value: float) -> str:
        return f"{value:.2f} ×"

    def percent(value: float) -> str:
        return f"{value:.2%}" if math.isfinite(value) else "never there"

    worst = results.worst
    limits = {c.name: results.figures(c, "limit")[0][0].rise_time_s for c in FROM_REST}
    to_limit = max(worst([c], "model", "rise_time_s") / limits[c.name] for c in FROM_REST)
    faster = worst(FROM_REST, "single", "rise_time_s") / worst(FROM_REST, "double", "rise_time_s")
    loops = [DOWN, MINOR]
    rows = [
        row("single / double, rise time, worst target", faster, 3.0, times, higher=True),
        row("model / limit, rise time, worst target", to_limit, 1.3, times),
        row("double, RMSE after 30 s, worst", worst(FROM_REST, "double", "rmse_after_30s"), 0.01, percent),
        row("model, RMSE after 30 s, worst", worst(FROM_REST, "model", "rmse_after_30s"), 0.005, percent),
        row("double, overshoot, worst", worst(FROM_REST, "double", "overshoot"), 0.05, percent),
        row("model, overshoot, worst", worst(FROM_REST, "model", "overshoot"), 0.01, percent),
        row("double, steps down and minor loops, RMSE", worst(loops, "double", "rmse_after_30s", 1), 0.02, percent),
        row("model, steps down and minor loops, RMSE", worst(loops, "model", "rmse_after_30s", 1), 0.01, percent),
    ]
    times_limit = {
        m: max(worst([c], m, "rise_time_s") / limits[c.name] for c in FROM_REST) for m in ("single", "double")
    }
    text = (
        "The first bar cannot be met: with gains from `lce tune` the single loop gives full power until shortly before "
        f"the target, as the double loop does, and takes at most {times_limit['single']:.2f} × what the limit takes "
        f"(double: {times_limit['double']:.2f} ×). Nothing can be three times as fast as that; only a single loop that "
        "is tuned badly would leave room for it."
    )
    return ["## The bars", "", *table(["figure", "measured", "bar", ""], rows), text, ""]


def loops(results: Results) -> list[str]:
    """Steps down and minor loops: the worst of all seeds for each step."""
    text = [
        "## Steps down and minor loops",
        "",
        "Worst seed. A step begins where the one before left the strip: a mode that overshot there holds it on a "
        "colder branch, and is down a little before the limit, which never overshoots.",
        "",
    ]
    for case in (DOWN, MINOR):
        rows = []
        before = 0.0
        for k, (_, target_m) in enumerate(case.targets):
            of = {m: [f[k] for f in results.figures(case, m)] for m in (*MODES, "limit")}
            rows.append(
                [
                    f"{before:g} → {1e3 * target_m:g}",
                    *(seconds(max(f.rise_time_s for f in of[m])) for m in (*MODES, "limit")),
                    *(f"{max(f.rmse_after_30s for f in of[m]):.2%}" for m in MODES),
                    *(f"{max(f.overshoot for f in of[m]):.2%}" for m in MODES),
                ]
            )
            before = 1e3 * target_m
        head = ["mm", *(f"80 % [s] {m}" for m in (*MODES, "limit")), *(f"RMSE {m}" for m in MODES),
                *(f"overshoot {m}" for m in MODES)]  # fmt: skip
        text += table(head, rows)
    return text


def trajectories(results: Results) -> list[str]:
    """RMS distance from a target that moves."""
    rows = []
    for case in TRAJECTORIES:
        cells = []
        for mode in (*MODES, "limit"):
            errors = []
            for loop in results.of(case, mode):
                late = loop.time_s >= START_S
                errors.append(np.sqrt(np.mean((loop.displacement_m - case.target_m(loop.time_s))[late] ** 2)))
            cells.append(f"{1e6 * max(errors):.0f}")
        rows.append([case.name, *cells])
    return [
        "## Trajectories",
        "",
        "RMS distance from the target [µm], from the moment it moves, worst seed. The strip heats faster than it "
        "cools, and has to cool through its loop before it lengthens at all: a falling target can be faster than any "
        "controller. The limit here knows everything about the strip, and of the target where it is and how it moves; "
        "it never goes beyond it.",
        "",
        *table(["target", *MODES, "limit"], rows),
    ]


def disturbances(results: Results) -> list[str]:
    """How far a disturbance moves a strip that is held, and for how long."""
    rows = []
    for case in DISTURBANCES:
        cells = [case.name]
        for mode in (*MODES, "limit"):
            off, back_s = [], []
            for loop in results.of(case, mode):
                error = np.abs(loop.displacement_m[loop.time_s >= AT_S] / HELD_M - 1.0)
                off.append(error.max())
                outside = np.flatnonzero(error > 0.02)
                back_s.append(0.0 if outside.size == 0 else (outside[-1] + 1) * PERIOD_S)
            longest = max(back_s)
            cells.append(f"{max(off):.2%}, {'never' if longest >= 90.0 - AT_S else f'{longest:.1f} s'}")
        rows.append(cells)
    return [
        "## Disturbances",
        "",
        f"{1e3 * HELD_M:g} mm are held; after {AT_S:g} s the strip is disturbed. Largest error, and time until it "
        "stays within 2 %, worst seed.",
        "",
        *table(["disturbance", *MODES, "limit"], rows),
    ]


def model_errors(results: Results, cases: Sequence[Case]) -> list[str]:
    """A strip that is not the model: the worst over both targets."""
    pairs: dict[str, list[Case]] = {}
    for case in cases:
        pairs.setdefault(case.name.rpartition(" ")[0], []).append(case)
    rows = [
        [
            name,
            *(f"{results.worst(pair, m, 'overshoot'):.2%}" for m in MODES),
            *(f"{results.worst(pair, m, 'rmse_after_30s'):.2%}" for m in MODES),
            *(seconds(results.worst(pair, m, "rise_time_s")) for m in (*MODES, "limit")),
        ]
        for name, pair in pairs.items()
    ]
    head = ["strip", *(f"overshoot {m}" for m in MODES), *(f"RMSE {m}" for m in MODES),
            *(f"80 % [s] {m}" for m in (*MODES, "limit"))]  # fmt: skip

    def largest(mode: str) -> str:
        name = max(pairs, key=lambda name: results.worst(pairs[name], mode, "overshoot"))
        return f"{mode} {results.worst(pairs[name], mode, 'overshoot'):.2%} ({name})"

    return [
        "## A strip that is not the model",
        "",
        "One parameter of the strip is 10 % off what the controllers know (of T_c, 10 % of what it lies above the "
        f"surroundings); worst of 1.0 and 2.5 mm. Largest overshoots: {', '.join(map(largest, MODES))}.",
        "",
        *table(head, rows),
    ]


def unknown_strip(seeds: int, workers: int) -> list[str]:
    """Strips of other equations, with a model identified from their recordings."""
    turns = "; ".join(
        f"{s.strip.name}: {', '.join(f'{t:g}' for t in s.targets_mm)} mm" for s in control_independent.SPECIMENS
    )
    head = ["strip", "mode", "80 % of the first [s]", "full power [s]", "overshoot, worst", "RMSE after 30 s, worst"]
    return [
        "## A strip of other equations, identified first",
        "",
        "The independent strip (`validation/independent_strip`) shares no code with the models. A `kinetic` model with "
        "natural convection and phase kinetics is fitted to four noisy recordings of it "
        f"({', '.join(control_independent.TRAINING)} of `make comparison`); that is what the controllers know, while "
        f"the gains stay those of the default strip. Targets in turn, {control_independent.HOLD_S:g} s each, from "
        f"rest: {turns}. {seeds} seeds, worst of all steps.",
        "",
        *table(head, list(control_independent.rows(seeds, workers))),
    ]


def through_nodes() -> list[str]:
    """The same target through the real nodes and without them."""
    rows = []
    case = FROM_REST[2]
    for mode in MODES:
        with TemporaryDirectory() as folder:
            bag = Path(folder) / "bag"
            words = ["control", "2", "--mode", mode, "--fast", "--seed", "0", "--out", str(bag)]
            if lce(words) != 0:
                raise SystemExit(f"lce {' '.join(words)} failed")
            series = read_series(bag)
        begin_s = series[TARGET][0][0]
        time_s, d = series["sim/displacement"]
        nodes = step_metrics((time_s - begin_s)[time_s >= begin_s], d[time_s >= begin_s], 2e-3)
        pure = _figures(case, play(case, mode, 0))[0]
        rows.append(
            [mode] + [f"{seconds(f.rise_time_s)}, {f.overshoot:.2%}, {f.rmse_after_30s:.2%}" for f in (nodes, pure)]
        )
    return [
        "## Through the real nodes",
        "",
        "2.0 mm from rest: rise time [s], overshoot, RMSE after 30 s. With `lce control 2 --fast --seed 0` the nodes "
        "of the bench exchange messages, the laser takes a command at its next tick, and the noise is another one.",
        "",
        *table(["mode", "nodes", "without"], rows),
    ]


def picture(results: Results) -> None:
    """A step from rest and a step down of each mode, over the limit."""

    def panel(case: Case, k: int, mode: str, title: str) -> Picture:
        piece = slice(k * 6000, k * 6000 + 3000)
        limit, loop = results.of(case, "limit")[0], results.of(case, mode)[0]
        time_s = limit.time_s[piece] - limit.time_s[piece][0]
        return Picture(title, time_s, 1e3 * limit.displacement_m[piece], 1e3 * loop.displacement_m[piece])

    up = [panel(FROM_REST[2], 0, mode, f"{mode}: 2 mm from rest") for mode in MODES]
    down = [panel(DOWN, 3, mode, f"{mode}: from 2 to 1 mm") for mode in MODES]
    PICTURE.parent.mkdir(exist_ok=True)
    draw([*up, *down], ("time in s", "d in mm", "limit", "mode"), PICTURE)


def main() -> None:
    """Play everything and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=20, help="seeds of the noise for steps (20)")
    parser.add_argument("--workers", type=int, default=2, help="processes (2)")
    args = parser.parse_args()
    results, everything, other = Results(args.workers), (*MODES, "limit"), unlike()
    results.play(FROM_REST, everything, args.seeds)
    results.play([DOWN, MINOR], everything, args.seeds)
    results.play(TRAJECTORIES, everything, min(args.seeds, 3))
    results.play(DISTURBANCES, everything, min(args.seeds, 5))
    results.play(other, everything, 1)
    text = [
        "# The modes of control beside each other",
        "",
        "Written by `make control`. The strip is that of `lce control`, camera at 10 Hz with 0.06 K of noise, distance "
        "sensor with 4 µm, command limit 2 W; all modes see the same noise. `single` and `double` have the gains of "
        "[`control.yaml`](../../src/lce_bringup/config/control.yaml). The limit is the bang-bang limit of the same "
        "strip: full power until the switching time, then what holds the target, everything about it known. Figures "
        f"are those of the true displacement; {args.seeds} seeds of the noise for steps.",
        "",
        "![Steps of the three modes over the limit](../pictures/control.svg)",
        "",
        *bars(results),
        *from_rest(results),
        *loops(results),
        *trajectories(results),
        *disturbances(results),
        *model_errors(results, other),
        *unknown_strip(min(args.seeds, 3), args.workers),
        *through_nodes(),
    ]
    picture(results)
    lines = [line if line.startswith("|") else fill(line, 120, break_long_words=False, break_on_hyphens=False)
             for line in text]  # fmt: skip
    PAGE.write_text("\n".join(lines).rstrip() + "\n", encoding="utf-8")
    print(PAGE)


if __name__ == "__main__":
    main()
