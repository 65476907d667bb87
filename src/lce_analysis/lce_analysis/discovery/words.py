# SPDX-License-Identifier: Apache-2.0
"""What was discovered, in sentences; none says more than its table."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lce_analysis.diagnosis.words import outcome
from lce_model.closures.covariates import NUMBER

if TYPE_CHECKING:
    from collections.abc import Iterator

    from lce_analysis.discovery.discover import Discovery, Found
    from lce_analysis.unknown_function import Candidate

MEMORIES = frozenset({"time", "dose", "path", "cycle"})
"""Covariates that only ever grow, as every slow memory seems to do in runs of one kind."""


LISTED = 3
"""Formulas in the sentence, at most."""


def in_words(found: Discovery) -> Iterator[str]:
    """What was found, what it may be confused with, what the residual shows, and what to do next."""
    for one in found.found:
        yield from _of_function(one)
    # A function that was found says already which covariate the residual follows.
    seen = [one for one in found.signatures if one.outside or not found.found]
    yield from (_sentence(signature.words) for signature in seen)
    if not found.found:
        yield from _nothing(found)
    yield from (_sentence(walk.words) for walk in found.walks)
    if found.heat_unexplained:
        yield "The deformation was not searched, as the heat does not explain the temperature."
    if found.found and found.largest > found.explained:
        yield f"Much is left: {found.largest:.1f} × the noise. What was found may stand in for something else."


def _of_function(one: Found) -> Iterator[str]:
    closure = one.closure
    yield _sentence(one.curve.words)
    if closure.held_out is not None:
        yield f"It is {outcome(closure.held_out, '')}."
    others = list(dict.fromkeys(_pair(c) for c in closure.alike if _pair(c) != _pair(closure.candidate)))
    if others:
        yield f"These data cannot tell it from {'; '.join(others)}."
    if MEMORIES & {c.covariate.name for c in closure.alike}:
        yield "Runs with a rest, or in another order, would tell a slow memory from time, dose, path and cycle."
    if one.formulas:
        listed = [f"{f.expression} ({f.form.name})" for f in one.formulas]
        if len(listed) > LISTED:
            listed = [*listed[: LISTED - 1], f"one of {len(listed) - LISTED + 1} other formulas"]
        if len(listed) == 1:
            yield f"It is {listed[0]}."
        else:
            yield f"It may be {', '.join(listed[:-1])} or {listed[-1]}: they describe the curve equally well."
    else:
        yield "No formula of the dictionary describes the curve as well; the effect file holds the curve."


def _sentence(words: str) -> str:
    return f"{words[0].upper()}{words[1:]}."


def _pair(candidate: Candidate) -> str:
    name = candidate.covariate.published.replace("_", " ")
    return f"{candidate.place.words} over {name}"


def _nothing(found: Discovery) -> Iterator[str]:
    if found.largest <= found.explained:
        yield f"Nothing is left to be found: the model leaves {found.largest:.2f} × the noise."
        return
    yield (
        f"No function of one covariate explains what is left, {found.largest:.1f} × the noise: "
        f"{len(NUMBER)} covariates were examined at every place of the model."
    )
