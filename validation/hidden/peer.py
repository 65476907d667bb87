# SPDX-License-Identifier: Apache-2.0
"""The hidden suite put to petab-select: forward selection by BIC, on the same runs, simulator and library.

    make peer
    make peer PEER="--cases relays-heat/radiation relays-heat/nothing"

What of it is petab-select's and what ours, :mod:`peer_search` tells. Each case is judged twice. The noise is taken for
white, as in the examples of petab-select, and then whitened as in the product. Finished cases are kept in --results
(JSON lines), so that a run that was stopped goes on where it was. `suite.py` sets beside them what the product says of
the same cases.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from functools import partial
from pathlib import Path
from typing import Any, Final

from tqdm import tqdm

sys.path.insert(0, str(Path(__file__).parents[1]))

from campaign import Case, campaign
from cases import cases
from families import ALL, FAMILIES

from lce_analysis.identification import fit
from lce_analysis.options import FitOptions
from lce_model import default_model
from lce_model.effects import library

RESULTS: Final = Path(__file__).parents[2] / "docs/results/hidden-peer-results.jsonl"
NOISES: Final = {"iid": "noise taken for white", "autoregressive": "noise whitened as ours"}
"""What each case is judged with, and how the report calls it."""


def read_results(path: Path = RESULTS) -> list[dict[str, Any]]:
    """What has been judged so far; nothing where there is no such file."""
    return [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []


def _show(bar: tqdm[Any], case: Case, text: str) -> None:
    bar.set_description_str(f"{case.name}: {text}")


def main() -> int:
    """Judge what is not done yet, within the time given."""
    parser = argparse.ArgumentParser(description="petab-select on strips with hidden effects")
    parser.add_argument("--cases", nargs="*", default=[""], help="those whose name holds one of these texts")
    parser.add_argument("--families", nargs="+", default=list(FAMILIES), choices=list(ALL), metavar="FAMILY")
    parser.add_argument("--noise", nargs="*", choices=NOISES, default=list(NOISES))
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--first-seed", type=int, default=0)
    parser.add_argument("--minutes", type=float, default=120.0, help="stop beginning new cases after this time")
    parser.add_argument("--case-minutes", type=float, default=15.0, help="and new calibrations of a case after this")
    parser.add_argument("--results", type=Path, default=RESULTS)
    args = parser.parse_args()
    try:
        from peer_search import judge
    except ImportError as error:
        print(f"peer.py: {error}; make peer installs it", file=sys.stderr)
        return 2
    known = {(r["case"], r["noise"]) for r in read_results(args.results)}
    every = cases(args.seeds, args.families, first=args.first_seed)
    chosen = [c for c in every if any(text in c.name for text in args.cases)]
    end = time.monotonic() + 60.0 * args.minutes
    with (
        tqdm(total=len(chosen) * len(args.noise), unit="case", dynamic_ncols=True) as bar,
        args.results.open("a") as log,
    ):
        for case in chosen:
            left = [noise for noise in args.noise if (case.name, noise) not in known]
            bar.update(len(args.noise) - len(left))
            if not left or time.monotonic() > end:
                continue
            bar.set_description_str(f"{case.name}: fit")
            train, test = campaign(case)
            base = fit(default_model("lumped", ALL[case.family].base), train, FitOptions(seed=case.seed)).model
            # An effect that begins at a time of its own is no candidate of the diagnosis either, beside several runs.
            known_effects = [e for e in library().values() if not e.in_durations]
            candidates = [e for e in known_effects if case.library == "whole" or e.name not in case.hidden]
            for noise in left:
                found = judge(
                    train, test, base, noise, candidates, limit_s=60.0 * args.case_minutes,
                    tell=partial(_show, bar, case),
                )  # fmt: skip
                log.write(json.dumps({"case": case.name, "noise": noise} | found) + "\n")
                log.flush()
                bar.update()
    return 0


if __name__ == "__main__":
    sys.exit(main())
