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
"""(201,) frequencies of all responses [rad/s], up to the Nyquist frequency of a controller of 100 Hz."""
AGE_S: Final = 1.5 * PERIOD_S
"""Delay of a command [s]: its way through the nodes, and half the time for which it holds."""
STEADY_S: Final = 5000.0
"""Time after which the strip is as warm as it gets [s]."""
STEP_SHARE: Final = 0.01
"""Size of the step from which the strip is linearised, over the power before it."""


@dataclass(frozen=True, slots=True)
class Margins:
    """Stability margins of an open loop.

    Attributes
    ----------
    gain : gain margin, a factor.
    phase_deg : phase margin [degrees].
    crossover_rad_s : frequency at which the gain is 1 [rad/s]. Without one it is NaN; the margins are then infinite for
        a gain below 1, and 0 and -180 for a gain above 1 at all frequencies.
    """

    gain: float
    phase_deg: float
    crossover_rad_s: float


def margins(open_loop: Complex) -> Margins:
    """Margins of an open loop (201,) known at ``OMEGA``, by python-control."""
    gain, phase, _, _, crossover, _ = control.stability_margins(control.FRD(open_loop, OMEGA, smooth=True))
    if math.isfinite(crossover):
        return Margins(float(gain), float(phase), float(crossover))
    # Without a crossover the gain is below 1 at all frequencies, or above 1 up to the Nyquist frequency.
    below = bool(np.abs(open_loop[-1]) < 1.0)
    return Margins(float(gain) if below else 0.0, math.inf if below else -180.0, math.nan)


@dataclass(frozen=True)
class LinearPlant:
    """A strip linearised at a power that holds it in a steady state.

    Attributes
    ----------
    response : (201,) temperature over power at ``OMEGA`` [K/W].
    slope_m_k : displacement over temperature, the steepest that a loop meets [m/K].
    gain_k_w : static gain [K/W].
    tau_s : time in which a step has come to 63 % [s].
    """

    response: Complex
    slope_m_k: float
    gain_k_w: float
    tau_s: float

    @classmethod
    def of(cls, model: Model, power_w: float, displacement_m: tuple[float, float]) -> "LinearPlant":
        """Linearise a model.

        Parameters
        ----------
        model : a model with a thermal and a deformation stage.
        power_w : operating point [W]; the response is that to a small step up from it.
        displacement_m : range of displacements [m] within which the slope is the steepest.

        Raises
        ------
        LceError
            If the strip does not get warmer with more power.
        """
        after = np.concatenate([[0.0], np.geomspace(0.1 * PERIOD_S, STEADY_S, 10000)])
        time = np.concatenate([after, STEADY_S + 1.0 + after])
        power = np.where(time <= STEADY_S, power_w, (1.0 + STEP_SHARE) * power_w)
        temperature_k = simulate(model, time, power).temperature_k[after.size :]
        rise = (temperature_k - temperature_k[0]) / (STEP_SHARE * power_w)
        if not rise[-1] > 0.0:
            raise LceError(f"the strip does not get warmer with more than {power_w:g} W: nothing can be tuned on it")
        # Fourier transform of the slope of a rise that is straight between its samples.
        middle, width = 0.5 * (after[1:] + after[:-1]), np.diff(after)
        straight = np.sinc(np.outer(OMEGA, width) / (2.0 * math.pi))
        response = (np.exp(-1j * np.outer(OMEGA, middle)) * straight) @ np.diff(rise)
        tau_s = float(after[np.searchsorted(rise, 0.632 * rise[-1])])
        return cls(response, _steepest(model, displacement_m), float(rise[-1]), tau_s)

    def inner(self, gains: Gains, filter_s: float, sensors: Sensors) -> Complex:
        """Open inner loop (201,): (6.2), filter, camera, power to temperature. The age of a sample is a delay."""
        age_s = sensors.camera_latency_s + 0.5 * sensors.camera_period_s + AGE_S
        return _controller(gains, filter_s, age_s) * self.response

    def outer(self, gains: Gains, inner_gains: Gains, filter_s: float, sensors: Sensors) -> Complex:
        """Open outer loop (201,): (6.9), filter, the closed inner loop from its setpoint, temperature to displacement.

        Filter and age of the camera are in the feedback of the inner loop; its setpoint becomes power at once.
        """
        forward = _pid(inner_gains, inner_gains.setpoint_weight, inner_gains.derivative_weight) * self.response
        closed = forward / (1.0 + self.inner(inner_gains, filter_s, sensors))
        return _controller(gains, filter_s, AGE_S) * closed * self.slope_m_k

    def single(self, gains: Gains, filter_s: float) -> Complex:
        """Open single loop (201,): PID, filter, power to displacement."""
        return _controller(gains, filter_s, AGE_S) * self.response * self.slope_m_k


def _controller(gains: Gains, filter_s: float, delay_s: float) -> Complex:
    s = 1j * OMEGA
    return np.asarray(_pid(gains) * np.exp(-s * delay_s) / (filter_s * s + 1.0))


def _pid(gains: Gains, proportional: float = 1.0, derivative: float = 1.0) -> Complex:
    """Response of (6.2) to the measured value, or, with the weights of the setpoint, to the setpoint."""
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
