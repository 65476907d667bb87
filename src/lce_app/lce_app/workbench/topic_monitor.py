# SPDX-License-Identifier: Apache-2.0
"""The topics of the bench as the page sees them, received by a node in a process of its own."""

from __future__ import annotations

import multiprocessing
from collections import deque
from collections.abc import Iterable, Mapping
from contextlib import ExitStack
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import TYPE_CHECKING, Final

from lce_app.workbench.live_series import Series, TopicFields
from lce_app.workbench.snapshot import PERIOD_S, Snapshot
from lce_data.errors import LceError
from lce_data.marker import Marker

if TYPE_CHECKING:
    from lce_app.workbench.history import History

SNAPSHOTS_S: Final = 60.0
"""How long snapshots are kept [s]."""
FORGOTTEN_S: Final = 3.0
"""Age [s] at which the condition of a node is dropped; nodes report once a second."""
MOST_MARKERS: Final = 500
_FORK: Final = multiprocessing.get_context("forkserver")


class TopicMonitor:
    """Receives the topics of one ROS domain while it is open: the user's own if it is set, else a new one.

    snapshots : those of the last minute; ``count`` says how many there have been.
    topics : what can be watched. histories : what has been received of the series that are.
    markers : the latest, ``marker_count`` how many there have been. began_s : time of the first snapshot [s].
    """

    def __init__(self) -> None:
        self.snapshots: deque[Snapshot] = deque(maxlen=round(SNAPSHOTS_S / PERIOD_S))
        self.count = self.marker_count = 0
        self.began_s = 0.0
        self.topics: tuple[TopicFields, ...] = ()
        self.histories: dict[Series, History] = {}
        self.markers: deque[Marker] = deque(maxlen=MOST_MARKERS)
        self.domain: int | None = None
        self._watched: frozenset[Series] = frozenset()
        self._domain_lock = ExitStack()
        self._process: BaseProcess | None = None
        self._link: Connection | None = None

    def open(self) -> int:
        """Start to receive, unless that has happened, and return the domain."""
        from lce_experiment.domain import own_domain

        if self.domain is None or self._process is None or not self._process.is_alive():
            self.close()
            self.domain = self._domain_lock.enter_context(own_domain())
            self._link, link = _FORK.Pipe()
            self._process = _FORK.Process(target=_monitor, args=(link, self.domain), daemon=True)
            self._process.start()
            link.close()
            self._send(self._watched)
        return self.domain

    def watch(self, wanted: Iterable[Series]) -> None:
        """Receive these series from now on, and no others; what was received of others is forgotten."""
        if (wanted := frozenset(wanted)) == self._watched:
            return
        self._watched = wanted
        self.histories = {series: history for series, history in self.histories.items() if series in wanted}
        self._send(wanted)

    def mark(self, text: str, age_s: float) -> None:
        """Publish a marker of what was ``age_s`` [s] ago. Raises LceError if no topics are received."""
        if self.domain is None:
            raise LceError("nothing runs that could be marked")
        self._send((text, age_s))

    def poll(self) -> None:
        """Take in the new snapshots; to be called often."""
        try:
            while self._link is not None and self._link.poll():
                self._take(self._link.recv())
        except (EOFError, ConnectionResetError):
            self.close()

    def _take(self, snapshot: Snapshot) -> None:
        self.began_s = self.began_s or snapshot.time_s
        self.snapshots.append(snapshot)
        self.count += 1
        self.markers.extend(snapshot.markers)
        self.marker_count += len(snapshot.markers)
        self.topics = self.topics if snapshot.topics is None else snapshot.topics
        if snapshot.samples:
            self._add(snapshot.samples)

    def _add(self, samples: Mapping[Series, tuple[bytes, bytes]]) -> None:
        import numpy as np  # late: the page comes first, and needs neither

        from lce_app.workbench.history import History

        for series, (times, values) in samples.items():
            if series in self._watched:
                history = self.histories.setdefault(series, History())
                history.add(np.frombuffer(times), np.frombuffer(values, np.float32))

    def _send(self, command: frozenset[Series] | tuple[str, float]) -> None:
        if self._link is None:
            return
        try:
            self._link.send(command)
        except (BrokenPipeError, ConnectionResetError):  # its process has ended; poll takes that in
            return

    @property
    def conditions(self) -> dict[str, tuple[int, str]]:
        """Level and message that each node last reported, if within the last seconds."""
        recent = list(self.snapshots)[-round(FORGOTTEN_S / PERIOD_S) :]
        return {name: condition for snapshot in recent for name, condition in snapshot.conditions.items()}

    @property
    def recording(self) -> bool:
        """Is a recorder at work?"""
        return any(name.endswith("/recorder") for name in self.conditions)

    def close(self) -> None:
        """Stop to receive."""
        if self._process is not None and self._link is not None:
            self._link.close()
            self._process.terminate()
            self._process.join(5.0)
        self.domain = self._process = self._link = None
        self._domain_lock.close()


def _monitor(link: Connection, domain: int) -> None:
    """In a process of its own: the server does not import ROS."""
    from lce_app.workbench.topic_monitor_node import monitor_topics

    monitor_topics(link, domain)
