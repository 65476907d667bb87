# SPDX-License-Identifier: Apache-2.0
"""`make heater`: what does the diagnosis say of a measured heater whose runs differ from day to day?

    python validation/heater_splits.py --source raw --effect my_effect.py

Every split of the six heater runs of docs/results/heater.md into at least two for training and at least one held out: a
lumped model is fitted to the training runs and diagnosed with the others as test. The heater has a second mass, and
another ambient temperature in every run (a two-state model with an ambient temperature of each run is the reference),
so second_mass is what should be named, and ambient.t_env, lumped.gain or lumped.tau what differs. Each split is
diagnosed once more without it in the library: then nothing should be named.
"""

import argparse
import os
import sys
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from tempfile import TemporaryDirectory

from joblib import Parallel, delayed, parallel_config
from tqdm import tqdm

sys.path.insert(0, str(Path(__file__).resolve().parent))

import heater

from lce_analysis.diagnosis import Diagnosis, diagnose
from lce_analysis.identification import fit, problem
from lce_data.channels import TEMPERATURE
from lce_data.read_runs import read_run
from lce_data.run import Run
from lce_model import default_model
from lce_model.effects import find, library

MISSING = "second_mass"
BARS = 0.05, 0.20
"""NRMSE in training and held out that should not be exceeded."""


@dataclass(frozen=True)
class Split:
    """What was said of one split.

    train, test : names of the runs.
    added : effects that were named, in their order; varies : parameters found to differ from run to run.
    instead : effects that are named where the library lacks what is missing.
    nrmse : of the temperature with them, in training and held out.
    train_rms, test_rms : RMS error of the temperature in units of its noise, of the refitted model without them and
        with them, over all runs together.
    """

    train: tuple[str, ...]
    test: tuple[str, ...]
    verdict: str
    added: tuple[str, ...]
    instead: tuple[str, ...]
    varies: tuple[str, ...]
    nrmse: tuple[float, float]
    train_rms: tuple[float, float]
    test_rms: tuple[float, float]


def splits(names: Sequence[str]) -> list[tuple[tuple[str, ...], tuple[str, ...]]]:
    """Every choice of two runs or more for training that leaves one or more to hold out."""
    chosen = [c for size in range(2, len(names)) for c in combinations(names, size)]
    return [(train, tuple(n for n in names if n not in train)) for train in chosen]


def diagnosed(
    train: Sequence[Run], test: Sequence[Run], effect_files: Sequence[str] = (), without: str = ""
) -> Diagnosis:
    """A lumped model fitted to the training runs and diagnosed, the others held out; ``without`` an effect."""
    model = fit(default_model("lumped", "none"), train).model
    candidates = [*library().values(), *map(find, effect_files)]
    return diagnose(model, train, test, [effect for effect in candidates if effect.name != without])


def judge(folder: Path, train: Sequence[str], test: Sequence[str], effect_files: Sequence[str], threads: int) -> Split:
    """Judge one split in a worker process, from the experiment files in a folder."""
    # The product takes all cores for one fit; splits side by side would fight for them.
    problem._POOL = ThreadPoolExecutor(threads)
    learned, held_out = ([read_run(folder / f"{name}.csv") for name in names] for names in (train, test))
    found = diagnosed(learned, held_out, effect_files)
    before, after = (
        tuple(table.misfit[column].rms[TEMPERATURE] for table in (found.train, found.test))
        for column in ("before", "after")
    )
    added = tuple(step.added for step in found.steps)
    instead = tuple(step.added for step in diagnosed(learned, held_out, effect_files, without=MISSING).steps)
    train_nrmse, test_nrmse = (table.nrmse["after"]["temperature_nrmse"] for table in (found.train, found.test))
    assert train_nrmse is not None and test_nrmse is not None
    return Split(
        tuple(train),
        tuple(test),
        found.verdict,
        added,
        instead,
        tuple(found.model.varies),
        (train_nrmse, test_nrmse),
        (before[0], after[0]),
        (before[1], after[1]),
    )


