# SPDX-License-Identifier: Apache-2.0
"""`make bench`: everything that is measured rather than tested. Writes docs/benchmarks.md.

--only NAME… measures some of it (and prints, leaving the document alone); --quick shortens the long ones.
"""

import argparse
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import graph
import speed

HEAD = """# Benchmarks

Written by `make bench`. Two shared cores; ratios were measured side by side in one run and are what counts.
"""


def in_real_time(duration_s: float) -> list[str]:
    """The node graph as separate processes, beside a bare publisher and subscriber."""
    with tempfile.TemporaryDirectory() as folder:
        rows = graph.measure(Path(folder), duration_s)
    return [f"## Node graph in real time, {duration_s:g} s, every node a process", "", graph.table(rows), ""]


def main() -> int:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description="benchmarks")
    parser.add_argument("--only", nargs="+", choices=("simulation", "start_up", "identification", "graph"))
    parser.add_argument(
        "--quick", action="store_true", help="one minute of the graph, 5 × the fit's time for the rival"
    )
    args = parser.parse_args()
    parts: dict[str, Callable[[], list[str]]] = {
        "simulation": speed.simulation,
        "start_up": speed.start_up,
        "identification": lambda: speed.identification(5.0 if args.quick else 20.0),
        "graph": lambda: in_real_time(60.0 if args.quick else 600.0),
    }
    text = "\n".join([HEAD, *(line for name in args.only or parts for line in parts[name]())])
    print(text)
    if not args.only and not args.quick:
        (Path(__file__).parents[2] / "docs" / "benchmarks.md").write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
