# SPDX-License-Identifier: Apache-2.0
"""What is tuned on a model of the strip: the inner loop on the temperature, then the cascade, and the single loop."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_control.loops import Cascade, Loop, OuterLoop
from lce_control.pid import Limits
from lce_control.tuning.closed_loop import Controller, Sensors, run
from lce_control.tuning.linear import Complex, Plant
from lce_control.tuning.requirements import Parameters, Requirements, Step, Tuned
from lce_control.tuning.search import Task, gains_of, search
from lce_data.errors import LceError
from lce_data.progress import Progress
from lce_model import Model, simulate
from lce_model.inverse import HOTTEST_K, InverseChart, temperature_from_here_k

Floats = NDArray[np.float64]

INNER, OUTER, SINGLE = "inner_controller", "outer_controller", "single_controller"
SETPOINTS: Final = Limits(273.15, 383.15)
"""The outer loop's output [K], as its node has it."""
FILTER_S: Final = 0.1
"""T_f of §6.2."""
SHARES: Final = (0.3, 0.45, 0.65, 0.9)
"""Steps to tune on: shares of the displacement that the laser can hold."""
SHORTEST_S, LONGEST_S = 30.0, 300.0
HELD_S: Final = np.concatenate([[0.0], np.geomspace(0.1, 3000.0, 300)])
SOFTER: Final = 10.0
"""Than alone: how the inner loop of the cascade begins."""
CHART_OFF_K: Final = 2.0
"""How wrong the feed-forward is where the cascade is tuned."""


