# SPDX-License-Identifier: Apache-2.0
"""Cases for the modes of control: targets, trajectories, disturbances, and a strip that differs from the model."""

from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any, Final

import numpy as np
import yaml
from numpy.typing import NDArray
from reference_controllers import DoubleLoop, ReferenceController, SingleLoop

from lce_control.cascade import Loop, OuterLoop
from lce_control.model_control import ModelController
from lce_control.nodes import inner_controller_node, outer_controller_node, single_controller_node
from lce_control.pid import Gains, Limits
from lce_control.time_optimal import fastest_power_w
from lce_control.tuning.closed_loop import PERIOD_S, ClosedLoop, run
from lce_data.units import KELVIN
from lce_experiment.config import config_file
from lce_model import Model, Stepper, load_model

Floats = NDArray[np.float64]
MODES: Final = ("single", "double", "model")
MAX_POWER_W: Final = 2.0
STREAM_S: Final = 0.04
"""A trajectory is a new target every 40 ms."""


@dataclass(frozen=True)
class Case:
    """Targets on a strip.

    Parameters
    ----------
    name : of the case.
    targets : pairs of time [s] and target [m].
    duration_s : of the whole case [s].
    settings : parameters of the strip that differ from the model that the controllers know, by name.
    changes : from each time [s] on, the strip has other parameters, by name: a disturbance.
    """

    name: str
    targets: tuple[tuple[float, float], ...]
    duration_s: float
    settings: Mapping[str, float] = field(default_factory=dict)
    changes: tuple[tuple[float, Mapping[str, float]], ...] = ()

    def target_m(self, time_s: Floats) -> Floats:
        """The target at each time (n,) [m]."""
        times, targets = np.array(self.targets).T
        return np.asarray(targets[np.searchsorted(times, time_s + 1e-9, side="right") - 1])


def steps(name: str, targets_mm: tuple[float, ...], hold_s: float = 60.0, **others: Any) -> Case:
    """Targets one after the other, from rest."""
    targets = tuple((k * hold_s, 1e-3 * target_mm) for k, target_mm in enumerate(targets_mm))
    return Case(name, targets, hold_s * len(targets), **others)


def trajectory(name: str, target_m: Callable[[Floats], Floats], duration_s: float) -> Case:
    """A target that moves, set anew every STREAM_S."""
    time_s = np.arange(0.0, duration_s, STREAM_S)
    return Case(name, tuple(zip(time_s.tolist(), target_m(time_s).tolist(), strict=True)), duration_s)


@cache
def known() -> Model:
    """The strip as the controllers know it."""
    return load_model(config_file("models/strip.yaml"))


def controller(mode: str, model: Model) -> ReferenceController:
    """The controller of a mode with the parameters that its nodes have under config/control.yaml."""
    power = Limits(0.0, MAX_POWER_W)
    if mode == "model":
        return ModelController(model, MAX_POWER_W, to_kelvin(110.0)).step
    if mode == "single":
        return SingleLoop(_loop("single_controller", single_controller_node.TUNED, power)).step
    outer = _loop("outer_controller", outer_controller_node.TUNED, Limits(to_kelvin(0.0), to_kelvin(110.0)))
    follow_k = _configured("outer_controller")["follow_k"]
    inner = _loop("inner_controller", inner_controller_node.TUNED, power)
    return DoubleLoop(model, OuterLoop(outer, follow_k), inner).step


def _loop(node: str, tuned: Gains, limits: Limits) -> Loop:
    given = _configured(node)
    loop = Loop.of(replace(tuned, **{k: v for k, v in given.items() if hasattr(tuned, k)}), limits)
    loop.pid.horizon_s = given.get("horizon_s", loop.pid.horizon_s)
    loop.feedback.time_constant_s = given.get("filter_s", loop.feedback.time_constant_s)
    return loop


@cache
def _configured(node: str) -> dict[str, Any]:
    content = yaml.safe_load(config_file("control.yaml").read_text(encoding="utf-8"))
    return dict(content.get(f"/**/{node}", {}).get("ros__parameters", {}))


def to_kelvin(celsius: float) -> float:
    """°C in K."""
    return celsius + KELVIN


def play(case: Case, mode: str, seed: int) -> ClosedLoop:
    """A case under a mode of control, or under "limit": the controller knows the true state of the strip."""
    plant = known().set(case.settings)
    changes = [(t_s, plant.set(values)) for t_s, values in case.changes]
    strip = Stepper(plant)
    strip.step(0.0, 0.0)
    target_m = case.target_m(np.arange(round(case.duration_s / PERIOD_S)) * PERIOD_S).tolist()
    if mode == "limit":
        rates = _rates(case, len(target_m))
        return run(
            strip,
            lambda t, *_: fastest_power_w(
                strip, target_m[k := round(t / PERIOD_S)], PERIOD_S, MAX_POWER_W, rate_m_s=rates[k]
            ),
            case.duration_s,
            changes=changes,
        )
    step = controller(mode, known())
    return run(
        strip,
        lambda t, displacement, temperature: step(t, target_m[round(t / PERIOD_S)], displacement, temperature),
        case.duration_s,
        seed=seed,
        changes=changes,
    )


def _rates(case: Case, size: int) -> list[float]:
    """Rate of the target in each period [m/s]; 0 for steps."""
    times, targets = np.array(case.targets).T
    if times.size < 2 or np.diff(times).max() > STREAM_S + 1e-9:
        return [0.0] * size
    row = np.minimum(np.arange(size) * PERIOD_S / STREAM_S, times.size - 2).astype(int)
    return [*(np.diff(targets)[row] / STREAM_S).tolist()]


def play_all(jobs: list[tuple[Case, str, int]], workers: int) -> Iterator[ClosedLoop]:
    """Every (case, mode, seed), in that order."""
    with ProcessPoolExecutor(workers) as pool:
        yield from pool.map(play, *zip(*jobs, strict=True), chunksize=4)
