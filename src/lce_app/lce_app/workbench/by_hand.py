# SPDX-License-Identifier: Apache-2.0
"""A run beside a model whose parameters are moved by hand: curves that follow a slider at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from lce_analysis.comparison.compare import QUANTITIES, Quantity
from lce_analysis.prediction import CAMERA, DISTANCE, SimulationInput, simulation_input, start_temperature
from lce_data.run import Floats, Run
from lce_data.units import KELVIN
from lce_model import Model
from lce_report import Block, Curve, Lines
from lce_report.run_section import NAMES, TIME, VALUE

LABEL: Final = "by hand"
FOLLOWED: Final = 4000
"""Samples of a curve that follows a slider, at most: the pixels of a wide screen."""


@dataclass(frozen=True)
class ByHand:
    """What stays as it is while parameters move: the run as the kernel takes it, and the temperature it begins with.

    `predict` would estimate that temperature for every position of a slider, which takes longer than all the rest.
    """

    run: Run
    prepared: SimulationInput
    start_k: float

    @classmethod
    def of(cls, model: Model, run: Run) -> ByHand:
        """The run beside the model that the sliders begin with; LceError where the run lacks what the model needs."""
        prepared = simulation_input(run, model)
        return cls(run, prepared, start_temperature(prepared, model))

    def curves(self, model: Model) -> dict[str, Floats]:
        """What a model says of the run, in the units of the axes: by figure and curve of ``blocks``."""
        out = self.prepared.simulate(model, model.vector[None], np.array([self.start_k]))[0]
        found = {}
        if self.prepared.at_temperature and model.thermal != "none" and self.run.power is not None:
            found[_key("temperature")] = _shown("temperature", self.prepared.at_temperature(out[:, CAMERA]))
        if self.prepared.at_displacement and model.deformation != "none":
            found[_key("displacement")] = _shown("displacement", self.prepared.at_displacement(out[:, DISTANCE]))
        return found

    def blocks(self, model: Model, moved: Model) -> Sequence[Block]:
        """Measured, the model, and the model moved by hand."""
        before, by_hand = self.curves(model), self.curves(moved)
        blocks: list[Block] = []
        for quantity, series in zip(QUANTITIES, (self.run.temperature, self.run.displacement), strict=True):
            key = _key(quantity)
            if series is None or key not in before:
                continue
            curves = (
                Curve("measured", _shown(quantity, series.value), "measured"),
                Curve("model", before[key], "model"),
                Curve(LABEL, by_hand[key], "after"),
            )
            axis, time_s = VALUE[quantity][0], _thin(series.time_s)
            linked = f"by hand {self.run.name}"
            blocks.append(Lines(NAMES[quantity], TIME, axis, time_s, curves, linked=linked, height=220))
        return blocks


def _key(quantity: Quantity) -> str:
    return f"{NAMES[quantity]}/{LABEL}"


def _shown(quantity: Quantity, values: Floats) -> Floats:
    """K or m (n,) in the unit of the axis, as many as are drawn."""
    return (_thin(values) - (KELVIN if quantity == "temperature" else 0.0)) * VALUE[quantity][1]


def _thin(values: Floats) -> Floats:
    """At most FOLLOWED samples, evenly spaced."""
    return values[:: -(-values.size // FOLLOWED)]
