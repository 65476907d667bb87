# SPDX-License-Identifier: Apache-2.0
"""Bounded physical parameters as the free variables of an optimiser."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lce_model import Value

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Transformation:
    """Maps between parameters p, the unit box u and unbounded variables z, each of shape (…, k).

    u is linear in the axis of a parameter, which is p, ln p or asinh(p/knee) by its ``scale``; z = arcsin(2u - 1), the
    transformation that MINUIT uses, turns Levenberg–Marquardt into a method that keeps to the bounds.
    """

    lower: Floats
    upper: Floats
    logarithmic: NDArray[np.bool_]
    knee: Floats

    @classmethod
    def of(cls, values: Sequence[Value]) -> "Transformation":
        """The coordinates of these parameters, with their bounds."""
        return cls(
            np.array([v.lower for v in values]),
            np.array([v.upper for v in values]),
            np.array([v.parameter.scale == "log" for v in values], dtype=np.bool_),
            np.array([v.parameter.knee for v in values]),
        )

    @cached_property
    def _safe_knee(self) -> Floats:
        return np.where(self.knee > 0.0, self.knee, 1.0)

    @cached_property
    def _span(self) -> tuple[Floats, Floats]:
        low = self._axis(self.lower)
        return low, self._axis(self.upper) - low

    def _axis(self, p: Floats) -> Floats:
        log = np.log(np.where(self.logarithmic, p, 1.0))
        return np.where(self.logarithmic, log, np.where(self.knee > 0.0, np.arcsinh(p / self._safe_knee), p))

    def to_box(self, p: Floats) -> Floats:
        """p → u."""
        low, span = self._span
        return np.asarray((self._axis(p) - low) / span)

    def from_box(self, u: Floats) -> Floats:
        """u → p, never outside the bounds."""
        low, span = self._span
        axis = low + u * span
        grown = np.exp(np.where(self.logarithmic, axis, 0.0))
        bent = self._safe_knee * np.sinh(np.where(self.knee > 0.0, axis, 0.0))
        p = np.where(self.logarithmic, grown, np.where(self.knee > 0.0, bent, axis))
        return np.asarray(np.clip(p, self.lower, self.upper))

    def to_search(self, p: Floats) -> Floats:
        """p → z."""
        # A start on a bound would have no slope to leave it by.
        u = np.clip(self.to_box(p), 1e-4, 1.0 - 1e-4)
        return np.asarray(np.arcsin(2.0 * u - 1.0))

    def to_model(self, z: Floats) -> Floats:
        """z → p."""
        return self.from_box(0.5 * (np.sin(z) + 1.0))

    @property
    def natural_unit(self) -> Floats:
        """What counts as a large change of the axis: an e-fold, or a tenth of the bounds of a linear parameter."""
        curved = self.logarithmic | (self.knee > 0.0)
        return np.where(curved, 1.0, 0.1 * (self.upper - self.lower))

    def to_natural(self, p: Floats) -> Floats:
        """The axis in natural units."""
        return np.asarray(self._axis(p) / self.natural_unit)

    def natural_slope(self, p: Floats) -> Floats:
        """dp/d(natural coordinate) at p."""
        return np.where(self.logarithmic, p, np.where(self.knee > 0.0, np.hypot(p, self.knee), self.natural_unit))

    def natural_per_free(self, p: Floats) -> Floats:
        """d(natural coordinate)/dz at p; zero on a bound."""
        u = self.to_box(p)
        return np.asarray(self._span[1] / self.natural_unit * np.sqrt(np.clip(u * (1.0 - u), 0.0, None)))

    @property
    def multiplicative(self) -> NDArray[np.bool_]:
        """Where a step along the axis multiplies the parameter."""
        return np.asarray(self.logarithmic | (self.knee > 0.0))
