# SPDX-License-Identifier: Apache-2.0
"""`make demo`: the main job from end to end, with the commands that a user would type.

A simulated strip is driven through the node graph and recorded. It has an effect that the model fitted to it does not
know; the model is compared with the recordings, the effect found, added, and judged on a run that was held out.
Everything goes to ``demo/``.
"""

import json
import shlex
import shutil
import sys
import time
from pathlib import Path

from lce_app.cli.main import main as lce

MARK = ".made-by-lce-demo"
HIDDEN = "creep", {"creep.share": 0.12, "creep.tau_v": 12.0}
TRAINING = {
    "pulse": "pulse:amp=0.4,th=20,rest=60",
    "stairs": "stairs:low=0.3,high=1.8,steps=5,hold=10,rest=40",
    "cycles": "cycles:low=0.5,high=1.6,period=30,count=2,start=10,rest=30",
}
HELD_OUT = {"prbs": "prbs:low=0.4,high=1.8,bit=3,order=5,rest=30"}


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
    strip, model, better = folder / "strip.yaml", folder / "model.yaml", folder / "model-2.yaml"
    _make_strip(strip)
    protocols = TRAINING | HELD_OUT
    steps: list[list[object]] = [
        ["run", protocol, "--fast", "--model", strip, "--seed", i, "--out", folder / name]
        for i, (name, protocol) in enumerate(protocols.items())
    ]
    runs, test = [folder / name for name in TRAINING], ["--test", *(folder / name for name in HELD_OUT)]
    reports = [folder / f"{name}.html" for name in ("compare", "diagnose", "add")]
    steps += [
        ["fit", *runs, "--deformation", "kinetic", "--out", model],
        ["compare", *runs, "--model", model, "--report", reports[0]],
        ["diagnose", *runs, *test, "--model", model, "--report", reports[1], "--json", folder / "diagnose.json"],
    ]
    if status := _run(steps):
        return status
    found = json.loads((folder / "diagnose.json").read_text(encoding="utf-8"))["added"]
    for effect in found[:1]:
        add: list[object] = ["add", effect, *runs, *test, "--model", model, "--out", better, "--report", reports[2]]
        if status := _run([add]):
            return status
    named = ", ".join(found) or "nothing"
    print(f"\nDone in {time.monotonic() - begin:.0f} s. Hidden: {HIDDEN[0]}; found: {named}. Pictures:")
    print("".join(f"  {report}\n" for report in reports if report.exists()), end="")
    return 0


def _run(steps: list[list[object]]) -> int:
    """The `lce` commands, one after the other; the first status that is not 0."""
    for step in steps:
        words = [str(word) for word in step]
        print(f"\n$ lce {shlex.join(words)}", flush=True)
        if status := lce(words):
            return status
    return 0


def _make_strip(path: Path) -> None:
    """A strip whose contraction partly arrives late, which the model fitted to it does not know."""
    from lce_model import default_model, save_model

    effect, values = HIDDEN
    save_model(default_model("lumped", "kinetic").add(effect).set(values), path)


if __name__ == "__main__":
    sys.exit(main())
