# SPDX-License-Identifier: Apache-2.0
"""Make a run of a foreign table: what was understood of it, a choice of channel and unit for each column, figures."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Final

from nicegui import background_tasks, events, ui

from lce_app.use_cases.import_runs import Options, import_runs, understand
from lce_app.workbench.figures import Figures
from lce_app.workbench.memory import handed_over, turn_to
from lce_app.workbench.state import WorkbenchState
from lce_app.workbench.texts import named
from lce_app.workbench.uploads import RUNS, TABLES
from lce_data.errors import LceError
from lce_data.importing.headers import SI_UNITS, si_unit
from lce_data.importing.layout import find_layout
from lce_data.importing.recording import HEAD, Pick, Recording
from lce_data.importing.units import typed, units_of
from lce_report.figures.recording import recording_figures

if TYPE_CHECKING:
    from lce_report import Block

LEFT_OUT: Final = "left out"


def fill(state: WorkbenchState) -> Callable[[], None]:
    """The tab, and what brings its list of files up to date."""
    return ImportTab(state).follow


class ImportTab:
    """The tab; ``follow`` lists the files that are no runs yet."""

    def __init__(self, state: WorkbenchState) -> None:
        self._state, self._version = state, -1
        self._file: Path | None = None
        self._recording: Recording | None = None
        self._names: tuple[str, ...] = ()
        ui.label(
            "A table that is no run yet: choose one of this folder, or one from elsewhere. Its separator, columns and "
            "units are found out; correct below what is wrong. (Bags: lce import --topic.) Files that are dropped "
            "anywhere on the page come here too: runs, models and effects of yours go where they belong."
        )
        with ui.row().classes("line"):
            self._files = ui.select({}, label="File of this folder").classes("protocol").mark("foreign file")
            self._files.on_value_change(self._open_chosen)
            pick = ui.button("File from elsewhere …").props("outline no-caps")
            pick.on("click", js_handler="() => lcePickFiles()")
        self._columns = ui.element("div").mark("columns")
        self._figures = Figures(self._blocks).mark("recording")
        self._button = ui.button("Import", color="accent", on_click=self._import).props("unelevated no-caps")
        self._button.classes("as-wide").mark("import")
        self._button.set_enabled(False)

    def follow(self) -> None:
        """Take a table that came from elsewhere; list the files anew when something has changed."""
        if (table := handed_over()) is not None:
            self._files.set_value(None)
            background_tasks.create(self._open(table), name="understand")
        if self._version == self._state.version:
            return
        self._version = self._state.version
        folder = self._state.folder
        refused = [name for name, entry in self._state.entries.items() if entry.error]
        others = [path.name for path in sorted(folder.iterdir()) if path.suffix.lower() in TABLES[1:]]
        names = [name for name in (*refused, *others) if Path(name).suffix.lower() in TABLES]
        self._files.set_options({str(folder / name): name for name in names})

    async def _open_chosen(self, event: events.ValueChangeEventArguments[str | None]) -> None:
        if event.value:
            await self._open(Path(event.value))

    async def _open(self, file: Path) -> None:
        """Another file: what was understood of the one before is shown and imported no more."""
        self._file, self._recording = file, None
        self._columns.clear()
        self._figures.reload()
        self._button.set_enabled(False)
        await self._understand(file)

    async def _understand(self, file: Path, picks: tuple[Pick, ...] = ()) -> None:
        """Understand a file, and show what was understood; a choice that leaves no run is taken back."""
        try:
            names = (await asyncio.to_thread(find_layout, file)).table.names
            (recording,) = await asyncio.to_thread(understand, [file], Options(picks))
            if file != self._file:
                return  # another one was chosen meanwhile
            self._recording, self._names = recording, names
        except LceError as error:
            ui.notify(" ".join(str(error).split()), type="negative")
        if self._recording is not None:
            self._show_columns(self._recording)
            self._figures.reload()
            self._button.set_enabled(True)

    def _show_columns(self, recording: Recording) -> None:
        """A row for each column of the file: what it is, in which unit, and whether that was guessed."""
        held = {signal.source: signal for signal in recording.signals}
        self._columns.clear()
        with self._columns, ui.element("table").classes("columns"):
            with ui.element("thead"), ui.element("tr"):
                for head in (*HEAD[:3], "guessed", *HEAD[3:]):
                    with ui.element("th").props("scope=col"):
                        ui.label(head)
            with ui.element("tbody"):
                for name in self._names:
                    signal = held.get(name)
                    with ui.element("tr"):
                        with ui.element("th").props("scope=row"):
                            ui.label(name)
                        with ui.element("td"):
                            quantity = signal.quantity if signal else LEFT_OUT
                            chosen = ui.select(list(dict.fromkeys([LEFT_OUT, *SI_UNITS, quantity])), value=quantity)
                            named(chosen.props("dense"), f"what {name} is").mark(f"quantity {name}")
                            chosen.on_value_change(partial(self._choose, name))
                        with ui.element("td"):
                            if signal:
                                unit = ui.select(_unit_choices(signal.quantity), value=signal.pick.unit)
                                named(unit.props("dense"), f"unit of {name}").mark(f"unit {name}")
                                unit.on_value_change(partial(self._choose_unit, name))
                        for cell in (" and ".join(signal.guessed), *signal.row()[3:]) if signal else ("",) * 4:
                            with ui.element("td"):
                                ui.label(cell)

    async def _choose(self, name: str, event: events.ValueChangeEventArguments[str]) -> None:
        """Another quantity of a column; the column that was it before is left out."""
        kept = [pick for pick in self._picks() if pick.source != name and pick.quantity != event.value]
        new = [] if event.value == LEFT_OUT else [Pick(event.value, name)]
        await self._decide([*kept, *new])

    async def _choose_unit(self, name: str, event: events.ValueChangeEventArguments[str]) -> None:
        """Another unit of a column."""
        await self._decide([Pick(p.quantity, p.source, event.value) if p.source == name else p for p in self._picks()])

    async def _decide(self, picks: list[Pick]) -> None:
        """Understand the file again as the user says; a quantity that no column is keeps none."""
        assert self._recording is not None
        said = {pick.quantity for pick in picks}
        none = [Pick(quantity, "") for quantity in SI_UNITS if quantity not in said]
        await self._understand(self._recording.path, (*picks, *none))

    def _picks(self) -> list[Pick]:
        return [signal.pick for signal in self._recording.signals] if self._recording else []

    def _blocks(self) -> list[Block]:
        return list(recording_figures(self._recording)) if self._recording else []

    async def _import(self) -> None:
        """Write the run into the folder of the page, and show it there."""
        assert self._recording is not None
        try:
            (file,) = await asyncio.to_thread(import_runs, [self._recording], self._state.folder / RUNS)
        except LceError as error:
            ui.notify(" ".join(str(error).replace("; --force overwrites it", "").split()), type="negative")
            return
        ui.notify(f"{file.relative_to(self._state.folder)} written", type="positive")
        turn_to("Runs")
        await self._state.open()


def _unit_choices(quantity: str) -> dict[str, str]:
    """Units of a quantity as they are picked, and shown; a displacement may count the other way round."""
    units = {typed(unit): unit.symbol for unit in units_of(si_unit(quantity))}
    flipped = {f"-{name}": f"{symbol}, sign flipped" for name, symbol in units.items()}
    return {**units, **flipped} if quantity == "displacement" else units
