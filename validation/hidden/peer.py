# SPDX-License-Identifier: Apache-2.0
"""The hidden suite put to petab-select: forward selection by BIC, on the same runs, simulator and library.

    pip install --no-deps -r requirements/peer.txt
    python validation/hidden/peer.py --cases equilibrium/radiation equilibrium/nothing
    python validation/hidden/peer.py --families equilibrium-heat relays-heat

How it is done, and what is petab-select's and what ours, is told in :mod:`peer_search`. Two rows come of it: noise that
is taken for white, as in the examples of petab-select, and whitened as in the product. Finished cases are kept in
--results (JSON lines), so that a run that was stopped goes on where it was. ``peer_rows`` makes the rows of the report,
and needs no petab-select.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Final

import numpy as np
from tqdm import tqdm

sys.path.insert(0, str(Path(__file__).parents[1]))

from campaign import Case, campaign
from cases import cases, kind
from families import ALL, FAMILIES

from lce_analysis.identification import fit
from lce_analysis.options import FitOptions
from lce_analysis.prediction import predict
from lce_data.run import Run
from lce_model import Model, default_model

RESULTS: Final = Path(__file__).parents[2] / "docs/results/hidden-peer-results.jsonl"
NOISES: Final = {"iid": "noise taken for white", "autoregressive": "noise whitened as ours"}
VISIBLE: Final = 0.5
"""What the base leaves beyond the noise of the worse sensor, in units of that noise, for an effect to be visible."""
JUDGED: Final = ("nothing", "one", "two")
"""Kinds of cases; the others hide what no candidate can be."""
PEER_HEAD: Final = (
    "| peer | visible effect: named first | false additions a case | nothing hidden: nothing added | median time |",
    "|---|---|---|---|---|",
)


def peer_rows(results: Sequence[Mapping[str, Any]]) -> list[str]:
    """Rows below PEER_HEAD, one for each noise, of the results that this file writes (:func:`read_results`)."""
    rows = []
    for noise, words in NOISES.items():
        mine = [r for r in results if r["noise"] == noise]
        if not mine:
            continue
        seen = [r["added"][:1] == r["hidden"] for r in mine if len(r["hidden"]) == 1 and r["misfit"] >= VISIBLE]
        quiet = [not r["added"] for r in mine if not r["hidden"] and not r["own"]]
        false = sum(len({*r["added"]} - {*r["hidden"], *r["own"]}) for r in mine) / len(mine)
        unfinished = sum(not r["finished"] for r in mine)
        seconds = f"{np.median([r['seconds'] for r in mine]):.0f} s" + f", {unfinished} cut short" * bool(unfinished)
        shares = [f"{sum(passed)} of {len(passed)}" if passed else "no case" for passed in (seen, quiet)]
        rows.append(
            f"| petab-select, forward BIC, {words} | {shares[0]} | {false:.2f} ({len(mine)} cases) | {shares[1]} "
            f"| {seconds} |"
        )
    return rows


def read_results(path: Path = RESULTS) -> list[dict[str, Any]]:
    """What has been judged so far; nothing where there is no such file."""
    return [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []


def misfit(model: Model, case: Case, runs: Sequence[Run]) -> float:
    """RMS of what the model lacks in the worse sensor, in units of the noise that was put in."""
    ratio = 0.0
    ideal = [case.ideal(run) for run in runs]
    for channel in ideal[0]:
        lacking = [
            predict(model, run).at_samples[channel] - true[channel] for run, true in zip(runs, ideal, strict=True)
        ]
        noise = [run.series[channel].value - true[channel] for run, true in zip(runs, ideal, strict=True)]
        ratio = max(ratio, float(np.std(np.concatenate(lacking)) / np.std(np.concatenate(noise))))
    return ratio


def _show(bar: tqdm[Any], case: Case, text: str) -> None:
    bar.set_description_str(f"{case.name}: {text}")


def main() -> int:
    """Judge what is not done yet, within the time given; print the rows."""
    parser = argparse.ArgumentParser(description="petab-select on strips with hidden effects")
    parser.add_argument("--cases", nargs="*", default=[""], help="those whose name holds one of these texts")
    parser.add_argument("--families", nargs="+", default=list(FAMILIES), choices=list(ALL), metavar="FAMILY")
    parser.add_argument("--noise", nargs="*", choices=NOISES, default=list(NOISES))
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--minutes", type=float, default=120.0, help="stop beginning new cases after this time")
    parser.add_argument("--case-minutes", type=float, default=15.0, help="and new calibrations of a case after this")
    parser.add_argument("--results", type=Path, default=RESULTS)
    args = parser.parse_args()
    try:
        from peer_search import judge
    except ImportError as error:
        print(f"peer.py: {error}; pip install --no-deps -r requirements/peer.txt", file=sys.stderr)
        return 2
    known = {(r["case"], r["noise"]) for r in read_results(args.results)}
    fair = [c for c in cases(args.seeds, args.families) if kind(c.hidden, c.library) in JUDGED]
    chosen = [c for c in fair if any(text in c.name for text in args.cases)]
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
            own, lacks = ALL[case.family].own, round(misfit(base, case, train), 3)
            about = {"case": case.name, "hidden": list(case.hidden), "own": list(own), "misfit": lacks}
            for noise in left:
                found = judge(
                    train, test, base, noise, limit_s=60.0 * args.case_minutes,
                    tell=partial(_show, bar, case),
                )  # fmt: skip
                log.write(json.dumps(about | found) + "\n")
                log.flush()
                bar.update()
    print("\n".join([*PEER_HEAD, *peer_rows(read_results(args.results))]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
