# SPDX-License-Identifier: Apache-2.0
"""The topics of the bench as the page sees them: heard by a node in a process of its own."""

from __future__ import annotations

import multiprocessing
from collections import deque
from contextlib import ExitStack
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Final

from lce_app.workbench.snapshot import PERIOD_S, Heard

KEPT_S: Final = 60.0
FORGOTTEN_S: Final = 3.0
"""What a node said of itself so long ago holds no more; it says so once a second."""
_FORK: Final = multiprocessing.get_context("forkserver")


class Ear:
    """Hears the topics of one ROS domain while it is open: the user's own where it is set, else a new one.

    ``heard`` are the moments of the last minute, ``count`` how many there have been.
    """

    def __init__(self) -> None:
        self.heard: deque[Heard] = deque(maxlen=round(KEPT_S / PERIOD_S))
        self.count = 0
        self.domain: int | None = None
        self._held = ExitStack()
        self._process: BaseProcess | None = None

    def open(self) -> int:
        """Begin to listen, if that has not happened, and return the domain."""
        from lce_experiment.domain import own_domain

        if self.domain is None or self._process is None or not self._process.is_alive():
            self.close()
            self.domain = self._held.enter_context(own_domain())
            self._receive, send = _FORK.Pipe(duplex=False)
            self._process = _FORK.Process(target=_listen, args=(send, self.domain), daemon=True)
            self._process.start()
            send.close()
        return self.domain

    def poll(self) -> None:
        """Take in what was heard; to be called often."""
        try:
            while self.domain is not None and self._receive.poll():
                moment: Heard = self._receive.recv()
                self.heard.append(moment)
                self.count += 1
        except EOFError:
            self.close()

    @property
    def conditions(self) -> dict[str, tuple[int, str]]:
        """What the nodes said of themselves in the last seconds, by their names."""
        recent = [moment.conditions for moment in list(self.heard)[-round(FORGOTTEN_S / PERIOD_S) :]]
        return {name: told for conditions in recent for name, told in conditions.items()}

    def since(self, count: int) -> list[Heard]:
        """What was heard after the first ``count`` moments, as far as it is kept."""
        new = self.count - count
        return list(self.heard)[-new:] if new > 0 else []

    def close(self) -> None:
        """Listen no longer."""
        if self._process is not None:
            self._receive.close()
            self._process.terminate()
            self._process.join(5.0)
        self.domain = self._process = None
        self._held.close()


def _listen(send: Connection, domain: int) -> None:
    """In a process of its own: the server does without ROS."""
    from lce_app.workbench.live_node import listen

    listen(send, domain)
