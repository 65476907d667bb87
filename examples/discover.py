# SPDX-License-Identifier: Apache-2.0
"""What no effect of the library holds: the unknown function of a strip, its curve and its formula.

    python examples/discover.py demo/pulse demo/stairs demo/cycles --model demo/model.yaml --test demo/prbs

A curve per found function is written as an SVG. It takes a minute or two.
"""

import argparse
from pathlib import Path

import lce_analysis as lce
from lce_report.pages.discovery import discovery_sections
from lce_report.paper import curves_of, written


def main() -> None:
    """Search, say what was found, and draw it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", nargs="+", type=Path, help="recordings to learn from")
    parser.add_argument("--model", type=Path, required=True, help="model file, as lce fit writes it")
    parser.add_argument("--test", nargs="*", type=Path, default=[], help="recordings held out")
    parser.add_argument("--out", type=Path, default=Path("discovered"), help="folder of the pictures")
    args = parser.parse_args()

    model, runs, test_runs = lce.load_model(args.model), lce.read_runs(args.runs), lce.read_runs(args.test)
    found = lce.discover(model, runs, test_runs)
    for sentence in found.sentences:
        print(sentence)

    args.out.mkdir(exist_ok=True)
    for section in discovery_sections(found):
        for number, figure in enumerate(curves_of(section.blocks)):
            file = args.out / f"{section.heading.replace(' ', '-')}-{number}.svg"
            file.write_bytes(written(figure, "svg"))
            print(file)


if __name__ == "__main__":
    main()
