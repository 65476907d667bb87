# SPDX-License-Identifier: Apache-2.0
"""The way into a node's process: the stop signals first, then the imports, which take seconds.

``python -m lce_ros.executable MODULE --ros-args …`` runs the node of a module, `Executable` does so for ``ros2 run``.
"""

import importlib
import os
import signal
import sys
from dataclasses import dataclass
from types import FrameType

from lce_ros.signals import STOP_SIGNALS, handled_signals


@dataclass(frozen=True)
class Executable:
    """An entry point that runs ``main`` of ``module``, the module of a node; it can be stopped from the beginning."""

    module: str

    def __call__(self) -> int:
        """Run the node; returns its exit status. A stop signal during the imports ends the process with status 0."""
        for number in handled_signals():
            signal.signal(number, _leave)
        # Whoever starts nodes has blocked them until now, so that none strikes the start of Python itself.
        signal.pthread_sigmask(signal.SIG_UNBLOCK, STOP_SIGNALS)
        status: int = importlib.import_module(self.module).main()
        for number in STOP_SIGNALS:  # the process ends anyway, and with this status
            signal.signal(number, signal.SIG_IGN)
        return status


def _leave(number: int, frame: FrameType | None) -> None:
    """End at once: nothing has been opened so far. An exception could come in the middle of any import."""
    os._exit(0)


if __name__ == "__main__":
    del sys.argv[0]
    sys.exit(Executable(sys.argv[0])())
