# SPDX-License-Identifier: Apache-2.0
"""One positioning run on the simulated bench: which nodes, with which parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from lce_experiment import graph
from lce_experiment.recording import conditions, simulated_strip, topics


@dataclass(frozen=True)
class SimulatedBench:
    """What the controllers know (`model_file`), and how the strip differs from it: TERM.PARAM, or a `strip_file`.

    `gains` are laid over control.yaml.
    """

    model_file: Path
    settings: Mapping[str, float] = field(default_factory=dict)
    gains: Path | None = None
    strip_file: Path | None = None


def plan(
    mode: str, target_m: float, bench: SimulatedBench, folder: Path, seed: int, hold_s: float, fast: bool
) -> graph.Plan:
    """The run of a step from rest to `target_m` [m], held for `hold_s` [s] and recorded in `folder`."""
    strip_file = bench.strip_file or bench.model_file
    strip = simulated_strip(strip_file, bench.settings)
    controllers = graph.CONTROLLERS[mode]
    following = {
        "target_m": [target_m],
        "duration_s": hold_s,
        "wait_for": [c.name for c in controllers if c in graph.FOLLOWERS],
    }
    knowing = {c.name: {"model_file": str(bench.model_file.resolve())} for c in controllers if c in graph.MODEL_READERS}
    return graph.Plan(
        f"control {1e3 * target_m:g} mm, {mode}",
        hold_s,
        folder,
        strip_file,
        bench.settings,
        seed,
        fast,
        conditions(strip),
        topics(strip),
        graph.TARGET_PLAYER,
        controllers,
        tuple(f for f in (graph.config_file("control.yaml"), bench.gains) if f is not None),
        {graph.TARGET_PLAYER.name: following, **knowing},
    )
