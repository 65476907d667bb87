# SPDX-License-Identifier: Apache-2.0
"""The topics of the bench as the page sees them: heard by a node in a process of its own."""

from __future__ import annotations

import importlib
import multiprocessing
from collections import deque
from contextlib import ExitStack
from dataclasses import dataclass, field
from multiprocessing.process import BaseProcess
from typing import Final

from lce_bringup.domain import own_domain

PERIOD_S: Final = 1.0 / 15.0
KEPT_S: Final = 60.0
HEARD: Final = (
    "temperature",
    "temperature_setpoint",
    "displacement",
    "target_displacement",
    "laser/power",
    "laser/power_command",
)
"""Topics whose values are shown."""
_FORK: Final = multiprocessing.get_context("forkserver")


@dataclass(frozen=True)
class Heard:
    """What came last, at ``time_s`` of the node's clock: values by topic (°C, m, W), conditions of nodes by name."""

    time_s: float
    values: dict[str, float]
    conditions: dict[str, tuple[int, str]] = field(default_factory=dict)


class Ear:
    """Hears the topics of one ROS domain while it is open: the user's own where it is set, else a new one.

    ``heard`` are the moments of the last minute, ``count`` how many there have been, ``conditions`` those told last.
    """

    def __init__(self) -> None:
        self.heard: deque[Heard] = deque(maxlen=round(KEPT_S / PERIOD_S))
        self.count = 0
        self.conditions: dict[str, tuple[int, str]] = {}
        self.domain: int | None = None
        self._held = ExitStack()
        self._process: BaseProcess | None = None

    def open(self) -> int:
        """Begin to listen, if that has not happened, and return the domain."""
        if self.domain is None or self._process is None or not self._process.is_alive():
            self.close()
            self.domain = self._held.enter_context(own_domain())
            listen = importlib.import_module("lce_bringup.workbench.live_node").listen
            self._receive, send = _FORK.Pipe(duplex=False)
            self._process = _FORK.Process(target=listen, args=(send, self.domain), daemon=True)
            self._process.start()
            send.close()
        return self.domain

    def poll(self) -> None:
        """Take in what was heard; to be called often."""
        try:
            while self.domain is not None and self._receive.poll():
                moment: Heard = self._receive.recv()
                self.heard.append(moment)
                self.conditions |= moment.conditions
                self.count += 1
        except EOFError:
            self.close()

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
