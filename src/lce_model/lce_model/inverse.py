# SPDX-License-Identifier: Apache-2.0
"""Which temperature gives a wanted displacement: from a chart of the major loop, or from where the strip is now."""

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from lce_data.errors import LceError
from lce_model.model import Floats, Model
from lce_model.simulation import simulate

COLDEST_K, HOTTEST_K, STEP_K = 290.0, 400.0, 0.025

Branch = Literal["middle", "heating", "cooling"]
BRANCHES: tuple[Branch, ...] = ("middle", "heating", "cooling")


class OutOfReach(LceError):
    """No temperature of the chart gives the displacement; it reaches from ``lower_m`` to ``upper_m``."""

    def __init__(self, displacement_m: float, lower_m: float, upper_m: float) -> None:
        self.lower_m, self.upper_m = lower_m, upper_m
        super().__init__(
            f"{displacement_m * 1e3:.3f} mm is out of reach: "
            f"the strip reaches {lower_m * 1e3:.3f} to {upper_m * 1e3:.3f} mm"
        )


class InverseChart:
    """The major loop of a model as a table, read backwards: the inverse chart of Wu (2021), §6.4.

    The strip is driven from ``coldest_k`` to ``hottest_k`` and back; each branch gives a temperature for a
    displacement, and ``middle`` the mean of the two, as the feed-forward controller of Wu (2021) takes it.

    Attributes
    ----------
    temperature_grid_k : (n,) rising.
    heating_m, cooling_m : (n,) displacement on each branch of the major loop at those temperatures.
    """

    def __init__(
        self, model: Model, coldest_k: float = COLDEST_K, hottest_k: float = HOTTEST_K, samples: int = 4401
    ) -> None:
        if model.deformation == "none":
            raise LceError("an inverse chart needs a model with a deformation stage")
        if not 200.0 <= coldest_k < hottest_k <= 600.0:
            raise LceError(f"chart from {coldest_k:g} K to {hottest_k:g} K: must rise, within [200, 600] K")
        up = np.linspace(coldest_k, hottest_k, samples)
        path = np.concatenate([up, up[-2::-1]])
        d = simulate(model, np.arange(path.size, dtype=np.float64), None, temperature_k=path).displacement_m
        self.temperature_grid_k: Floats = up
        self.heating_m: Floats = np.maximum.accumulate(d[:samples])
        self.cooling_m: Floats = np.maximum.accumulate(d[samples - 1 :][::-1])

    def reach_m(self, branch: Branch = "middle") -> tuple[float, float]:
        """Smallest and largest displacement [m] that the chart gives on ``branch``."""
        curves = {"heating": [self.heating_m], "cooling": [self.cooling_m]}.get(
            branch, [self.heating_m, self.cooling_m]
        )
        return max(float(c[0]) for c in curves), min(float(c[-1]) for c in curves)

    def temperature_k(self, displacement_m: float, branch: Branch = "middle") -> float:
        """Temperature [K] for a displacement [m]. Raises OutOfReach if no temperature of the chart gives it."""
        if branch not in BRANCHES:
            raise LceError(f"branch {branch!r}: one of {', '.join(BRANCHES)}")
        lower, upper = self.reach_m(branch)
        if not lower <= displacement_m <= upper:
            raise OutOfReach(displacement_m, lower, upper)
        heating = self._read(self.heating_m, displacement_m)
        cooling = self._read(self.cooling_m, displacement_m)
        return {"heating": heating, "cooling": cooling, "middle": 0.5 * (heating + cooling)}[branch]

    def _read(self, curve: Floats, displacement_m: float) -> float:
        """The lowest temperature at which a rising curve reaches the displacement."""
        i = int(np.searchsorted(curve, displacement_m, side="left"))
        if i == 0:
            return float(self.temperature_grid_k[0])
        i = min(i, curve.size - 1)
        share = (displacement_m - curve[i - 1]) / (curve[i] - curve[i - 1]) if curve[i] > curve[i - 1] else 1.0
        return float(
            self.temperature_grid_k[i - 1]
            + min(share, 1.0) * (self.temperature_grid_k[i] - self.temperature_grid_k[i - 1])
        )


def temperature_from_here_k(
    model: Model, time_s: ArrayLike, temperature_k: ArrayLike, displacement_m: float, deadband_k: float = 0.3
) -> float:
    """Temperature [K] that brings a strip from its present state to a displacement [m], along the minor loop it is on.

    The model follows the measured past, ``time_s`` and ``temperature_k`` (n,), to the present state. From there it is
    heated slowly to a larger displacement, or cooled slowly to a smaller one. Without a past the strip is cold and at
    rest. Reversals of the measured temperature smaller than ``deadband_k`` [K] count as noise.

    Raises OutOfReach, with the range that heating and cooling reach, if neither reaches the displacement.
    """
    time, past = np.asarray(time_s, dtype=np.float64), np.asarray(temperature_k, dtype=np.float64)
    if past.size == 0:
        time, past = np.array([0.0]), np.array([COLDEST_K])

    def way(end_k: float) -> tuple[Floats, Floats]:
        there = np.linspace(past[-1], end_k, 2 + int(abs(end_k - past[-1]) / STEP_K))[1:]
        t = np.concatenate([time, time[-1] + 1.0 + np.arange(there.size)])
        d = simulate(model, t, None, temperature_k=np.concatenate([past, there]), deadband_k=deadband_k).displacement_m
        return np.concatenate([past[-1:], there]), d[past.size - 1 :]

    temperature, d = way(HOTTEST_K)
    sign = 1.0
    if displacement_m < d[0]:
        hottest_m = float(d.max())
        temperature, d = way(COLDEST_K)
        sign = -1.0
    reached = np.flatnonzero(sign * d >= sign * displacement_m)
    if reached.size == 0:
        lower, upper = (float(way(COLDEST_K)[1].min()), float(d.max())) if sign > 0.0 else (float(d.min()), hottest_m)
        raise OutOfReach(displacement_m, lower, upper)
    i = int(reached[0])
    if i == 0:
        return float(temperature[0])
    share = (displacement_m - d[i - 1]) / (d[i] - d[i - 1])
    return float(temperature[i - 1] + share * (temperature[i] - temperature[i - 1]))
