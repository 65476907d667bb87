# SPDX-License-Identifier: Apache-2.0
"""Which formulas describe a curve: a dictionary of forms fitted to it, the best refitted in full.

A form f with its numbers is as good as the direction Σ f(z_k) g_k of the examination: it promises (f·b)²/(fᵀAf). A and b
hold what the free parameters of the model can absorb, and how well the data determine each part of the curve.
"""

import itertools
import math
from dataclasses import dataclass, replace
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from lce_analysis.diagnosis.linearized_fit import LinearizedFit, refit
from lce_analysis.discovery.closure import Closure
from lce_analysis.discovery.closures import Candidate
from lce_analysis.identification.parallel import each
from lce_analysis.options import DiscoverOptions
from lce_data.progress import Progress
from lce_model import Model
from lce_model.closures.forms import FORMS, Form, Meaning, value

Floats = NDArray[np.float64]
Numbers = dict[str, float]

NO_CURVE: Final = np.zeros(2)
ITERATIONS: Final = 25
PRICE: Final = 2.0
"""Of a number more, in units of the variance (Akaike's)."""
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


def formulas(closure: Closure, variance: float, options: DiscoverOptions, progress: Progress) -> tuple[Formula, ...]:
    """The formulas that describe the curve as well as the data can tell, the best first; empty if none does.

    variance : s² of the examination.
    """
    promising = sorted(_promised(closure), key=lambda p: PRICE * len(p[2]) - p[0] / variance)[: options.forms]
    tasks = [partial(_refitted, closure, number, numbers, variance) for _, number, numbers in promising]
    found = sorted(each(tasks, "formulas", progress), key=lambda f: f.score)
    allowed = 2.0 * math.log(options.diagnosis.min_likelihood_ratio)
    enough = [f for f in found if f.gain >= options.alike * closure.gain]
    return tuple(f for f in enough if f.score - enough[0].score < allowed)


def _promised(closure: Closure) -> list[tuple[float, int, Numbers]]:
    """What each form promises at its best numbers: the gain, the number of the form, a and b."""
    candidate, moments = closure.candidate, closure.examined.moments
    gram, moment = moments.gram, moments.moment

    def gain(number: int, numbers: Numbers) -> float:
        values = _at_knots(number, candidate, numbers)
        energy = float(values @ gram @ values)
        seen = energy > 1e-9 * float(values @ moments.before @ values)
        return float(values @ moment) ** 2 / energy if seen and np.isfinite(energy) else 0.0

    found = []
    for number, form in enumerate(FORMS, start=1):
        if "z0" in form.arguments and candidate.covariate.name != "temperature":
            continue
        tried = [dict(zip(form.numbers, point, strict=True)) for point in itertools.product(*_grid(form, candidate))]
        best = max(tried, key=partial(gain, number))
        if best:
            best = _polished(partial(gain, number), best, candidate, form)
        found.append((gain(number, best), number, best))
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


def _polished(gain: partial[float], first: Numbers, candidate: Candidate, form: Form) -> Numbers:
    """The numbers at the nearest maximum of the gain."""
    names = list(first)
    bounds = [bounds_of(form.numbers[name], candidate) for name in names]
    found = minimize(
        lambda x: -gain(dict(zip(names, x.tolist(), strict=True))),
        [first[name] for name in names],
        method="Nelder-Mead",
        bounds=bounds,
        options={"maxiter": 200},
    )
    return dict(zip(names, found.x.tolist(), strict=True))


def _refitted(closure: Closure, number: int, numbers: Numbers, variance: float, progress: Progress) -> Formula:
    """The model refitted with the form instead of the curve."""
    candidate, base = closure.candidate, closure.stage.fit.problem
    form, term = FORMS[number - 1], candidate.term
    strength = _strength(closure, number, numbers)
    chosen = {"form": float(number), "strength": strength, **numbers}
    model = closure.fit.problem.model.set(dict.fromkeys(candidate.weights, 0.0))
    held = {"strength": (-ROOM * abs(strength), ROOM * abs(strength))}
    held |= {name: bounds_of(meaning, candidate) for name, meaning in form.numbers.items()}
    if candidate.tau_s is not None:
        held["tau"] = candidate.tau_s / 4.0, candidate.tau_s * 4.0
    model = model.hold({f"{term}.{name}": limits for name, limits in held.items()})
    model = model.set({f"{term}.{name}": x for name, x in chosen.items()})
    free = tuple(sorted({*base.free, *(model.index(f"{term}.{name}") for name in held)}))
    fit = refit(replace(base, model=model, free=free), f"as {form.name}", progress, ITERATIONS, 1e-4)
    price = PRICE * (len(free) - len(base.free))
    return Formula(candidate, number, fit, closure.stage.fit.error - fit.error, fit.error / variance + price)


def _strength(closure: Closure, number: int, numbers: Numbers) -> float:
    """Where the refit begins: the strength that promises most."""
    moments, values = closure.examined.moments, _at_knots(number, closure.candidate, numbers)
    return float(values @ moments.moment) / float(values @ moments.gram @ values)


def with_formula(model: Model, formula: Formula) -> Model:
    """The model with the values that the refit of the formula gave."""
    return model.set({v.key: v.value for v in formula.fit.problem.model.values if v.key in model})
