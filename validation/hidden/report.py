# SPDX-License-Identifier: Apache-2.0
"""What the hidden suite found, family by family, as Markdown, with the bars of the project beside it.

HEAD explains what is counted. Beside the gates stand the two numbers of Prieto et al. (2021): of the cases that hide
something, how many get no name at all, and of the names given, how many are right.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from cases import KINDS, kind
from effects import OUTSIDE
from families import ALL, Family
from peer import NOISES
from scipy.stats import binomtest, chi2

Result = dict[str, Any]
FOR_FALSE = ("nothing", "one", "two")
"""Kinds of cases in which the bar counts false additions."""
VISIBLE = 0.5
HELD_OUT = 1.3


@dataclass(frozen=True)
class Gate:
    """A line of the table: what is counted, the bar with an exact and with an imperfect base (None: only told)."""

    name: str
    passed: list[bool]
    bars: tuple[float | None, float | None]


def of_kind(results: Sequence[Result], *kinds: str) -> list[Result]:
    """The cases of some kinds."""
    return [r for r in results if kind(r["hidden"], r["library"]) in kinds]


def false_additions(result: Result) -> int:
    """Effects that were added and should not have been; a case that failed counts for one.

    So does the advice of another base model where the base is exact.
    """
    if "failed" in result:
        return 1
    family = ALL[result["family"]]
    real = {*result["hidden"], *family.own}
    wrong = sum(not real & {name, *alias} for name, alias in zip(result["added"], result["sets"], strict=True))
    return wrong + bool(family.exact and result["advised"])


def named_first(result: Result) -> bool:
    """Is what is hidden the first name, but for the family's own physics, which may come before it?"""
    foreign = [name for name in result.get("added", ()) if name not in ALL[result["family"]].own]
    return foreign[:1] == result["hidden"]


def found(result: Result) -> set[str]:
    """All effects that the answer names, with their aliases."""
    return {name for alias in result.get("sets", ()) for name in alias}


def gates(results: Sequence[Result], family: Family) -> Iterator[Gate]:
    """The gates that count cases."""

    def gate(name: str, members: list[Result], test: Callable[[Result], bool], *bars: float | None) -> Gate:
        exact, imperfect = bars
        return Gate(name, ["failed" not in r and test(r) for r in members], (exact, imperfect))

    one = of_kind(results, "one")
    seen = [r for r in one if r.get("visible", math.inf) >= VISIBLE]
    masked = [r for r in one if r.get("visible", math.inf) < VISIBLE]
    right = [r for r in seen if named_first(r)]
    outside, left_out = of_kind(results, "outside"), of_kind(results, "left out")
    yield gate("visible effect: named first", seen, named_first, 0.95, 0.90)
    yield gate("visible effect: in a set", seen, lambda r: r["hidden"][0] in found(r), 0.95, 0.95)
    yield gate("visible effect: leads the ranking, named or not", seen, _leads, None, None)
    yield gate(f"named first: held-out error ≤ {HELD_OUT} × noise", right, _at_noise, 0.95, None)
    yield gate("the same on every sample, at jumps as well", right, _at_noise_everywhere, None, None)
    yield gate("masked effect: no wrong name", masked, lambda r: not false_additions(r), 0.95, 0.95)
    if not family.own:
        nothing = of_kind(results, "nothing")
        yield gate("nothing hidden: nothing added", nothing, lambda r: not (r["added"] or false_additions(r)), 1.0, 1.0)
        yield gate("nothing hidden: adequate", nothing, lambda r: r["verdict"] == "adequate", 0.95, None)
    yield gate("outside the library: no wrong name", outside, lambda r: not false_additions(r), 0.90, 0.90)
    yield gate("effect left out: no wrong name", left_out, lambda r: not false_additions(r), 0.90, 0.90)
    yield gate("two effects: both found", of_kind(results, "two"), lambda r: set(r["hidden"]) <= found(r), 0.80, 0.80)
    yield gate(
        "two effects: both named", of_kind(results, "two"), lambda r: set(r["hidden"]) <= {*r["added"]}, None, None
    )
    yield gate("aliases: resolved by the designed run", [r for r in one if "resolved" in r], _resolved, 0.80, 0.80)


