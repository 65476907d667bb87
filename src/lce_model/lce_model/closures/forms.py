# SPDX-License-Identifier: Apache-2.0
"""The forms that an unknown function may have: a curve through knots, and a dictionary of formulas.

A formula c f(x; a, b) is of x = z - z0: the covariate z less its reference z0, for a temperature that of the
surroundings, else 0. Its strength c carries the unit of the place; a and b are its numbers, if it has any.
"""

import inspect
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Meaning = Literal["place", "width", "exponent", "period", "activation"]
"""What a number of a form means: a value of x, a width of x, an exponent, a period of x, or an activation in kelvin."""
KNOTS: Final = 8
"""Knots of the curve, evenly between its ends."""
CURVE: Final = 0
"""Number of the curve; the formulas of FORMS count from 1."""


@register_jitable
def constant(x: float) -> float:
    """1."""
    return 1.0


@register_jitable
def linear(x: float) -> float:
    """x."""
    return x


@register_jitable
def quadratic(x: float) -> float:
    """x^2."""
    return x * x


@register_jitable
def cubic(x: float) -> float:
    """x^3."""
    return x**3


@register_jitable
def power(x: float, a: float) -> float:
    """|x|^a sign(x)."""
    return math.copysign(abs(x) ** a, x)


@register_jitable
def fourth_power(z: float, z0: float) -> float:
    """z^4 - z0^4."""
    return z**4 - z0**4


@register_jitable
def magnitude(x: float) -> float:
    """|x|."""
    return abs(x)


@register_jitable
def sign(x: float) -> float:
    """sign(x)."""
    return 0.0 if x == 0.0 else math.copysign(1.0, x)


@register_jitable
def exponential(x: float, a: float) -> float:
    """exp(x/a) - 1."""
    return math.expm1(min(x / a, 50.0))


@register_jitable
def saturation(x: float, a: float) -> float:
    """1 - exp(-x/a)."""
    return -math.expm1(min(-x / a, 50.0))


@register_jitable
def stretched_saturation(x: float, a: float, b: float) -> float:
    """1 - exp(-(|x|/a)^b)."""
    return -math.expm1(-((abs(x) / a) ** b))


@register_jitable
def hyperbolic(x: float, a: float) -> float:
    """x/(a + |x|)."""
    return x / (a + abs(x))


@register_jitable
def tanh(x: float, a: float) -> float:
    """tanh(x/a)."""
    return math.tanh(x / a)


@register_jitable
def arctangent(x: float, a: float) -> float:
    """arctan(x/a)."""
    return math.atan(x / a)


@register_jitable
def logarithm(x: float, a: float) -> float:
    """ln(1 + |x|/a) sign(x)."""
    return math.copysign(math.log1p(abs(x) / a), x)


@register_jitable
def inverse(x: float, a: float) -> float:
    """1/(1 + |x|/a)."""
    return 1.0 / (1.0 + abs(x) / a)


@register_jitable
def resonance(x: float, a: float) -> float:
    """x/(1 + (x/a)^2)."""
    return x / (1.0 + (x / a) ** 2)


@register_jitable
def sigmoid(x: float, a: float, b: float) -> float:
    """1/(1 + exp(-(x - b)/a))."""
    return 0.5 * (1.0 + math.tanh(0.5 * (x - b) / a))


@register_jitable
def bell(x: float, a: float, b: float) -> float:
    """exp(-((x - b)/a)^2/2)."""
    return math.exp(-0.5 * ((x - b) / a) ** 2)


@register_jitable
def lorentzian(x: float, a: float, b: float) -> float:
    """1/(1 + ((x - b)/a)^2)."""
    return 1.0 / (1.0 + ((x - b) / a) ** 2)


@register_jitable
def bell_slope(x: float, a: float, b: float) -> float:
    """-(x - b)/a exp(-((x - b)/a)^2/2)."""
    return -(x - b) / a * math.exp(-0.5 * ((x - b) / a) ** 2)


@register_jitable
def threshold(x: float, b: float) -> float:
    """max(x - b, 0)."""
    return max(x - b, 0.0)


@register_jitable
def threshold_squared(x: float, b: float) -> float:
    """max(x - b, 0)^2."""
    return max(x - b, 0.0) ** 2


@register_jitable
def ceiling(x: float, b: float) -> float:
    """min(x, b)."""
    return min(x, b)


@register_jitable
def dead_zone(x: float, a: float) -> float:
    """sign(x) max(|x| - a, 0)."""
    return math.copysign(max(abs(x) - a, 0.0), x)


@register_jitable
def step_at(x: float, b: float) -> float:
    """1 where x > b, else 0."""
    return 1.0 if x > b else 0.0


@register_jitable
def sine(x: float, a: float) -> float:
    """sin(2 pi x/a)."""
    return math.sin(2.0 * math.pi * x / a)


@register_jitable
def cosine(x: float, a: float) -> float:
    """cos(2 pi x/a)."""
    return math.cos(2.0 * math.pi * x / a)


