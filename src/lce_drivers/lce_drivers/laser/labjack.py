# SPDX-License-Identifier: Apache-2.0
"""Laser power as the analogue output of a LabJack T7 or T8, over Modbus TCP.

Registers are big-endian pairs. The device's watchdog is armed with a key that only this process writes: when the
process dies or the cable breaks, the device itself takes DAC0 to 0 V. It counts in whole seconds, two at least. It
backs up the 100 ms of the laser node and a hardware interlock; it does not replace them. Nothing in the device tells
that it has struck, except DAC0, which then is not what was written.
"""

import math
import struct
from dataclasses import dataclass
from typing import Final

from lce_drivers.laser.modbus import Registers

DAC0: Final = 1000
TEST: Final = 55100
TEST_VALUE: Final = 0x00112233
PRODUCT_ID: Final = 60000
PRODUCTS: Final = (7.0, 8.0)
POWER_UP_IS_FACTORY: Final = 49000
SET_POWER_UP_TO_FACTORY: Final = 49004
WATCHDOG_ENABLE: Final = 61600
WATCHDOG_ADVANCED: Final = 61602
WATCHDOG_TIMEOUT_S: Final = 61604
WATCHDOG_STARTUP_DELAY_S: Final = 61606
WATCHDOG_STRICT_ENABLE: Final = 61610
WATCHDOG_STRICT_KEY: Final = 61612
WATCHDOG_STRICT_CLEAR: Final = 61614
WATCHDOG_RESET_ENABLE: Final = 61620
WATCHDOG_DAC0_ENABLE: Final = 61640
WATCHDOG_DAC0: Final = 61642
KEY: Final = 0x4C4345
READBACK_V: Final = 0.01
"""Largest difference between a voltage as written and as read back; a step of the T7's output is 1.2 mV."""


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
        self._written_v = 0.0
        self._lost = False
        try:
            self._recognise()
            self._put_float(DAC0, 0.0)
            self._set_power_up()
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
        self._written_v = self._calibration.voltage(power_w)
        try:
            self._put_float(DAC0, self._written_v)
            self._put(WATCHDOG_STRICT_CLEAR, KEY)
        except OSError:
            self._lost = True
            raise

    def mismatch(self) -> str | None:
        """In which way the device is not as it was left by the last ``write``; None if it is."""
        try:
            shown_v, armed = self._get_float(DAC0), self._get(WATCHDOG_ENABLE)
        except OSError:
            self._lost = True
            raise
        if not abs(shown_v - self._written_v) <= READBACK_V:
            hint = ": its watchdog has struck" if abs(shown_v) <= READBACK_V else ""
            return f"DAC0 is {shown_v:g} V, not {self._written_v:g} V as written{hint}"
        return None if armed == 1 else "the watchdog of the LabJack is off"

    def close(self) -> None:
        """Set 0 V, over a new connection if the one in use is lost, and hang up."""
        try:
            if not self._lost:
                try:
                    self._put_float(DAC0, 0.0)
                    return
                except OSError:
                    pass
            self._registers.reconnect()
            self._put_float(DAC0, 0.0)
        finally:
            self._registers.close()

    def _recognise(self) -> None:
        if (test := self._get(TEST)) != TEST_VALUE:
            raise OSError(f"register {TEST} reads {test:#010x}, not {TEST_VALUE:#010x}: not a LabJack T7 or T8")
        if (product := self._get_float(PRODUCT_ID)) not in PRODUCTS:
            raise OSError(f"product {product:g} is not a LabJack T7 or T8")

    def _set_power_up(self) -> None:
        """See that the outputs come up as they left the factory, at 0 V; in flash memory, written only if need be."""
        if self._get(POWER_UP_IS_FACTORY) == 1:
            return
        self._put(SET_POWER_UP_TO_FACTORY, 1)
        if self._get(POWER_UP_IS_FACTORY) != 1:
            raise OSError(f"register {SET_POWER_UP_TO_FACTORY}: the outputs of the LabJack may come up lit")

    def _arm(self, watchdog_s: int) -> None:
        """Set the watchdog. Its settings are in flash memory, so only those that differ are written."""
        settings = {
            WATCHDOG_ADVANCED: 0,
            WATCHDOG_TIMEOUT_S: watchdog_s,
            WATCHDOG_STARTUP_DELAY_S: watchdog_s,
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
