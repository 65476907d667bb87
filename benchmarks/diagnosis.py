# SPDX-License-Identifier: Apache-2.0
"""`lce diagnose` as a command on ten runs: time with start-up, and memory."""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "validation"))
sys.path.insert(0, str(Path(__file__).parents[1] / "validation" / "hidden"))

from campaign import Case, waves

from lce_data.run import Run
from lce_model import default_model, save_model

PROGRAM = (
    "import resource, sys; from lce_app.cli.main import main; status = main(sys.argv[1:]); "
    "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, file=sys.stderr); sys.exit(status)"
)


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
        took = []
        for _ in range(2):
            begin = time.perf_counter()
            done = subprocess.run(
                [sys.executable, "-c", PROGRAM, "diagnose", *files, "--model", str(model)],
                capture_output=True,
                text=True,
                check=True,
            )
            took.append(time.perf_counter() - begin)
        memory = int(done.stderr.split()[-1]) / 1024.0
    return [
        f"## `lce diagnose`, {len(chosen)} runs, {samples / 100.0:.0f} s at 100 Hz, 21 candidates, start-up included",
        "",
        "| | time | memory |",
        "|---|---|---|",
        f"| first call, kernels compiled | {took[0]:.0f} s | |",
        f"| second call | {took[1]:.0f} s | {memory:.0f} MB |",
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
