# SPDX-License-Identifier: Apache-2.0
"""The loops around an operating point as linear systems: frequency responses of the open loops, and their margins."""

import math
from dataclasses import dataclass
from typing import Final

import control
import numpy as np
from numpy.typing import NDArray

from lce_control.pid import Gains
from lce_control.tuning.closed_loop import PERIOD_S, Sensors
from lce_data.errors import LceError
from lce_model import Model, simulate
from lce_model.inverse import InverseChart

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

OMEGA: Final[Floats] = np.geomspace(1e-3, math.pi / PERIOD_S, 201)
"""Where responses are known [rad/s], up to what a controller of 100 Hz can do."""
AGE_S: Final = 1.5 * PERIOD_S
"""Delay of a command: its way through the nodes, and half the time for which it holds."""
SETTLED_S: Final = 5000.0
NUDGE: Final = 0.01


@dataclass(frozen=True, slots=True)
class Margins:
    """Gain margin (a factor) and phase margin [degrees], infinite where there is no crossover; crossover [rad/s]."""

    gain: float
    phase_deg: float
    crossover_rad_s: float


def margins(open_loop: Complex) -> Margins:
    """Margins of an open loop known at ``OMEGA`` (python-control)."""
    gain, phase, _, _, crossover, _ = control.stability_margins(control.FRD(open_loop, OMEGA, smooth=True))
    if math.isfinite(crossover):
        return Margins(float(gain), float(phase), float(crossover))
    # Without a crossover it is quiet everywhere, or still loud where a sampled controller ends.
    quiet = bool(np.abs(open_loop[-1]) < 1.0)
    return Margins(float(gain) if quiet else 0.0, math.inf if quiet else -180.0, math.nan)


@dataclass(frozen=True)
class Plant:
    """A strip near a state that it can be held in.

    response : temperature over power [K/W] at ``OMEGA``.
    slope_m_k : displacement over temperature [m/K], the steepest that a loop meets.
    gain_k_w, tau_s : static gain, and the time in which a step has come to 63 %.
    """

    response: Complex
    slope_m_k: float
    gain_k_w: float
    tau_s: float

    @classmethod
    def of(cls, model: Model, power_w: float, displacement_m: tuple[float, float]) -> "Plant":
        """From the answer to a small step up from ``power_w`` [W]; the slope within a range of displacements [m]."""
        after = np.concatenate([[0.0], np.geomspace(0.1 * PERIOD_S, SETTLED_S, 10000)])
        time = np.concatenate([after, SETTLED_S + 1.0 + after])
        power = np.where(time <= SETTLED_S, power_w, (1.0 + NUDGE) * power_w)
        answer = simulate(model, time, power).temperature_k[after.size :]
        rise = (answer - answer[0]) / (NUDGE * power_w)
        if not rise[-1] > 0.0:
            raise LceError(f"the strip does not get warmer with more than {power_w:g} W: nothing can be tuned on it")
        # Transform of the slope of a rise that runs straight between its samples.
        middle, width = 0.5 * (after[1:] + after[:-1]), np.diff(after)
        straight = np.sinc(np.outer(OMEGA, width) / (2.0 * math.pi))
        response = (np.exp(-1j * np.outer(OMEGA, middle)) * straight) @ np.diff(rise)
        tau_s = float(after[np.searchsorted(rise, 0.632 * rise[-1])])
        return cls(response, _steepest(model, displacement_m), float(rise[-1]), tau_s)

    def inner(self, gains: Gains, filter_s: float, sensors: Sensors) -> Complex:
        """Open inner loop: (6.2), filter, camera, power to temperature. The age of a sample counts as a delay."""
        age_s = sensors.camera_latency_s + 0.5 * sensors.camera_period_s + AGE_S
        return _controller(gains, filter_s, age_s) * self.response

    def outer(self, gains: Gains, inner_gains: Gains, filter_s: float, sensors: Sensors) -> Complex:
        """Open outer loop: (6.9), filter, the closed inner loop from its setpoint, temperature to displacement.

        Filter and age of the camera are in the feedback of the inner loop; its setpoint becomes power at once.
        """
        forward = _pid(inner_gains, inner_gains.setpoint_weight, inner_gains.derivative_weight) * self.response
        closed = forward / (1.0 + self.inner(inner_gains, filter_s, sensors))
        return _controller(gains, filter_s, AGE_S) * closed * self.slope_m_k

    def single(self, gains: Gains, filter_s: float) -> Complex:
        """Open single loop: PID, filter, power to displacement."""
        return _controller(gains, filter_s, AGE_S) * self.response * self.slope_m_k


def _controller(gains: Gains, filter_s: float, delay_s: float) -> Complex:
    s = 1j * OMEGA
    return np.asarray(_pid(gains) * np.exp(-s * delay_s) / (filter_s * s + 1.0))


def _pid(gains: Gains, proportional: float = 1.0, derivative: float = 1.0) -> Complex:
    """From what is measured, or, with the weights of the setpoint, from that."""
    s = 1j * OMEGA
    return np.asarray(proportional * gains.kp + gains.ki / s + derivative * gains.kd * gains.n * s / (s + gains.n))


def _steepest(model: Model, displacement_m: tuple[float, float]) -> float:
    """Largest slope of the heating branch over 1 K, between two displacements [m/K]."""
    chart = InverseChart(model)
    per_sample = round(1.0 / float(chart.temperature_grid_k[1] - chart.temperature_grid_k[0]))
    d = chart.heating_m
    slope = d[per_sample:] - d[:-per_sample]
    within = (d[:-per_sample] >= displacement_m[0]) & (d[per_sample:] <= displacement_m[1])
    return float(slope[within].max() if within.any() else slope.max())