def _leads(result: Result) -> bool:
    return result.get("leader") == result["hidden"][0]


def _at_noise(result: Result) -> bool:
    return max(result["after"].values()) <= HELD_OUT


def _at_noise_everywhere(result: Result) -> bool:
    return max(result["after_on_every_sample"].values()) <= HELD_OUT


def _resolved(result: Result) -> bool:
    return bool(result["resolved"])


def family_table(results: Sequence[Result], family: Family) -> list[str]:
    """The lines of one family."""
    models = "`lumped`" if family.heat_only else f"`lumped` + `{family.base}`"
    base = f"{models}, {'exact' if family.exact else 'imperfect'}"
    lines = [f"## {family.name}: {base}", "", "| | bar | found | share | 95 % interval |", "|---|---|---|---|---|"]
    for gate in gates(results, family):
        bar = gate.bars[0 if family.exact else 1]
        wanted = "" if bar is None else "all" if bar == 1.0 else f"≥ {bar:.0%}"
        lines.append(f"| {gate.name} | {wanted} | {_share(gate.passed)} |")
    lines += _false_lines(results, family.exact)
    return [*lines, *_names_lines(results), "", *_numbers(results), *_never_judged(results, family)]


def _never_judged(results: Sequence[Result], family: Family) -> list[str]:
    """Which effects of the library no case has hidden so that they show."""
    judged = {r["hidden"][0] for r in of_kind(results, "one") if r.get("visible", 0.0) >= VISIBLE}
    never = [name for name in family.may_hide if name not in (*judged, *OUTSIDE)]
    return [f"Not judged alone, or never visible: {', '.join(never)}.", ""] if never else []


def overview(results: Sequence[Result]) -> list[str]:
    """A line for each family, and for all with an exact, and with an imperfect base.

    What passed each gate with a bar, and false additions; bold where it missed its bar.
    """
    present = [f for f in ALL.values() if any(r["family"] == f.name for r in results)]
    rows = [(f.name, [f], f.exact) for f in present]
    for exact in (True, False):
        alike = [f for f in present if f.exact is exact]
        if len(alike) > 1:
            rows.append((f"all with an {'exact' if exact else 'imperfect'} base", alike, exact))
    tables = [_with_bars(results, families) for _, families, _ in rows]
    names = list(dict.fromkeys(name for table in tables for name in table))
    lines = [f"| family | cases | {' | '.join(names)} | false additions |", "|---" * (len(names) + 3) + "|"]
    for (name, families, exact), table in zip(rows, tables, strict=True):
        members = [r for r in results if r["family"] in {f.name for f in families}]
        cells = [_cell(table.get(gate), exact) for gate in names]
        lines.append(f"| {name} | {len(members)} | {' | '.join(cells)} | {_false_cell(members, exact)} |")
    return lines


def _with_bars(results: Sequence[Result], families: Sequence[Family]) -> dict[str, Gate]:
    """The gates that have a bar, by name, of the cases of several families together."""
    together: dict[str, Gate] = {}
    for family in families:
        for gate in gates([r for r in results if r["family"] == family.name], family):
            if any(bar is not None for bar in gate.bars):
                before = together[gate.name].passed if gate.name in together else []
                together[gate.name] = replace(gate, passed=[*before, *gate.passed])
    return together


def _false_cell(members: Sequence[Result], exact: bool) -> str:
    count, size, bar = _false(members, exact)
    words = f"{count} in {size}"
    return words if count <= bar * size else f"**{words}**"


def _false(members: Sequence[Result], exact: bool, kinds: Sequence[str] = FOR_FALSE) -> tuple[int, int, float]:
    """False additions, the cases of some kinds that count for them, and how many a case may have.

    With nothing hidden a strip that has physics of its own counts for nothing: every name is right there.
    """
    counted = [r for r in of_kind(members, *kinds) if r["hidden"] or not ALL[r["family"]].own]
    return sum(false_additions(r) for r in counted), len(counted), 0.05 if exact else 0.15


def _cell(gate: Gate | None, exact: bool) -> str:
    if gate is None or not gate.passed:
        return ""
    bar = gate.bars[0 if exact else 1]
    words = f"{sum(gate.passed)} of {len(gate.passed)}"
    return words if bar is None or np.mean(gate.passed) >= bar else f"**{words}**"


