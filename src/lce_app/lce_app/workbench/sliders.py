# SPDX-License-Identifier: Apache-2.0
"""Parameters under sliders, with the curves of a run following."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Final

import numpy as np
from nicegui import ui

from lce_analysis.identification.transformation import Transformation
from lce_app.workbench.by_hand import ByHand
from lce_app.workbench.error_notification import notify_errors
from lce_app.workbench.figures import Figures
from lce_app.workbench.memory import remember, remembered
from lce_app.workbench.state import WorkbenchState
from lce_app.workbench.texts import heading
from lce_data.errors import LceError
from lce_data.run import Floats
from lce_data.units import after_number
from lce_model import Model, Value
from lce_model.effects import Effect
from lce_report import Block

STEPS: Final = 1000
THROTTLE_S: Final = 0.05


class Sliders:
    """A slider for each parameter that a fit would move, over its bounds, and the curves of a run."""

    def __init__(self, state: WorkbenchState, model: Model) -> None:
        self._state, self._start, self._moved = state, model, model
        self._by_hand: ByHand | None = None
        names = list(state.used())
        heading("By hand")
        self._chosen = ui.select(names, value=remembered("run", names), label="Run").classes("chosen")
        self._chosen.on_value_change(partial(remember, "run"))
        with ui.element("div").classes("hand"):
            with ui.element("div").classes("sliders"):
                with ui.row().classes("line"):
                    ui.button("Keep as a model", on_click=notify_errors(self._keep)).props("outline no-caps").mark(
                        "keep"
                    )
                    ui.button("Back", on_click=self._back).props("outline no-caps").mark("back")
                self._bounds = _Bounds(model, notify_errors(self._widen))
                self._sliders = [_Slider(value, self._follow) for value in model.values if not value.fixed]
            self._figures = Figures(self._curves)
        self._chosen.on_value_change(self._reload)

    def _curves(self) -> Sequence[Block]:
        run = self._state.used()[str(self._chosen.value)]
        self._by_hand = ByHand.of(self._start, run)
        return self._by_hand.blocks(self._start, self._moved)

    def _reload(self) -> None:
        self._by_hand = None
        self._figures.reload()

    def _follow(self, key: str, number: float) -> None:
        others = {varying: own for varying, own in self._moved.varies.items() if varying != key}
        self._move(self._moved.set({key: number}).varying(others))

    def _move(self, model: Model) -> None:
        self._moved = model
        if self._by_hand is not None:
            self._figures.replace(self._by_hand.curves(model))

    def _keep(self) -> None:
        self._state.keep(self._moved, "by hand")

    def _widen(self) -> None:
        key, lower, upper = self._bounds.chosen
        self._state.keep(self._moved.hold({key: (lower, upper)}), f"bounds of {key}: {lower:g} to {upper:g}")

    def _back(self) -> None:
        for slider in self._sliders:
            slider.back()
        self._move(self._start)


class StrengthSlider:
    """A slider on the strength of an effect, from nothing to twice its typical value, and the curves of a run.

    model : without the effect; refitted : with it, all other parameters as they are with the effect.
    """

    def __init__(self, state: WorkbenchState, model: Model, refitted: Model, effect: Effect) -> None:
        self._state, self._start = state, model
        self._moved = refitted.set({effect.strength_key: effect.typical})
        self._by_hand: ByHand | None = None
        names = list(state.used())
        self._chosen = ui.select(names, value=remembered("run", names), label="Run").classes("chosen")
        self._chosen.on_value_change(partial(remember, "run"))
        with ui.element("div").classes("hand"):
            with ui.element("div").classes("sliders"):
                value = self._moved.values[self._moved.index(effect.strength_key)]
                _Slider(value, self._follow, _Between(effect.null, 2.0 * effect.typical - effect.null))
                ui.label("All other parameters stay as they were refitted with it.")
            self._figures = Figures(self._curves)
        self._chosen.on_value_change(self._reload)

    def _curves(self) -> Sequence[Block]:
        run = self._state.used()[str(self._chosen.value)]
        self._by_hand = ByHand.of(self._start, run)
        return self._by_hand.blocks(self._start, self._moved)

    def _reload(self) -> None:
        self._by_hand = None
        self._figures.reload()

    def _follow(self, key: str, number: float) -> None:
        self._moved = self._moved.set({key: number})
        if self._by_hand is not None:
            self._figures.replace(self._by_hand.curves(self._moved))


class _Bounds:
    """A parameter and two numbers, which become its bounds: of its slider, and of whatever is fitted after."""

    def __init__(self, model: Model, kept: Callable[[], None]) -> None:
        self._model = model
        with ui.row().classes("line"):
            keys = [value.key for value in model.values if not value.fixed]
            self._key = ui.select(keys, value=keys[0] if keys else None, label="Bounds of").mark("bounds of")
            self._lower = ui.number("from").mark("bounds from")
            self._upper = ui.number("to").mark("bounds to")
            ui.button("Set bounds", on_click=kept).props("outline no-caps").mark("set bounds")
        self._key.on_value_change(self._show)
        self._show()

    @property
    def chosen(self) -> tuple[str, float, float]:
        """TERM.PARAM and its bounds; LceError if a number is missing."""
        lower, upper = self._lower.value, self._upper.value
        if lower is None or upper is None:
            raise LceError(f"{self._key.value}: give both bounds")
        return str(self._key.value), float(lower), float(upper)

    def _show(self) -> None:
        if self._key.value is not None:
            value = self._model.values[self._model.index(str(self._key.value))]
            self._lower.value, self._upper.value = value.lower, value.upper


@dataclass(frozen=True)
class _Between:
    """A slider that goes evenly from the value ``begin`` to ``end``, which may be the smaller one."""

    begin: float
    end: float

    def to_box(self, values: Floats) -> Floats:
        """Where values lie, from 0 to 1."""
        return (values - self.begin) / (self.end - self.begin)

    def from_box(self, places: Floats) -> Floats:
        """The values there."""
        return self.begin + places * (self.end - self.begin)


class _Slider(ui.element, component="slider.js"):
    """A slider that tells ``follow`` key and value; where it began it stands for exactly the value it began with.

    It goes over the usual range of the parameter, where the value lies in it and nobody chose other bounds; or over
    ``between``.
    """

    def __init__(self, value: Value, follow: Callable[[str, float], None], between: _Between | None = None) -> None:
        self._value, self._follow = value, follow
        self._coordinates = between or Transformation.of([_usual(value)])
        self._began = round(float(self._coordinates.to_box(np.array([value.value]))[0]) * STEPS)
        self._told = ui.label().props("aria-live=polite").tooltip(value.parameter.description)
        super().__init__()
        self._props.update({"began": self._began, "steps": STEPS, "aria-label": value.key})
        self.on("move", lambda event: self._move(int(event.args)), throttle=THROTTLE_S)
        self.mark(f"slider {value.key}")
        self._tell(value.value)

    def back(self) -> None:
        """To where it began."""
        self.run_method("back")
        self._tell(self._value.value)

    def _move(self, position: int) -> None:
        moved = float(self._coordinates.from_box(np.array([position / STEPS]))[0])
        number = self._value.value if position == self._began else moved
        self._tell(number)
        self._follow(self._value.key, number)

    def _tell(self, number: float) -> None:
        self._told.text = f"{self._value.key} = {number:.4g}{after_number(self._value.unit)}"


def _usual(value: Value) -> Value:
    """The value within the usual range of its parameter, if that is where it is and its bounds are the default ones."""
    default = value.parameter
    if default.usual is None or (value.lower, value.upper) != (default.lower, default.upper):
        return value
    lower, upper = default.usual
    return replace(value, lower=lower, upper=upper) if lower <= value.value <= upper else value
