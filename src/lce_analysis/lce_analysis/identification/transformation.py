# SPDX-License-Identifier: Apache-2.0
"""Bounded physical parameters as the free variables of an optimiser."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lce_model import Value

Floats = NDArray[np.float64]


class Scale(Protocol):
    """The scale on which a parameter p is searched: maps p to its place on the scale, and back.

    ``multiplicative`` says whether a step along the scale multiplies p.
    """

    multiplicative: bool

    def place(self, p: Floats) -> Floats:
        """Where p (…,) lies on the scale."""

    def value(self, place: Floats) -> Floats:
        """p at a place (…,) of the scale."""

    def slope(self, p: Floats) -> Floats:
        """dp/d(place) at p (…,)."""

    def span(self, lower: float, upper: float) -> float:
        """What counts as a large change between two bounds, as a distance on the scale."""


@dataclass(frozen=True)
class LinearScale:
    """p itself; a tenth of the bounds is a large change."""

    multiplicative = False

    def place(self, p: Floats) -> Floats:
        """Where p lies."""
        return p

    def value(self, place: Floats) -> Floats:
        """p at a place."""
        return place

    def slope(self, p: Floats) -> Floats:
        """dp/d(place)."""
        return np.ones_like(p)

    def span(self, lower: float, upper: float) -> float:
        """A large change."""
        return 0.1 * (upper - lower)


@dataclass(frozen=True)
class LogScale:
    """ln p; an e-fold is a large change."""

    multiplicative = True

    def place(self, p: Floats) -> Floats:
        """Where p lies."""
        return np.log(p)

    def value(self, place: Floats) -> Floats:
        """p at a place."""
        return np.exp(place)

    def slope(self, p: Floats) -> Floats:
        """dp/d(place)."""
        return p

    def span(self, lower: float, upper: float) -> float:
        """A large change."""
        return 1.0


@dataclass(frozen=True)
class AsinhScale:
    """asinh(p/knee), linear around zero and logarithmic beyond the knee, for strengths that may vanish."""

    knee: float
    multiplicative = True

    def place(self, p: Floats) -> Floats:
        """Where p lies."""
        return np.arcsinh(p / self.knee)

    def value(self, place: Floats) -> Floats:
        """p at a place."""
        return self.knee * np.sinh(place)

    def slope(self, p: Floats) -> Floats:
        """dp/d(place)."""
        return np.hypot(p, self.knee)

    def span(self, lower: float, upper: float) -> float:
        """A large change."""
        return 1.0


def scale_of(value: Value) -> Scale:
    """The scale on which a parameter asks to be searched."""
    if value.parameter.scale == "log":
        return LogScale()
    return AsinhScale(value.parameter.knee) if value.parameter.knee > 0.0 else LinearScale()


@dataclass(frozen=True)
class Transformation:
    """Maps between parameters p, the unit box u and unbounded search variables z, each of shape (…, k).

    u is linear in the place on the scale of a parameter; z = arcsin(2u - 1), the transformation that MINUIT uses, turns
    Levenberg–Marquardt into a method that keeps to the bounds.
    """

    scales: tuple[Scale, ...]
    lower: Floats
    upper: Floats

    @classmethod
    def of(cls, values: Sequence[Value]) -> "Transformation":
        """The transformation of these parameters, with their bounds."""
        return cls(
            tuple(scale_of(v) for v in values), np.array([v.lower for v in values]), np.array([v.upper for v in values])
        )

    def _each(self, convert: Callable[[Scale, Floats], Floats], values: Floats) -> Floats:
        """``convert`` of each scale over its column of values (…, k)."""
        out = np.empty(np.shape(values))
        for i, scale in enumerate(self.scales):
            out[..., i] = convert(scale, values[..., i])
        return out

    @cached_property
    def _low(self) -> Floats:
        return self._each(lambda scale, p: scale.place(p), self.lower)

    @cached_property
    def _span(self) -> Floats:
        return self._each(lambda scale, p: scale.place(p), self.upper) - self._low

    def to_box(self, p: Floats) -> Floats:
        """p → u."""
        return np.asarray((self._each(lambda scale, p: scale.place(p), p) - self._low) / self._span)

    def from_box(self, u: Floats) -> Floats:
        """u → p, never outside the bounds."""
        p = self._each(lambda scale, place: scale.value(place), self._low + u * self._span)
        return np.asarray(np.clip(p, self.lower, self.upper))

    def to_search(self, p: Floats) -> Floats:
        """p → z."""
        # A start on a bound would have no slope to leave it by.
        u = np.clip(self.to_box(p), 1e-4, 1.0 - 1e-4)
        return np.asarray(np.arcsin(2.0 * u - 1.0))

    def to_model(self, z: Floats) -> Floats:
        """z → p."""
        return self.from_box(0.5 * (np.sin(z) + 1.0))

    @cached_property
    def natural_unit(self) -> Floats:
        """What counts as a large change of each parameter (k,), as a distance on its scale."""
        bounds = zip(self.scales, self.lower.tolist(), self.upper.tolist(), strict=True)
        return np.array([scale.span(low, high) for scale, low, high in bounds])

    def natural_slope(self, p: Floats) -> Floats:
        """dp/d(place in natural units) at p."""
        return np.asarray(self._each(lambda scale, p: scale.slope(p), p) * self.natural_unit)

    def natural_per_search(self, p: Floats) -> Floats:
        """d(place in natural units)/dz at p; zero on a bound."""
        u = self.to_box(p)
        return np.asarray(self._span / self.natural_unit * np.sqrt(np.clip(u * (1.0 - u), 0.0, None)))

    @property
    def multiplicative(self) -> NDArray[np.bool_]:
        """Whether a step along the scale multiplies the parameter (k,)."""
        return np.array([scale.multiplicative for scale in self.scales], dtype=np.bool_)
