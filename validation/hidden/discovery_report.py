# SPDX-License-Identifier: Apache-2.0
"""What the discovery found, as Markdown, with the bars of the project beside it."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from families import FAMILIES
from scipy.stats import binomtest

Result = dict[str, Any]
VISIBLE = 0.5
"""Part of a sensor's noise that an effect leaves behind a refitted base, from which it counts as visible."""
HELD_OUT = 1.3
SECONDS = 120.0


@dataclass(frozen=True)
class Gate:
    """A line of the table: what is counted, the bar, and whether it is a floor or a ceiling."""

    name: str
    passed: list[bool]
    bar: float | None
    at_most: bool = False


def gates(results: Sequence[Result]) -> Iterator[Gate]:
    """The lines of the table; a case that failed passes none."""

    def gate(name: str, members: list[Result], test: Callable[[Result], bool], bar: float | None) -> Gate:
        return Gate(name, ["failed" not in r and test(r) for r in members], bar)

    def marked(key: str) -> Callable[[Result], bool]:
        return lambda r: bool(r.get(key))

    done = [r for r in results if "failed" not in r]
    seen = [r for r in results if r["hidden"] and r.get("visible", VISIBLE) >= VISIBLE]
    functions = [r for r in seen if "place" in r or "failed" in r]
    nothing = [r for r in done if not r["hidden"]]
    yield gate("place in the set", functions, marked("place"), 0.85)
    yield gate("covariate in the set", functions, marked("covariate"), 0.70)
    yield gate("formula in the set", functions, marked("formula"), 0.50)
    yield gate(f"held-out error ≤ {HELD_OUT} × noise", functions, _at_noise, 0.70)
    yield gate("disturbance called one", [r for r in seen if "disturbance" in r], marked("disturbance"), None)
    yield Gate("discovery on nothing", [bool(r["closures"]) for r in nothing], 0.05, at_most=True)
    yield Gate("disturbance on nothing", [r["verdict"] == "disturbance" for r in nothing], 0.05, at_most=True)
    yield gate("signature named", [r for r in seen if "named" in r], marked("named"), 0.90)
    yield Gate("wrong signature", [r["wrong"] for r in done], 0.05, at_most=True)
    yield gate(f"within {SECONDS:.0f} s", done, lambda r: r["seconds"] <= SECONDS, 1.0)


def _at_noise(result: Result) -> bool:
    return max(result["after"].values()) <= HELD_OUT


def gate_table(results: Sequence[Result]) -> list[str]:
    """The gates of some cases; what misses its bar is bold."""
    lines = ["| | bar | found | share | 95 % interval |", "|---|---|---|---|---|"]
    for one in gates(results):
        sign = "≤" if one.at_most else "≥"
        bar = "" if one.bar is None else "all" if one.bar == 1.0 else f"{sign} {one.bar:.0%}"
        lines.append(f"| {one.name} | {bar} | {_share(one)} |")
    return lines


def _share(one: Gate) -> str:
    if not one.passed:
        return "no case | |"
    count, size = sum(one.passed), len(one.passed)
    interval = binomtest(count, size).proportion_ci(method="wilson")
    share = count / size
    missed = one.bar is not None and (share > one.bar if one.at_most else share < one.bar)
    words = f"{count} of {size} | {share:.0%}"
    return f"{f'**{words}**'.replace(' | ', '** | **') if missed else words} | {interval.low:.0%}–{interval.high:.0%}"


def by_effect(results: Sequence[Result]) -> list[str]:
    """A line for each hidden effect: how often each part of the answer was right, over the visible cases."""
    lines = ["| hidden | visible | place | covariate | formula | disturbance |", "|---|---|---|---|---|---|"]
    for effect in dict.fromkeys(sorted(r["hidden"][0] for r in results if r["hidden"])):
        own = [r for r in results if r["hidden"] == [effect] and "failed" not in r]
        seen = [r for r in own if r["visible"] >= VISIBLE]
        cells = [_count(seen, key) for key in ("place", "covariate", "formula", "disturbance")]
        lines.append(f"| {effect} | {len(seen)} of {len(own)} | {' | '.join(cells)} |")
    return lines


def _count(results: Sequence[Result], key: str) -> str:
    marks = [r[key] for r in results if key in r]
    return f"{sum(marks)} of {len(marks)}" if marks else ""


def cases_table(results: Sequence[Result]) -> list[str]:
    """Every case in a line."""
    head = "| case | visible | verdict | found | formulas | signatures | held out, before → after | s |"
    lines = [head, "|---|---|---|---|---|---|---|---|"]
    for r in sorted(results, key=lambda r: r["case"]):
        if "failed" in r:
            lines.append(f"| {r['case']} | | failed | {r['failed'].splitlines()[0].replace('|', '/')} | | | | |")
            continue
        places = [f"{place}({covariate})" for place, covariate, _ in r["closures"]]
        found = "; ".join([*places, *r["walks"]])
        forms = ", ".join(form for _, form, _ in r["formulas"])
        signatures = ", ".join(dict.fromkeys(name for name, _, _ in r["signatures"]))
        change = f"{max(r['before'].values()):.2f} → {max(r['after'].values()):.2f}"
        cells = [
            r["case"],
            f"{r['visible']:.2f}",
            r["verdict"],
            found,
            forms,
            signatures,
            change,
            f"{r['seconds']:.0f}",
        ]
        lines.append(f"| {' | '.join(cells)} |")
    return lines


def report(results: Sequence[Result], version: str, arguments: str) -> str:
    """The whole document; ``arguments`` say which cases were judged."""
    lines = [
        "# What no library holds",
        "",
        HEAD.format(version=version, arguments=arguments),
        "",
        "## All families",
        "",
        *gate_table(results),
    ]
    for family in FAMILIES.values():
        if members := [r for r in results if r["family"] == family.name]:
            base = f"`lumped` + `{family.base}`, {'exact' if family.exact else 'imperfect'}"
            lines += ["", f"## {family.name}: {base}", "", *gate_table(members), "", *_times(members)]
    return "\n".join(
        [*lines, "", "## By effect", "", *by_effect(results), "", "## Cases", "", *cases_table(results), ""]
    )


def _times(results: Sequence[Result]) -> list[str]:
    done = [r for r in results if "failed" not in r]
    words = f"{len(results)} cases, {len(results) - len(done)} failed."
    if not done:
        return [words]
    seconds = [r["seconds"] for r in done]
    return [f"{words} `discover` took {np.median(seconds):.0f} s (median), {max(seconds):.0f} s (most)."]


HEAD = """Written by `make discovery DISCOVERY="{arguments}"`, version {version}.
Strips of `validation/hidden`, which share no code with the product, hide an effect. The product fits a base model to
six runs, and `lce discover` looks for a function that is missing. It knows nothing of the library of effects.

An effect is visible if it leaves at least half of a sensor's noise that the base cannot follow. Place, covariate and
formula are right if a set that is reported holds one that `validation/hidden/discovery_answers.py` lists for the
effect; a covariate counts in a right place only. A disturbance is what does not repeat from run to run. A signature is
wrong if it says clipped, rounded, period or outliers where nothing of that kind is hidden. Intervals are Wilson's.
Errors are in units of the noise that was put in. What misses its bar is bold."""
