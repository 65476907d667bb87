# SPDX-License-Identifier: Apache-2.0
"""Simulation, start-up and identification, each beside its alternative in the same run.

The alternatives are written here from the equations, with NumPy and SciPy alone, and share nothing with the product.
"""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import differential_evolution
from tqdm import tqdm

from lce_analysis.comparison.metrics import nrmse
from lce_analysis.identification import fit
from lce_analysis.prediction import predict
from lce_data.channels import DISPLACEMENT
from lce_data.run import Run, Series
from lce_model import default_model, simulate

Floats = NDArray[np.float64]
BOLTZMANN = 1.380649e-23
AMBIENT_K, GAIN, TAU_S, HEATED_S, POWER_W = 301.15, 73.0, 18.0, 20.0, 1.75
NAMES = (
    "a0_r", "b_r", "c_r", "a0_f", "b_f", "c_f", "t_star", "cr1_r", "cr2_r", "cf1_r", "cr1_f", "cf1_f", "cf2_f",
)  # fmt: skip


def best_of(times: int, work: Callable[[], object]) -> float:
    """Shortest of several runs, in s."""
    durations = []
    for _ in range(times):
        begin = time.perf_counter()
        work()
        durations.append(time.perf_counter() - begin)
    return min(durations)


def rates(t: Any, branch: str, p: dict[str, Any]) -> tuple[Any, Any, Any]:
    """(w13, w31, Q3) of chapter 5, for numbers or arrays."""
    a0, b, c = (p[f"{n}_{branch}"] for n in ("a0", "b", "c"))
    root = np.sqrt(np.maximum(b * b - 4.0 * a0 * (t - p["t_star"]) * c, 0.0))
    q2, q3 = np.maximum((b - root) / (2.0 * c), 0.0), (b + root) / (2.0 * c)

    def energy(q: Any) -> Any:
        return 0.5 * a0 * (t - p["t_star"]) * q**2 - b * q**3 / 3.0 + 0.25 * c * q**4

    gap, kt = q3 - q2, BOLTZMANN * t
    first, second = (p["cf1_r"], 0.0) if branch == "r" else (p["cf1_f"], p["cf2_f"])
    back, back2 = (p["cr1_r"], p["cr2_r"]) if branch == "r" else (p["cr1_f"], 0.0)
    w13 = (first + second * gap) * gap * np.exp(-energy(q2) / kt)
    w31 = (back + back2 * q2) * q2 * np.exp(-(energy(q2) - energy(q3)) / kt)
    return w13, w31, q3


def _published() -> dict[str, float]:
    return {v.name: v.value for v in default_model("lumped", "dynamic").values}


def lsoda(time_s: Floats, power_w: Floats, rtol: float, restart: bool) -> Floats:
    """Displacement (n,) by LSODA on the equations of P → T → x, every power held to the next time.

    With ``restart`` the solver begins anew wherever the power changes, as its smooth right-hand side demands; without,
    it is left to find the steps of the input by itself, as most users do.
    """
    p = _published()

    def rhs(t: float, y: Floats) -> list[float]:
        power = power_w[min(int(t * 100.0 + 1e-9), power_w.size - 1)] if not restart else held
        speed = (GAIN * power - (y[0] - AMBIENT_K)) / TAU_S
        w13, w31, _ = rates(y[0], "r" if speed >= 0.0 else "f", p)
        return [speed, (w13 * (1.0 - y[1]) - w31 * y[1]) * abs(speed)]

    edges = np.append(np.flatnonzero(np.diff(power_w, prepend=np.nan) != 0.0), time_s.size - 1)
    edges = edges if restart else np.array([0, time_s.size - 1])
    states = np.empty((2, time_s.size))
    y = states[:, 0] = np.array([AMBIENT_K, 1.0])
    for first, last in pairwise(edges):
        held = power_w[first]
        if last > first:
            at = time_s[first : last + 1]
            solution = solve_ivp(rhs, (at[0], at[-1]), y, "LSODA", t_eval=at, rtol=rtol, atol=[rtol * 300.0, rtol])
            states[:, first : last + 1] = solution.y
            y = solution.y[:, -1]
    rising = np.append(True, np.diff(states[0]) >= 0.0)
    return np.where(rising, _displacement(*states, "r", p), _displacement(*states, "f", p))


def _displacement(t: Floats, x: Floats, branch: str, p: dict[str, Any]) -> Floats:
    alpha, reference = p["alpha"], rates(p["t_ref"], "r", p)[2]
    return np.asarray(
        p["length"] * (1.0 - ((1.0 + alpha * x * rates(t, branch, p)[2]) / (1.0 + alpha * reference)) ** (1 / 3))
    )


