# SPDX-License-Identifier: Apache-2.0
"""A controller closed over a model of the strip, its sensors and its laser: faster than the nodes, and without ROS."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_control.filters import Sample
from lce_data.channels import DISPLACEMENT, POWER, TEMPERATURE, Channel
from lce_data.errors import LceError
from lce_model import Model, Stepper

Floats = NDArray[np.float64]
Controller = Callable[[float, Sample, Sample], float]
"""(t_s, displacement [m], temperature [K]) → power [W]; each sample has the time at which it was measured."""

PERIOD_S: Final = 0.01
"""Time between two commands [s], as in the nodes."""


@dataclass(frozen=True, slots=True)
class Sensors:
    """Noise and delay of the simulated sensors; zeros make them ideal. The defaults are those of simulated.yaml.

    Parameters
    ----------
    distance_noise_m : standard deviation of the Gaussian noise of the distance sensor [m]; it measures every 10 ms.
    camera_noise_k : standard deviation of the Gaussian noise of the camera [K].
    camera_period_s : time between two images [s].
    camera_latency_s : time from an image to its arrival [s].
    """

    distance_noise_m: float = DISPLACEMENT.noise
    camera_noise_k: float = TEMPERATURE.noise
    camera_period_s: float = 0.1
    camera_latency_s: float = 0.03


@dataclass(frozen=True)
class ClosedLoop:
    """The response of the strip: its true series at 100 Hz.

    Attributes
    ----------
    time_s : (n,) [s].
    power_w : (n,) applied from each time to the next [W].
    temperature_k : (n,) [K].
    displacement_m : (n,) [m].
    """

    time_s: Floats
    power_w: Floats
    temperature_k: Floats
    displacement_m: Floats

    def __getitem__(self, channel: Channel) -> Floats:
        """The true series of a channel, (n,) [SI]."""
        return {POWER: self.power_w, TEMPERATURE: self.temperature_k, DISPLACEMENT: self.displacement_m}[channel]

    @property
    def energy_j(self) -> float:
        """Light spent [J]."""
        return float(self.power_w.sum() * PERIOD_S)


def run(
    strip: Model | Stepper,
    control: Controller,
    duration_s: float,
    sensors: Sensors = Sensors(),
    seed: int = 0,
    max_power_w: float = 2.0,
    changes: Sequence[tuple[float, Model]] = (),
) -> ClosedLoop:
    """Let a controller act on a strip.

    Parameters
    ----------
    strip : a Model starts from rest, a Stepper from its present state.
    control : gives the power [W] in every period; limited to [0, ``max_power_w``], as by the laser node.
    duration_s : how long [s].
    sensors : their noise and delay.
    seed : of the noise; the same seed gives the same noise.
    max_power_w : limit of the laser [W].
    changes : disturbances; from each time [s] on, the strip has the parameters of the model beside it.

    Raises
    ------
    LceError
        If the duration or the camera's period is shorter than 10 ms, or a change has other terms than the strip.
    """
    if isinstance(strip, Model):
        strip = Stepper(strip)
        strip.step(0.0, 0.0)
    size, shot, latency = (round(t / PERIOD_S) for t in (duration_s, sensors.camera_period_s, sensors.camera_latency_s))
    if size < 1 or shot < 1:
        raise LceError(
            f"a closed loop of {duration_s:g} s with a camera every {sensors.camera_period_s:g} s: too short"
        )
    random = np.random.default_rng(seed)
    distance_noise = sensors.distance_noise_m * random.standard_normal(size)
    camera_noise = sensors.camera_noise_k * random.standard_normal(-(-size // shot))
    events = {round(t_s / PERIOD_S): model for t_s, model in changes}
    time, power, temperature, displacement = np.arange(size, dtype=np.float64) * PERIOD_S, *np.empty((3, size))
    shots = [Sample(strip.measured_temperature_k, 0.0)]
    seen = shots[0]
    for k, t_s in enumerate(time.tolist()):
        if k in events:
            strip.become(events[k])
        temperature[k], displacement[k] = strip.temperature_k, strip.displacement_m
        if k % shot == 0:
            shots.append(Sample(strip.measured_temperature_k + float(camera_noise[k // shot]), t_s))
        if k >= latency and (k - latency) % shot == 0:
            seen = shots[1 + (k - latency) // shot]
        measured = Sample(strip.measured_displacement_m + float(distance_noise[k]), t_s)
        power[k] = min(max(control(t_s, measured, seen), 0.0), max_power_w)
        strip.step(float(power[k]), PERIOD_S)
    return ClosedLoop(time, power, temperature, displacement)
