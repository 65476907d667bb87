# SPDX-License-Identifier: Apache-2.0
"""Run a model: over a whole input at once, or step by step as a live strip."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, Self

import numpy as np
from numpy.typing import ArrayLike

from lce_data.channels import DISPLACEMENT, TEMPERATURE, Channel
from lce_data.errors import LceError
from lce_model.kernel.compose import SIGNAL_INDEX
from lce_model.kernel.generate import RECORDED
from lce_model.model import Floats, Model

NO_DRIVE: Floats = np.empty(0)
NO_INPUTS: Final[Mapping[Channel, float]] = MappingProxyType({})


@dataclass(frozen=True, eq=False)
class Trajectory:
    """A simulated run: every recorded signal at every time.

    ``trajectory[channel]`` is what a sensor without noise reports, (n,) in the SI unit of the channel.

    Attributes
    ----------
    time_s : (n,) [s].
    signals : the signals of :data:`lce_model.kernel.generate.RECORDED` by name, each (n,) in the unit of
        :data:`lce_model.terms.SIGNALS`; NaN where the model has no such stage.
    """

    time_s: Floats
    signals: Mapping[str, Floats]

    def __getitem__(self, channel: Channel) -> Floats:
        return self.signals[_output(channel)]

    @property
    def temperature_k(self) -> Floats:
        """Temperature of the strip, (n,) [K]."""
        return self.signals["temperature"]

    @property
    def displacement_m(self) -> Floats:
        """Displacement of the strip, (n,) [m]."""
        return self.signals["displacement"]

    @property
    def order(self) -> Floats:
        """Mean order parameter, (n,)."""
        return self.signals["order"]

    @property
    def direction(self) -> Floats:
        """+1 on the heating branch and -1 on the cooling branch, (n,)."""
        return self.signals["direction"]

    @property
    def measured_temperature_k(self) -> Floats:
        """Temperature that a camera without noise reports, (n,) [K]."""
        return self[TEMPERATURE]

    @property
    def measured_displacement_m(self) -> Floats:
        """Displacement that a distance sensor without noise reports, (n,) [m]."""
        return self[DISPLACEMENT]


def _output(channel: Channel) -> str:
    """The signal that the sensor of a channel reports."""
    if channel.output is None:
        raise LceError(f"{channel.name} is an input of the model, not something that it predicts")
    return channel.output


def _checked_time(time_s: ArrayLike) -> Floats:
    time = np.ascontiguousarray(time_s, dtype=np.float64)
    if time.ndim != 1 or time.size < 2 or not np.isfinite(time).all() or not (np.diff(time) > 0.0).all():
        raise LceError("time must be a strictly increasing, finite series of at least two samples")
    return time


def _checked_input(values: ArrayLike, name: str, size: int) -> Floats:
    array = np.ascontiguousarray(values, dtype=np.float64)
    if array.shape != (size,) or not np.isfinite(array).all():
        raise LceError(f"{name} must be {size} finite numbers, one for each time")
    return array


def simulate(
    model: Model,
    time_s: ArrayLike,
    power_w: ArrayLike | None,
    initial_temperature_k: float | None = None,
    temperature_k: ArrayLike | None = None,
    deadband_k: float = 0.0,
    inputs: Mapping[Channel, ArrayLike] = NO_INPUTS,
) -> Trajectory:
    """Simulate P→T→d.

    Parameters
    ----------
    model : terms and values.
    time_s : (n,) strictly increasing [s].
    power_w : (n,) laser power [W], each value held until the next time; None with ``temperature_k``.
    initial_temperature_k : [K]; the temperature of the surroundings if None.
    temperature_k : (n,) [K]; if given, it replaces the thermal stage (a measured temperature drives the strip).
    deadband_k : reversals of the temperature smaller than this [K] do not change the branch.
    inputs : optional inputs by channel [its SI unit], one number or (n,), straight between the times. What is not
        given is not known: the load then is that at which the parameters hold, and the room has the temperature T_env.

    Returns
    -------
    Trajectory
        The signals of the model at ``time_s``.

    Raises
    ------
    LceError
        If the time does not rise, the power, the temperature or an input is not a finite number for each time, or the
        model has no thermal stage and no temperature is given.

    Examples
    --------
    >>> run = simulate(default_model(), [0.0, 0.5, 1.0], [1.0, 1.0, 1.0])  # doctest: +SKIP
    >>> run.displacement_m, run[TEMPERATURE]  # doctest: +SKIP
    """
    time = _checked_time(time_s)
    power = np.zeros_like(time) if power_w is None else _checked_input(power_w, "power", time.size)
    drive = NO_DRIVE if temperature_k is None else _checked_input(temperature_k, "temperature", time.size)
    if temperature_k is None and model.thermal == "none":
        raise LceError("this model has no thermal stage: it needs a measured temperature")
    out = np.empty((time.size, len(RECORDED)))
    kernel = model.kernel
    given = np.full((time.size, len(kernel.inputs)), np.nan)
    for k, channel in enumerate(kernel.inputs):
        if channel in inputs:
            one_number = np.ndim(inputs[channel]) == 0
            value = np.full(time.size, inputs[channel]) if one_number else inputs[channel]
            given[:, k] = _checked_input(value, channel.name, time.size)
    start = math.nan if initial_temperature_k is None else float(initial_temperature_k)
    kernel.run(time, power, drive, given, start, deadband_k, model.vector, out)
    return Trajectory(time, {name: np.ascontiguousarray(out[:, i]) for i, name in enumerate(RECORDED)})


class Stepper:
    """A strip that is simulated step by step, as the simulator node does.

    Parameters
    ----------
    model : with a thermal stage.
    initial_temperature_k : [K]; the temperature of the surroundings if None.
    inputs : optional inputs at the beginning, by channel [its SI unit].

    Raises
    ------
    LceError
        If the model has no thermal stage.

    Examples
    --------
    >>> strip = Stepper(default_model())  # doctest: +SKIP
    >>> strip.step(power_w=1.0, dt_s=0.01)  # doctest: +SKIP
    >>> strip.displacement_m, strip.measured(TEMPERATURE)  # doctest: +SKIP
    """

    def __init__(
        self,
        model: Model,
        initial_temperature_k: float | None = None,
        inputs: Mapping[Channel, float] = NO_INPUTS,
    ) -> None:
        if model.thermal == "none":
            raise LceError("a strip that is stepped by laser power needs a thermal stage")
        self._model = model
        self._kernel = model.kernel
        self._parameters = model.vector
        self._state = np.empty(self._kernel.state_size)
        self._inputs = np.full(len(self._kernel.inputs), np.nan)
        self.set_inputs(inputs)
        start = math.nan if initial_temperature_k is None else float(initial_temperature_k)
        self._kernel.begin(start, 0.0, self._inputs, self._parameters, self._state)

    def copy(self) -> Self:
        """The same strip at the same moment, to be stepped on its own."""
        twin = type(self).__new__(type(self))
        twin.__dict__ |= self.__dict__ | {"_state": self._state.copy(), "_inputs": self._inputs.copy()}
        return twin

    def set_inputs(self, inputs: Mapping[Channel, float]) -> None:
        """Set optional inputs, by channel [its SI unit], from the end of the next step on; those left out stay."""
        for k, channel in enumerate(self._kernel.inputs):
            self._inputs[k] = inputs.get(channel, self._inputs[k])

    def step(self, power_w: float, dt_s: float) -> None:
        """Advance by ``dt_s`` [s] under constant power [W].

        Raises LceError if the power or the time is negative or not finite.
        """
        if not (0.0 <= power_w < math.inf and 0.0 <= dt_s < math.inf):
            raise LceError(f"cannot step by {dt_s} s at {power_w} W: both must be finite and not negative")
        self._kernel.advance(power_w, dt_s, self._inputs, self._parameters, self._state)

    def correct(self, temperature_k: float) -> None:
        """Continue from another temperature [K] than the computed one, as an observer does that has measured it.

        This is of use for thermal models without another state, such as `lumped`.
        """
        if not 0.0 < temperature_k < math.inf:
            raise LceError(f"cannot go on from {temperature_k} K")
        self._state[SIGNAL_INDEX["temperature"]] = temperature_k

    def become(self, model: Model) -> None:
        """Continue from the present state with the parameters of another model of the same terms: a disturbance.

        The parameters of a term whose state is an array have to stay: the array was filled from them at the start.
        Raises LceError if they change, or if the terms do.
        """
        if model.terms != self._model.terms:
            raise LceError("a strip can take on other parameters, not other terms")
        with_arrays = {t.name for t in model.terms if t.arrays}
        for old, new in zip(self._model.values, model.values, strict=True):
            if old.term in with_arrays and old.value != new.value:
                raise LceError(f"{old.key}: cannot change while the strip goes on")
        self._model, self._parameters = model, model.vector

    @property
    def temperature_k(self) -> float:
        """Temperature now [K]."""
        return self.signal("temperature")

    @property
    def displacement_m(self) -> float:
        """Displacement now [m], NaN where the model has no deformation stage."""
        return self.signal("displacement")

    @property
    def measured_temperature_k(self) -> float:
        """What a camera without noise shows now [K]."""
        return self.measured(TEMPERATURE)

    @property
    def measured_displacement_m(self) -> float:
        """What a distance sensor without noise shows now [m]."""
        return self.measured(DISPLACEMENT)

    def measured(self, channel: Channel) -> float:
        """What the sensor of a channel, without noise, reports now [SI]; NaN if the model does not predict it."""
        return self.signal(_output(channel))

    def signal(self, name: str) -> float:
        """A signal of the model now [SI], by its name in :data:`lce_model.terms.SIGNALS`; NaN without its stage."""
        return float(self._state[SIGNAL_INDEX[name]])
