# SPDX-License-Identifier: Apache-2.0
"""`make bench`: everything that is measured rather than tested, into docs/results/benchmarks.md.

--only NAME… measures some parts and replaces just their sections of the document; --quick shortens the long parts,
prints, and leaves the document alone.
"""

import argparse
import os
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the command `lce` does, before numpy is imported

import bands
import diagnosis
import graph
import least_squares
import loop_timing
import reading
import recovery
import speed
import workbench

DOCUMENT = Path(__file__).parents[1] / "docs" / "results" / "benchmarks.md"
HEAD = """# Benchmarks

Written by `make bench`. Two shared cores; ratios were measured side by side in one run and are what counts.
"""


def in_real_time(duration_s: float) -> list[str]:
    """The node graph as separate processes, beside a bare publisher and subscriber."""
    with tempfile.TemporaryDirectory() as folder:
        rows = graph.measure(Path(folder), duration_s)
    return [f"## Node graph in real time, {duration_s:g} s, every node a process", "", graph.table(rows), ""]


def in_the_loop(duration_s: float) -> list[str]:
    """The controllers as separate processes, beside empty nodes."""
    with tempfile.TemporaryDirectory() as folder:
        rows = loop_timing.measure(Path(folder), duration_s)
    return [f"## Double loop in real time, {duration_s:g} s, every node a process", "", loop_timing.table(rows), ""]


def sections(document: str) -> dict[str, str]:
    """Part name to text; each part of the document stands behind a comment with its name."""
    pieces = document.split("<!-- part: ")[1:]
    return {name: text.strip() for name, _, text in (piece.partition(" -->") for piece in pieces)}


def main() -> int:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description="benchmarks")
    parser.add_argument("--quick", action="store_true", help="shorter, and only printed")
    quick = "--quick" in sys.argv
    parts: dict[str, Callable[[], list[str]]] = {
        "simulation": speed.simulation,
        "start_up": speed.start_up,
        "reading": reading.measure,
        "identification": lambda: speed.identification(5.0 if quick else 20.0),
        "least_squares": least_squares.measure,
        "recovery": lambda: recovery.measure(3 if quick else 20),
        "bands": lambda: bands.measure(5 if quick else 50),
        "diagnosis": diagnosis.measure,
        "six_runs": diagnosis.six_runs,
        "graph": lambda: in_real_time(60.0 if quick else 600.0),
        "loop_timing": lambda: in_the_loop(20.0 if quick else 300.0),
        "workbench": lambda: workbench.measure(30.0 if quick else 600.0),
    }
    parser.add_argument("--only", nargs="+", choices=parts, default=list(parts), metavar="PART", help=", ".join(parts))
    args = parser.parse_args()
    for name in args.only:
        text = "\n".join(parts[name]()).strip()
        print(text, flush=True)
        if not quick:
            found = (sections(DOCUMENT.read_text(encoding="utf-8")) if DOCUMENT.exists() else {}) | {name: text}
            body = "\n".join(f"<!-- part: {key} -->\n{found[key]}\n" for key in parts if key in found)
            DOCUMENT.write_text(f"{HEAD}\n{body}", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