@dataclass(frozen=True)
class ModelBench:
    """The model and what is between it and the controllers; ``targets_m`` are the displacements to tune on."""

    model: Model
    targets_m: tuple[float, ...]
    max_power_w: float = 2.0
    sensors: Sensors = field(default_factory=Sensors)

    @classmethod
    def of(cls, model: Model, max_power_w: float = 2.0) -> "ModelBench":
        """With targets over what nine tenths of the power can hold."""
        if model.thermal == "none" or model.deformation == "none":
            raise LceError("gains are found on a model with a thermal and a deformation stage; this one lacks one")
        hottest_k = min(_held_k(model, 0.9 * max_power_w), SETPOINTS.upper, HOTTEST_K)
        lower_m, upper_m = InverseChart(model, hottest_k=hottest_k).reach_m("heating")
        return cls(model, tuple(max(lower_m, 0.0) + share * upper_m for share in SHARES), max_power_w)

    @cached_property
    def temperatures_k(self) -> tuple[float, ...]:
        """The feed-forward for each target, from rest."""
        return tuple(temperature_from_here_k(self.model, [], [], target_m) for target_m in self.targets_m)

    @cached_property
    def plant(self) -> Plant:
        """Linearised at the power that holds the middle target."""
        low_w, high_w, wanted_k = 0.0, self.max_power_w, self.temperatures_k[len(SHARES) // 2]
        for _ in range(12):
            middle_w = 0.5 * (low_w + high_w)
            low_w, high_w = (middle_w, high_w) if _held_k(self.model, middle_w) < wanted_k else (low_w, middle_w)
        return Plant.of(self.model, high_w, (self.targets_m[0], self.targets_m[-1]))

    @cached_property
    def duration_s(self) -> float:
        """Of a step: six times what full power takes to the highest target, within 30 and 300 s."""
        time = np.arange(0.0, LONGEST_S, 0.1)
        d = simulate(self.model, time, np.full(time.size, self.max_power_w)).displacement_m
        there = np.flatnonzero(d >= self.targets_m[-1])
        return min(max(6.0 * float(time[there[0]]), SHORTEST_S), LONGEST_S) if there.size else LONGEST_S

    def inner(self) -> Task:
        """The inner loop, on steps of the temperature from rest (§6.3)."""
        rest_k = float(simulate(self.model, HELD_S, np.zeros(HELD_S.size)).temperature_k[0])

        def control(parameters: Parameters, i: int) -> Controller:
            loop, setpoint_k = self._loop(parameters, INNER), self.temperatures_k[i]
            return lambda t_s, _, seen: loop.step(t_s, setpoint_k, seen)

        def steps(parameters: Parameters) -> tuple[Step, ...]:
            found = self._steps(lambda i: control(parameters, i), "temperature_k", self.temperatures_k)
            return tuple(replace(s, setpoint=s.setpoint - rest_k, reached=s.reached - rest_k) for s in found)

        def open_loops(parameters: Parameters) -> dict[str, Complex]:
            return {"inner": self.plant.inner(gains_of(parameters[INNER]), FILTER_S, self.sensors)}

        return Task("inner", self._box(INNER, 1.0 / self.plant.gain_k_w), steps, open_loops)

    def double(self) -> Task:
        """The cascade, on steps of the displacement from rest.

        The feed-forward is off by CHART_OFF_K, up and down in turn: on the model itself it is perfect, and the outer
        loop, which is there for what it gets wrong, would have nothing to be judged by.
        """

        def control(parameters: Parameters, i: int) -> Controller:
            cascade = Cascade(OuterLoop(self._loop(parameters, OUTER)), self._loop(parameters, INNER))
            target_m, feedforward_k = self.targets_m[i], self.temperatures_k[i] + CHART_OFF_K * (-1.0) ** i
            return lambda t_s, d, seen: cascade.step(t_s, target_m, feedforward_k, d, seen)

        def open_loops(parameters: Parameters) -> dict[str, Complex]:
            outer, inner = gains_of(parameters[OUTER]), gains_of(parameters[INNER])
            return {
                "inner": self.plant.inner(inner, FILTER_S, self.sensors),
                "outer": self.plant.outer(outer, inner, FILTER_S, self.sensors),
            }

        box = self._box(OUTER, 0.05 / self.plant.slope_m_k) | self._box(INNER, 1.0 / self.plant.gain_k_w)
        return Task("double", box, self._displacements(control), open_loops)

    def single(self) -> Task:
        """The single loop, on steps of the displacement from rest."""

        def control(parameters: Parameters, i: int) -> Controller:
            loop, target_m = self._loop(parameters, SINGLE), self.targets_m[i]
            return lambda t_s, d, _: loop.step(t_s, target_m, d)

        def open_loops(parameters: Parameters) -> dict[str, Complex]:
            return {"single": self.plant.single(gains_of(parameters[SINGLE]), FILTER_S)}

        box = self._box(SINGLE, 1.0 / (self.plant.gain_k_w * self.plant.slope_m_k))
        return Task("single", box, self._displacements(control), open_loops)

    def _displacements(
        self, control: Callable[[Parameters, int], Controller]
    ) -> Callable[[Parameters], tuple[Step, ...]]:
        return lambda parameters: self._steps(lambda i: control(parameters, i), "displacement_m", self.targets_m)

    def _steps(
        self, control: Callable[[int], Controller], quantity: str, setpoints: tuple[float, ...]
    ) -> tuple[Step, ...]:
        found = []
        for i, setpoint in enumerate(setpoints):
            closed = run(self.model, control(i), self.duration_s, self.sensors, i, self.max_power_w)
            found.append(Step(setpoint, closed.time_s, getattr(closed, quantity), closed.power_w))
        return tuple(found)

    def _loop(self, parameters: Parameters, node: str) -> Loop:
        limits = SETPOINTS if node == OUTER else Limits(0.0, self.max_power_w)
        return Loop.of(gains_of(parameters[node]), limits, FILTER_S)

    def _box(self, node: str, lowest_kp: float) -> dict[str, tuple[float, float]]:
        tau_s = self.plant.tau_s
        return {
            f"{node}.kp": (lowest_kp, 1000.0 * lowest_kp),
            f"{node}.ti": (0.01 * tau_s, 3.0 * tau_s),
            f"{node}.td": (5e-4 * tau_s, 0.1 * tau_s),
            f"{node}.n": (1.0, 100.0),
        }


def tune(bench: ModelBench, wanted: Requirements, progress: Progress, seed: int = 0) -> tuple[Tuned, Tuned, Tuned]:
    """The inner loop alone, the cascade, the single loop; LceError where the requirements cannot be met."""
    inner, single = (search(task, wanted, progress, seed) for task in (bench.inner(), bench.single()))
    guess = shared(single.parameters[SINGLE], inner.parameters[INNER])
    return inner, search(bench.double(), wanted, progress, seed, guess), single


def shared(single: Mapping[str, float], inner: Mapping[str, float]) -> Parameters:
    """Half a single loop as a cascade: a soft inner loop, and an outer one with the rest of the gain."""
    soft, lead_s = inner["kp"] / SOFTER, single["kd"] / single["kp"]
    outer = {name: 0.5 * single[name] / soft for name in ("kp", "ki", "kd")}
    within = {"kp": soft, "ki": inner["ki"] / SOFTER, "kd": soft * lead_s, "n": single["n"]}
    return {OUTER: {**outer, "n": single["n"]}, INNER: within}


def _held_k(model: Model, power_w: float) -> float:
    """Temperature [K] that a power holds."""
    return float(simulate(model, HELD_S, np.full(HELD_S.size, power_w)).temperature_k[-1])