def simulation() -> list[str]:
    """Joint simulation against LSODA, both against LSODA with restarts at a tolerance of 1e-12."""
    time_s = np.arange(6000) * 0.01
    model = default_model("lumped", "dynamic").set(
        {"lumped.gain": GAIN, "lumped.tau": TAU_S, "ambient.t_env": AMBIENT_K}
    )
    lines = [
        "## Joint simulation P → T → d, 6 000 samples, `dynamic`",
        "",
        "Errors are the largest over the range, against LSODA restarted at every change of the power, rtol 1e-12.",
        "",
        "| input | `lce_model` | error | SciPy LSODA, same equations | rtol | error | ratio of times |",
        "|---|---|---|---|---|---|---|",
    ]
    for name, power, restart in (
        ("rectangular pulse, LSODA restarted at its edge", np.where(time_s < HEATED_S, POWER_W, 0.0), True),
        (
            "pulse of (4.20) sampled at 100 Hz",
            np.where(time_s < 20.0, 0.4 * np.sin(np.pi / 40.0 * time_s) + 1.5, 0.0),
            False,
        ),
    ):
        reference = lsoda(time_s, power, 1e-12, restart=True)
        scale = float(np.max(np.abs(reference)))
        error = float(np.max(np.abs(simulate(model, time_s, power).displacement_m - reference))) / scale
        ours_s = best_of(50, lambda power=power: simulate(model, time_s, power))
        for rtol in 10.0 ** -np.arange(5.0, 13.0):
            theirs = float(np.max(np.abs(lsoda(time_s, power, rtol, restart) - reference))) / scale
            if theirs <= 1e-6:
                break
        lsoda_s = best_of(3, lambda power=power, rtol=rtol, restart=restart: lsoda(time_s, power, rtol, restart))
        lines.append(
            f"| {name} | {ours_s * 1e3:.2f} ms | {error:.0e} | {lsoda_s * 1e3:.0f} ms | {rtol:.0e} | {theirs:.0e} "
            f"| **{lsoda_s / ours_s:.0f}** |"
        )
    equilibrium = default_model("lumped", "equilibrium")
    equilibrium_s = best_of(50, lambda: simulate(equilibrium, time_s, power))
    return [*lines, "", f"`equilibrium`, the same length: {equilibrium_s * 1e3:.2f} ms.", ""]


KERNELS = """
import time
from lce_model import default_model
from lce_model.effects import library

model = default_model("lumped", "dynamic")
whole = model
for effect in library():
    whole = whole.add(effect)
for each in (model, model.add("creep"), whole):
    begin = time.perf_counter()
    each.kernel.run_many
    print(time.perf_counter() - begin)
"""
"""A model, the same with an effect, and with every effect of the library, one after the other in one process."""


def start_up() -> list[str]:
    """`lce --help`, and models compiled or loaded from the cache, each time in a new process."""
    help_s = best_of(5, lambda: subprocess.run(["lce", "--help"], capture_output=True, check=True))

    def kernels(cache: str) -> Floats:
        environment = os.environ | {"LCE_CACHE_DIR": cache}
        command = [sys.executable, "-c", KERNELS]
        out = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
        return np.array(out.stdout.split(), dtype=np.float64)

    with tempfile.TemporaryDirectory() as cache:
        compiled = kernels(cache)
        cached = np.min([kernels(cache) for _ in range(5)], axis=0)
    rows = zip(("`dynamic`", "then with `creep`", "then with every effect"), compiled, cached, strict=True)
    return [
        "## Start-up",
        "",
        f"`lce --help` takes {help_s:.2f} s. Kernels of one process, one after the other:",
        "",
        "| model | compiled for the first time | from the cache |",
        "|---|---|---|",
        *(f"| {name} | {first:.2f} s | {again:.2f} s |" for name, first, again in rows),
        "",
    ]


def made_run(th: float, seed: int) -> Run:
    """A pulse (4.20) of 60 s on the dynamic model with sensor noise."""
    time_s = np.arange(6000) * 0.01
    power = np.where(time_s < th, 0.4 * np.sin(np.pi / (2.0 * th) * time_s) + 1.5, 0.0)
    strip = simulate(default_model("lumped", "dynamic"), time_s, power)
    rng = np.random.default_rng(seed)
    camera = slice(None, None, 10)
    return Run.of(
        f"th{th:g}",
        Series(time_s, power),
        Series(time_s[camera], strip.temperature_k[camera] + 0.06 * rng.standard_normal(600)),
        Series(time_s, strip.displacement_m + 4e-6 * rng.standard_normal(6000)),
    )


