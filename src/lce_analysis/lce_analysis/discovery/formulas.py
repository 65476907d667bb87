# SPDX-License-Identifier: Apache-2.0
"""Which formulas describe a curve: a dictionary of forms fitted to it, the best refitted in full.

A form f with its numbers is as good as the direction Σ f(z_k) g_k at the refitted curve w: c f leaves an error larger
by (w - c f)ᵀA(w - c f). A holds what the free parameters of the model can absorb, and how well the data determine each
part of the curve.
"""

import itertools
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from lce_analysis.diagnosis.linearized_fit import LinearizedFit, refit
from lce_analysis.discovery.closure import Closure, curve_held
from lce_analysis.discovery.closures import Examination, Projected
from lce_analysis.identification.parallel import each
from lce_analysis.identification.problem import Problem
from lce_analysis.options import DiscoverOptions
from lce_analysis.unknown_function import Candidate
from lce_data.progress import Progress
from lce_model import Model
from lce_model.closures.forms import FORMS, Form, Meaning, value

Floats = NDArray[np.float64]
Numbers = dict[str, float]
Promise = tuple[float, int, Numbers]
"""What a form promises: the squared error that it leaves more than the curve, its number, a and b."""

NO_CURVE: Final = np.zeros(2)
ITERATIONS: Final = 40
TOLERANCE: Final = 1e-5
SYMBOLS: Final[dict[str, str]] = {
    "temperature": "T",
    "rate": "dT/dt",
    "power": "P",
    "order": "Q",
    "displacement": "d",
    "time": "t",
    "dose": "E",
    "path": "s",
    "branch": "sign(dT/dt)",
    "cycle": "n",
    "lagged_temperature": "T - lag(T, tau)",
    "lagged_power": "P - lag(P, tau)",
    "lagged_displacement": "d - lag(d, tau)",
    "late_power": "lag(P, tau)",
    "displacement_path": "s",
}
"""How formulas write a covariate."""
PRICE: Final = 2.0
"""Of a number more, in units of the variance (Akaike's)."""
SAME: Final = 1.0 - 1e-9
"""Correlation of two curves that are one."""
SEEN: Final = 1e-5
"""Share of the energy of a form below which the model absorbs it."""
ROOM: Final = 100.0
"""The strength may become so many times what was promised."""


@dataclass(frozen=True)
class Formula:
    """A form refitted in the place of the curve.

    number : of the form in the dictionary, from 1.
    fit : the refit, with its strength and numbers among the free parameters.
    gain : of the squared error, in units of the noise.
    score : squared error in units of the variance, with a price for each number: the least is the best.
    """

    candidate: Candidate
    number: int
    fit: LinearizedFit
    gain: float
    score: float

    @property
    def form(self) -> Form:
        """Which form."""
        return FORMS[self.number - 1]

    @property
    def expression(self) -> str:
        """The formula of the covariate: "c (T - T_env)^2"."""
        symbol = SYMBOLS[self.candidate.covariate.name]
        alone = "T - T_env" if symbol == "T" else symbol
        inside = f"({alone})" if " " in alone else alone
        text = self.form.expression
        for written, meant in (("|x|", f"|{alone}|"), ("(x)", f"({alone})")):
            text = text.replace(written, meant)
        for written, meant in (("x", inside), ("z0", "T_env"), ("z", symbol)):
            text = re.sub(rf"\b{written}\b", meant, text)
        return f"c ({text})" if " - " in self.form.expression or " + " in self.form.expression else f"c {text}"

    @property
    def parameters(self) -> tuple[str, ...]:
        """TERM.PARAM of what the form has: its strength, its numbers, and the time constant of the lag."""
        names = ["strength", *self.form.numbers, *(["tau"] if self.candidate.covariate.lagged else [])]
        return tuple(f"{self.candidate.term}.{name}" for name in names)

    @property
    def values(self) -> tuple[tuple[str, float, float | None], ...]:
        """Name, value and standard error of each of them; "c" is the strength."""
        problem, variance = self.fit.problem, self.fit.error / self.fit.residual.size
        gram = self.fit.jacobian.T @ self.fit.jacobian
        errors = np.sqrt(np.maximum(np.diag(np.linalg.pinv(gram, hermitian=True)) * variance, 0.0))
        found = []
        for key in self.parameters:
            place, name = problem.free.index(problem.model.index(key)), key.partition(".")[2]
            error = float(abs(problem.slopes[place]) * errors[place])
            found.append(("c" if name == "strength" else name, problem.model[key], error))
        return tuple(found)


