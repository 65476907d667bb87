# SPDX-License-Identifier: Apache-2.0
"""From recordings to the effect that a model lacks, in Python.

    python examples/fit_and_diagnose.py demo/pulse demo/stairs demo/cycles --test demo/prbs

The recordings are those of `make demo`; any others will do.
"""

import argparse
from pathlib import Path

import lce_analysis as lce


def main() -> None:
    """Fit a model, say what it lacks, add that, and save the better model."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", nargs="+", type=Path, help="recordings to learn from")
    parser.add_argument("--test", nargs="*", type=Path, default=[], help="recordings held out")
    parser.add_argument("--deformation", default="kinetic", help="base model of T→d")
    parser.add_argument("--out", type=Path, default=Path("better.yaml"), help="model file to write")
    args = parser.parse_args()

    runs, test_runs = lce.read_runs(args.runs), lce.read_runs(args.test)
    fitted = lce.fit(lce.default_model("lumped", args.deformation), runs)
    print(fitted.summary())

    for sentence in lce.compare(fitted.model, runs).sentences:
        print(sentence)

    found = lce.diagnose(fitted.model, runs, test_runs)
    for sentence in found.sentences:
        print(sentence)
    lce.save_model(found.model, args.out)
    print(args.out)


if __name__ == "__main__":
    main()