def _share(passed: list[bool]) -> str:
    if not passed:
        return "no case | |"
    count, size = sum(passed), len(passed)
    interval = binomtest(count, size).proportion_ci(method="wilson")
    return f"{count} of {size} | {count / size:.0%} | {interval.low:.0%}–{interval.high:.0%}"


def _false_lines(members: Sequence[Result], exact: bool) -> list[str]:
    """False additions per case, with the interval of a Poisson count."""
    lines = []
    for words, kinds, told in (("nothing, one or two hidden", FOR_FALSE, True), ("all kinds", KINDS, False)):
        count, size, bar = _false(members, exact, kinds)
        name = f"| false additions a case ({words}) | {f'≤ {bar}' if told else ''} |"
        if not size:
            lines.append(f"{name} no case | | |")
            continue
        low = chi2.ppf(0.025, 2 * count) / 2.0 if count else 0.0
        high = chi2.ppf(0.975, 2 * count + 2) / 2.0
        lines.append(f"{name} {count} in {size} | {count / size:.2f} | {low / size:.2f}–{high / size:.2f} |")
    return lines


def _names_lines(results: Sequence[Result]) -> list[str]:
    """Precision where a name is given, and abstentions, over all cases that hide something that shows."""
    members = [r for r in results if r["hidden"] and "failed" not in r and r.get("visible", 0.0) >= VISIBLE]
    names = [
        wrong == 0 for r in members for wrong in [1] * false_additions(r) + [0] * (len(r["added"]) - false_additions(r))
    ]
    silent = [not r["added"] for r in members]
    return [
        f"| something visible hidden: names that are right | | {_share(names)} |",
        f"| something visible hidden: no name given | | {_share(silent)} |",
    ]


def _numbers(results: Sequence[Result]) -> list[str]:
    """Held-out error of what was found, and times, in sentences."""
    done = [r for r in results if "failed" not in r]
    sentences = [f"{len(results)} cases, {len(results) - len(done)} failed."]
    right = [r for r in of_kind(done, "one") if r["visible"] >= VISIBLE and named_first(r)]
    for words, key in (("before", "before"), ("after", "after")):
        if errors := [max(r[key].values()) for r in right]:
            sentences.append(
                f"Held-out error {words}, worse sensor, where the name was right: {np.median(errors):.2f} × noise "
                f"(median), {max(errors):.2f} (most)."
            )
    for words, key in (("fit", "fit_s"), ("diagnose", "diagnose_s")):
        if times := [r[key] for r in done]:
            sentences.append(f"`{words}` took {np.median(times):.0f} s (median), {max(times):.0f} s (most).")
    return [" ".join(sentences), ""]


def cases_table(results: Sequence[Result]) -> list[str]:
    """Every case in a line."""
    lines = ["| case | visible | verdict | sets | held out, before → after |", "|---|---|---|---|---|"]
    for r in sorted(results, key=lambda r: r["case"]):
        if "failed" in r:
            lines.append(f"| {r['case']} | | failed | {r['failed'].splitlines()[0].replace('|', '/')} | |")
            continue
        sets = "; ".join(", ".join(alias) for alias in r["sets"])
        change = f"{max(r['before'].values()):.2f} → {max(r['after'].values()):.2f}"
        verdict = f"{r['verdict']}, begin with {r['advised']}" if r["advised"] else r["verdict"]
        lines.append(f"| {r['case']} | {r['visible']:.2f} | {verdict} | {sets} | {change} |")
    return lines


def peer_table(results: Sequence[Result], peer: Sequence[Result]) -> list[str]:
    """The product and petab-select on the same cases: those that petab-select has judged with each noise."""
    ours = {r["case"]: r for r in results if "failed" not in r}
    theirs = {noise: {r["case"]: r for r in peer if r["noise"] == noise} for noise in NOISES}
    cases = [case for case in ours if all(case in found for found in theirs.values())]
    if not cases:
        return []
    rows = [_peer_row("`lce diagnose`", [ours[c] | {"seconds": ours[c]["diagnose_s"]} for c in cases])]
    for noise, words in NOISES.items():
        rows.append(_peer_row(f"petab-select, forward BIC, {words}", [ours[c] | theirs[noise][c] for c in cases]))
    return [
        "## Peer: petab-select, forward by BIC",
        "",
        f"Made by `validation/hidden/peer.py` on {len(cases)} of the cases; what `lce diagnose` says of the same ones "
        "beside it. Both begin at the model that `lce fit` gives, and times count from there: of `lce diagnose` on one "
        "core, of petab-select on as many as are free. Only the names that were added count here, of `lce diagnose` "
        "too, not the effects that look like them.",
        "",
        "| | visible effect: named first | nothing hidden: nothing added "
        "| outside the library or left out: no wrong name | two effects: both found | false additions | median time |",
        "|---|---|---|---|---|---|---|",
        *rows,
        "",
    ]


