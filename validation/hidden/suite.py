# SPDX-License-Identifier: Apache-2.0
"""`make hidden`: does the diagnosis find what a strip hides, and does it keep quiet where nothing is hidden?

    python validation/hidden/suite.py --minutes 30 --families relays --only radiation

A finished case is a line of --results, so a suite that was stopped goes on where it was; results of another version of
the software are refused. Cases go to the cores of this machine, or to a Dask cluster whose workers have this repository
at the same path; a task is a case, a few words and numbers, and the worker makes the runs itself.
"""

import argparse
import importlib
import json
import os
import subprocess
import sys
import time
import zlib
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, ExitStack
from pathlib import Path
from typing import Any

from joblib import Parallel, delayed, parallel_config
from tqdm import tqdm

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parent))

from campaign import CAMPAIGNS, Case
from cases import cases
from families import ALL, FAMILIES
from peer import RESULTS as PEER_RESULTS
from peer import read_results
from report import report

FOLDER = Path(__file__).resolve().parent
RESULTS = FOLDER.parents[1] / "docs/results/hidden-results.jsonl"
Result = dict[str, Any]
JUDGED = (
    "src/lce_analysis/lce_analysis",
    "src/lce_model/lce_model",
    "src/lce_data/lce_data",
    "validation/hidden",
    "validation/independent_strip",
    ":!validation/hidden/peer*.py",
    ":!validation/hidden/suite.py",
    ":!validation/hidden/report.py",
    ":!validation/hidden/discovery_report.py",
    ":!*.jsonl",
)
"""What a case runs: changes elsewhere, as in the command line, do not make the results another version's."""


def task(folder: str, words: tuple[Any, ...], threads: int, judge: str = "judge") -> Result:
    """Judge one case by a module of this folder, in a worker process, which may be on another machine."""
    for path in (str(Path(folder).parent), folder):
        if path not in sys.path:
            sys.path.insert(0, path)
    from campaign import Case

    from lce_analysis.identification import problem

    # The product takes all cores for one fit; cases side by side would fight for them.
    problem._POOL = ThreadPoolExecutor(threads)
    result: Result = importlib.import_module(judge).judge(Case(*words))
    return result


def version() -> str:
    """The software that is judged: the last commit that touched it, and a checksum of what is not committed."""
    if not (FOLDER.parents[1] / ".git").exists():
        return "unknown"

    def git(*words: str) -> str:
        return subprocess.run(["git", *words], cwd=FOLDER.parents[1], capture_output=True, text=True, check=True).stdout

    commit = git("log", "-1", "--format=%H", "--", *JUDGED).strip()
    changed = git("diff", "HEAD", "--", *JUDGED)
    name = git("describe", "--always", "--tags", commit).strip()
    for path in git("ls-files", "--others", "--exclude-standard", "--", *JUDGED).split():
        changed += path + (FOLDER.parents[1] / path).read_text(encoding="utf-8", errors="replace")
    return f"{name}+{zlib.crc32(changed.encode()):08x}" if changed else name


def read(path: Path, now: str) -> list[Result]:
    """The results in a file of this version; SystemExit if it is another's. A line that was cut off is left out."""
    if not path.exists() or not path.read_text(encoding="utf-8"):
        path.write_text(json.dumps({"version": now}) + "\n", encoding="utf-8")
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    if lines and not lines[-1].endswith("\n"):
        lines.pop()
        path.write_text("".join(lines), encoding="utf-8")
    head = json.loads(lines[0]) if lines else {}
    if head.get("version") != now:
        raise SystemExit(
            f"{path} is of version {head.get('version', 'unknown')}, the software is {now}: --fresh begins anew, "
            "--results FILE writes elsewhere"
        )
    return [found for line in lines[1:] if "case" in (found := json.loads(line))]


def ran(path: Path) -> str:
    """The arguments of all the commands that have judged cases of this file."""
    lines = (json.loads(line) for line in path.read_text(encoding="utf-8").splitlines())
    return ", then ".join(dict.fromkeys(f"`{line['ran']}`" for line in lines if "ran" in line))


def until(end: float, todo: Sequence[Case]) -> Iterator[Case]:
    """The cases that begin before a time."""
    for case in todo:
        if time.monotonic() >= end:
            return
        yield case


def where(scheduler: str | None, jobs: int, threads: int) -> AbstractContextManager[Any]:
    """The cores of this machine, or the cluster."""
    block = ExitStack()
    if scheduler:
        from distributed import Client

        block.enter_context(Client(scheduler, timeout="10s"))
        block.enter_context(parallel_config("dask", n_jobs=-1))
    else:
        block.enter_context(parallel_config("loky", n_jobs=jobs, inner_max_num_threads=threads))
    return block


