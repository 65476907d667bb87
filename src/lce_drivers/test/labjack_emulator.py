# SPDX-License-Identifier: Apache-2.0
"""An emulated LabJack on 127.0.0.1."""

import socket
import socketserver
import struct
import threading
from collections.abc import Callable
from contextlib import suppress

WATCHDOG = range(61600, 61700)


class LabJackEmulator:
    """A LabJack as far as the laser needs one: registers over Modbus TCP and the watchdog.

    Written from the register table with plain sockets, so that nothing of it is the client's own library.
    Listens on 127.0.0.1:``port``; ``dac0_v`` is what the output gives now, watchdog included. The watchdog goes by
    ``time_s``, which the test sets, or by ``clock`` [s] if there is one. ``mute`` answers nothing; so many
    ``resets`` reset the connection of the next requests instead of answering them; ``stuck`` registers keep a value;
    ``echo`` is the address in the answers to writes.
    """

    def __init__(self, product: float = 8.0, clock: Callable[[], float] | None = None) -> None:
        watchdog = (61600, 61602, 61604, 61606, 61610, 61612, 61620, 61640, 61642)
        self.registers = dict.fromkeys([1000, *watchdog], 0)
        self.registers |= {55100: 0x00112233, 60000: _bits(product), 61604: 60, 49000: 1}
        self.flash_writes: list[tuple[int, int]] = []
        self.wrong_keys = 0
        self.mute = False
        self.resets = 0
        self.stuck: dict[int, int] = {}
        self.echo: int | None = None
        self.time_s = 0.0
        self._clock = clock
        self._fed_s = self._now_s()
        emulator = self

        class Handler(socketserver.BaseRequestHandler):
            def handle(self) -> None:
                while len(head := _exactly(self.request, 7)) == 7:
                    transaction, _, length, unit = struct.unpack(">HHHB", head)
                    request = _exactly(self.request, length - 1)
                    if emulator.resets > 0:
                        emulator.resets -= 1
                        self.request.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
                        self.request.close()
                        return
                    answer = emulator.answer(request)
                    if not emulator.mute:
                        self.request.sendall(struct.pack(">HHHB", transaction, 0, len(answer) + 1, unit) + answer)

        class Server(socketserver.ThreadingTCPServer):
            daemon_threads = True
            allow_reuse_address = True

        self._server = Server(("127.0.0.1", 0), Handler)
        self.port: int = self._server.server_address[1]
        threading.Thread(target=self._server.serve_forever, args=(0.05,), daemon=True).start()

    @property
    def dac0_v(self) -> float:
        r = self.registers
        hungry = self._now_s() - self._fed_s > r[61604]
        if r[61600] == 1 and hungry and r[61640] == 1:
            r[1000] = r[61642]
        return float(struct.unpack(">f", r[1000].to_bytes(4, "big"))[0])

    def answer(self, request: bytes) -> bytes:
        function, address, count = struct.unpack(">BHH", request[:5])
        self.dac0_v  # noqa: B018  the watchdog may have struck before this request
        if function == 3 and count == 2 and address in self.registers:
            return struct.pack(">BBI", 3, 4, self.stuck.get(address, self.registers[address]))
        if function == 16 and count == 2 and (address in self.registers or address in (49004, 61614)):
            self._set(address, int.from_bytes(request[6:10], "big"))
            return struct.pack(">BHH", 16, address if self.echo is None else self.echo, 2)
        return struct.pack(">BB", function | 0x80, 2)

    def _set(self, address: int, value: int) -> None:
        if address == 61614:
            if value == self.registers[61612]:
                self._fed_s = self._now_s()
            else:
                self.wrong_keys += 1
            return
        if address in WATCHDOG or address == 49004:
            self.flash_writes.append((address, value))
        if address == 61600 and value == 1:
            self._fed_s = self._now_s()
        if address == 49004:
            self.registers[49000] = value
            return
        self.registers[address] = value

    def _now_s(self) -> float:
        return self.time_s if self._clock is None else self._clock()

    def close(self) -> None:
        self._server.shutdown()
        self._server.server_close()


def _exactly(connection: socket.socket, count: int) -> bytes:
    """So many bytes, or fewer where the connection ends."""
    data = b""
    with suppress(OSError):
        while len(data) < count and (more := connection.recv(count - len(data))):
            data += more
    return data


def _bits(value: float) -> int:
    return int.from_bytes(struct.pack(">f", value), "big")
