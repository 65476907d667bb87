# SPDX-License-Identifier: Apache-2.0
"""What a controller has to be, and how one with given gains is judged: by its steps and its open loops."""

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

STEP_FIGURES: Final = ("rise_s", "settling_s", "overshoot", "undershoot", "shake_w")
NEVER_S: Final = 1e6


@dataclass(frozen=True, slots=True)
class Requirements:
    """What every step has to be: rise to 80 % and settling within 2 % [s], over- and undershoot [fractions of it].

    Undershoot is how far it falls back below the target after it was there, shake the RMS of the power [W] around its
    trend in the last third: what noise becomes under gains that are too large (rule 4 of §6.4). The margins are those
    of the linearised loops, where they are steepest.
    """

    rise_s: float = math.inf
    settling_s: float = math.inf
    overshoot: float = 0.02
    undershoot: float = 0.02
    shake_w: float = 0.05
    gain_margin: float = 2.0
    phase_margin_deg: float = 45.0

    def __post_init__(self) -> None:
        for name in self.__slots__:
            if not getattr(self, name) > 0.0:
                raise LceError(f"{name}: {getattr(self, name):g} must be above 0")


@dataclass(frozen=True)
class Step:
    """A step from 0 to ``setpoint`` and what was ``reached`` (n,), [K or m], under ``power_w`` (n,) at ``time_s``."""

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
    def shake_w(self) -> float:
        """RMS of the power around a straight line, over the last third [W]."""
        late = self.power_w[-(self.power_w.size // 3) :]
        x = np.arange(late.size)
        return float(np.std(late - np.polyval(np.polyfit(x, late, 1), x)))

    @cached_property
    def itae(self) -> float:
        """∫ t |e| dt / ∫ t dt."""
        return float(np.sum(self.time_s * np.abs(1.0 - self.reached / self.setpoint)) / np.sum(self.time_s))


@dataclass(frozen=True)
class Tuned:
    """A controller with its gains; its steps and its open loops (by name, at OMEGA) are the evidence."""

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
        """J: that of the worst step."""
        return max(step.itae for step in self.steps)

    def worst(self) -> dict[str, float]:
        """The worst of each figure and margin, by the names of Requirements; infinite: never."""
        return _worst_figures(self.steps) | _least_margins(self.margins)


def check(tuned: Tuned, wanted: Requirements) -> None:
    """Raise LceError, with every figure that is missed, where a controller does not meet the requirements."""
    worst, names = tuned.worst(), (name for name, share in missing(tuned, wanted).items() if share > 0.0)
    told = [f"{name} {worst[name]:.3g} instead of {getattr(wanted, name):.3g}" for name in names]
    if told:
        raise LceError(f"{tuned.name}: no gains found that meet the requirements; the best have {', '.join(told)}")


def missing(tuned: Tuned, wanted: Requirements) -> dict[str, float]:
    """By how much each figure and margin is missed."""
    return missing_margins(tuned.margins, wanted) | missing_figures(tuned.steps, wanted)


def missing_margins(found: Mapping[str, Margins], wanted: Requirements) -> dict[str, float]:
    """By which share of it each margin is missed; 0 or less where it is there."""
    least = _least_margins(found)
    return {
        "gain_margin": 1.0 - min(least["gain_margin"], 1e3) / wanted.gain_margin,
        "phase_margin_deg": 1.0 - min(max(least["phase_margin_deg"], -180.0), 180.0) / wanted.phase_margin_deg,
    }


def missing_figures(steps: Sequence[Step], wanted: Requirements) -> dict[str, float]:
    """By which multiple of itself each figure of the worst step is exceeded; 0 or less where it is met."""
    worst = _worst_figures(steps)
    limits = {name: getattr(wanted, name) for name in STEP_FIGURES}
    return {name: min(worst[name], NEVER_S) / min(limit, NEVER_S) - 1.0 for name, limit in limits.items()}


def _worst_figures(steps: Sequence[Step]) -> dict[str, float]:
    rows = [
        (s.metrics.rise_time_s, s.metrics.settling_time_s, s.metrics.overshoot, s.undershoot, s.shake_w) for s in steps
    ]
    worst = np.max(np.where(np.isnan(rows), math.inf, rows), axis=0)
    return dict(zip(STEP_FIGURES, worst.tolist(), strict=True))


def _least_margins(found: Mapping[str, Margins]) -> dict[str, float]:
    gain, phase = (min(getattr(m, name) for m in found.values()) for name in ("gain", "phase_deg"))
    return {"gain_margin": gain, "phase_margin_deg": phase}
