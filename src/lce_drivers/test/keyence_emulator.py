# SPDX-License-Identifier: Apache-2.0
"""An emulated Keyence controller on a pseudo-terminal."""

import os
import threading
import tty


class Controller:
    """A controller at the other end of a pseudo-terminal, written from the manual's command table."""

    def __init__(self, older: bool = False) -> None:
        self._master, slave = os.openpty()
        tty.setraw(slave)
        self.path = os.ttyname(slave)
        self._slave = slave
        self._older = older
        self.display = "+000.073"
        self.measuring = True
        self.dumb = False
        self.asked: list[str] = []
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def _serve(self) -> None:
        line = b""
        try:
            while byte := os.read(self._master, 1):
                if byte != b"\r":
                    line += byte
                    continue
                command, line = line.decode(), b""
                self.asked.append(command)
                if not self.dumb:
                    os.write(self._master, self._answer(command).encode() + b"\r")
        except OSError:
            return

    def _answer(self, command: str) -> str:
        if command in ("Q0", "R0"):
            self.measuring = command == "R0"
            return command
        known = command == "M1" if self._older else command in ("MS,01", "MS,02")
        if not known:
            return f"ER,{command[:2]},50"
        if not self.measuring:
            return f"ER,{command[:2]},51"
        return f"{command},{self.display}"

    def close(self) -> None:
        # With the last slave closed the thread's read fails; only then may the number of the master be used again.
        os.close(self._slave)
        self._thread.join(timeout=5)
        os.close(self._master)
