# SPDX-License-Identifier: Apache-2.0
"""Pauses of the whole machine, which no software on it can do anything about."""

import subprocess
import sys
import threading
from typing import Final


class StandStill:
    """How long this machine stood still, seen by a process that only sleeps.

    A sleeper is served before those who compute, so mere load is not counted: only pauses of more than 20 ms are.
    """

    CODE: Final = """
import sys, time
print(0.0, flush=True)
stood, last = 0.0, time.monotonic()
while True:
    time.sleep(0.005)
    now = time.monotonic()
    if now - last > 0.02:
        stood += now - last
        print(stood, flush=True)
    last = now
"""

    def __enter__(self) -> "StandStill":
        self.stood_s = 0.0
        self._sleeper = subprocess.Popen([sys.executable, "-c", self.CODE], stdout=subprocess.PIPE, text=True)
        assert self._sleeper.stdout is not None
        self._sleeper.stdout.readline()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._sleeper.kill()
        self._reader.join()
        self._sleeper.communicate()

    def _read(self) -> None:
        assert self._sleeper.stdout is not None
        for line in self._sleeper.stdout:
            self.stood_s = float(line)
