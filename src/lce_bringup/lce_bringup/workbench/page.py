# SPDX-License-Identifier: Apache-2.0
"""The page: a head with the model and the job under way, and the tabs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from nicegui import ui

from lce_bringup.workbench.bench import Workbench
from lce_bringup.workbench.figures import HEAD
from lce_bringup.workbench.job_strip import JobStrip
from lce_bringup.workbench.tabs.add import add
from lce_bringup.workbench.tabs.apart import apart
from lce_bringup.workbench.tabs.bench import Bench
from lce_bringup.workbench.tabs.learn import learn
from lce_bringup.workbench.tabs.look import look
from lce_bringup.workbench.tabs.runs import runs
from lce_bringup.workbench.tabs.take_away import take_away

PERIOD_S: Final = 0.1
TABS: Final[dict[str, Callable[[Workbench], None]]] = {
    "Runs": runs,
    "Look": look,
    "Learn": learn,
    "Add": add,
    "Tell apart": apart,
    "Take away": take_away,
}
BENCH: Final = "Bench"
THEME: Final = """<script>
addEventListener("DOMContentLoaded", () => {
  const follow = () => {
    document.documentElement.dataset.theme = document.body.classList.contains("body--dark") ? "dark" : "light";
    document.dispatchEvent(new Event("theme"));
  };
  new MutationObserver(follow).observe(document.body, { attributeFilter: ["class"] });
  follow();
});
</script>"""


def page(bench: Workbench, tab: str) -> None:
    """Build the page for one client, and keep it up to date."""
    ui.add_head_html(HEAD + THEME)
    ui.colors(primary="#1b5e9e", accent="#1b5e9e", negative="#b3261e")
    dark = ui.dark_mode(None)
    with ui.header().classes("head"):
        ui.html("<h1>LCE workbench</h1>", sanitize=False)
        ui.label(str(bench.folder)).classes("folder")
        state = ui.label().classes("state").props("role=status")
        ui.button("light / dark", on_click=lambda: dark.set_value(not dark.value)).props("flat no-caps")
    strip = JobStrip(bench)
    tab = tab if tab in (*TABS, BENCH) else "Runs"
    with ui.tabs().props("no-caps align=left aria-label=Views") as tabs:
        for name in (*TABS, BENCH):
            ui.tab(name)
    tabs.on_value_change(lambda event: ui.navigate.history.replace(f"/?tab={event.value}"))
    refreshers = []
    with ui.tab_panels(tabs, value=tab, animated=False).classes("panels"):
        for name, fill in TABS.items():
            with ui.tab_panel(name):
                refreshers.append(_refreshable(bench, fill))
        with ui.tab_panel(BENCH):
            live = Bench(bench)
    shown = bench.version

    def follow() -> None:
        nonlocal shown
        strip.follow()
        live.follow()
        state.text = bench.busy or _model_line(bench)
        if bench.version != shown:
            shown = bench.version
            for refresh in refreshers:
                refresh()

    follow()
    ui.timer(PERIOD_S, follow)


def _refreshable(bench: Workbench, fill: Callable[[Workbench], None]) -> Callable[[], object]:
    filled = ui.refreshable(fill)
    filled(bench)
    return filled.refresh


def _model_line(bench: Workbench) -> str:
    if bench.session.current is None:
        return "no model yet"
    return f"model {bench.session.current}: {bench.session.kept(bench.session.current).how}"
