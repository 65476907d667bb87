# SPDX-License-Identifier: Apache-2.0
"""A run beside a model whose parameters are moved by hand: curves that follow a slider at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from lce_analysis.prediction import SimulationInput, model_of_run, predict_from, simulation_input, start_temperature
from lce_data.channels import Channel
from lce_data.run import Floats, Run
from lce_model import Model
from lce_report import Block, Curve, Lines
from lce_report.figures.axes import TIME, title, value_axis

LABEL: Final = "by hand"
FOLLOWED: Final = 4000
"""Samples of a curve that follows a slider, at most: the pixels of a wide screen."""


@dataclass(frozen=True)
class ByHand:
    """What stays as it is while parameters move: the run as the kernel takes it, and the temperature it begins with.

    `predict` would estimate that temperature for every position of a slider, which takes longer than all the rest.
    """

    run: Run
    run_input: SimulationInput
    start_k: float

    @classmethod
    def of(cls, model: Model, run: Run) -> ByHand:
        """The run beside the model that the sliders begin with; LceError if the run lacks what the model needs."""
        run_input = simulation_input(run, model)
        return cls(run, run_input, start_temperature(run_input, model_of_run(model, run)))

    def curves(self, model: Model) -> dict[str, Floats]:
        """The model's account of the run, in the units of the axes, by figure and curve of ``blocks``."""
        found = predict_from(self.run_input, self.start_k, model_of_run(model, self.run)).at_samples
        return {_key(channel): _shown(channel, values) for channel, values in found.items()}

    def blocks(self, model: Model, moved: Model) -> Sequence[Block]:
        """Measured, the model, and the model moved by hand."""
        before, by_hand = self.curves(model), self.curves(moved)
        blocks: list[Block] = []
        for channel, series in self.run.measured.items():
            key = _key(channel)
            if key not in before:
                continue
            curves = (
                Curve("measured", _shown(channel, series.value), "measured"),
                Curve("model", before[key], "model"),
                Curve(LABEL, by_hand[key], "after"),
            )
            axis, time_s, linked = value_axis(channel), _thin(series.time_s), f"by hand {self.run.name}"
            blocks.append(Lines(title(channel), TIME, axis, time_s, curves, linked=linked, height=220))
        return blocks


def _key(channel: Channel) -> str:
    """Figure and curve, as ``Figures.replace`` names them."""
    return f"{title(channel)}/{LABEL}"


def _shown(channel: Channel, values: Floats) -> Floats:
    """Values [SI] (n,) in the unit of the axis, as many as are drawn."""
    return channel.display.from_si(_thin(values))


def _thin(values: Floats) -> Floats:
    """At most FOLLOWED samples, evenly spaced."""
    return values[:: -(-values.size // FOLLOWED)]