def _peer_row(name: str, results: Sequence[Result]) -> str:
    members = [r | {"sets": [[added] for added in r["added"]]} for r in results]
    one, nothing = of_kind(members, "one"), of_kind(members, "nothing")
    shares = (
        [named_first(r) for r in one if r["visible"] >= VISIBLE],
        [not r["added"] for r in nothing if not ALL[r["family"]].own],
        [not false_additions(r) for r in of_kind(members, "outside", "left out")],
        [set(r["hidden"]) <= found(r) for r in of_kind(members, "two")],
    )
    cells = [f"{sum(passed)} of {len(passed)}" if passed else "no case" for passed in shares]
    counted = of_kind(members, "nothing", "one", "two")
    cut_short = sum(not r.get("finished", True) for r in members)
    seconds = f"{np.median([r['seconds'] for r in members]):.0f} s"
    if cut_short:
        seconds += f", {cut_short} cut short"
    false = sum(map(false_additions, counted))
    return f"| {name} | {' | '.join(cells)} | {false} in {len(counted)} | {seconds} |"


def report(results: Sequence[Result], version: str, arguments: str = "", peer: Sequence[Result] = ()) -> str:
    """The whole document; ``arguments`` of the command that made it, ``peer`` the results of `hidden/peer.py`."""
    heat_only = all(ALL[r["family"]].heat_only for r in results)
    title = "# Hidden effects, the heat alone" if results and heat_only else "# Hidden effects"
    lines = [title, "", HEAD.format(version=version, arguments=arguments), "", *overview(results), ""]
    for family in ALL.values():
        if members := [r for r in results if r["family"] == family.name]:
            lines += family_table(members, family)
    return "\n".join([*lines, *peer_table(results, peer), "## Cases", "", *cases_table(results), ""])


HEAD = """Written by `validation/hidden/suite.py`, version {version}, run with {arguments}.
Strips of `validation/hidden`, which share no code with the product, hide an effect. The product fits a base model to
its training runs, and `lce diagnose` says what is missing. An exact base holds the equations of the strip, an imperfect
one does not. `validation/hidden/effects.py` says which of the hidden effects have another form than in the library.
Each seed is other strips. Those of seeds 0 to 4 were used to mend the product, of the family skewed-relays those of
seed 9, and one case each after the pages of seeds 7, 10 and 11; a few of seeds 0 to 6, 9 and 11 are in the tests. A
seed by whose cases the product was mended is used up.
The `.jsonl` file beside this page holds what was noted of each case, in the order in which they ended.
Of each kind of case in each family, those judged are a fair sample. The command goes on with the rest as long as what
a case runs stays the same, a part of them with `--minutes` and `--only`; with `--fresh` it begins anew.

An effect is visible if it leaves at least half of a sensor's noise that the base cannot follow.
`validation/hidden/judge.py` defines that without the diagnosis. A false addition is an added effect that is not hidden
and whose set of aliases holds nothing hidden; where the base is exact, the advice of another one counts as well. The
independent strip has physics of its own beside what is hidden: to name one of those effects, even first, is no false
addition. An effect leads the ranking if nothing stands before it there, whether the verdict names it or not. "Outside
the library" hides what the product has no effect for. "Effect left out" hides an effect that was taken out of the
candidates. Intervals are Wilson's; that of the false additions is a Poisson count's.
Where the answer says to begin with another base model, what it names beside that one counts, and the error is that of
that one. Errors are in units of the noise that was put in; displacements within 0.25 s of a jump of the strip do not
count. In the table of all families, what misses its bar is bold."""
