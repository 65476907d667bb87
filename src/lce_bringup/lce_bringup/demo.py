# SPDX-License-Identifier: Apache-2.0
"""`make demo`: the main job from end to end, with the commands that a user would type.

A simulated strip is driven through the node graph and recorded; two models are identified from the recordings and
compared with them. The strip follows the dynamic model of chapter 5, so the equilibrium model of chapter 4 must fail
where the phase transition lags, and the dynamic one must come down to the sensor noise. Everything goes to ``demo/``.
"""

import shlex
import shutil
import sys
import time
from pathlib import Path

from lce_bringup.cli import main as lce

MARK = ".made-by-lce-demo"
RUNS = {
    "pulse": "pulse:amp=0.4,th=20,rest=40",
    "stairs": "stairs:low=0.2,high=1.2,steps=5,hold=8,rest=30",
}


def main() -> int:
    """Run the demo; 0 if every command of it did."""
    folder = Path("demo")
    if folder.exists():
        if not (folder / MARK).exists():
            print("demo: a folder named demo is in the way; move it elsewhere", file=sys.stderr)
            return 1
        shutil.rmtree(folder)
    folder.mkdir()
    (folder / MARK).touch()
    begin = time.monotonic()
    strip = folder / "strip.yaml"
    _make_strip(strip)
    runs = [folder / name for name in RUNS]
    steps: list[list[object]] = [
        ["run", protocol, "--fast", "--model", strip, "--seed", i, "--out", run]
        for i, (run, protocol) in enumerate(zip(runs, RUNS.values(), strict=True))
    ]
    for name in ("equilibrium", "dynamic"):
        model = folder / f"{name}.yaml"
        steps.append(["fit", *runs, "--deformation", name, "--out", model])
        steps.append(["compare", *runs, "--model", model, "--report", folder / f"{name}.html"])
    for step in steps:
        words = [str(word) for word in step]
        print(f"\n$ lce {shlex.join(words)}", flush=True)
        if status := lce(words):
            return status
    print(f"\nDone in {time.monotonic() - begin:.0f} s. Where the models fit and where they do not, in pictures:")
    print(f"  {folder / 'equilibrium.html'}\n  {folder / 'dynamic.html'}")
    return 0


def _make_strip(path: Path) -> None:
    from lce_model import default_model, save_model

    save_model(default_model("lumped", "dynamic"), path)


if __name__ == "__main__":
    sys.exit(main())
