# SPDX-License-Identifier: Apache-2.0
"""`make days`: is it found what differs from day to day in a campaign of ten runs, and nothing else named?

    python validation/days.py --seeds 2 --minutes 20

Ten runs of one strip of the family "equilibrium" (`validation/hidden`), made without any code of the product. From run
to run the ambient temperature, the laser's gain, both, the load, or nothing differs; the model equilibrium is fitted
to all of them and diagnosed. Each run says its load in its conditions; a load raises the temperature of the transition.
Where nothing differs, nothing may be named. The strips follow the very equations of that model: other bases are for
`make hidden`.
"""

import argparse
import os
import sys
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from joblib import Parallel, delayed, parallel_config
from tqdm import tqdm

sys.path.insert(0, str(Path(__file__).resolve().parent / "hidden"))

from campaign import waves
from equilibrium import GRID_K, Equilibrium
from families import FAMILIES, Strip
from stages import Body, Floats

from lce_analysis.diagnosis import diagnose
from lce_analysis.identification import fit, problem
from lce_data.experiment_file import Conditions, Experiment
from lce_data.run import Run, Series
from lce_model import default_model

RUNS = ("pulse-16", "pulse-22", "pulse-28", "stairs", "holds")
"""Each is made twice, on two days."""
DIFFERS = ("nothing", "ambient", "gain", "ambient and gain", "load")
EXPECTED = {
    "nothing": ((), ()),
    "ambient": (("ambient.t_env",), ()),
    "gain": (("lumped.gain",), ()),
    "ambient and gain": (("ambient.t_env", "lumped.gain"), ()),
    "load": ((), ("load_shift",)),
}
"""What must be named: parameters that differ from run to run, and effects."""


@dataclass(frozen=True)
class Day:
    """What one run has of its own: ambient [K] and gain relative to the strip's, load [N]."""

    ambient_k: float = 0.0
    gain: float = 1.0
    load_n: float = 0.0


@dataclass(frozen=True)
class Judged:
    """What was said of one campaign.

    varies : parameters found to differ; added : effects named; rms : errors left, × noise; seconds : of the diagnosis.
    """

    differs: str
    seed: int
    verdict: str
    varies: tuple[str, ...]
    added: tuple[str, ...]
    rms: tuple[float, ...]
    seconds: float

    @property
    def found(self) -> bool:
        """Is all named that differs?"""
        varies, effects = EXPECTED[self.differs]
        return set(varies) <= set(self.varies) and set(effects) <= set(self.added)

    @property
    def more(self) -> tuple[str, ...]:
        """What was named that does not differ, and is not missing."""
        varies, effects = EXPECTED[self.differs]
        return tuple(sorted({*self.varies, *self.added} - {*varies, *effects}))


def days(differs: str, rng: np.random.Generator, count: int) -> list[Day]:
    """What each run has of its own: ambient ± 2 K, gain ± 8 %, load 0–50 mN."""
    ambient = rng.normal(0.0, 2.0, count) * ("ambient" in differs)
    gain = np.exp(rng.normal(0.0, 0.08, count) * ("gain" in differs))
    load = rng.uniform(0.0, 0.05, count) * (differs == "load")
    return [Day(*map(float, day)) for day in zip(ambient, gain, load, strict=True)]


@dataclass(frozen=True)
class OnDay:
    """A strip on one day. Its length is that of the strip as mounted, on the day of the strip's own ambient."""

    core: Equilibrium
    mounted: Equilibrium

    @property
    def body(self) -> Body:
        """With the ambient temperature and the gain of the day."""
        return self.core.body

    def run(self, light_w: Floats, gusts: Floats, hidden: dict[str, float]) -> tuple[Floats, Floats]:
        """Temperature [K] and stretch at each power sample."""
        temperature, stretch = self.core.run(light_w, gusts, hidden)
        ratio = (1.0 + self.body.alpha * _cold(self.core)) / (1.0 + self.body.alpha * _cold(self.mounted))
        return temperature, stretch * ratio ** (1.0 / 3.0)


def _cold(core: Equilibrium) -> float:
    """Order at the ambient temperature."""
    share, well = (float(np.interp(core.body.ambient, GRID_K, values)) for values in core.branches[0])
    return share * well


def on(day: Day, strip: Strip) -> Strip:
    """The strip on that day. 50 K/N: a load of 50 mN raises T* by 2.5 K."""
    core = strip.core
    assert isinstance(core, Equilibrium)
    body = core.body._replace(ambient=core.body.ambient + day.ambient_k, gain=core.body.gain * day.gain)
    colder = GRID_K - 50.0 * day.load_n
    branches = np.array([[np.interp(colder, GRID_K, values) for values in branch] for branch in core.branches])
    return Strip(OnDay(core._replace(body=body, branches=np.ascontiguousarray(branches)), core), strip.noise)


