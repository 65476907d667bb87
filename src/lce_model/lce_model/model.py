# SPDX-License-Identifier: Apache-2.0
"""A model with numbers: which terms, and the value of every parameter."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lce_data.channels import Channel
from lce_data.errors import LceError, did_you_mean
from lce_model.effects import Effect, find, library
from lce_model.kernel.compose import Kernel, kernel_of
from lce_model.library import PUBLISHED, terms
from lce_model.terms import SENSOR_INPUT, Parameter, Term, inputs_of
from lce_model.variation import Variation

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Value:
    """A parameter of a model: its value, the bounds of its search, and what the data say of it.

    Attributes
    ----------
    term : name of the term that has the parameter.
    parameter : its name, unit, description and default bounds.
    value, lower, upper : value and bounds of a fit, in the unit of the parameter; narrower or wider than by default.
    fixed : a fit leaves the value as it is.
    standard_error : in the unit of the parameter; None before a fit, and if the data do not determine the parameter.
    determined : whether the data determine the parameter; None before a fit.

    Raises
    ------
    LceError
        If the bounds are not an interval of what the parameter can be, or the value is outside them.
    """

    term: str
    parameter: Parameter
    value: float
    lower: float
    upper: float
    fixed: bool
    standard_error: float | None = None
    determined: bool | None = None

    def __post_init__(self) -> None:
        if not (math.isfinite(self.lower) and math.isfinite(self.upper) and self.lower < self.upper):
            raise LceError(f"{self.key}: bounds [{self.lower:g}, {self.upper:g}] {self.unit} are not an interval")
        least = self.parameter.least
        if self.lower < least or (self.lower <= 0.0 and self.parameter.scale == "log"):
            meant = "above 0, as its scale is logarithmic" if self.parameter.scale == "log" else f"at least {least:g}"
            raise LceError(f"{self.key}: the lower bound, {self.lower:g} {self.unit}, must be {meant}")
        if not self.lower <= self.value <= self.upper:
            raise LceError(
                f"{self.key}: {self.value:g} {self.unit} is outside [{self.lower:g}, {self.upper:g}] {self.unit}"
            )

    @property
    def name(self) -> str:
        """Name within its term."""
        return self.parameter.name

    @property
    def unit(self) -> str:
        """Unit of value, bounds and standard error."""
        return self.parameter.unit

    @property
    def key(self) -> str:
        """TERM.PARAM, the name on the command line and in errors."""
        return f"{self.term}.{self.parameter.name}"


@dataclass(frozen=True)
class Model:
    """A composed model P→T→d. It never changes: ``set``, ``add`` and the like return changed copies.

    ``model["lumped.tau"]`` is the value of a parameter, in its unit.

    Attributes
    ----------
    thermal, deformation : names of the base models (:mod:`lce_model.library`).
    effects : names of the effects added to them; the path of its file for an effect of the user's own.
    values : one per parameter, in the order of the terms.
    fit : record of the identification that gave the values; empty before the first.
    varies : the parameters TERM.PARAM that differ from run to run; their value in ``values`` is that of a run that is
        not listed.

    Raises
    ------
    LceError
        From its methods, if a parameter TERM.PARAM or an effect does not exist, or a value is outside its bounds; the
        message names those that exist, or the bounds.

    Examples
    --------
    >>> model = default_model("lumped", "equilibrium").set({"lumped.tau": 20.0}).add("creep")
    >>> model["lumped.tau"], model.effects
    (20.0, ('creep',))
    """

    thermal: str
    deformation: str
    effects: tuple[str, ...]
    values: tuple[Value, ...]
    fit: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    varies: Mapping[str, Variation] = field(default_factory=lambda: MappingProxyType({}))

    def __getstate__(self) -> dict[str, Any]:
        # The kernel stays behind: another process loads its own.
        return {f.name: getattr(self, f.name) for f in fields(self)}

    @property
    def terms(self) -> tuple[Term, ...]:
        """The visible tuple of terms, in the order of evaluation."""
        return terms(self.thermal, self.deformation, self.effects)

    @property
    def effect_names(self) -> tuple[str, ...]:
        """Names of the effects, those of the user's own by theirs."""
        return tuple(find(e).name for e in self.effects)

    @cached_property
    def kernel(self) -> Kernel:
        """The compiled form of the terms."""
        return kernel_of(self.terms)

    @property
    def inputs(self) -> tuple[Channel, ...]:
        """The optional inputs of a run that its terms read, such as the load."""
        return inputs_of(self.terms)

    @property
    def vector(self) -> Floats:
        """Parameter values as the kernel takes them, shape (k,)."""
        return np.array([v.value for v in self.values])

    def index(self, key: str) -> int:
        """Position of TERM.PARAM in ``values``."""
        for i, value in enumerate(self.values):
            if value.key == key:
                return i
        known = [v.key for v in self.values]
        raise LceError(f"unknown parameter {key!r}{did_you_mean(key, known)}; this model has {', '.join(known)}")

    def __getitem__(self, key: str) -> float:
        return self.values[self.index(key)].value

    def __contains__(self, key: str) -> bool:
        return any(v.key == key for v in self.values)

    def set(self, changes: Mapping[str, float]) -> "Model":
        """A copy with the parameters TERM.PARAM changed.

        Raises LceError if a parameter does not exist or a value is outside its bounds.
        """
        values = list(self.values)
        for key, number in changes.items():
            i = self.index(key)
            values[i] = replace(values[i], value=float(number), standard_error=None, determined=None)
        return replace(self, values=tuple(values))

    def configured(self, changes: Mapping[str, float]) -> "Model":
        """As ``set``, but an effect of the library whose parameter is named is added first if the model lacks it."""
        model = self
        for name in dict.fromkeys(key.partition(".")[0] for key in changes):
            if name in library() and name not in model.effects:
                model = model.add(name)
        return model.set(changes)

    def hold(self, ranges: Mapping[str, tuple[float, float]]) -> "Model":
        """A copy whose parameters TERM.PARAM are searched between (lower, upper) only.

        They may be wider than the default bounds, as far as the parameter can be there at all: a time, for one, is
        never negative. A value outside of them moves to the nearer bound.
        """
        values = list(self.values)
        for key, (lower, upper) in ranges.items():
            i = self.index(key)
            inside = min(max(values[i].value, lower), upper)
            values[i] = replace(values[i], value=inside, lower=lower, upper=upper)
        return replace(self, values=tuple(values))

    def fix(self, keys: Iterable[str]) -> "Model":
        """A copy in which a fit leaves the parameters TERM.PARAM as they are."""
        fixed = {self.index(key) for key in keys}
        values = tuple(replace(v, fixed=True) if i in fixed else v for i, v in enumerate(self.values))
        return replace(self, values=values)

    def varying(self, varies: Mapping[str, Variation]) -> "Model":
        """A copy in which exactly the parameters TERM.PARAM of ``varies`` differ from run to run.

        Raises LceError if a parameter does not exist or a value is outside its bounds.
        """
        for key, variation in varies.items():
            value = self.values[self.index(key)]
            for own in variation.by_run.values():
                replace(value, value=own.value)
        return replace(self, varies=MappingProxyType(dict(varies)))

    def searches(self, value: Value) -> bool:
        """Does a fit look for the value? What is fixed it leaves, unless that differs from run to run."""
        return not value.fixed or value.key in self.varies

    def knows(self, key: str, name: str, sha256: str = "") -> bool:
        """Has the parameter TERM.PARAM a value of its own in the run of this name and content?

        A run of another content than that of the same name that was fitted is another run.
        """
        fitted = {entry.get("name"): entry.get("sha256") for entry in self.fit.get("runs", ()) if sha256}
        return key in self.varies and name in self.varies[key].by_run and fitted.get(name, sha256) == sha256

    def of_run(self, name: str, sha256: str = "") -> "Model":
        """The model of one run: with the run's own values of what differs from run to run."""
        own = {key: v.by_run[name].value for key, v in self.varies.items() if self.knows(key, name, sha256)}
        if not own:
            return self
        values = tuple(replace(v, value=own[v.key]) if v.key in own else v for v in self.values)
        return replace(self, values=values)

    def add(self, effect: str | Effect) -> "Model":
        """A copy with one more effect at its null value: a name, the path of a file, or the effect with bounds.

        Raises LceError if the model has it already.
        """
        chosen = find(effect) if isinstance(effect, str) else effect
        if chosen.reference in self.effects:
            raise LceError(f"the model has {chosen.reference} already")
        added = self._carried(default_model(self.thermal, self.deformation, (*self.effects, chosen.reference)))
        return added.hold({f"{chosen.name}.{p.name}": (p.lower, p.upper) for p in chosen.parameters})

    def without(self, effect: str) -> "Model":
        """A copy without an effect."""
        reference = find(effect).reference
        if reference not in self.effects:
            raise LceError(f"the model has no effect {effect}; it has {', '.join(self.effects) or 'none'}")
        kept = tuple(e for e in self.effects if e != reference)
        return self._carried(default_model(self.thermal, self.deformation, kept))

    def deformed_by(self, deformation: str) -> "Model":
        """A copy with another deformation model, whose own parameters have their default values."""
        return self._carried(default_model(self.thermal, deformation, self.effects))

    def predicts(self, channel: Channel) -> bool:
        """Whether the model says what the sensor of a channel reports.

        A base term has to write the signal that the sensor measures; effects only change it. Where the model has no
        such signal (:data:`lce_model.terms.SENSOR_INPUT`), any term may write what the sensor reports.
        """
        if channel.output is None:
            return False
        measured = SENSOR_INPUT.get(channel.output)
        if measured is None:
            return any(channel.output in term.outputs for term in self.terms)
        return any(measured in term.outputs for term in terms(self.thermal, self.deformation))

    def _carried(self, other: "Model") -> "Model":
        """The other model, with the values of this one where they have a parameter in common."""
        own = {v.key: v for v in self.values}
        varies = {key: v for key, v in self.varies.items() if key in other}
        return replace(other, values=tuple(own.get(v.key, v) for v in other.values)).varying(varies)

    def with_values(self, values: tuple[Value, ...], fit: Mapping[str, Any]) -> "Model":
        """A copy with new values and the record of the fit that gave them."""
        return replace(self, values=values, fit=MappingProxyType(dict(fit)))


def default_model(thermal: str = "lumped", deformation: str = "equilibrium", effects: tuple[str, ...] = ()) -> Model:
    """Make the model of a pair of base models, with published or default values.

    Parameters
    ----------
    thermal : P→T model: none, lumped or hammerstein_wiener (:data:`lce_model.library.THERMAL`).
    deformation : T→d model: none, equilibrium, dynamic, kinetic, prandtl_ishlinskii or bouc_wen
        (:data:`lce_model.library.DEFORMATION`).
    effects : names, or paths of files, of effects at their null values.

    Returns
    -------
    Model
        Its terms with their published values, or else their default values.

    Raises
    ------
    LceError
        If there is no such model or effect; the message names those that exist.

    Examples
    --------
    >>> default_model("lumped", "none")["lumped.tau"]
    18.0
    """
    values = tuple(
        Value(term.name, p, p.default, p.lower, p.upper, p.fixed)
        for term in terms(thermal, deformation, effects)
        for p in term.parameters
    )
    model = Model(thermal, deformation, tuple(find(e).reference for e in effects), values)
    return model.set({k: v for k, v in PUBLISHED.get(deformation, {}).items() if k in model})