def formulas(
    closure: Closure, examination: Examination, options: DiscoverOptions, progress: Progress
) -> tuple[Formula, ...]:
    """The formulas that describe the curve as well as the data can tell, the simplest first; empty if none does."""
    near = _Near.of(closure)
    promising = _different(closure.candidate, sorted(_promised(near), key=lambda p: _score(p, examination.variance)))
    promising = promising[: options.forms]
    tasks = [partial(_refitted, near, examination.variance, number, numbers) for _, number, numbers in promising]
    enough = [f for f in each(tasks, "formulas", progress) if f.gain >= options.alike * closure.gain]
    allowed = min((f.score for f in enough), default=0.0) + 2.0 * math.log(options.diagnosis.min_likelihood_ratio)
    return tuple(sorted((f for f in enough if f.score < allowed), key=lambda f: (len(f.form.numbers), f.score)))


def _score(promise: Promise, variance: float) -> float:
    lost, _, numbers = promise
    return PRICE * len(numbers) + lost / variance


def _different(candidate: Candidate, promises: Sequence[Promise]) -> list[Promise]:
    """Without the forms that are in these data the same curve as a better one."""
    found: list[Promise] = []
    curves: list[Floats] = []
    for promise in promises:
        curve = _at_knots(promise[1], candidate, promise[2])
        curve = curve / max(float(np.linalg.norm(curve)), 1e-300)
        if all(abs(float(curve @ other)) < SAME for other in curves):
            found.append(promise)
            curves.append(curve)
    return found


@dataclass(frozen=True)
class _Near:
    """The model linearised at the refitted curve.

    fit : with the curve held. directions : (K, N) of its knots. gram : (K, K) A. moment : (K,) A w, and what is left.
    """

    closure: Closure
    fit: LinearizedFit
    directions: Floats
    gram: Floats
    moment: Floats

    @classmethod
    def of(cls, closure: Closure) -> "_Near":
        fit = curve_held(closure)
        projected = Projected.of(fit)
        directions = projected.directions(closure.candidate)
        left = projected.without_free(directions)
        gram = left @ left.T
        return cls(closure, fit, directions, gram, gram @ closure.weights + left @ projected.rest)

    def strength(self, values: Floats) -> float:
        """The best factor of a form with these values (K,) at the knots; 0 where the model absorbs it."""
        energy = float(values @ self.gram @ values)
        seen = np.isfinite(energy) and energy > SEEN * float(np.sum((values @ self.directions) ** 2))
        return float(values @ self.moment) / energy if seen else 0.0

    def lost(self, values: Floats) -> float:
        """What the best multiple of these values leaves more than the curve."""
        change = self.strength(values) * values - self.closure.weights
        return float(change @ self.gram @ change - 2.0 * change @ (self.moment - self.gram @ self.closure.weights))


def _promised(near: _Near) -> list[Promise]:
    """What each form leaves at its best numbers."""
    candidate = near.closure.candidate

    def lost(number: int, numbers: Numbers) -> float:
        return near.lost(_at_knots(number, candidate, numbers))

    found = []
    for number, form in enumerate(FORMS, start=1):
        if "z0" in form.arguments and candidate.covariate.name != "temperature":
            continue
        tried = [dict(zip(form.numbers, point, strict=True)) for point in itertools.product(*_grid(form, candidate))]
        best = min(tried, key=partial(lost, number))
        if best:
            best = _polished(partial(lost, number), best, candidate, form)
        found.append((lost(number, best), number, best))
    return found


