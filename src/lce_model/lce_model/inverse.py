# SPDX-License-Identifier: Apache-2.0
"""The inverse chart of §6.4: which temperature gives a wanted displacement."""

from typing import Literal

import numpy as np

from lce_model.errors import LceError
from lce_model.model import Floats, Model
from lce_model.simulate import simulate

Branch = Literal["middle", "heating", "cooling"]
BRANCHES: tuple[Branch, ...] = ("middle", "heating", "cooling")


class OutOfReach(LceError):
    """A displacement that no temperature of the chart gives; ``lower_m`` and ``upper_m`` are what it reaches."""

    def __init__(self, displacement_m: float, lower_m: float, upper_m: float) -> None:
        self.lower_m, self.upper_m = lower_m, upper_m
        super().__init__(
            f"{displacement_m * 1e3:.3f} mm is out of reach: "
            f"the strip reaches {lower_m * 1e3:.3f} to {upper_m * 1e3:.3f} mm"
        )


class InverseChart:
    """Numerical chart of the major loop, read backwards.

    The strip is driven from ``coldest_k`` to ``hottest_k`` and back; each branch gives a temperature for a
    displacement, and ``middle`` the mean of the two, as the seed's feed-forward controller takes it.

    Attributes
    ----------
    temperature_grid_k : (n,) rising.
    heating_m, cooling_m : (n,) displacement on each branch of the major loop at those temperatures.
    """

    def __init__(self, model: Model, coldest_k: float = 290.0, hottest_k: float = 400.0, samples: int = 4401) -> None:
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
        """Temperature [K] for a displacement [m]; OutOfReach instead of a clipped number."""
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