def campaign(differs: str, seed: int) -> list[Run]:
    """Ten runs of one strip."""
    rng = np.random.default_rng([seed, *differs.encode()])
    strip = FAMILIES["equilibrium"].random(rng)
    powers = waves(strip.body.top_w)
    runs = []
    for number, day in enumerate(days(differs, rng, 2 * len(RUNS))):
        wave = RUNS[number % len(RUNS)]
        power = powers[wave]
        camera, distance = on(day, strip).measure(power, {}, rng)
        time_s = np.arange(power.size) / 100.0
        name = f"{wave}, day {1 + number // len(RUNS)}"
        run = Run.of(name, Series(time_s, power), Series(time_s[::10], camera), Series(time_s, distance), sha256=name)
        if differs == "load":
            run = replace(run, experiment=Experiment(conditions=Conditions(load_n=day.load_n)))
        runs.append(run)
    return runs


def judge(differs: str, seed: int, threads: int) -> Judged:
    """Fit and diagnose one campaign in a worker process."""
    # The product takes all cores for one fit; campaigns side by side would fight for them.
    problem._POOL = ThreadPoolExecutor(threads)
    runs = campaign(differs, seed)
    found = diagnose(fit(default_model("lumped", "equilibrium"), runs).model, runs)
    return Judged(
        differs,
        seed,
        found.verdict,
        tuple(found.model.varies),
        tuple(step.added for step in found.steps),
        tuple(found.train.misfit["after"].rms.values()),
        found.seconds,
    )


def run(seeds: int, minutes: float, jobs: int) -> Iterator[Judged]:
    """Judge the campaigns that begin within the time given; results come as they are ready."""
    end, threads = time.monotonic() + 60.0 * minutes, max(1, (os.cpu_count() or 1) // jobs)
    todo = (
        delayed(judge)(differs, seed, threads) for seed in range(seeds) for differs in DIFFERS if time.monotonic() < end
    )
    with parallel_config("loky", n_jobs=jobs, inner_max_num_threads=threads):
        yield from Parallel(return_as="generator_unordered", batch_size=1, pre_dispatch="n_jobs")(todo)


def report(done: Sequence[Judged], planned: int) -> str:
    """How often what differs was named, how often more, and every campaign."""
    differing = [d for d in done if d.differs != "nothing"]
    named, more = sum(d.found for d in differing), sum(bool(d.more) for d in done)
    left = f"; {planned - len(done)} of {planned} were not run." if len(done) < planned else "."
    lines = [
        "# Campaigns of ten runs",
        "",
        "Written by `make days`: ten runs of one strip, five waveforms twice each, made without the product's",
        "code (`validation/days.py`). What differs from run to run is drawn anew for each run: the ambient temperature",
        "(± 2 K), the gain of the laser (± 8 %), or the load (0 to 50 mN, 50 K/N, recorded in the conditions). The",
        "model equilibrium is fitted to all runs and diagnosed, without a run held out.",
        "",
        f"**What differs was named in {named} of {len(differing)} campaigns (bar: 90 %); something else was named in "
        f"{more} of {len(done)}** (bar: none){left}",
        "",
        "| differs | seed | found to differ | effects named | else | left, × noise (T, d) | diagnosis, s |",
        "|---|---|---|---|---|---|---|",
        *map(_row, sorted(done, key=lambda d: (DIFFERS.index(d.differs), d.seed))),
        "",
    ]
    return "\n".join(lines)


def _row(d: Judged) -> str:
    left = ", ".join(f"{x:.2f}" for x in d.rms)
    names = (", ".join(names) or "–" for names in (d.varies, d.added, d.more))
    return " | ".join((f"| {d.differs}", str(d.seed), *names, left, f"{d.seconds:.0f} |"))


def options() -> argparse.Namespace:
    """What the command line says."""
    parser = argparse.ArgumentParser(description="diagnosis of campaigns whose runs differ from day to day")
    parser.add_argument("--seeds", type=int, default=4, help="campaigns of each kind")
    parser.add_argument("--minutes", type=float, default=60.0, help="stop beginning new campaigns after this time")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="campaigns at once")
    parser.add_argument("--out", type=Path, help="write the report, as docs/results/days.md")
    return parser.parse_args()


def main() -> int:
    """Judge every campaign; print and write the report."""
    args = options()
    done, planned = [], args.seeds * len(DIFFERS)
    with tqdm(total=planned, unit="campaign", dynamic_ncols=True) as bar:
        for judged in run(args.seeds, args.minutes, args.jobs):
            done.append(judged)
            bar.set_description_str(judged.differs)
            bar.update()
    text = report(done, planned)
    print(text)
    if args.out:
        args.out.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
