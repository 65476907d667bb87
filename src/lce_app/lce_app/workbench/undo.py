# SPDX-License-Identifier: Apache-2.0
"""Decisions taken back, and taken again: the use and the preparation of runs, and which model is the current one.

No file is removed by it: a model that was added stays in the history.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from lce_app.workbench.session import Decisions, Session
from lce_data.errors import LceError

MOST: Final = 200


@dataclass(frozen=True)
class Decided:
    """What was decided, in words, and the decisions on the other side of it."""

    what: str
    decisions: Decisions


class Undo:
    """The decisions of a session that can be undone, the last one last, and those that can be done again."""

    def __init__(self) -> None:
        self._past: list[Decided] = []
        self._future: list[Decided] = []

    @property
    def to_undo(self) -> str:
        """What `undone` takes back; "" if there is nothing."""
        return self._past[-1].what if self._past else ""

    @property
    def to_redo(self) -> str:
        """What `redone` decides again; "" if there is nothing."""
        return self._future[-1].what if self._future else ""

    def decided(self, what: str, before: Session) -> None:
        """Note a decision; what had been undone cannot be done again."""
        self._past = [*self._past, Decided(what, before.decisions)][-MOST:]
        self._future.clear()

    def undone(self, session: Session) -> Session:
        """The session before its last decision. Raises LceError if there is none."""
        return _step(self._past, self._future, session, "nothing to undo")

    def redone(self, session: Session) -> Session:
        """The session with the decision that was undone last. Raises LceError if there is none."""
        return _step(self._future, self._past, session, "nothing to do again")


def _step(this: list[Decided], other: list[Decided], session: Session, nothing: str) -> Session:
    if not this:
        raise LceError(nothing)
    last = this.pop()
    other.append(Decided(last.what, session.decisions))
    return session.decided(last.decisions)
