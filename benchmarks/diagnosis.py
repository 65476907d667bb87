# SPDX-License-Identifier: Apache-2.0
"""`lce fit` and `lce diagnose` as commands: time with start-up, and memory."""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "validation"))
sys.path.insert(0, str(Path(__file__).parents[1] / "validation" / "hidden"))

from campaign import Case, campaign, waves
from families import FAMILIES

from lce_data.run import Run
from lce_model import default_model, save_model

PROGRAM = (
    "import resource, sys; from lce_app.cli.main import main; status = main(sys.argv[1:]); "
    "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, file=sys.stderr); sys.exit(status)"
)
SIX_RUNS = (
    Case("equilibrium", ("creep",), "clear", seed=0),
    Case("chapter-5-continuous", ("creep",), "clear", seed=0),
    Case("chapter-5-literal", ("elastic_softening",), "clear", seed=0),
    Case("relays", ("creep",), "clear", seed=0),
    Case("equilibrium-by-dynamic", ("residual_strain",), "clear", seed=0),
    Case("chapter-5-literal", ("natural_convection", "phase_kinetics"), "clear", seed=0),
    Case("equilibrium-by-dynamic", ("natural_convection", "phase_kinetics"), "clear", seed=0),
)
"""A strip for each base model, one with jumps, one beside a wrong base, and two that hide two effects."""


def six_runs() -> list[str]:
    """Six runs of a strip and two held out, with every base model; kernels are compiled by a call before."""
    rows = []
    for case in SIX_RUNS:
        train, test = campaign(case)
        with tempfile.TemporaryDirectory() as folder:
            files = [_csv(Path(folder) / f"{run.name}.csv", run) for run in train]
            held_out = [_csv(Path(folder) / f"{run.name}.csv", run) for run in test]
            model = str(Path(folder) / "m.yaml")
            base = FAMILIES[case.family].base
            fit = ["fit", *files, "--deformation", base, "--out", model]
            diagnose = ["diagnose", *files, "--test", *held_out, "--model", model]
            for command in (fit, diagnose):
                _timed(command)
            (fitted, _), (diagnosed, done) = _timed(fit), _timed(diagnose)
        answer, hidden = done.stdout.splitlines()[0], " and ".join(case.hidden)
        rows.append(f"| {case.family}, {hidden} | {base} | {fitted:.0f} s | {diagnosed:.0f} s | {answer} |")
    return [
        "## `lce fit` and `lce diagnose`, six runs and two held out, start-up included",
        "",
        "The strips are cases of [hidden.md](hidden.md).",
        "",
        "| strip and what it hides | base model | `lce fit` | `lce diagnose` | its first sentence |",
        "|---|---|---|---|---|",
        *rows,
        "",
    ]


def _timed(words: list[str]) -> tuple[float, subprocess.CompletedProcess[str]]:
    """Wall time [s] of an `lce` command, and what it printed."""
    begin = time.perf_counter()
    done = subprocess.run([sys.executable, "-c", PROGRAM, *words], capture_output=True, text=True, check=True)
    return time.perf_counter() - begin, done


def measure() -> list[str]:
    """Ten runs of a strip that creeps, every effect of the library a candidate; the second call has its kernels."""
    strip = Case("equilibrium", ("creep",), "clear", seed=2)
    body = strip.strip.body
    powers = waves(body.top_w)
    chosen = [*powers, "stairs", "prbs"]
    with tempfile.TemporaryDirectory() as folder:
        model = Path(folder) / "m.yaml"
        save_model(default_model().set({"lumped.gain": body.gain, "lumped.tau": body.tau}), model)
        files, samples = [], 0
        for i, name in enumerate(chosen):
            run = strip.record(f"{name}-{i}", powers[name])
            files.append(_csv(Path(folder) / f"{i}-{name}.csv", run))
            samples += powers[name].size
        (first, _), (second, done) = (_timed(["diagnose", *files, "--model", str(model)]) for _ in range(2))
        memory = int(done.stderr.split()[-1]) / 1024.0
    return [
        f"## `lce diagnose`, {len(chosen)} runs, {samples / 100.0:.0f} s at 100 Hz, 21 candidates, start-up included",
        "",
        "| | time | memory |",
        "|---|---|---|",
        f"| first call, kernels compiled | {first:.0f} s | |",
        f"| second call | {second:.0f} s | {memory:.0f} MB |",
        "",
        f"Its answer: {done.stdout.splitlines()[0]}",
        "",
    ]


def _csv(path: Path, run: Run) -> str:
    power, camera, distance = run.power, run.temperature, run.displacement
    assert power is not None and camera is not None and distance is not None
    rows = ["time_s,power_w,temperature_c,displacement_m"]
    for i, t in enumerate(power.time_s):
        celsius = f"{camera.value[i // 10] - 273.15:.3f}" if i % 10 == 0 else ""
        rows.append(f"{t:.2f},{power.value[i]:.5f},{celsius},{distance.value[i]:.8f}")
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return str(path)
