# SPDX-License-Identifier: Apache-2.0
"""What is tuned on a model of the strip: the inner loop on the temperature, then the cascade, and the single loop."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final

import numpy as np

from lce_control.cascade import Cascade, Loop, OuterLoop
from lce_control.pid import Limits
from lce_control.tuning.closed_loop import Controller, Sensors, run
from lce_control.tuning.linear import Complex, LinearPlant
from lce_control.tuning.options import DEFAULTS, TuneOptions
from lce_control.tuning.requirements import Parameters, Requirements, Step, Tuned
from lce_control.tuning.search import Task, gains_of, search
from lce_data.channels import DISPLACEMENT, TEMPERATURE, Channel
from lce_data.errors import LceError
from lce_data.progress import Progress
from lce_model import Model, simulate
from lce_model.inverse import HOTTEST_K, InverseChart, temperature_from_here_k

INNER, OUTER, SINGLE = "inner_controller", "outer_controller", "single_controller"
"""The nodes that are tuned."""
SETPOINTS: Final = Limits(273.15, 383.15)
"""Limits of the outer loop's output [K], as its node has them."""
STEADY_S: Final = np.concatenate([[0.0], np.geomspace(0.1, 3000.0, 300)])
"""(301,) times [s], after the last of which a strip under constant power is as hot as it gets."""
HALVINGS: Final = 12
"""How often the range of powers is halved: from 2 W down to half a milliwatt."""


