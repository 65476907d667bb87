# SPDX-License-Identifier: Apache-2.0
"""Pairs of 16-bit registers over Modbus TCP."""

import logging
from typing import Protocol


class Registers(Protocol):
    """Pairs of 16-bit registers. Methods raise OSError if the device does not answer, or not as asked."""

    def read(self, address: int) -> tuple[int, int]:
        """The two registers from ``address`` on."""

    def write(self, address: int, pair: tuple[int, int]) -> None:
        """Set the two registers from ``address`` on."""

    def reconnect(self) -> None:
        """Give up the connection and make a new one."""

    def close(self) -> None:
        """Hang up."""


class ModbusRegisters:
    """Registers over Modbus TCP by pymodbus (function 3 reads, 16 writes)."""

    def __init__(self, host: str, port: int, timeout_s: float) -> None:
        """``timeout_s`` [s] : longest wait for a connection and for an answer."""
        from pymodbus.client import ModbusTcpClient
        from pymodbus.exceptions import ModbusException

        # What goes wrong is in our errors; pymodbus would say it once more on stderr.
        logging.getLogger("pymodbus").addHandler(logging.NullHandler())
        self._where = f"LabJack at {host}:{port}"
        self._failure = ModbusException
        self._make_client = lambda: ModbusTcpClient(host, port=port, timeout=timeout_s, retries=0)
        self._connect()

    def read(self, address: int) -> tuple[int, int]:
        """The two registers from ``address`` on."""
        try:
            answer = self._client.read_holding_registers(address, count=2)
        except (self._failure, OSError) as error:
            raise ConnectionError(f"{self._where}: register {address} cannot be read ({error})") from error
        if answer.isError() or len(answer.registers) != 2:
            raise OSError(f"{self._where}: register {address} cannot be read ({answer})")
        return answer.registers[0], answer.registers[1]

    def write(self, address: int, pair: tuple[int, int]) -> None:
        """Set the two registers from ``address`` on."""
        try:
            answer = self._client.write_registers(address, list(pair))
        except (self._failure, OSError) as error:
            raise ConnectionError(f"{self._where}: register {address} cannot be written ({error})") from error
        if answer.isError() or (answer.address, answer.count) != (address, 2):
            raise OSError(f"{self._where}: register {address} cannot be written ({answer})")

    def reconnect(self) -> None:
        """Give up the connection and make a new one."""
        self._client.close()
        self._connect()

    def close(self) -> None:
        """Hang up."""
        self._client.close()

    def _connect(self) -> None:
        # A new client: no answer that is still under way on the old connection can be taken for a new one.
        self._client = self._make_client()
        if not self._client.connect():
            raise ConnectionError(f"{self._where} does not answer")
