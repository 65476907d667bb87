# SPDX-License-Identifier: Apache-2.0
"""`make fuzz`: thousands of damaged and hostile files, and what `lce` and its page say of each.

    python validation/fuzz.py --cases 2000 --minutes 60 --out docs/results/fuzz.md

Each case changes one file of a good set and gives it to a command, in a process that runs one case after the other and
is replaced when it hangs or dies. A case fails by a traceback, by more than 10 s of computation (of a fit: 60 s) or
120 s in all, by an exit status that is neither 0 nor 1, and by a status 1 without exactly one line on stderr that says
why. Warnings beside it may be many.
The same seed makes the same cases; `--case "MCAP:17"` runs one of them again, and shows what it printed.
"""

import argparse
import multiprocessing
import os
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from random import Random
from shutil import copytree, rmtree
from typing import Final

from fuzz_files import write_good_files
from fuzz_worker import LIMIT_S, PAGE, Answer, answer_for_ever
from mutations import Mutation, in_mcap, in_program, in_text
from tqdm import tqdm

from lce_data.errors import LceError
from lce_data.files import write_atomically

PATIENCE_S: Final = 120.0
"""Time [s] after which a process that waits for something is ended; one that computes may take `LIMIT_S` of it."""
START_S: Final = 180.0
"""Time [s] that the process may take until it is ready: it imports everything and compiles the model."""
COMPARE, FIT = "compare @{} --model @m.yaml", "fit @{} --out @made.yaml"
SIMULATE: Final = "simulate --model @m.yaml --input {} --out @made.csv"


@dataclass(frozen=True)
class Kind:
    """The file of a case that is changed, how, one of these commands, then another; and its share of all cases.

    A word ``@name`` of a command is a file of the case.
    """

    file: str
    mutation: Mutation
    commands: tuple[str, ...]
    then: str = ""
    share: int = 1


BAG: Final = "bag/recording.mcap"
KINDS: Final = {
    "MCAP": Kind(
        BAG,
        in_mcap,
        (COMPARE.format("bag"), COMPARE.format(BAG), FIT.format("bag"), "import @bag --out @made"),
        share=5,
    ),
    "compressed MCAP": Kind(
        "compressed.mcap", in_mcap, (COMPARE.format("compressed.mcap"), FIT.format("compressed.mcap")), share=2
    ),
    "repaired bag": Kind(BAG, in_mcap, ("repair @bag", f"repair @{BAG}"), then=COMPARE.format("bag"), share=3),
    "bag metadata": Kind("bag/metadata.yaml", in_text, (COMPARE.format("bag"), "repair @bag"), share=1),
    "experiment.yaml": Kind("bag/experiment.yaml", in_text, (COMPARE.format("bag"), PAGE), share=2),
    "conditions of a CSV": Kind("run.yaml", in_text, (COMPARE.format("run.csv"), PAGE), share=1),
    "CSV": Kind(
        "run.csv",
        in_text,
        (COMPARE.format("run.csv"), FIT.format("run.csv"), "import @run.csv --out @made", PAGE),
        share=3,
    ),
    "model file": Kind("m.yaml", in_text, (SIMULATE.format("pulse:th=5"), COMPARE.format("run.csv")), share=3),
    "waveform": Kind("wave.csv", in_text, (SIMULATE.format("@wave.csv"),), share=1),
    "effect file": Kind("late.py", in_program, ("effects @late.py",), share=1),
    "session of the page": Kind("workbench/session.yaml", in_text, (PAGE,), share=1),
    "model of the page": Kind("workbench/model-2.yaml", in_text, (PAGE,), share=1),
    "record of the page": Kind("workbench/wave-1.json", in_text, (PAGE,), share=1),
}


@dataclass(frozen=True)
class Case:
    """A case by its kind and seed; ``fault`` is what is wrong with the answer to it, "" if nothing is."""

    kind: str
    seed: int
    answer: Answer

    @property
    def fault(self) -> str:
        """What is wrong with the answer."""
        return self.answer.fault