@register_jitable
def arrhenius(z: float, z0: float, a: float) -> float:
    """exp(a (1/z0 - 1/z)) - 1."""
    return math.expm1(min(a * (1.0 / z0 - 1.0 / z), 50.0))


@register_jitable
def ramp_and_hold(x: float, a: float, b: float) -> float:
    """min(max(x - b, 0)/a, 1)."""
    return min(max(x - b, 0.0) / a, 1.0)


@dataclass(frozen=True)
class Form:
    """A formula.

    function : of x, z, z0, a and b, as far as it needs them.
    numbers : what a and b mean, by name.
    """

    function: Callable[..., float]
    numbers: dict[str, Meaning]

    @property
    def name(self) -> str:
        """Its name."""
        return self.function.__name__

    @property
    def expression(self) -> str:
        """The formula as text, of x, z, z0, a and b."""
        return (inspect.getdoc(self.function) or "").rstrip(".")

    @property
    def arguments(self) -> tuple[str, ...]:
        """What it takes."""
        return tuple(inspect.signature(self.function).parameters)


FORMS: Final[tuple[Form, ...]] = (
    Form(constant, {}),
    Form(linear, {}),
    Form(quadratic, {}),
    Form(cubic, {}),
    Form(power, {"a": "exponent"}),
    Form(fourth_power, {}),
    Form(magnitude, {}),
    Form(sign, {}),
    Form(exponential, {"a": "width"}),
    Form(saturation, {"a": "width"}),
    Form(stretched_saturation, {"a": "width", "b": "exponent"}),
    Form(hyperbolic, {"a": "width"}),
    Form(tanh, {"a": "width"}),
    Form(arctangent, {"a": "width"}),
    Form(logarithm, {"a": "width"}),
    Form(inverse, {"a": "width"}),
    Form(resonance, {"a": "width"}),
    Form(sigmoid, {"a": "width", "b": "place"}),
    Form(bell, {"a": "width", "b": "place"}),
    Form(lorentzian, {"a": "width", "b": "place"}),
    Form(bell_slope, {"a": "width", "b": "place"}),
    Form(threshold, {"b": "place"}),
    Form(threshold_squared, {"b": "place"}),
    Form(ceiling, {"b": "place"}),
    Form(dead_zone, {"a": "width"}),
    Form(step_at, {"b": "place"}),
    Form(sine, {"a": "period"}),
    Form(cosine, {"a": "period"}),
    Form(arrhenius, {"a": "activation"}),
    Form(ramp_and_hold, {"a": "width", "b": "place"}),
)
"""The dictionary, each after the number of the one before."""


@register_jitable
def value(form: float, z: float, z0: float, a: float, b: float, lower: float, upper: float, w: Floats) -> float:
    """The form of this number at the covariate z; 0 where z is not known.

    The curve has the values w (KNOTS,) at knots evenly between ``lower`` and ``upper``, and those of its ends beyond.
    """
    if math.isnan(z):
        return 0.0
    if form == 0.0:
        at = min(max((z - lower) / (upper - lower), 0.0), 1.0) * (w.size - 1)
        i = min(int(at), w.size - 2)
        return float(w[i] + (at - i) * (w[i + 1] - w[i]))
    x = z - z0
    result = 0.0
    if form == 1.0:
        result = constant(x)
    elif form == 2.0:
        result = linear(x)
    elif form == 3.0:
        result = quadratic(x)
    elif form == 4.0:
        result = cubic(x)
    elif form == 5.0:
        result = power(x, a)
    elif form == 6.0:
        result = fourth_power(z, z0)
    elif form == 7.0:
        result = magnitude(x)
    elif form == 8.0:
        result = sign(x)
    elif form == 9.0:
        result = exponential(x, a)
    elif form == 10.0:
        result = saturation(x, a)
    elif form == 11.0:
        result = stretched_saturation(x, a, b)
    elif form == 12.0:
        result = hyperbolic(x, a)
    elif form == 13.0:
        result = tanh(x, a)
    elif form == 14.0:
        result = arctangent(x, a)
    elif form == 15.0:
        result = logarithm(x, a)
    elif form == 16.0:
        result = inverse(x, a)
    elif form == 17.0:
        result = resonance(x, a)
    elif form == 18.0:
        result = sigmoid(x, a, b)
    elif form == 19.0:
        result = bell(x, a, b)
    elif form == 20.0:
        result = lorentzian(x, a, b)
    elif form == 21.0:
        result = bell_slope(x, a, b)
    elif form == 22.0:
        result = threshold(x, b)
    elif form == 23.0:
        result = threshold_squared(x, b)
    elif form == 24.0:
        result = ceiling(x, b)
    elif form == 25.0:
        result = dead_zone(x, a)
    elif form == 26.0:
        result = step_at(x, b)
    elif form == 27.0:
        result = sine(x, a)
    elif form == 28.0:
        result = cosine(x, a)
    elif form == 29.0:
        result = arrhenius(z, z0, a)
    elif form == 30.0:
        result = ramp_and_hold(x, a, b)
    return result