def _at_knots(number: int, candidate: Candidate, numbers: Numbers) -> Floats:
    """(K,) the form at the knots of the curve."""
    a, b, ends = numbers.get("a", 1.0), numbers.get("b", 0.0), (candidate.lower, candidate.upper)
    return np.array([value(float(number), z, candidate.reference, a, b, *ends, NO_CURVE) for z in candidate.knots])


def bounds_of(meaning: Meaning, candidate: Candidate) -> tuple[float, float]:
    """Between which values a number of a form makes sense in these data."""
    extent = candidate.upper - candidate.lower
    return {
        "place": (candidate.lower - candidate.reference, candidate.upper - candidate.reference),
        "width": (extent / 30.0, 10.0 * extent),
        "exponent": (0.2, 8.0),
        "period": (extent / 20.0, 4.0 * extent),
        "activation": (100.0, 2e4),
    }[meaning]


def _grid(form: Form, candidate: Candidate) -> list[Floats]:
    found = []
    for meaning in form.numbers.values():
        lower, upper = bounds_of(meaning, candidate)
        linear = meaning == "place"
        found.append(np.linspace(lower, upper, 17)[1:-1] if linear else np.geomspace(lower, upper, 15))
    return found


def _polished(lost: partial[float], first: Numbers, candidate: Candidate, form: Form) -> Numbers:
    """The numbers at the nearest minimum of what is lost."""
    names = list(first)
    bounds = [bounds_of(form.numbers[name], candidate) for name in names]

    def of(numbers: Floats) -> float:
        return lost(dict(zip(names, numbers.tolist(), strict=True)))

    start = np.array([first[name] for name in names])
    found = minimize(of, start, method="Nelder-Mead", bounds=bounds, options={"maxiter": 200})
    return dict(zip(names, found.x.tolist(), strict=True))


def _refitted(near: _Near, variance: float, number: int, numbers: Numbers, progress: Progress) -> Formula:
    """The model refitted with the form instead of the curve."""
    candidate, base = near.closure.candidate, near.closure.stage.fit
    form, term = FORMS[number - 1], candidate.term
    values = _at_knots(number, candidate, numbers)
    strength = near.strength(values)
    settings = {"form": float(number), "strength": strength, **numbers}
    start = _beside(near, strength * values, {f"{term}.{name}": x for name, x in settings.items()})
    held = {"strength": (-ROOM * abs(strength), ROOM * abs(strength))}
    held |= {name: bounds_of(meaning, candidate) for name, meaning in form.numbers.items()}
    if candidate.tau_s is not None:
        held["tau"] = candidate.tau_s / 4.0, candidate.tau_s * 4.0
    model = start.model.hold({f"{term}.{name}": limits for name, limits in held.items()})
    free = tuple(sorted({*start.free, *(model.index(f"{term}.{name}") for name in held)}))
    fit = refit(replace(start, model=model, free=free), f"as {form.name}", progress, ITERATIONS, TOLERANCE)
    price = PRICE * (len(free) - len(start.free))
    return Formula(candidate, number, fit, base.error - fit.error, fit.error / variance + price)


def _beside(near: _Near, values: Floats, settings: dict[str, float]) -> Problem:
    """The problem with the form set, its free parameters where they make room for what they absorb of it.

    values : (K,) the form at the knots. Of a few lengths of the step the best is taken.
    """
    change = (values - near.closure.weights) @ near.directions
    shift = -np.linalg.lstsq(near.fit.jacobian, near.fit.residual + change, rcond=1e-8)[0]
    variables = near.fit.problem.first()
    tried = [near.fit.problem.at(variables + length * shift) for length in (1.0, 0.3, 0.1, 0.0)]
    tried = [replace(problem, model=problem.model.set(settings)) for problem in tried]
    errors = [float(np.sum(np.nan_to_num(p.residuals(p.first()), nan=1e9) ** 2)) for p in tried]
    return tried[int(np.argmin(errors))]


def with_formula(model: Model, formula: Formula) -> Model:
    """The model, which holds the closure, with the values and bounds that the refit of the formula gave."""
    found = {v.key: v for v in formula.fit.problem.model.values}
    return model.with_values(tuple(found.get(v.key, v) for v in model.values), model.fit)
