# SPDX-License-Identifier: Apache-2.0
"""What a model is made of: terms, each with its parameters, and the signals that they pass on.

A term is one small physical statement. Its ``step`` is a plain function of floats, and its arguments are bound *by
name* to the signals below, to the term's own parameters and states, to ``dt`` [s], and to the columns ``input_NAME`` of
a run. What it returns is assigned, in order, to ``states + outputs``. A model is a tuple of terms, evaluated in that
order once per sample; see :mod:`lce_model.kernel.compose` for how the tuple becomes one compiled loop.
"""

import inspect
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Final, Literal, get_args

from lce_data.channels import INPUTS, NAMED_INPUT, SENSORS, Channel, in_order, named_input
from lce_data.errors import LceError

Stage = Literal["surroundings", "light", "heat", "order", "strain", "sensor"]
STAGES: Final[tuple[Stage, ...]] = get_args(Stage)

SIGNALS: Final[dict[str, str]] = {
    "elapsed_time": "s, time since the beginning of the run, at the end of the step",
    "power": "W, laser power held over the step",
    "light": "W, power that counts as light on the strip, after effects of the light",
    "ambient": "K, temperature of the surroundings, mean over the step",
    "rest_temperature": "K, temperature of the surroundings when the run began; of the strip without a heat balance",
    "heating": "K/s, heating rate added by effects of the heat balance",
    "heat_capacity": "1, heat capacity after effects, in units of that of the heat balance",
    "temperature": "K, temperature of the strip at the end of the step",
    "temperature_before": "K, the same at its beginning",
    "temperature_midway": "K, the same in its middle, extrapolated with the rate of the step before",
    "warming": "K/s, mean rate of the temperature over the step",
    "loss_rate": "1/s, rate at which the heat balance loses the excess over the surroundings",
    "order_temperature": "K, temperature that the order follows",
    "transition_spread": "K, standard deviation of the transition temperature over the domains, from effects",
    "deadband": "K, reversals of the temperature smaller than this are taken for noise",
    "direction": "+1 on the heating branch, -1 on the cooling branch",
    "path_from": "K, beginning of the part of the temperature path that this step adds",
    "path_to": "K, its end",
    "fraction": "1, share x of the molecules in the nematic well",
    "well_order": "1, order parameter Q3 of the nematic well",
    "order": "1, mean order parameter, fraction * well_order (4.8)",
    "reference_order": "1, mean order parameter at which the stretch is 1",
    "stretch": "1, deformation coefficient lambda (3.1)",
    "displacement": "m, contraction of the strip, positive upwards (6.8)",
    **{
        channel.sets: f"{channel.unit}, {channel.name} as measured, at the end of the step; NaN where it is not known"
        for channel in INPUTS
        if channel.sets is not None
    },
} | {
    channel.output: f"{channel.unit}, {channel.name} that a sensor without noise reports, after effects of the sensor"
    for channel in SENSORS
    if channel.output is not None
}
"""Every quantity that terms can read or write, with its unit. Each optional input adds its own, and each sensor
(:mod:`lce_data.channels`)."""

