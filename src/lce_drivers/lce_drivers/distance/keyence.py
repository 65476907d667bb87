# SPDX-License-Identifier: Apache-2.0
"""Keyence laser displacement sensors over RS-232: LK-G5000 and the older LK-G; ASCII, ended by CR."""

import re
import termios
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Final, Protocol

from lce_drivers.background import NoReading
from lce_drivers.sensor import Reading

CR: Final = b"\r"
NUMBER: Final = re.compile(r"[+-]?[0-9]+(\.[0-9]*)?")
"""All that a display can show: no exponent, whatever noise on the line makes look like one."""
WRONG_STATE: Final = 51
ERRORS: Final = {
    50: "command error",
    51: "state error",
    60: "command length error",
    61: "parameter count error",
    62: "parameter range error",
    88: "time-out error",
    99: "other error",
}


class Refused(NoReading):
    """The controller answered ER,<command>,<code>."""

    def __init__(self, command: str, code: int) -> None:
        self.code = code
        super().__init__(f"the controller refuses {command}: {ERRORS.get(code, 'unknown error')} ({code})")


@dataclass(frozen=True, slots=True)
class Dialect:
    """How one output of a series of controllers is asked for; ``measure`` formats with ``out``."""

    measure: str

    def command(self, out: int) -> str:
        """Text of the command that asks for output ``out``."""
        return self.measure.format(out=out)


DIALECTS: Final = {"lk_g5000": Dialect("MS,{out:02d}"), "lk_g": Dialect("M{out}")}


def parse(answer: bytes, command: str) -> float:
    """Value in the unit of the display.

    The decimal point moves with the settings of the controller, so the field is parsed, not its columns. Raises
    NoReading, with the answer, if the controller did not send a number.
    """
    text = answer.decode("ascii", errors="replace").strip()
    if text.startswith("ER,"):
        code = text.rpartition(",")[2]
        raise Refused(command, int(code) if code.isdigit() else 99)
    echo, _, field = text.rpartition(",")
    if echo != command:
        raise NoReading(f"{text!r} is no answer to {command}")
    digits = field.lstrip("+-")
    if digits and set(digits) == {"F"}:
        raise NoReading(f"over range ({field})")
    if digits and set(digits) <= {"X", "-"}:
        raise NoReading(f"no value ({field})")
    if not NUMBER.fullmatch(field):
        raise NoReading(f"{field!r} in the answer {text!r} is not a number")
    return float(field)


@dataclass(frozen=True, slots=True)
class Mounting:
    """How the display becomes a displacement: (sign * display - zero) * metres, contraction positive.

    Beyond ``lower_m`` and ``upper_m`` [m] there is no displacement: twice the ±40 mm that an LK-H152 measures. Raises
    ValueError if the sign is neither 1 nor -1.
    """

    sign: float = 1.0
    zero: float = 0.0
    metres: float = 1e-3
    lower_m: float = -0.08
    upper_m: float = 0.08

    def __post_init__(self) -> None:
        if self.sign not in (1.0, -1.0):
            raise ValueError(f"keyence.sign: {self.sign:g} is neither 1 nor -1; a scale belongs into keyence.metres")

    def displacement_m(self, display: float) -> float:
        """Displacement [m] for a value in the unit of the display. Raises NoReading if it cannot be one."""
        found_m = (self.sign * display - self.zero) * self.metres
        if not self.lower_m <= found_m <= self.upper_m:
            raise NoReading(f"a displacement of {found_m:g} m is outside [{self.lower_m:g}, {self.upper_m:g}] m")
        return found_m


class Port(Protocol):
    """The part of serial.Serial that the link uses."""

    def write(self, data: bytes, /) -> int | None:
        """Send bytes."""

    def read_until(self, expected: bytes = ...) -> bytes:
        """Bytes up to and with ``expected``, or what came before the time-out."""

    def reset_input_buffer(self) -> None:
        """Forget what came so far."""

    def close(self) -> None:
        """Let go of the port."""


def open_port(path: str, baud_rate: int, timeout_s: float) -> Port:
    """A serial port, 8N1. Raises OSError if the port does not exist or is in use."""
    import serial

    with _lost_port_is_os_error():
        port: Port = serial.Serial(path, baud_rate, timeout=timeout_s, write_timeout=timeout_s, exclusive=True)
    return port


@contextmanager
def _lost_port_is_os_error() -> Iterator[None]:
    """pySerial lets termios.error through, which is no OSError, when an adapter is unplugged."""
    try:
        yield
    except termios.error as error:
        raise OSError(*error.args) from error


class KeyenceLink:
    """Asks one output for its value; a reading is stamped half-way between question and answer."""

    def __init__(self, port: Port, dialect: str, out: int, mounting: Mounting, clock: Callable[[], float]) -> None:
        self._port = port
        self._command = DIALECTS[dialect].command(out)
        self._mounting = mounting
        self._clock = clock

    def read(self) -> Reading | None:
        """Ask once. Raises NoReading if the answer is not a number, OSError if no answer comes."""
        asked_s = self._clock()
        try:
            value = parse(self._ask(self._command), self._command)
        except Refused as error:
            if error.code == WRONG_STATE:
                # Somebody left the controller in its settings (Q0), where it does not measure.
                self._ask("R0")
            raise
        return Reading(self._mounting.displacement_m(value), 0.5 * (asked_s + self._clock()))

    def close(self) -> None:
        """Let go of the port."""
        with _lost_port_is_os_error():
            self._port.close()

    def _ask(self, command: str) -> bytes:
        with _lost_port_is_os_error():
            self._port.reset_input_buffer()
            self._port.write(command.encode("ascii") + CR)
            answer = self._port.read_until(CR)
        if not answer.endswith(CR):
            raise TimeoutError(f"no answer to {command} from the displacement sensor")
        return answer
