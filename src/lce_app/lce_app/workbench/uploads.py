# SPDX-License-Identifier: Apache-2.0
"""Files from elsewhere, dropped on the page or picked: each goes where it belongs, and no program runs."""

from __future__ import annotations

import asyncio
import shutil
from pathlib import Path
from typing import Final

from nicegui import events, ui

from lce_app.workbench.memory import hand_over, turn_to
from lce_app.workbench.state import WorkbenchState
from lce_data.errors import LceError

RUNS: Final = "runs"
"""Folder into which runs are written, in that of the page."""
TABLES: Final = (".csv", ".txt", ".tsv", ".dat")
SCRIPT: Final = """<script>
const lceUpload = (method, words) => runMethod(Number(document.querySelector(".upload").id.slice(1)), method, words);
const lcePickFiles = () => lceUpload("pickFiles", []);
addEventListener("dragover", (event) => event.preventDefault());
addEventListener("drop", (event) => {
  event.preventDefault();
  if (event.dataTransfer.files.length) lceUpload("addFiles", [event.dataTransfer.files]);
});
</script>"""


class Uploads:
    """Takes the files that a page is given."""

    def __init__(self, state: WorkbenchState) -> None:
        self._state = state
        upload = ui.upload(auto_upload=True, multiple=True, on_upload=self._take).classes("upload").mark("upload")
        upload.style("display: none")  # screen readers cannot use it; a button of our own opens its dialog

    async def _take(self, event: events.UploadEventArguments) -> None:
        state, name = self._state, Path(event.file.name).name
        effect = Path(name).suffix.lower() == ".py"
        file = (state.session.own_effects if effect else state.session.uploads) / name
        try:
            if effect and file.exists():
                raise LceError(f"{name}: there is an effect file of that name, which models may list; rename yours")
            file.parent.mkdir(parents=True, exist_ok=True)
            await event.file.save(file)
            await self._sort(file)
        except (LceError, OSError) as error:
            ui.notify(" ".join(str(error).split()), type="negative")

    async def _sort(self, file: Path) -> None:
        """Put a file where it belongs, and show it there. Raises LceError if it cannot be used."""
        state, kind = self._state, file.suffix.lower()
        if kind == ".py":
            state.version += 1
            turn_to("Add")
        elif kind in (".yaml", ".yml"):
            await asyncio.to_thread(state.begin_with, file)
            turn_to("Add")
        elif kind == ".mcap" or (kind == ".csv" and await asyncio.to_thread(_is_run, file)):
            runs = state.folder / RUNS
            runs.mkdir(exist_ok=True)
            if (runs / file.name).exists():
                raise LceError(f"{RUNS}/{file.name}: there is a run of that name; rename yours")
            shutil.move(file, runs / file.name)
            turn_to("Runs")
            await state.open()
        elif kind in TABLES:
            hand_over(file)
            turn_to("Import")
        else:
            raise LceError(f"{file.name}: neither a run (.mcap, .csv), a model (.yaml), an effect (.py) nor a table")


def _is_run(file: Path) -> bool:
    from lce_data.run_csv import read_run_csv

    try:
        read_run_csv(file)
    except LceError:
        return False
    return True
