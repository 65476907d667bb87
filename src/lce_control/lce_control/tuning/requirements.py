# SPDX-License-Identifier: Apache-2.0
"""Requirements of a controller, and how one with given gains is judged: by its steps and its open loops."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_control.step_metrics import StepMetrics, step_metrics
from lce_control.tuning.linear import Complex, Margins, margins
from lce_data.errors import LceError

Floats = NDArray[np.float64]
Parameters = Mapping[str, Mapping[str, float]]
"""ROS parameters by node name."""

STEP_FIGURES: Final = ("rise_s", "settling_s", "overshoot", "undershoot", "power_ripple_w")
NEVER_S: Final = 1e6
"""In the place of a rise or settling time that a step never reaches, and of a requirement that allows any time [s]."""


@dataclass(frozen=True, slots=True)
class Requirements:
    """Limits that every step and every open loop has to keep; all above 0.

    Parameters
    ----------
    rise_s : slowest rise to 80 % [s].
    settling_s : slowest settling within 2 % [s].
    overshoot : largest overshoot, in fractions of the step.
    undershoot : largest fall below the target after it was reached, in fractions of the step.
    power_ripple_w : largest RMS of the power around its trend in the last third of a step [W]. Gains that are too large
        turn noise into ripple (rule 4 of §6.4).
    gain_margin : smallest gain margin of the linearised loops, a factor.
    phase_margin_deg : their smallest phase margin [degrees].

    Raises
    ------
    LceError
        If a value is not above 0; it names the field.
    """

    rise_s: float = math.inf
    settling_s: float = math.inf
    overshoot: float = 0.02
    undershoot: float = 0.02
    power_ripple_w: float = 0.05
    gain_margin: float = 2.0
    phase_margin_deg: float = 45.0

    def __post_init__(self) -> None:
        for name in self.__slots__:
            if not getattr(self, name) > 0.0:
                raise LceError(f"{name}: {getattr(self, name):g} must be above 0")


@dataclass(frozen=True)
class Step:
    """The response to a step from 0.

    Parameters
    ----------
    setpoint : height of the step [K or m].
    time_s : (n,) since the step [s].
    reached : (n,) in the unit of the setpoint.
    power_w : (n,) [W].
    """

    setpoint: float
    time_s: Floats
    reached: Floats
    power_w: Floats

    @cached_property
    def metrics(self) -> StepMetrics:
        """Rise, settling, overshoot, late error."""
        return step_metrics(self.time_s, self.reached, self.setpoint)

    @cached_property
    def undershoot(self) -> float:
        """Largest fall below the setpoint after it was reached, in fractions of it."""
        there = np.flatnonzero(self.reached >= self.setpoint)
        return float(max(0.0, 1.0 - self.reached[there[0] :].min() / self.setpoint)) if there.size else 0.0

    @cached_property
    def power_ripple_w(self) -> float:
        """RMS of the power around its linear trend, over the last third of the step [W]."""
        late = self.power_w[-(self.power_w.size // 3) :]
        x = np.arange(late.size)
        return float(np.std(late - np.polyval(np.polyfit(x, late, 1), x)))

    @cached_property
    def itae(self) -> float:
        """Time-weighted error ∫ t |e| dt / ∫ t dt, with e in fractions of the step."""
        return float(np.sum(self.time_s * np.abs(1.0 - self.reached / self.setpoint)) / np.sum(self.time_s))


@dataclass(frozen=True)
class Tuned:
    """A controller with its gains, and the responses by which they are judged.

    Attributes
    ----------
    name : of the controller: "inner", "double" or "single".
    parameters : gains by node and name.
    steps : the step responses.
    open_loops : frequency responses (201,) of the linearised open loops at OMEGA, by name.
    evaluations : candidates that were tried to find it.
    """

    name: str
    parameters: Parameters
    steps: tuple[Step, ...]
    open_loops: Mapping[str, Complex]
    evaluations: int = 1

    @cached_property
    def margins(self) -> Mapping[str, Margins]:
        """Of each linearised loop."""
        return {name: margins(loop) for name, loop in self.open_loops.items()}

    @property
    def itae(self) -> float:
        """J, the time-weighted error of the worst step."""
        return max(step.itae for step in self.steps)

    def worst(self) -> dict[str, float]:
        """The worst of each figure and margin, by the names of Requirements; infinite if never reached."""
        return _worst_figures(self.steps) | _least_margins(self.margins)


def check(tuned: Tuned, wanted: Requirements) -> None:
    """Raise LceError, with every figure that is missed, if a controller does not meet the requirements."""
    worst = tuned.worst()
    missed = [name for name, share in missing(tuned, wanted).items() if share > 0.0]
    if missed:
        figures = ", ".join(f"{name} {worst[name]:.3g} instead of {getattr(wanted, name):.3g}" for name in missed)
        raise LceError(f"{tuned.name}: no gains found that meet the requirements; the best have {figures}")


def missing(tuned: Tuned, wanted: Requirements) -> dict[str, float]:
    """By how much each figure and margin is missed, in shares of the requirement; 0 or less if it is met."""
    return missing_margins(tuned.margins, wanted) | missing_figures(tuned.steps, wanted)


def missing_margins(found: Mapping[str, Margins], wanted: Requirements) -> dict[str, float]:
    """By which share of the requirement each margin is missed; 0 or less if it is met."""
    least = _least_margins(found)
    return {
        "gain_margin": 1.0 - min(least["gain_margin"], 1e3) / wanted.gain_margin,
        "phase_margin_deg": 1.0 - min(max(least["phase_margin_deg"], -180.0), 180.0) / wanted.phase_margin_deg,
    }


def missing_figures(steps: Sequence[Step], wanted: Requirements) -> dict[str, float]:
    """By which share of the requirement each figure of the worst step exceeds it; 0 or less if it is met."""
    worst = _worst_figures(steps)
    limits = {name: getattr(wanted, name) for name in STEP_FIGURES}
    return {name: min(worst[name], NEVER_S) / min(limit, NEVER_S) - 1.0 for name, limit in limits.items()}


def _worst_figures(steps: Sequence[Step]) -> dict[str, float]:
    rows = [
        (s.metrics.rise_time_s, s.metrics.settling_time_s, s.metrics.overshoot, s.undershoot, s.power_ripple_w)
        for s in steps
    ]
    worst = np.max(np.where(np.isnan(rows), math.inf, rows), axis=0)
    return dict(zip(STEP_FIGURES, worst.tolist(), strict=True))


def _least_margins(found: Mapping[str, Margins]) -> dict[str, float]:
    gain, phase = (min(getattr(m, name) for m in found.values()) for name in ("gain", "phase_deg"))
    return {"gain_margin": gain, "phase_margin_deg": phase}
