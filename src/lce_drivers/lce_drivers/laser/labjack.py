# SPDX-License-Identifier: Apache-2.0
"""Laser power as the analogue output of a LabJack T7 or T8, over Modbus TCP.

Registers are big-endian pairs (function 3 reads, 16 writes). The device's watchdog is armed with a key that
only this process writes: when the process dies or the cable breaks, the device itself takes DAC0 to 0 V. It
counts in whole seconds, two at least. It backs up the 100 ms of the laser node and a hardware interlock; it does
not replace them.
"""

import logging
import math
import struct
from dataclasses import dataclass
from typing import Final, Protocol

DAC0: Final = 1000
TEST: Final = 55100
TEST_VALUE: Final = 0x00112233
PRODUCT_ID: Final = 60000
PRODUCTS: Final = (7.0, 8.0)
WATCHDOG_ENABLE: Final = 61600
WATCHDOG_TIMEOUT_S: Final = 61604
WATCHDOG_STRICT_ENABLE: Final = 61610
WATCHDOG_STRICT_KEY: Final = 61612
WATCHDOG_STRICT_CLEAR: Final = 61614
WATCHDOG_RESET_ENABLE: Final = 61620
WATCHDOG_DAC0_ENABLE: Final = 61640
WATCHDOG_DAC0: Final = 61642
KEY: Final = 0x4C4345


class Registers(Protocol):
    """Pairs of 16-bit registers. Methods raise OSError if the device does not answer."""

    def read(self, address: int) -> tuple[int, int]:
        """The two registers from ``address`` on."""

    def write(self, address: int, pair: tuple[int, int]) -> None:
        """Set the two registers from ``address`` on."""

    def close(self) -> None:
        """Hang up."""


class ModbusRegisters:
    """Registers over Modbus TCP by pymodbus."""

    def __init__(self, host: str, port: int, timeout_s: float) -> None:
        from pymodbus.client import ModbusTcpClient
        from pymodbus.exceptions import ModbusException

        # What goes wrong is in our errors; pymodbus would say it once more on stderr.
        logging.getLogger("pymodbus").addHandler(logging.NullHandler())
        self._where = f"LabJack at {host}:{port}"
        self._failure = ModbusException
        self._client = ModbusTcpClient(host, port=port, timeout=timeout_s, retries=0)
        if not self._client.connect():
            raise ConnectionError(f"{self._where} does not answer")

    def read(self, address: int) -> tuple[int, int]:
        """The two registers from ``address`` on."""
        try:
            answer = self._client.read_holding_registers(address, count=2)
        except self._failure as error:
            raise ConnectionError(f"{self._where}: register {address} cannot be read ({error})") from error
        if answer.isError() or len(answer.registers) != 2:
            raise OSError(f"{self._where}: register {address} cannot be read ({answer})")
        return answer.registers[0], answer.registers[1]

    def write(self, address: int, pair: tuple[int, int]) -> None:
        """Set the two registers from ``address`` on."""
        try:
            answer = self._client.write_registers(address, list(pair))
        except self._failure as error:
            raise ConnectionError(f"{self._where}: register {address} cannot be written ({error})") from error
        if answer.isError():
            raise OSError(f"{self._where}: register {address} cannot be written ({answer})")

    def close(self) -> None:
        """Hang up."""
        self._client.close()


@dataclass(frozen=True, slots=True)
class Calibration:
    """Voltage of a power: 0 V for no power, else threshold_v + volts_per_watt * P, at most max_v."""

    volts_per_watt: float
    threshold_v: float
    max_v: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.volts_per_watt) and self.volts_per_watt > 0.0):
            raise ValueError(
                f"labjack.volts_per_watt: {self.volts_per_watt:g} V/W; measure the driver's slope and set it"
            )
        if not 0.0 <= self.threshold_v < self.max_v <= 10.0:
            raise ValueError(
                f"labjack.threshold_v, max_v: {self.threshold_v:g} V, {self.max_v:g} V; "
                "0 <= threshold_v < max_v <= 10 V"
            )

    @property
    def max_power_w(self) -> float:
        """Power [W] at max_v."""
        return (self.max_v - self.threshold_v) / self.volts_per_watt

    def voltage(self, power_w: float) -> float:
        """Voltage [V] for a power [W]. Raises ValueError for a power that the output cannot give."""
        if not 0.0 <= power_w <= self.max_power_w * (1.0 + 1e-12):
            raise ValueError(f"{power_w:g} W is outside [0, {self.max_power_w:g}] W")
        return min(self.threshold_v + self.volts_per_watt * power_w, self.max_v) if power_w > 0.0 else 0.0


class LabJackLaser:
    """A PowerOutput on DAC0, which is 0 V before this returns and after ``close``."""

    def __init__(self, registers: Registers, calibration: Calibration, watchdog_s: int) -> None:
        if watchdog_s < 2:
            raise ValueError(f"labjack.watchdog_s: {watchdog_s} s is outside [2, inf) s")
        self._registers = registers
        self._calibration = calibration
        try:
            self._recognise()
            self._put_float(DAC0, 0.0)
            self._arm(watchdog_s)
        except OSError:
            registers.close()
            raise

    @property
    def max_power_w(self) -> float:
        """Power [W] at the highest voltage."""
        return self._calibration.max_power_w

    def write(self, power_w: float) -> None:
        """Set the voltage for a power [W] and feed the watchdog."""
        self._put_float(DAC0, self._calibration.voltage(power_w))
        self._put(WATCHDOG_STRICT_CLEAR, KEY)

    def close(self) -> None:
        """Set 0 V and hang up."""
        try:
            self._put_float(DAC0, 0.0)
        finally:
            self._registers.close()

    def _recognise(self) -> None:
        if (test := self._get(TEST)) != TEST_VALUE:
            raise OSError(f"register {TEST} reads {test:#010x}, not {TEST_VALUE:#010x}: not a LabJack T7 or T8")
        if (product := self._get_float(PRODUCT_ID)) not in PRODUCTS:
            raise OSError(f"product {product:g} is not a LabJack T7 or T8")

    def _arm(self, watchdog_s: int) -> None:
        """Set the watchdog. Its settings are in flash memory, so only those that differ are written."""
        settings = {
            WATCHDOG_TIMEOUT_S: watchdog_s,
            WATCHDOG_RESET_ENABLE: 0,
            WATCHDOG_DAC0_ENABLE: 1,
            WATCHDOG_DAC0: _bits(0.0),
            WATCHDOG_STRICT_ENABLE: 1,
            WATCHDOG_STRICT_KEY: KEY,
        }
        different = {address: value for address, value in settings.items() if self._get(address) != value}
        if different:
            self._put(WATCHDOG_ENABLE, 0)
            for address, value in different.items():
                self._put(address, value)
        if self._get(WATCHDOG_ENABLE) != 1:
            self._put(WATCHDOG_ENABLE, 1)
        self._put(WATCHDOG_STRICT_CLEAR, KEY)

    def _get(self, address: int) -> int:
        high, low = self._registers.read(address)
        return high << 16 | low

    def _put(self, address: int, value: int) -> None:
        self._registers.write(address, (value >> 16, value & 0xFFFF))

    def _get_float(self, address: int) -> float:
        return float(struct.unpack(">f", self._get(address).to_bytes(4, "big"))[0])

    def _put_float(self, address: int, value: float) -> None:
        self._put(address, _bits(value))


def _bits(value: float) -> int:
    return int.from_bytes(struct.pack(">f", value), "big")
