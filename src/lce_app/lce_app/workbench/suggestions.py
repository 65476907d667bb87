# SPDX-License-Identifier: Apache-2.0
"""What the fields of the tabs hold to begin with: what the diagnosis of the current model suggests."""

from __future__ import annotations

from collections.abc import Sequence

from lce_app.workbench.records import CandidateRecord
from lce_app.workbench.state import WorkbenchState
from lce_data.errors import LceError
from lce_model.effects import library


def effect_to_add(state: WorkbenchState, choices: Sequence[str]) -> str:
    """The effect that the diagnosis found, else the best of its ranking, else the first choice."""
    ranked = (candidate.effect for candidate in _ranking(state))
    return next((effect for effect in ranked if effect in choices), choices[0])


def pair_to_tell_apart(state: WorkbenchState) -> tuple[str, str]:
    """What the diagnosis found and what looks like it, or else comes next; the first two effects without one."""
    ranking = _ranking(state)
    for candidate in ranking:
        if candidate.aliases:
            return candidate.effect, candidate.aliases[0]
    names = [*(candidate.effect for candidate in ranking), *library()]
    return names[0], next(name for name in names if name != names[0])


def _ranking(state: WorkbenchState) -> list[CandidateRecord]:
    """Candidates of the diagnosis, those found first; none if there is no diagnosis that can be read."""
    try:
        found = state.diagnosis()
    except LceError:  # the tab Diagnose says what is wrong with it
        return []
    return sorted(found.candidates, key=lambda c: c.effect not in found.added) if found is not None else []