@dataclass(frozen=True)
class TuningPlant:
    """A model of the strip with its sensors and its laser, on which controllers are tuned.

    Parameters
    ----------
    model : a model with a thermal and a deformation stage.
    targets_m : displacements to tune on, rising [m].
    max_power_w : limit of the laser [W].
    sensors : their noise and delay.
    options : duration of the steps, feedback filter, and how the gains are searched.
    """

    model: Model
    targets_m: tuple[float, ...]
    max_power_w: float = 2.0
    sensors: Sensors = field(default_factory=Sensors)
    options: TuneOptions = DEFAULTS

    @classmethod
    def of(cls, model: Model, max_power_w: float = 2.0, options: TuneOptions = DEFAULTS) -> "TuningPlant":
        """A plant with targets over what ``options.power_share`` of the laser's power can hold.

        Raises
        ------
        LceError
            If the model lacks a stage.
        """
        if model.thermal == "none" or model.deformation == "none":
            raise LceError("gains are found on a model with a thermal and a deformation stage; this one lacks one")
        held_k = _steady_temperature_k(model, options.power_share * max_power_w)
        hottest_k = min(held_k, SETPOINTS.upper, HOTTEST_K)
        lower_m, upper_m = InverseChart(model, hottest_k=hottest_k).reach_m("heating")
        targets_m = tuple(max(lower_m, 0.0) + share * upper_m for share in options.shares)
        return cls(model, targets_m, max_power_w, options=options)

    @cached_property
    def temperatures_k(self) -> tuple[float, ...]:
        """The feed-forward for each target, from rest [K]."""
        return tuple(temperature_from_here_k(self.model, [], [], target_m) for target_m in self.targets_m)

    @cached_property
    def linear(self) -> LinearPlant:
        """The strip linearised at the power that holds the middle target."""
        low_w, high_w, wanted_k = 0.0, self.max_power_w, self.temperatures_k[len(self.targets_m) // 2]
        for _ in range(HALVINGS):
            middle_w = 0.5 * (low_w + high_w)
            if _steady_temperature_k(self.model, middle_w) < wanted_k:
                low_w = middle_w
            else:
                high_w = middle_w
        return LinearPlant.of(self.model, high_w, (self.targets_m[0], self.targets_m[-1]))

    @cached_property
    def duration_s(self) -> float:
        """Duration of a step [s]: six times what full power takes to the highest target, within the options' limits."""
        shortest_s, longest_s = self.options.shortest_s, self.options.longest_s
        time = np.arange(0.0, longest_s, 0.1)
        d = simulate(self.model, time, np.full(time.size, self.max_power_w)).displacement_m
        there = np.flatnonzero(d >= self.targets_m[-1])
        return min(max(6.0 * float(time[there[0]]), shortest_s), longest_s) if there.size else longest_s

    def inner(self) -> Task:
        """The inner loop, on steps of the temperature from rest (§6.3)."""
        rest_k = float(simulate(self.model, STEADY_S, np.zeros(STEADY_S.size)).temperature_k[0])

        def control(parameters: Parameters, i: int) -> Controller:
            loop, setpoint_k = self._loop(parameters, INNER), self.temperatures_k[i]
            return lambda t_s, _, temperature: loop.step(t_s, setpoint_k, temperature)

        def steps(parameters: Parameters) -> tuple[Step, ...]:
            found = self._steps(lambda i: control(parameters, i), TEMPERATURE, self.temperatures_k)
            return tuple(replace(s, setpoint=s.setpoint - rest_k, reached=s.reached - rest_k) for s in found)

        def open_loops(parameters: Parameters) -> dict[str, Complex]:
            return {"inner": self.linear.inner(gains_of(parameters[INNER]), self.options.filter_s, self.sensors)}

        return Task("inner", self._box(INNER, 1.0 / self.linear.gain_k_w), steps, open_loops)

    def double(self) -> Task:
        """The cascade, on steps of the displacement from rest, its feed-forward wrong by ``feedforward_error_k``."""

        def control(parameters: Parameters, i: int) -> Controller:
            cascade = Cascade(OuterLoop(self._loop(parameters, OUTER)), self._loop(parameters, INNER))
            target_m = self.targets_m[i]
            feedforward_k = self.temperatures_k[i] + self.options.feedforward_error_k * (-1.0) ** i
            return lambda t_s, d, temperature: cascade.step(t_s, target_m, feedforward_k, d, temperature)

        def open_loops(parameters: Parameters) -> dict[str, Complex]:
            outer, inner = gains_of(parameters[OUTER]), gains_of(parameters[INNER])
            return {
                "inner": self.linear.inner(inner, self.options.filter_s, self.sensors),
                "outer": self.linear.outer(outer, inner, self.options.filter_s, self.sensors),
            }

        box = self._box(OUTER, 0.05 / self.linear.slope_m_k) | self._box(INNER, 1.0 / self.linear.gain_k_w)
        return Task("double", box, self._displacement_steps(control), open_loops)

    def single(self) -> Task:
        """The single loop, on steps of the displacement from rest (§6.5.3)."""

        def control(parameters: Parameters, i: int) -> Controller:
            loop, target_m = self._loop(parameters, SINGLE), self.targets_m[i]
            return lambda t_s, d, _: loop.step(t_s, target_m, d)

        def open_loops(parameters: Parameters) -> dict[str, Complex]:
            return {"single": self.linear.single(gains_of(parameters[SINGLE]), self.options.filter_s)}

        box = self._box(SINGLE, 1.0 / (self.linear.gain_k_w * self.linear.slope_m_k))
        return Task("single", box, self._displacement_steps(control), open_loops)

    def _displacement_steps(
        self, control: Callable[[Parameters, int], Controller]
    ) -> Callable[[Parameters], tuple[Step, ...]]:
        return lambda parameters: self._steps(lambda i: control(parameters, i), DISPLACEMENT, self.targets_m)

    def _steps(
        self, control: Callable[[int], Controller], channel: Channel, setpoints: tuple[float, ...]
    ) -> tuple[Step, ...]:
        found = []
        for i, setpoint in enumerate(setpoints):
            closed = run(self.model, control(i), self.duration_s, self.sensors, seed=i, max_power_w=self.max_power_w)
            found.append(Step(setpoint, closed.time_s, closed[channel], closed.power_w))
        return tuple(found)

    def _loop(self, parameters: Parameters, node: str) -> Loop:
        limits = SETPOINTS if node == OUTER else Limits(0.0, self.max_power_w)
        return Loop.of(gains_of(parameters[node]), limits, self.options.filter_s)

    def _box(self, node: str, lowest_kp: float) -> dict[str, tuple[float, float]]:
        """Bounds of a node's axes: gains from ``lowest_kp`` on, times in shares of the strip's time constant."""
        tau_s = self.linear.tau_s
        return {
            f"{node}.kp": (lowest_kp, 1000.0 * lowest_kp),
            f"{node}.ti": (0.01 * tau_s, 3.0 * tau_s),
            f"{node}.td": (5e-4 * tau_s, 0.1 * tau_s),
            f"{node}.n": (1.0, 100.0),
        }


def tune(plant: TuningPlant, wanted: Requirements, progress: Progress) -> tuple[Tuned, Tuned, Tuned]:
    """Tune the inner loop alone, the cascade, and the single loop, in this order of the result.

    Parameters
    ----------
    plant : the strip, its targets and, in ``plant.options``, how the gains are searched.
    wanted : what every loop has to meet.
    progress : called after each candidate, with the smallest J so far; what it raises ends the search.

    Raises
    ------
    LceError
        If no gains meet the requirements; it names every figure that the best ones miss.
    """
    options = plant.options
    inner, single = (search(task, wanted, options, progress) for task in (plant.inner(), plant.single()))
    guess = shared(single.parameters[SINGLE], inner.parameters[INNER], options.softer)
    return inner, search(plant.double(), wanted, options, progress, guess), single


def shared(single: Mapping[str, float], inner: Mapping[str, float], softer: float) -> Parameters:
    """A cascade with half the gain of a single loop: its inner loop is ``softer`` times softer, the outer has the rest.

    Parameters
    ----------
    single : kp [W/m], ki [W/(m s)], kd [W s/m] and n [1/s] of the single loop.
    inner : kp [W/K] and ki [W/(K s)] of the inner loop alone.
    softer : factor by which the inner loop's gains are reduced.
    """
    soft, lead_s = inner["kp"] / softer, single["kd"] / single["kp"]
    outer = {name: 0.5 * single[name] / soft for name in ("kp", "ki", "kd")}
    within = {"kp": soft, "ki": inner["ki"] / softer, "kd": soft * lead_s, "n": single["n"]}
    return {OUTER: {**outer, "n": single["n"]}, INNER: within}


def _steady_temperature_k(model: Model, power_w: float) -> float:
    """Temperature that a constant power holds [K]."""
    return float(simulate(model, STEADY_S, np.full(STEADY_S.size, power_w)).temperature_k[-1])
