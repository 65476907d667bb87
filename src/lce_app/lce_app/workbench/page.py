# SPDX-License-Identifier: Apache-2.0
"""The page: a head with the model and the job under way, and the tabs."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import Final

from nicegui import ui
from nicegui.events import KeyEventArguments

from lce_app.workbench import tabs
from lce_app.workbench.error_notification import notify_errors_of
from lce_app.workbench.figures import HEAD
from lce_app.workbench.job_status_bar import JobStatusBar
from lce_app.workbench.memory import keep_tabs
from lce_app.workbench.state import WorkbenchState
from lce_app.workbench.texts import heading
from lce_app.workbench.uploads import SCRIPT, Uploads
from lce_data.errors import LceError

PERIOD_S: Final = 0.1
TABS: Final = {
    "Runs": "runs",
    "Import": "import_",
    "Prepare": "prepare",
    "Compare": "compare",
    "Diagnose": "diagnose",
    "Add": "add",
    "Design": "design",
    "Export": "export",
    "Bench": "bench",
}
"""Their modules."""
FORMER_NAMES: Final = {"Look": "Compare", "Learn": "Diagnose", "Tell apart": "Design", "Take away": "Export"}
"""Names that the tabs had before; old links hold on to them."""
FIRST: Final = "Runs"
"""It needs no more than the runs; the others come when the analysis is loaded, which takes a second or two."""
THEME: Final = """<script>
addEventListener("DOMContentLoaded", () => {
  const follow = () => {
    document.documentElement.dataset.theme = document.body.classList.contains("body--dark") ? "dark" : "light";
    document.dispatchEvent(new Event("theme"));
  };
  new MutationObserver(follow).observe(document.body, { attributeFilter: ["class"] });
  follow();
  const here = new URL(location);
  if (here.searchParams.has("token")) {  // a cookie keeps it: it need not stay where others may read it
    here.searchParams.delete("token");
    history.replaceState(history.state, "", here);
  }
});
addEventListener("keydown", (event) => {  // else the browser takes back what was typed last, in whatever field
  const undoes = (event.ctrlKey || event.metaKey) && ["z", "y"].includes(event.key.toLowerCase());
  if (undoes && !event.target.closest("input, select, textarea")) event.preventDefault();
});
</script>"""


class Page:
    """The page of one client, kept up to date by one timer."""

    def __init__(self, state: WorkbenchState, tab: str) -> None:
        self._state, self._shown_version = state, -1
        tab = FORMER_NAMES.get(tab, tab)
        ui.add_head_html(HEAD + THEME + SCRIPT)
        ui.colors(primary="#1b5e9e", accent="#1b5e9e", negative="#b3261e")
        dark = ui.dark_mode(None)
        with ui.header().classes("head"):
            heading("LCE workbench", level=1)
            ui.label(str(state.folder)).classes("folder")
            self._status = ui.label().classes("state").props("role=status")
            self._undo = ui.button("Undo", on_click=notify_errors_of(state.undo)).props("flat no-caps").mark("undo")
            self._redo = ui.button("Redo", on_click=notify_errors_of(state.redo)).props("flat no-caps").mark("redo")
            ui.button("light / dark", on_click=lambda: dark.set_value(not dark.value)).props("flat no-caps")
        self._status_bar = JobStatusBar(state)
        Uploads(state)
        with ui.tabs().props("no-caps align=left aria-label=Views") as heads:
            for name in TABS:
                ui.tab(name)
        keep_tabs(heads)
        heads.on_value_change(lambda event: ui.navigate.history.replace(f"/?tab={event.value}"))
        with ui.tab_panels(heads, value=tab if tab in TABS else FIRST, animated=False):
            self._panels = {name: ui.tab_panel(name) for name in TABS}
        for panel in self._panels.values():
            with panel:
                ui.label("loading …")
        ui.keyboard(on_key=self._on_key, ignore=[])
        ui.keyboard(on_key=self._on_undo_key, ignore=["input", "select", "textarea"])  # a field undoes its own text
        self._follow: dict[str, Callable[[], None]] = {}
        self.follow()
        ui.timer(PERIOD_S, self.follow)

    def follow(self) -> None:
        """Show what has changed."""
        state = self._state
        self._status_bar.follow()
        self._status.text = state.busy or _model_line(state)
        for button, word, what in (
            (self._undo, "Undo", state.undoing.to_undo),
            (self._redo, "Redo", state.undoing.to_redo),
        ):
            if button.props.get("title") != (told := f"{word} {what}".rstrip()):
                button.enabled = bool(what)
                button.props["title"] = button.props["aria-label"] = told
        if state.version != self._shown_version and (state.entries or state.ready):
            self._shown_version = state.version
            self._fill()
        for follow in self._follow.values():
            follow()

    def _on_key(self, event: KeyEventArguments) -> None:
        """Esc, wherever it is pressed, stops the bench."""
        if event.key.escape and event.action.keydown:
            self._state.stop()

    async def _on_undo_key(self, event: KeyEventArguments) -> None:
        """Ctrl+Z takes the last decision back, Ctrl+Shift+Z or Ctrl+Y decides it again."""
        held, undoing = event.modifiers, self._state.undoing
        if not event.action.keydown or not (held.ctrl or held.meta) or held.alt:
            return
        key = event.key.name.lower()
        if key == "z" and not held.shift and undoing.to_undo:
            await self._state.undo()
        elif ((key == "z" and held.shift) or key == "y") and undoing.to_redo:
            await self._state.redo()

    def _fill(self) -> None:
        """Fill the tabs anew that do not follow by themselves."""
        for name, panel in self._panels.items():
            if name in self._follow or not (self._state.ready or name == FIRST):
                continue
            panel.clear()
            with panel:
                try:
                    follow = importlib.import_module(f"{tabs.__name__}.{TABS[name]}").fill(self._state)
                except LceError as error:
                    ui.label(str(error)).classes("bad")
                    continue
            if follow is not None:
                self._follow[name] = follow


def _model_line(state: WorkbenchState) -> str:
    if state.session.current is None:
        return "no model yet"
    return f"model {state.session.current}: {state.session.kept(state.session.current).how}"