class PlainLoop:
    """The dynamic model as NumPy loops: one step of the path at a time, all candidates of a population at once."""

    def __init__(self, runs: list[Run]) -> None:
        model = default_model("lumped", "dynamic")
        self.paths = [np.asarray(predict(model, r).temperature_k) for r in runs]
        self.measured = [r.displacement.value for r in runs if r.displacement is not None]
        values = {v.name: v for v in model.values}
        self.lower = np.array([values[n].lower for n in (*NAMES, "alpha")])
        self.upper = np.array([values[n].upper for n in (*NAMES, "alpha")])

    def parameters(self, u: Floats) -> dict[str, Floats]:
        """Candidates (k, m) of the unit box, logarithmic where the bounds allow it."""
        low, high = np.maximum(self.lower, 1e-3 * (self.lower == 0.0) + self.lower)[:, None], self.upper[:, None]
        log = high / low > 20.0
        p = np.where(log, low * (high / low) ** u, low + u * (high - low))
        return dict(zip((*NAMES, "alpha"), p, strict=True))

    def nrmse(self, u: Floats) -> Floats:
        """(m,) NRMSE of the displacement over all runs."""
        p = self.parameters(u)
        reference = rates(300.0, "r", p)[2]
        total, spread, count = np.zeros(u.shape[1]), 0.0, 0
        for path, measured in zip(self.paths, self.measured, strict=True):
            x, modelled = np.ones(u.shape[1]), np.empty((path.size, u.shape[1]))
            for i, t in enumerate(path):
                previous = path[max(i - 1, 0)]
                branch = "r" if t >= previous else "f"
                w13, w31, q3 = rates(0.5 * (t + previous), branch, p)
                total_rate = np.maximum(w13 + w31, 1e-300)
                settled = w13 / total_rate
                x = settled + (x - settled) * np.exp(-total_rate * abs(t - previous))
                modelled[i] = 0.01 * (1.0 - ((1.0 + p["alpha"] * x * q3) / (1.0 + p["alpha"] * reference)) ** (1 / 3))
            total += np.sum((modelled - measured[:, None]) ** 2, axis=0)
            spread += float(np.sum((measured - measured.mean()) ** 2))
            count += measured.size
        return np.nan_to_num(np.sqrt(total / spread), nan=1e3)


def identification(factor: float) -> list[str]:
    """The two-step strategy against SciPy's evolution over the plain loop, given ``factor`` times as long."""
    runs = [made_run(th, seed) for seed, th in enumerate((16, 17, 18, 19, 20, 21))]
    model = default_model("lumped", "dynamic")
    # From the defaults of the equilibrium rig rather than from the values that made the data.
    far = model.set({"lumped.gain": 30.0, "dynamic.t_star": 320.0, "dynamic.b_r": 8e-20, "stretch_law.alpha": 1.0})
    begin = time.perf_counter()
    result = fit(far, runs)
    ours_s = time.perf_counter() - begin
    error = np.sqrt(
        np.mean(
            [nrmse(predict(result.model, r).at_samples[DISPLACEMENT], r.series[DISPLACEMENT].value) ** 2 for r in runs]
        )
    )
    loop = PlainLoop(runs)
    stop = time.perf_counter() + factor * ours_s
    best = np.inf
    bar = tqdm(total=round(factor * ours_s), unit="s", desc="SciPy evolution over the plain loop")

    def objective(u: Floats) -> Floats:
        nonlocal best
        if time.perf_counter() > stop:
            return np.full(u.shape[1], best)
        value = loop.nrmse(u)
        best = min(best, float(value.min()))
        bar.n = min(bar.total, round(bar.total - (stop - time.perf_counter())))
        bar.refresh()
        return value

    differential_evolution(
        objective,
        [(0.0, 1.0)] * 14,
        strategy="best1bin",
        mutation=0.8,
        recombination=0.9,
        popsize=10,
        maxiter=100000,
        vectorized=True,
        updating="deferred",
        polish=False,
        tol=0.0,
        rng=0,
        callback=lambda *_a, **_k: time.perf_counter() > stop,
    )
    bar.close()
    return [
        "## Two-step identification of the dynamic model, six runs of 60 s at 100 Hz (T_h 16–21)",
        "",
        "| | time | NRMSE of d reached |",
        "|---|---|---|",
        f"| `lce fit` (both stages, 17 parameters) | {ours_s:.1f} s | {error:.2%} |",
        "| SciPy differential_evolution, NumPy loop over time, population vectorised "
        f"| {factor * ours_s:.0f} s (stopped) "
        f"| {best:.2%} |",
        "",
    ]