class Worker:
    """The process that runs the commands; a new one takes its place when it has hung or died."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._process, self._connection = self._started()

    def _started(self) -> tuple[BaseProcess, Connection]:
        spawn = multiprocessing.get_context("spawn")
        ours, theirs = spawn.Pipe()
        process = spawn.Process(target=answer_for_ever, args=(theirs, self._folder), daemon=True)
        process.start()
        theirs.close()
        assert ours.poll(START_S), "the process that runs the commands did not start"
        assert ours.recv() == "ready"
        return process, ours

    def ask(self, commands: Sequence[Sequence[str]]) -> Answer:
        """Give the commands, and wait for the answer to the last one."""
        self._connection.send([list(words) for words in commands])
        try:
            if self._connection.poll(PATIENCE_S):
                answer: Answer = self._connection.recv()
                return answer
            fault = f"no answer within {PATIENCE_S:g} s"
        except EOFError:
            self._process.join()
            fault = f"the process died ({self._process.exitcode})"
        self.close()
        self._process, self._connection = self._started()
        return Answer(None, fault)

    def close(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.join()


def planned(cases: int, seed: int) -> Iterator[tuple[str, int]]:
    """Kind and seed of each case, the kinds mixed by their shares."""
    turns = [name for name, kind in KINDS.items() for _ in range(kind.share)]
    Random(seed).shuffle(turns)
    for i in range(cases):
        yield turns[i % len(turns)], seed + i


def commands_of(kind: Kind, folder: Path, rng: Random) -> list[list[str]]:
    """Change the file of a case in its folder; the commands that are given of it."""
    file = folder / kind.file
    file.write_bytes(kind.mutation(file.read_bytes(), rng))
    return [_typed(line, folder) for line in (rng.choice(kind.commands), kind.then) if line]


def _typed(line: str, folder: Path) -> list[str]:
    return [str(folder / word[1:]) if word.startswith("@") else word for word in line.split()]


def check_good_files(worker: Worker, good: Path, made: Path) -> None:
    """Raise AssertionError if a command refuses the files as they are: then their changes would prove nothing."""
    for line in {line for kind in KINDS.values() for line in (*kind.commands, kind.then) if line}:
        copytree(good, made)
        answer = worker.ask([_typed(line, made)])
        assert answer.status == 0, (line, answer)
        rmtree(made)


def run(cases: Sequence[tuple[str, int]], minutes: float) -> Iterator[Case]:
    """Run cases until the time is up."""
    end = time.monotonic() + 60.0 * minutes
    with tempfile.TemporaryDirectory(prefix="lce_fuzz_") as made:
        good = Path(made) / "good"
        good.mkdir()
        os.environ |= {"LCE_CACHE_DIR": f"{made}/cache", "XDG_CONFIG_HOME": f"{made}/config"}
        write_good_files(good)
        worker = Worker(good)
        try:
            check_good_files(worker, good, Path(made) / "copy")
            for name, seed in cases:
                if time.monotonic() > end:
                    return
                place = Path(made) / f"{seed}"
                copytree(good, place)
                yield Case(name, seed, worker.ask(commands_of(KINDS[name], place, Random(f"{name}:{seed}"))))
                rmtree(place)
        finally:
            worker.close()


def page(found: Sequence[Case], seed: int, seconds: float) -> str:
    """The counts by kind, and the faults, as a page of docs."""
    lines = [
        "# Damaged and hostile files",
        "",
        f"Written by `make fuzz`: {len(found)} cases from seed {seed} in {seconds / 60.0:.0f} minutes. Each changes "
        "one file of a good set at random and gives it to a command or to the page "
        "([fuzz.py](../../validation/fuzz.py)).",
        "",
        "| file | cases | used | refused in one line | faults |",
        "|---|---|---|---|---|",
    ]
    for name in KINDS:
        of_kind = [case for case in found if case.kind == name]
        faults = sum(bool(case.fault) for case in of_kind)
        used = sum(case.answer.status == 0 and not case.fault for case in of_kind)
        lines.append(f"| {name} | {len(of_kind)} | {used} | {len(of_kind) - used - faults} | {faults} |")
    faults = sum(bool(case.fault) for case in found)
    lines += [
        "",
        f"{faults} faults: tracebacks, more than {LIMIT_S:g} s of computation (of a fit: 60 s), wrong exit "
        "codes, several lines or none.",
    ]
    return "\n".join([*lines, ""])


def main() -> int:
    """Run the cases, print the faults, write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=2000)
    parser.add_argument("--minutes", type=float, default=60.0, help="ends earlier if this time is up")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, help="page of docs to write")
    parser.add_argument("--case", metavar="KIND:SEED", help="one case again, and all that it said")
    args = parser.parse_args()
    if args.case:
        name, _, seed = args.case.rpartition(":")
        (case,) = run([(name, int(seed))], args.minutes)
        print(case.answer.said, case.answer.traceback, f"status {case.answer.status}", sep="\n")
        return int(bool(case.fault))
    began = time.monotonic()
    found: list[Case] = []
    with tqdm(total=args.cases, unit="case", file=sys.stderr) as bar:
        for case in run(list(planned(args.cases, args.seed)), args.minutes):
            found.append(case)
            bar.update()
            if case.fault:
                bar.write(f"{case.kind}:{case.seed}: {case.fault}")
    kinds = Counter(case.kind for case in found if case.fault)
    print(f"{len(found)} cases, {kinds.total()} faults", *(f"{n} {name}" for name, n in kinds.items()), sep="; ")
    if args.out:
        try:
            write_atomically(args.out, page(found, args.seed, time.monotonic() - began))
        except LceError as error:
            print(error, file=sys.stderr)
            return 1
    return int(bool(kinds))


if __name__ == "__main__":
    sys.exit(main())
