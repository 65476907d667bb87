# SPDX-License-Identifier: Apache-2.0
"""What a user may choose of the search for gains: a frozen class, each field with its unit and its reason."""

import math
from dataclasses import dataclass
from typing import Final

from lce_data.errors import LceError


@dataclass(frozen=True)
class TuneOptions:
    """How gains are searched, and on which steps they are judged; the defaults serve the strips of the library.

    Parameters
    ----------
    seed : of the differential evolution; the same seed gives the same gains.
    generations : of the differential evolution, which finds the neighbourhood of the best gains.
    candidates : members of a generation for every axis of the search.
    local_tries : tries of Nelder-Mead on the model, which goes on from there.
    experiments : tries of Nelder-Mead in an experiment; each is one run of the nodes for every step.
    first_step : first steps of Nelder-Mead, as a change of the logarithm of each axis, up and down in turn.
    digits : significant digits of the gains.
    shares : steps to tune on, in shares of the displacement that the laser can hold: over the whole range, because the
        slope of displacement over temperature differs within it.
    power_share : share of the laser's power from which that displacement is taken; the rest is left to the controller.
    shortest_s, longest_s : limits of the duration of a step [s]; in between it is six times what full power takes.
    filter_s : time constant T_f of the feedback filters [s] (§6.2).
    feedforward_error_k : error of the feed-forward under which the cascade is tuned [K], up and down in turn. On the
        model itself the feed-forward is perfect, and the outer loop would have nothing to correct.
    softer : the search for the cascade begins with an inner loop whose gains are so many times smaller than alone.

    Raises
    ------
    LceError
        If a value cannot be used; it names the field.
    """

    seed: int = 0
    generations: int = 8
    candidates: int = 6
    local_tries: int = 250
    experiments: int = 20
    first_step: float = 0.2
    digits: int = 3
    shares: tuple[float, ...] = (0.3, 0.45, 0.65, 0.9)
    power_share: float = 0.9
    shortest_s: float = 30.0
    longest_s: float = 300.0
    filter_s: float = 0.1
    feedforward_error_k: float = 2.0
    softer: float = 10.0

    def __post_init__(self) -> None:
        for name in ("generations", "candidates", "local_tries", "experiments", "digits"):
            if getattr(self, name) < 1:
                raise LceError(f"{name}: {getattr(self, name)} is not 1 or more")
        for name in ("first_step", "shortest_s", "longest_s", "softer"):
            if not (math.isfinite(getattr(self, name)) and getattr(self, name) > 0.0):
                raise LceError(f"{name}: {getattr(self, name):g} must be above 0")
        for name in ("filter_s", "feedforward_error_k"):
            if not (math.isfinite(getattr(self, name)) and getattr(self, name) >= 0.0):
                raise LceError(f"{name}: {getattr(self, name):g} must be 0 or above")
        if self.shortest_s > self.longest_s:
            raise LceError(f"shortest_s: {self.shortest_s:g} is above longest_s, {self.longest_s:g}")
        if not self.shares or not all(0.0 < share <= 1.0 for share in (*self.shares, self.power_share)):
            raise LceError(f"shares: {self.shares}, {self.power_share:g} of the power: each must be within (0, 1]")


DEFAULTS: Final = TuneOptions()