SENSOR_INPUT: Final[dict[str, str | None]] = {
    channel.output: channel.name if channel.name in SIGNALS else None
    for channel in SENSORS
    if channel.output is not None
}
"""The signal that a sensor measures, which has the name of its channel, by the signal that it reports. None where the
model has no such signal; that sensor reports NaN unless a term writes what it reports."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """A physical parameter of a term, in the unit that it has in the equation.

    ``scale`` is the axis on which the parameter is searched: linear, logarithmic, or, for a strength that may well be
    zero, linear up to ``knee`` and logarithmic beyond (asinh(p/knee)). ``fixed`` marks what a fit leaves alone by
    default (geometry, references).

    ``lower`` and ``upper`` are where it is searched unless a model has other bounds; :attr:`least` is what no bounds
    may go below. ``usual`` is where the first guesses of a search are drawn from, the bounds if it is None.
    """

    name: str
    unit: str
    default: float
    lower: float
    upper: float
    description: str
    source: str
    scale: Literal["linear", "log", "asinh"] = "linear"
    knee: float = 0.0
    fixed: bool = False
    usual: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if not self.name.isidentifier() or self.name in SIGNALS or self.name == "dt":
            raise LceError(f"parameter name {self.name!r}: not an identifier, or the name of a signal")
        if not (math.isfinite(self.lower) and math.isfinite(self.upper) and self.lower < self.upper):
            raise LceError(f"parameter {self.name}: bounds [{self.lower:g}, {self.upper:g}] are not an interval")
        if self.scale == "log" and self.lower <= 0.0:
            raise LceError(f"parameter {self.name}: a log scale needs a positive lower bound, not {self.lower:g}")
        if (self.scale == "asinh") != (self.knee > 0.0):
            raise LceError(f"parameter {self.name}: a knee goes with the asinh scale, and is positive")
        if self.usual is not None and not self.lower <= self.usual[0] < self.usual[1] <= self.upper:
            raise LceError(f"parameter {self.name}: the usual range {self.usual} is not within the bounds")
        self.check(self.default)

    @property
    def least(self) -> float:
        """What no bounds may go below: 0 for what is never negative (times, capacities, temperatures), else -inf."""
        return 0.0 if self.lower >= 0.0 else -math.inf

    def bounded(self, lower: float, upper: float) -> "Parameter":
        """A copy with other bounds. Raises LceError if it cannot be there, or its default lies outside of them."""
        if lower < self.least:
            raise LceError(f"parameter {self.name}: the lower bound, {lower:g} {self.unit}, must be at least 0")
        usual = None if self.usual is None else (max(self.usual[0], lower), min(self.usual[1], upper))
        default = self.default if self.fixed or self.default == 0.0 else min(max(self.default, lower), upper)
        return replace(
            self,
            default=default,
            lower=lower,
            upper=upper,
            usual=usual if usual and usual[0] < usual[1] else None,
        )

    def check(self, value: float) -> float:
        """Return ``value``. Raises LceError if it is not finite or outside the bounds."""
        if not (math.isfinite(value) and self.lower <= value <= self.upper):
            raise LceError(
                f"parameter {self.name}: {value:g} {self.unit} is outside [{self.lower:g}, {self.upper:g}] {self.unit}"
            )
        return value


@dataclass(frozen=True, slots=True)
class Term:
    """One physical statement: name, equation, parameters, and the functions that advance it.

    Attributes
    ----------
    step : returns the new values of ``states`` and then of ``outputs`` at the end of a step of ``dt`` seconds.
    start : returns the same values before the first step, from the parameters and the signals present then. If it is
        None, ``step`` itself is called with ``dt = 0``, which serves every term without memory.
    arrays : states that are arrays, as (name, size): ``start`` fills and ``step`` changes them in place.
    vectors : parameters name_1, name_2 … that ``start`` and ``step`` take as one array, as (name, size).
    """

    name: str
    stage: Stage
    equation: str
    parameters: tuple[Parameter, ...]
    outputs: tuple[str, ...]
    step: Callable[..., float | tuple[float, ...]]
    start: Callable[..., float | tuple[float, ...]] | None = None
    states: tuple[str, ...] = field(default=())
    arrays: tuple[tuple[str, int], ...] = field(default=())
    vectors: tuple[tuple[str, int], ...] = field(default=())

    def __post_init__(self) -> None:
        if not self.name.isidentifier():
            raise LceError(f"term: {self.name!r} is no name; letters, digits and _ make one")
        if self.stage not in STAGES:
            raise LceError(f"term {self.name}: unknown stage {self.stage!r}; one of {', '.join(STAGES)}")
        unknown = [name for name in self.outputs if name not in SIGNALS]
        if unknown:
            raise LceError(f"term {self.name}: unknown output {unknown[0]!r}; one of {', '.join(SIGNALS)}")
        memory = [*self.states, *(name for name, _ in self.arrays)]
        if memory and self.start is None:
            raise LceError(f"term {self.name}: has states {', '.join(memory)} but no start function")
        names = [p.name for p in self.parameters]
        for name, size in self.vectors:
            members = [f"{name}_{i + 1}" for i in range(size)]
            if members[0] not in names or names[names.index(members[0]) :][:size] != members:
                raise LceError(f"term {self.name}: vector {name} needs parameters {name}_1 to {name}_{size}, in a row")
        for kind, function in self.functions.items():
            self._check_arguments(kind, function)

    @property
    def functions(self) -> dict[str, Callable[..., float | tuple[float, ...]]]:
        """Those of ``start`` and ``step`` that it has, by these names, whatever the file calls them."""
        return {"step": self.step} if self.start is None else {"start": self.start, "step": self.step}

    @property
    def idle_at(self) -> dict[str, float]:
        """Values of all its parameters at which the term changes nothing; empty if it always acts."""
        return {}

    def _check_arguments(self, kind: str, function: Callable[..., float | tuple[float, ...]]) -> None:
        arrays = {**dict(self.arrays), **dict(self.vectors)}
        known = {*SIGNALS, *self.states, *arrays, *(p.name for p in self.parameters), "dt"}
        for argument in arguments(function):
            if argument not in known and _input(argument) is None:
                raise LceError(f"term {self.name}: argument {argument!r} of {kind} is no signal, parameter or state")


@cache
def arguments(function: Callable[..., object]) -> tuple[str, ...]:
    """Names of the arguments, kept: to look at a signature takes longer than to simulate a step of it."""
    return tuple(inspect.signature(function).parameters)


def reads(term: Term, signal: str) -> bool:
    """Whether the signal is an argument of the term's step or start."""
    return any(signal in arguments(f) for f in term.functions.values())


def inputs_of(terms: Iterable[Term]) -> tuple[Channel, ...]:
    """The optional inputs of a run that the terms read, such as the load where one has the argument ``load``."""
    found = set[Channel | None]()
    for term in terms:
        own = {*term.states, *dict(term.arrays), *dict(term.vectors), *(p.name for p in term.parameters)}
        for function in term.functions.values():
            found |= {_input(name) for name in arguments(function) if name not in own}
    return in_order(channel for channel in found if channel is not None)


def _input(signal: str) -> Channel | None:
    """The optional input that sets a signal, None if none does."""
    if signal.startswith(NAMED_INPUT) and signal != NAMED_INPUT:
        return named_input(signal)
    return next((channel for channel in INPUTS if channel.sets == signal), None)
