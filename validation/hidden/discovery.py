# SPDX-License-Identifier: Apache-2.0
"""`make discovery`: does `lce discover` find what no library holds, and nothing where nothing is missing?

    python validation/hidden/discovery.py --minutes 30 --families equilibrium --only radiation

Every effect of the library is left out once: the strip hides it, and the search knows nothing of the library anyway.
Beside them stand what does not repeat, a camera that clips, and strips that hide nothing. What counts as right is in
`discovery_answers.py`; cases run side by side, and go on, as in `suite.py`.
"""

import math
import sys
import time
import traceback
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parent))

import numpy as np
from campaign import Case, campaign
from discovery_answers import ANSWERS, DISTURBANCES, SIGNATURES, TELLING
from discovery_report import report
from effects import OUTSIDE
from families import FAMILIES
from judge import over_noise, unabsorbed
from suite import arguments, judge_all, options, read, version

from lce_analysis.discovery import discover
from lce_analysis.identification import fit
from lce_analysis.options import FitOptions
from lce_model import default_model

Record = Mapping[str, Any]
USUAL = ("equilibrium", "relays")
"""An exact base, and one that is not."""
NOTHING = 20
"""Strips that hide nothing, over all families."""
NOT_FUNCTIONS = ("sticking_guide",)
"""Hidden things that are neither a function of a covariate nor a disturbance."""


def cases(seeds: int, families: Sequence[str], campaign: str) -> list[Case]:
    """All cases, in an order of which every first part is a fair sample."""
    found = []
    for family in (FAMILIES[name] for name in families):
        hidden = [n for n in family.may_hide if n not in NOT_FUNCTIONS]
        for seed in range(seeds):
            found += [
                Case(family.name, (n,), "clear", seed, "whole" if n in OUTSIDE else "without", campaign) for n in hidden
            ]
        count = 0 if family.own else NOTHING // len(families)
        found += [Case(family.name, (), "clear", seed, campaign=campaign) for seed in range(count)]
    order = np.random.default_rng(14).permutation(len(found))
    return [found[i] for i in order]


def judge(case: Case) -> dict[str, Any]:
    """Everything that the report needs to know of one case; with "failed", the message, if it raised."""
    record = {"case": case.name, "family": case.family, "hidden": list(case.hidden)}
    try:
        return record | _judged(case)
    except Exception as error:  # noqa: BLE001, whatever it is: the suite counts the case as a failure
        return record | {"failed": f"{type(error).__name__}: {error}", "traceback": traceback.format_exc()}


def _judged(case: Case) -> dict[str, Any]:
    family = FAMILIES[case.family]
    train, test = campaign(case)
    ideal = {run.name: case.ideal(run) for run in (*train, *test)}
    model = fit(default_model("lumped", family.base), train, FitOptions(seed=case.seed)).model
    began = time.perf_counter()
    found = discover(model, train, test)
    seconds = time.perf_counter() - began
    record = found.as_json()
    base = over_noise(model, train, ideal)
    misfit = max(math.copysign(math.sqrt(abs(x * x - 1.0)), x - 1.0) for x in base.values())
    return {
        "visible": misfit if family.exact else unabsorbed(case, model, train, ideal),
        "verdict": record["verdict"],
        "closures": [[c["place"], c["covariate"], c["set"]] for c in record["closures"]],
        "formulas": [[f["closure"], f["form"], f["set"]] for f in record["formulas"]],
        "walks": [walk.words for walk in found.walks],
        "signatures": [[s["name"], s["sensor"], s["value"]] for s in record["signatures"]],
        "before": over_noise(model, test, ideal),
        "after": over_noise(found.model, test, ideal),
        "seconds": round(seconds, 1),
        **marks(case.hidden, record),
    }


def marks(hidden: Sequence[str], record: Record) -> dict[str, bool]:
    """What of an answer, in the JSON form of the contract, is right for what is hidden: one effect, or nothing.

    place, covariate, formula : does any of the sets reported hold a right one? A covariate counts in a right place
    only, and a formula in a set that has both. Only for effects that are functions of a covariate.
    disturbance : is the verdict that? Only for those that are one.
    named : is the signature of the effect named? Only for effects that have one. wrong : is another one named?
    """
    found: dict[str, bool] = {}
    effect = hidden[0] if hidden else ""
    if effect in ANSWERS:
        found |= _functions(effect, record)
    if effect in DISTURBANCES:
        found["disturbance"] = record["verdict"] == "disturbance"
    names = {signature["name"] for signature in record["signatures"]}
    right = set(SIGNATURES.get(effect, ()))
    if right:
        found["named"] = bool(right & names)
    found["wrong"] = bool((names & set(TELLING)) - right)
    return found


def _functions(effect: str, record: Record) -> dict[str, bool]:
    place = covariate = formula = False
    for number, closure in enumerate(record["closures"]):
        pairs = [(closure["place"], closure["covariate"]), *map(tuple, closure["set"])]
        forms = {x for f in record["formulas"] if f["closure"] == number for x in (f["form"], *f["set"])}
        for answer in ANSWERS[effect]:
            place |= any(p in answer.places for p, _ in pairs)
            if any(p in answer.places and z in answer.covariates for p, z in pairs):
                covariate = True
                formula |= bool(forms & set(answer.forms))
    return {"place": place, "covariate": covariate, "formula": formula}


def main() -> int:
    """Run what is not done yet, within the time given; print and write the report."""
    args = options("discovery on strips that hide what no library holds", Path("discovery-results.jsonl"), seeds=3)
    families = args.families or USUAL
    now = version()
    if args.fresh:
        args.results.unlink(missing_ok=True)
    done = read(args.results, now)
    chosen = [c for c in cases(args.seeds, families, args.campaign) if args.only in c.name]
    status = judge_all(chosen, done, args, "discovery")
    names = {c.name for c in chosen}
    text = report([r for r in done if r["case"] in names], now, arguments(args))
    print(text)
    if args.out and status == 0:
        args.out.write_text(text, encoding="utf-8")
    return status


if __name__ == "__main__":
    sys.exit(main())
