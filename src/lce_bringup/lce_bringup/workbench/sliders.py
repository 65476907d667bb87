# SPDX-License-Identifier: Apache-2.0
"""Parameters under sliders, with the curves of a run following."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Final

import numpy as np
from nicegui import ui

from lce_analysis.fit.coordinates import Coordinates
from lce_analysis.report import Block
from lce_bringup.workbench import drawings
from lce_bringup.workbench.bench import Workbench
from lce_bringup.workbench.figures import Figures
from lce_bringup.workbench.memory import remember, remembered
from lce_bringup.workbench.telling import telling
from lce_model import Model, Value

STEPS: Final = 1000


def sliders(bench: Workbench) -> None:
    """A slider for each parameter that a fit would move, over its bounds, and the curves of a run."""
    start = bench.model()
    names = list(bench.runs("train") | bench.runs("test"))
    assert start is not None
    moved: Model = start
    ui.html("<h2>By hand</h2>", sanitize=False)
    chosen = ui.select(names, value=remembered("run", names), label="Run").classes("chosen")
    chosen.on_value_change(partial(remember, "run"))

    def curves() -> Sequence[Block]:
        run = bench.entries[str(chosen.value)].run
        assert run is not None
        return drawings.by_hand(start, run)

    def follow(value: Value, coordinates: Coordinates, told: ui.label, position: float) -> None:
        nonlocal moved
        number = float(coordinates.from_box(np.array([position / STEPS]))[0])
        moved = moved.set({value.key: number})
        told.text = _told(value, number)
        run = bench.entries[str(chosen.value)].run
        if run is not None:
            figures.replace(drawings.hand_curves(moved, run))

    with ui.element("div").classes("hand"):
        with ui.element("div").classes("sliders"):
            for value in start.values:
                if not value.fixed:
                    _slider(value, follow)
            ui.button("Keep as a model", on_click=telling(lambda: bench.keep(moved, "by hand"))).props(
                "outline no-caps"
            ).mark("keep")
        figures = Figures(curves)
    chosen.on_value_change(figures.reload)


def _slider(value: Value, follow: Callable[[Value, Coordinates, ui.label, float], None]) -> None:
    coordinates = Coordinates.of([value])
    position = float(coordinates.to_box(np.array([value.value]))[0]) * STEPS
    with ui.element("div").classes("slider"):
        told = ui.label(_told(value, value.value))
        slider = ui.slider(min=0, max=STEPS, step=1, value=round(position)).props(f'aria-label="{value.key}"')
        slider.on_value_change(lambda event: follow(value, coordinates, told, float(event.value)))
        slider.mark(f"slider {value.key}")


def _told(value: Value, number: float) -> str:
    return f"{value.key} = {number:.4g}{'' if value.unit == '1' else f' {value.unit}'}"
