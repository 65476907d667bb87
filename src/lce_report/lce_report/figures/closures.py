# SPDX-License-Identifier: Apache-2.0
"""An unknown function that was found: its curve with the formulas over it, and what every other one promised."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from lce_data.channels import DISPLACEMENT, TEMPERATURE
from lce_model.closures.forms import KNOTS, value
from lce_report.blocks import Axis, Block, Curve, Form, Grid, Heat, Lines, Role

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lce_analysis.discovery import Found
    from lce_analysis.discovery.closures import Examination, Examined
    from lce_analysis.discovery.formulas import Formula
    from lce_analysis.unknown_function import Candidate

Floats = NDArray[np.float64]

BAND: Final = 1.96
"""Standard errors that the band holds on either side."""
POINTS: Final = 200
"""Of a formula, over the range of the curve."""
VISIBLE: Final = 0.05
"""Share of the range of a formula that one sees in the figure."""
FEW_VALUES: Final = frozenset({"branch", "cycle"})
"""Covariates with nothing between their values, of which the figure draws points."""
FORMULA_ROLES: Final[tuple[Role, ...]] = ("model", "after", "input", "before", "residual")
"""Of the formulas that are drawn, the simplest; more colours could not be told apart."""
SCALES: Final = {"1": (100.0, "%"), "m": (1e6, "µm")}
"""From the unit of a place to that of the figure, where they differ."""
MISFIT_OF: Final = {"heat": "the temperature", "deformation": "the displacement", "both": "both sensors"}
"""In which sensors a part of the model shows."""


def found_function(found: Found) -> list[Block]:
    """The curve with its band over its covariate, the formulas over it and less it, and how to read that."""
    knots, candidate = found.curve.x, found.closure.candidate
    title = f"{found.name}: what is missing in {candidate.place.words}, over the {candidate.covariate.words}"
    curve = _figure(found, title, _drawn_at(candidate, knots), less_curve=False)
    if not found.formulas:
        return [_caption(found), curve]
    rest = _figure(found, "the formulas less the curve, at its knots", knots, less_curve=True)
    return [_caption(found), Grid([curve, rest], (3, 2))]


def overview(examination: Examination, found: Sequence[Found]) -> Heat:
    """The share of the squared error that each function promised, by covariate and place; what was found is framed.

    Of the time constants of a lag the likeliest is shown; the note of a cell has it, and the ln evidence.
    """
    best: dict[tuple[str, str], Examined] = {}
    for one in examination.examined:
        best.setdefault(_cell(one.candidate), one)
    places = list(dict.fromkeys(one.candidate.place.name for one in examination.examined))
    rows = list(dict.fromkeys(covariate for _, covariate in best))
    shares = [[_promised(best.get((place, row)), examination) for place in places] for row in rows]
    accepted = {_cell(one.closure.candidate) for one in found}
    return Heat(
        f"Squared error of {MISFIT_OF[examination.stage.part]} that a function promised to explain, before any refit",
        "covariate",
        [place.replace("_", " ") for place in places],
        [row.replace("_", " ") for row in rows],
        np.array(shares).reshape(len(rows), len(places)),
        notes=[[_note(best.get((place, row))) for place in places] for row in rows],
        framed=[(i, j) for i, row in enumerate(rows) for j, place in enumerate(places) if (place, row) in accepted],
    )


def _figure(found: Found, title: str, z: Floats, less_curve: bool) -> Lines:
    """The curve with its band, and the formulas, at values z (m,) of the covariate."""
    drawn, place = found.curve, found.closure.candidate.place
    scale, unit = SCALES.get(place.unit, (1.0, place.unit))
    y, width = (scale * np.interp(z, drawn.x, values) for values in (drawn.y, BAND * drawn.error))
    zero = y if less_curve else np.zeros_like(y)
    form: Form = "marked" if z.size <= KNOTS else "line"
    curves = [Curve("curve", y - zero, "measured", "line", y - zero - width, y - zero + width)]
    for formula, role in zip(found.formulas, FORMULA_ROLES, strict=False):
        curves.append(Curve(formula.expression, scale * formula_over_curve(formula, found, z) - zero, role, form))
    x_axis, x = _covariate(found.closure.candidate, z)
    y_axis = Axis("difference" if less_curve else f"missing in {place.words}", unit)
    return Lines(title, x_axis, y_axis, x, curves, linked=found.name, height=260)


def formula_over_curve(formula: Formula, found: Found, z: Floats) -> Floats:
    """(m,) the formula at values z (m,) of the covariate, in the unit of the place, laid over the drawn curve.

    The model absorbs a part of the formula as it does of the curve, so both are known but for that part: the formula
    is drawn less its own, and shifted (and tilted, where a straight line is absorbed) onto the curve.
    """
    drawn, own = found.curve, found.closure.examined.moments.visited
    seen = _seen(formula, found)
    if drawn.offset:
        line = np.column_stack([np.ones(own.size), drawn.x - drawn.x.mean()])[:, : 2 if drawn.slope else 1]
        weight = 1.0 / np.maximum(drawn.error, 1e-3 * float(np.max(drawn.error)) or 1.0)
        seen = seen + line @ np.linalg.lstsq(line * weight[:, None], (drawn.y - seen) * weight, rcond=None)[0]
    return _values(formula, z) + np.interp(z, drawn.x, seen - _values(formula, drawn.x))


def _seen(formula: Formula, found: Found) -> Floats:
    """(k,) the formula at the knots that the data visited, less what the model absorbs of it."""
    moments = found.closure.examined.moments
    return np.asarray((moments.seen @ _values(formula, moments.candidate.knots))[moments.visited])


def _values(formula: Formula, z: Floats) -> Floats:
    """(m,) the formula at z (m,), with the numbers of its refit."""
    candidate = formula.candidate
    numbers = {name: number for name, number, _ in formula.values}
    a, b, ends = numbers.get("a", 1.0), numbers.get("b", 0.0), (candidate.lower, candidate.upper)
    none = np.zeros(2)
    return numbers["c"] * np.array([value(formula.number, x, candidate.reference, a, b, *ends, none) for x in z])


def _drawn_at(candidate: Candidate, knots: Floats) -> Floats:
    """Values of the covariate from the first knot that the data visited to the last."""
    if candidate.covariate.name in FEW_VALUES:
        return knots
    return np.unique(np.concatenate([knots, np.linspace(knots[0], knots[-1], POINTS)]))


def _covariate(candidate: Candidate, z: Floats) -> tuple[Axis, Floats]:
    """The axis of a covariate, and its values [SI] in the unit of the axis."""
    of = candidate.covariate
    lag = "" if candidate.tau_s is None else f" (lag {candidate.tau_s:g} s)"
    if of.name == "temperature":
        return Axis(of.words, TEMPERATURE.display.symbol), TEMPERATURE.display.from_si(z)
    if of.unit == "m":
        return Axis(f"{of.words}{lag}", DISPLACEMENT.display.symbol), DISPLACEMENT.display.from_si(z)
    return Axis(f"{of.words}{lag}", of.unit, whole=of.name in FEW_VALUES), z


def _caption(found: Found) -> str:
    """What the figure shows, and what of it is not known."""
    drawn = found.curve
    told = f"The band holds ±{BAND:g} standard errors. The figure ends where the data end."
    if drawn.offset:
        part = "a constant and a straight line" if drawn.slope else "a constant"
        told += (
            f" The model without the function absorbs {part} over this covariate, so that part of the function is not "
            "known: the curve is drawn so that it begins with nothing, and each formula is laid over it."
        )
    elif any(_is_absorbed(formula, found) for formula in found.formulas):
        told += (
            " The model without the function absorbs a part of it, by other values of its own parameters. Curve and "
            "formulas are drawn less that part."
        )
    if not found.formulas:
        told += " No formula of the dictionary describes the curve as well as the curve does itself."
    elif len(found.formulas) > len(FORMULA_ROLES):
        told += f" Of {len(found.formulas)} formulas the {len(FORMULA_ROLES)} simplest are drawn."
    return told


def _is_absorbed(formula: Formula, found: Found) -> bool:
    """Does the model absorb a part of the formula that one would see in the figure?"""
    whole = _values(formula, found.curve.x)
    return float(np.ptp(whole - _seen(formula, found))) > VISIBLE * float(np.ptp(whole))


def _cell(candidate: Candidate) -> tuple[str, str]:
    return candidate.place.name, candidate.covariate.name


def _promised(one: Examined | None, examination: Examination) -> float:
    return float("nan") if one is None else max(one.gain, 0.0) / examination.error


def _note(one: Examined | None) -> str:
    if one is None:
        return ""
    lag = "" if one.candidate.tau_s is None else f", lag {one.candidate.tau_s:g} s"
    return f"ln evidence {one.ln_evidence:.4g}{lag}"
