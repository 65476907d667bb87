# SPDX-License-Identifier: Apache-2.0
"""The topics of the bench as the page sees them, received by a node in a process of its own."""

from __future__ import annotations

import multiprocessing
from collections import deque
from contextlib import ExitStack
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Final

from lce_app.workbench.snapshot import PERIOD_S, Snapshot

KEPT_S: Final = 60.0
FORGOTTEN_S: Final = 3.0
"""Age [s] at which the condition of a node is dropped; nodes report once a second."""
_FORK: Final = multiprocessing.get_context("forkserver")


class TopicMonitor:
    """Receives the topics of one ROS domain while it is open: the user's own if it is set, else a new one.

    ``snapshots`` are those of the last minute, ``count`` how many there have been.
    """

    def __init__(self) -> None:
        self.snapshots: deque[Snapshot] = deque(maxlen=round(KEPT_S / PERIOD_S))
        self.count = 0
        self.domain: int | None = None
        self._domain_lock = ExitStack()
        self._process: BaseProcess | None = None

    def open(self) -> int:
        """Start to receive, unless that has happened, and return the domain."""
        from lce_experiment.domain import own_domain

        if self.domain is None or self._process is None or not self._process.is_alive():
            self.close()
            self.domain = self._domain_lock.enter_context(own_domain())
            self._receive, send = _FORK.Pipe(duplex=False)
            self._process = _FORK.Process(target=_monitor, args=(send, self.domain), daemon=True)
            self._process.start()
            send.close()
        return self.domain

    def poll(self) -> None:
        """Take in the new snapshots; to be called often."""
        try:
            while self.domain is not None and self._receive.poll():
                snapshot: Snapshot = self._receive.recv()
                self.snapshots.append(snapshot)
                self.count += 1
        except EOFError:
            self.close()

    @property
    def conditions(self) -> dict[str, tuple[int, str]]:
        """Level and message that each node last reported, if within the last seconds."""
        recent = list(self.snapshots)[-round(FORGOTTEN_S / PERIOD_S) :]
        return {name: condition for snapshot in recent for name, condition in snapshot.conditions.items()}

    def since(self, count: int) -> list[Snapshot]:
        """The snapshots after the first ``count``, as far as they are kept."""
        new = self.count - count
        return list(self.snapshots)[-new:] if new > 0 else []

    def close(self) -> None:
        """Stop to receive."""
        if self._process is not None:
            self._receive.close()
            self._process.terminate()
            self._process.join(5.0)
        self.domain = self._process = None
        self._domain_lock.close()


def _monitor(send: Connection, domain: int) -> None:
    """In a process of its own: the server does not import ROS."""
    from lce_app.workbench.topic_monitor_node import monitor_topics

    monitor_topics(send, domain)
