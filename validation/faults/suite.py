# SPDX-License-Identifier: Apache-2.0
"""`make faults`: every fault, many times, on a bench of real processes with an emulated LabJack.

    python validation/faults/suite.py --repetitions 20 --only camera

A fault that was struck so often is a line of --results, so a suite that was stopped goes on where it was. Each line
tells the version of the software; with --again a fault is struck anew, and its last line counts.

Each time: reset and arm, half a second of light, the fault, the time until there is no voltage any more, the cause
taken away, and some seconds in which light must not come back by itself. Time in which the whole machine stood still is
taken off: no software on it can do anything then.
"""

import argparse
import json
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Final, get_args

from tqdm import tqdm

sys.path.insert(0, str(Path(__file__).resolve().parent))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "src" / "lce_drivers" / "test"))

from bench import Bench
from catalogue import FAULTS, Fault, Where

from lce_data.errors import LceError
from lce_experiment import registry
from lce_ros.testing import Graph, open_graph

WATCHED_S: Final = 1.0
"""After the cause has gone; longer than any pause that is not yet a fault."""
BACK_S: Final = 2.0
"""More, until a node that was killed has started and found the others."""
LOOP: Final = (*registry.BENCH[1:], *registry.CONTROLLERS["double"])


@dataclass
class Outcome:
    """What was seen of one fault.

    name, limit_s : of the fault.
    version : of the software.
    dark_s : time until there was no light [s], of each repetition.
    returned : repetitions in which light came back before anybody reset and armed.
    tracebacks : exceptions told by the nodes.
    lost : messages that the recording of all repetitions lacks; None if it cannot be read.
    failed : what ended the repetitions early, "" if nothing did.
    """

    name: str
    limit_s: float
    version: str
    dark_s: list[float] = field(default_factory=list)
    returned: int = 0
    tracebacks: int = 0
    lost: int | None = None
    failed: str = ""

    @property
    def held(self) -> bool:
        """Whether every promise was kept."""
        late = any(dark_s > self.limit_s for dark_s in self.dark_s)
        return not (late or self.returned or self.tracebacks or self.failed) and self.lost is not None


def once(bench: Bench, fault: Fault) -> tuple[float, bool]:
    """Time until there was no light [s], and whether it came back."""
    bench.mend()
    bench.lit()
    stood_s, began_s = bench.machine.stood_s, time.monotonic()
    cure = fault.strike(bench)
    bench.graph.spin_for(fault.limit_s + 0.7)
    dark_s = max(0.0, bench.light.lit_s - began_s - (bench.machine.stood_s - stood_s))
    if cure is not None:
        cure()
    started = bench.mend()
    cured_s = time.monotonic()
    bench.graph.spin_for(WATCHED_S + (BACK_S if started else 0.0))
    return dark_s, bench.light.lit_s > cured_s


def repeated(graph: Graph, fault: Fault, repetitions: int, bar: "tqdm[None]") -> Outcome:
    """One fault, so many times, on a bench of its own."""
    outcome = Outcome(fault.name, fault.limit_s, version())
    bench = Bench(graph, LOOP if fault.where == "loop" else (), fault.where == "by hand")
    try:
        for _ in range(repetitions):
            dark_s, returned = once(bench, fault)
            outcome.dark_s.append(dark_s)
            outcome.returned += returned
            bar.set_description_str(f"{fault.name}: {max(outcome.dark_s) * 1e3:.0f} ms")
            bar.update()
    except AssertionError as error:
        outcome.failed = str(error)
    finally:
        bench.close()
    outcome.tracebacks = bench.tracebacks()
    try:
        outcome.lost = bench.lost()
    except LceError as error:
        outcome.failed = outcome.failed or str(error)
    return outcome


def version() -> str:
    """The software that was judged: the last commit that touched it, and whether something is not committed."""
    root = Path(__file__).resolve().parents[2]

    def git(*words: str) -> str:
        said = subprocess.run(
            ["git", *words, "--", "src", "validation/faults"], cwd=root, capture_output=True, text=True
        )
        return said.stdout.strip()

    return f"{git('log', '-1', '--format=%h') or 'unknown'}{'-changed' if git('status', '--porcelain') else ''}"


def read(path: Path) -> dict[str, Outcome]:
    """The outcomes in a file by the name of the fault, the last of each."""
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    return {outcome.name: outcome for outcome in (Outcome(**json.loads(line)) for line in lines)}


def report(outcomes: Sequence[Outcome], command: str) -> str:
    """The table, as docs/results/faults.md."""
    lines = [
        "# Faults",
        "",
        f"Written by `{command}`.",
        "A bench of real processes on an emulated LabJack: the light is the voltage of its output, watchdog included.",
        "Each time the laser is reset and armed and shines for half a second; then comes the fault; then its cause",
        "goes away, what was killed is started again, and for some seconds light must not come back. Time in which the",
        "whole machine stood still is taken off. A recorder runs beside it; what its recording lacks is counted. What",
        "is promised, and why, is in [safety.md](../explanation/safety.md).",
        "",
        "| fault | times | median time to dark | worst | promised | light came back | exceptions | lost | version | |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for o in outcomes:
        times = sorted(o.dark_s)
        middle, worst = (f"{times[len(times) // 2] * 1e3:.0f} ms", f"{times[-1] * 1e3:.0f} ms") if times else ("", "")
        said = "held" if o.held else f"**not held** {o.failed}".strip()
        lines.append(
            f"| {o.name} | {len(times)} | {middle} | {worst} | {o.limit_s * 1e3:.0f} ms | {o.returned} | "
            f"{o.tracebacks} | {'all' if o.lost is None else o.lost} | {o.version} | {said} |"
        )
    return "\n".join(lines) + "\n"


def main() -> int:
    """Strike, print and write the table; 1 if a promise was broken."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repetitions", type=int, default=20, help="of each fault")
    parser.add_argument("--only", default="", help="faults whose name holds this text")
    parser.add_argument("--where", choices=get_args(Where), help="faults of one kind of bench")
    parser.add_argument("--out", type=Path, help="write the table, as docs/results/faults.md")
    parser.add_argument("--again", action="store_true", help="strike also what is in the results already")
    parser.add_argument("--results", type=Path, default=Path("faults-results.jsonl"))
    args = parser.parse_args()
    known = {} if args.again else read(args.results)
    faults = [fault for fault in FAULTS if args.only in fault.name and args.where in (None, fault.where)]
    faults = [fault for fault in faults if fault.name not in known]
    with tqdm(total=len(faults) * args.repetitions, unit="fault", dynamic_ncols=True) as bar:
        for fault in faults:
            with open_graph() as graph:
                outcome = repeated(graph, fault, args.repetitions, bar)
            with args.results.open("a", encoding="utf-8") as log:
                log.write(json.dumps(asdict(outcome)) + "\n")
    order = [fault.name for fault in FAULTS]
    outcomes = sorted(read(args.results).values(), key=lambda outcome: order.index(outcome.name))
    text = report(outcomes, f'make faults FAULTS="--repetitions {args.repetitions}"')
    print(text)
    if args.out:
        args.out.write_text(text, encoding="utf-8")
    return 0 if all(outcome.held for outcome in outcomes) else 1


if __name__ == "__main__":
    sys.exit(main())