def run(folder: Path, effect_files: Sequence[str], minutes: float, jobs: int) -> Iterator[Split]:
    """Judge the splits that begin within the time given, side by side; results come as they are ready."""
    end, threads = time.monotonic() + 60.0 * minutes, max(1, (os.cpu_count() or 1) // jobs)
    todo = (
        delayed(judge)(folder, train, test, effect_files, threads)
        for train, test in splits(heater.RUNS)
        if time.monotonic() < end
    )
    with parallel_config("loky", n_jobs=jobs, inner_max_num_threads=threads):
        yield from Parallel(return_as="generator_unordered", batch_size=1, pre_dispatch="n_jobs")(todo)


def report(done: Sequence[Split]) -> str:
    """How many splits named an effect, how many had each verdict, and all of them."""
    ordered = sorted(done, key=lambda s: (len(s.train), s.train))
    everything = len(splits(heater.RUNS))
    right = sum(set(s.added) == {MISSING} for s in done)
    wrong = sum(bool(set(s.added) - {MISSING}) for s in done)
    instead = sum(bool(s.instead) for s in done)
    good = [sum(s.nrmse[side] <= bar for s in done) for side, bar in enumerate(BARS)]
    verdicts = Counter(s.verdict for s in done)
    differs = Counter(key for s in done for key in s.varies)
    lines = [
        "# Splits of the heater runs",
        "",
        "Written by `make heater`: the six runs of the [measured heater](heater.md), split in every way into two or",
        "more for training and one or more held out. A lumped model is fitted to the training runs and diagnosed, the",
        "others held out. Of a held-out run only the ambient temperature is its own, from its first sample; whatever",
        "else differs has the value of all. Errors are RMS of the temperature in units of the sensor's noise, of the",
        "model refitted without what was found → with it.",
        "",
        f"**{right} of {len(done)} splits named {MISSING} and nothing else, {wrong} named another effect** (bar: none)"
        + (f"; {everything - len(done)} of {everything} were not run." if len(done) < everything else "."),
        f"**With {MISSING} taken out of the library, {instead} named an effect** (bar: none).",
        f"The NRMSE is at most {BARS[0]:.0%} in training in {_of(good[0], len(done))} splits, and at most",
        f"{BARS[1]:.0%} on those held out in {_of(good[1], len(done))} (bar: all). Found to differ:",
        f"{', '.join(f'{key} in {n}' for key, n in differs.most_common())}; the model has no other parameters.",
        "",
        "The splits share six runs, so they are not independent, and the rules of what differs from run to run were",
        "made with these runs at hand.",
        "",
        "| verdict | splits |",
        "|---|---|",
        *(f"| `{verdict}` | {count} |" for verdict, count in verdicts.most_common()),
        "",
        f"| training | held out | verdict | named | without {MISSING} | differs "
        "| training, × noise | held out, × noise | NRMSE |",
        "|---|---|---|---|---|---|---|---|---|",
        *map(_row, ordered),
        "",
    ]
    return "\n".join(lines)


def _row(split: Split) -> str:
    train, test = (", ".join(map(_short, names)) for names in (split.train, split.test))
    errors = (f"{before:.1f} → {after:.1f}" for before, after in (split.train_rms, split.test_rms))
    names = (", ".join(names) or "–" for names in (split.added, split.instead, split.varies))
    nrmse = " / ".join(f"{x:.1%}" for x in split.nrmse)
    return " | ".join((f"| {train}", test, f"`{split.verdict}`", *names, *errors, nrmse)) + " |"


def _of(count: int, size: int) -> str:
    """Bold where it is not all."""
    words = f"{count} of {size}"
    return words if count == size else f"**{words}**"


def _short(name: str) -> str:
    """sin_5_50_run_1 as sin_5/1."""
    wave, number = name.split("_50_run_")
    return f"{wave}/{number}"


def options() -> argparse.Namespace:
    """What the command line says."""
    parser = argparse.ArgumentParser(description="diagnosis on every split of the measured heater runs")
    parser.add_argument("--source", type=Path, default=heater.find(), help="folder of the measured runs")
    parser.add_argument("--effect", action="append", default=[], metavar="FILE.py", help="a candidate of your own")
    parser.add_argument("--minutes", type=float, default=30.0, help="stop beginning new splits after this time")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="splits at once")
    parser.add_argument("--out", type=Path, help="write the report, as docs/results/heater-splits.md")
    return parser.parse_args()


def main() -> int:
    """Judge every split; print and write the report."""
    args = options()
    if args.source is None:
        print("heater: skipped, the measured runs are not here (--source); docs/results/heater.md says where they are")
        return 0
    done: list[Split] = []
    with TemporaryDirectory() as name, tqdm(total=len(splits(heater.RUNS)), unit="split", dynamic_ncols=True) as bar:
        heater.convert_all(args.source, Path(name))
        for split in run(Path(name), args.effect, args.minutes, args.jobs):
            done.append(split)
            bar.set_description_str(", ".join(split.added) or split.verdict)
            bar.update()
    text = report(done)
    print(text)
    if args.out:
        args.out.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
