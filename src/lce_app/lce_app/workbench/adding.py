# SPDX-License-Identifier: Apache-2.0
"""New models, from whichever tab: one identified from scratch, or the current one with one effect more."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from lce_app.workbench import command_lines, tasks
from lce_app.workbench.memory import turn_to
from lce_app.workbench.state import WorkbenchState

if TYPE_CHECKING:
    from lce_app.use_cases.fit import ModelChoice


def fit(state: WorkbenchState, choice: ModelChoice) -> None:
    """Begin to identify a model from scratch."""
    how = " + ".join([str(choice.thermal), str(choice.deformation), *choice.effects])
    command = command_lines.fit(state, choice)
    state.start_model("Fit", tasks.fit, f"{how} fitted", None, command, runs=state.paths("train"), choice=choice)


def add(state: WorkbenchState, name: str, file: Path | None = None) -> None:
    """Begin adding an effect of the library, or that of a file, and show where its error falls."""
    number = state.session.current
    assert number is not None
    model = state.session.model_file(number)
    typed = name if file is None else f"./{file.relative_to(state.folder).as_posix()}"
    state.start_model(
        f"Add {name}",
        tasks.add,
        f"{name} added to model {number}",
        number,
        command_lines.add(state, typed, model),
        effect=name if file is None else str(file),
        runs=state.paths("train"),
        test=state.paths("test"),
        model=model,
    )
    turn_to("Add")