def run(
    todo: Sequence[Case], minutes: float, scheduler: str | None, jobs: int, judge: str = "judge"
) -> Iterator[Result]:
    """Judge cases side by side by a module of this folder; results come as they are ready."""
    begun = until(time.monotonic() + 60.0 * minutes, todo)
    threads = 1 if scheduler else max(1, (os.cpu_count() or 1) // jobs)
    with where(scheduler, jobs, threads):
        work = Parallel(return_as="generator_unordered", batch_size=1, pre_dispatch="n_jobs")
        yield from work(delayed(task)(str(FOLDER), _words(case), threads, judge) for case in begun)


def _words(case: Case) -> tuple[Any, ...]:
    return case.family, case.hidden, case.level, case.seed, case.library, case.campaign


def options(
    description: str = "diagnosis on strips with hidden effects",
    results: Path = RESULTS,
    seeds: int = 1,
    families: Iterable[str] = FAMILIES,
) -> argparse.Namespace:
    """What the command line says; ``families`` are those that it may name."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--seeds", type=int, default=seeds, help="strips of each kind of case")
    parser.add_argument("--first-seed", type=int, default=0, help="0 to 4, 7, 9 and 10 were used to mend the product")
    parser.add_argument("--minutes", type=float, default=150.0, help="stop beginning new cases after this time")
    parser.add_argument("--skip", type=int, default=0, help="begin behind so many cases of the order, known already")
    parser.add_argument("--only", default="", help="cases whose name holds this text")
    parser.add_argument("--families", nargs="+", default=[], choices=list(families), metavar="FAMILY")
    parser.add_argument("--campaign", default="full", choices=list(CAMPAIGNS), help="runs of each strip")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="cases at once on this machine")
    parser.add_argument("--scheduler", default=os.environ.get("DASK_SCHEDULER_ADDRESS"), help="of a Dask cluster")
    parser.add_argument("--results", type=Path, default=results)
    parser.add_argument(
        "--peer", type=Path, default=PEER_RESULTS, help="results of validation/hidden/peer.py, for its table"
    )
    parser.add_argument("--fresh", action="store_true", help="forget the results there are")
    parser.add_argument("--out", type=Path, help="write the report, as docs/results/hidden.md")
    return parser.parse_args()


def arguments(args: argparse.Namespace) -> str:
    """What decided which cases were judged, as the command line says it."""
    words = [f"--seeds {args.seeds}"]
    words += [f"--first-seed {args.first_seed}"] if args.first_seed else []
    words += [f"--skip {args.skip}"] if args.skip else []
    words += [f"--families {' '.join(args.families)}"] if args.families else []
    words += [f"--only {args.only}"] if args.only else []
    words += [f"--campaign {args.campaign}"] if args.campaign != "full" else []
    return " ".join(words)


def judge_all(chosen: Sequence[Case], done: list[Result], args: argparse.Namespace, judge: str = "judge") -> int:
    """Judge the cases that are not done yet, within the time given, and append them to ``done``; the exit status."""
    known = {r["case"] for r in done}
    todo = [c for c in [*chosen[args.skip :], *chosen[: args.skip]] if c.name not in known]
    with (
        tqdm(total=len(chosen), initial=len(chosen) - len(todo), unit="case", dynamic_ncols=True) as bar,
        args.results.open("a", encoding="utf-8") as log,
    ):
        if todo and args.minutes > 0.0:
            log.write(json.dumps({"ran": arguments(args)}) + "\n")
        try:
            for result in run(todo, args.minutes, args.scheduler, args.jobs, judge):
                done.append(result)
                log.write(json.dumps(result) + "\n")
                log.flush()
                bar.set_description_str(result["case"])
                bar.update()
        except KeyboardInterrupt:
            return 130
    return 0


def main() -> int:
    """Run what is not done yet, within the time given; print and write the report."""
    args = options(families=ALL)
    now = version()
    if args.fresh:
        args.results.unlink(missing_ok=True)
    done = read(args.results, now)
    chosen = [c for c in cases(args.seeds, args.families, args.campaign, args.first_seed) if args.only in c.name]
    status = judge_all(chosen, done, args)
    names = {c.name for c in chosen}
    judged, peer = ([r for r in results if r["case"] in names] for results in (done, read_results(args.peer)))
    text = report(judged, now, ran(args.results), peer)
    print(text)
    if args.out and status == 0:
        args.out.write_text(text, encoding="utf-8")
    return status


if __name__ == "__main__":
    sys.exit(main())
