# SPDX-License-Identifier: Apache-2.0
"""`make interrupts`: Ctrl-C at random moments of the start, and no traceback.

    python validation/interrupts.py --count 100 --seed 1 --only "lce run"

Nodes, `lce run` and, where ros2 is installed, `ros2 launch` are started in turn and interrupted at a random moment of
their first seconds, all processes of the command at once as by a terminal. Each has to end within the patience, with a
status that says "stopped", and to print no traceback. Exit status 1 if one does not.
"""

import argparse
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import cycle
from pathlib import Path
from typing import Final

from tqdm import tqdm

from lce_experiment import registry
from lce_experiment.config import config_file
from lce_ros.domain import free_domain

PATIENCE_S: Final = 20.0
LOOK_S: Final = 0.02
STOPPED: Final = (0, 130, -signal.SIGINT)
"""Exit statuses of a command that was interrupted."""
WORDS: Final = ("Traceback (most recent call last)", "Exception ignored in", "Fatal Python error")
NODES: Final = (
    *registry.BENCH, registry.FEEDFORWARD, registry.INNER, registry.MODEL, registry.RECORDER, registry.PLAYER
)  # fmt: skip


@dataclass(frozen=True)
class Case:
    """A command that is interrupted within its first ``within_s`` [s].

    Parameters
    ----------
    name, command : of it.
    within_s : counted from its start, or from the moment when it has printed ``once``.
    once : a text.
    cold : whether it finds no compiled kernels.
    fails : whether it would fail without the interrupt; then status 1 is well, too.
    """

    name: str
    command: Sequence[str]
    within_s: float = 4.0
    once: str = ""
    cold: bool = False
    fails: bool = False


@dataclass(frozen=True)
class Interrupt:
    """What came of one: its moment [s], the time until the end [s] (None: killed), the status and what was printed."""

    case: Case
    at_s: float
    took_s: float | None
    status: int
    printed: str

    @property
    def problem(self) -> str:
        """What is wrong; empty if nothing is."""
        if self.took_s is None:
            return f"still there after {PATIENCE_S:g} s"
        if any(word in self.printed for word in WORDS):
            return "a traceback"
        well = self.status in STOPPED or (self.case.fails and self.status == 1)
        return "" if well else f"status {self.status}"


@dataclass
class Tally:
    """All interrupts of one case."""

    problems: list[Interrupt] = field(default_factory=list)
    took_s: list[float] = field(default_factory=list)

    def take(self, interrupt: Interrupt) -> None:
        """Count one more."""
        if interrupt.took_s is not None:
            self.took_s.append(interrupt.took_s)
        if interrupt.problem:
            self.problems.append(interrupt)


def all_cases() -> list[Case]:
    """The nodes one by one, a node that compiles, and everything that starts many of them."""
    files = [word for name in ("bench", "simulated") for word in ("--params-file", str(config_file(f"{name}.yaml")))]
    ros = ["--ros-args", "-r", f"__ns:={registry.NAMESPACE}", *files, "-p"]
    nodes = {spec.name: [*spec.command, *ros, "protocol:=pulse"] for spec in NODES}
    cases = [Case(name, command) for name, command in nodes.items()]
    cases.append(Case("simulator, compiling", nodes[registry.SIMULATOR.name], 12.0, cold=True))
    lce = [sys.executable, "-m", "lce_app.cli.main", "run", "pulse:amp=0.4,th=20"]
    cases += [Case("lce run", lce, 8.0), Case("lce run --fast", [*lce, "--fast"], 8.0)]
    cases.append(Case("lce run --fast, compiling", [*lce, "--fast"], 16.0, cold=True))
    if shutil.which("ros2"):
        launch = ["ros2", "launch", "lce_bringup", "experiment.launch.py"]
        ours = "[experiment_player-6]: process started"  # before that, it is ros2 that starts
        cases.append(Case("ros2 launch", launch, 6.0, ours))
        cases.append(Case("ros2 launch, bad protocol", [*launch, "protocol:=no"], 6.0, ours, fails=True))
    return cases


def interrupt(case: Case, at_s: float, domain: int) -> Interrupt:
    """Start a command in a ROS domain and a folder of its own, and interrupt it after ``at_s`` [s]."""
    with tempfile.TemporaryDirectory(prefix="lce_interrupts_") as folder, (Path(folder) / "printed").open("w+") as out:
        environment = os.environ | {"ROS_DOMAIN_ID": str(domain), "ROS_LOG_DIR": folder}
        if case.cold:
            environment["LCE_CACHE_DIR"] = folder
        process = subprocess.Popen(
            case.command, cwd=folder, env=environment, stdout=out, stderr=out, start_new_session=True
        )
        with _ended(process):
            while case.once not in Path(out.name).read_text(encoding="utf-8") and process.poll() is None:
                time.sleep(LOOK_S)
            try:
                process.wait(at_s)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGINT)
            began = time.monotonic()
            try:
                process.wait(PATIENCE_S)
                took_s: float | None = time.monotonic() - began
            except subprocess.TimeoutExpired:
                took_s = None
        out.seek(0)
        return Interrupt(case, at_s, took_s, process.returncode, out.read())


@contextmanager
def _ended(process: "subprocess.Popen[bytes]") -> Iterator[None]:
    try:
        yield
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def interrupts(
    cases: Sequence[Case], count: int, seed: int, seen: Callable[[Interrupt], object] = lambda one: None
) -> Mapping[str, Tally]:
    """``count`` interrupts of the cases in turn, at moments that ``seed`` draws; ``seen`` is called with each."""
    moments = random.Random(seed)
    tallies: dict[str, Tally] = defaultdict(Tally)
    with free_domain() as domain:
        for case, _ in zip(cycle(cases), range(count), strict=False):
            one = interrupt(case, moments.uniform(0.0, case.within_s), domain)
            tallies[case.name].take(one)
            seen(one)
    return tallies


def main(argv: Sequence[str] | None = None) -> int:
    """Interrupt, and print what came of it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=100, help="interrupts in all, default 100")
    parser.add_argument("--seed", type=int, default=1, help="of the moments")
    parser.add_argument("--only", default="", help="cases whose name begins so")
    args = parser.parse_args(argv)
    cases = [case for case in all_cases() if case.name.startswith(args.only)]
    if not cases:
        parser.error(f"--only {args.only!r}: no such case")
    with tqdm(total=args.count, unit="interrupt") as bar:
        tallies = interrupts(cases, args.count, args.seed, lambda _: bar.update())
    bad = [one for tally in tallies.values() for one in tally.problems]
    for one in bad:
        print(f"--- {one.case.name} after {one.at_s:.3f} s: {one.problem}\n{one.printed}")
    for name, tally in tallies.items():
        last = f"ended within {max(tally.took_s):.1f} s" if tally.took_s else "never ended"
        print(f"{name}: {len(tally.took_s)} interrupts, {last}, {len(tally.problems)} with a problem")
    print(f"{args.count} interrupts, {len(bad)} with a problem")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
