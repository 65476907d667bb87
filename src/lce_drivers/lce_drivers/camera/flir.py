# SPDX-License-Identifier: Apache-2.0
"""FLIR A3x5 over GigE Vision by Aravis 0.8 (GObject introspection)."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Final

from lce_drivers.background import NoReading
from lce_drivers.camera.radiometry import (
    KELVIN_PER_COUNT,
    ByteOrder,
    Region,
    Statistic,
    decode_mono16,
    implausible,
    strip_temperature_k,
)
from lce_drivers.sensor import Reading

BUFFERS: Final = 8
SOCKET_BUFFER: Final = 4_000_000
FRAME_WAIT_US: Final = 200_000
SILENCE_S: Final = 2.0
WHOLE_FRAME: Final = Region()


@dataclass(frozen=True, slots=True)
class CameraSettings:
    """Which part of the frame to read, and how.

    Temperatures in K, times in s, rates in Hz; ``ir_format`` "" and ``packet_size`` 0 leave the camera's own settings.
    Raises ValueError if no temperature is plausible.
    """

    camera: str = ""
    ir_format: str = "TemperatureLinear10mK"
    byte_order: ByteOrder = "little"
    region: Region = WHOLE_FRAME
    statistic: Statistic = "mean"
    lower_k: float = 253.15
    upper_k: float = 623.15
    latency_s: float = 0.0
    packet_size: int = 0
    rate_hz: float = 10.0

    def __post_init__(self) -> None:
        if self.lower_k >= self.upper_k:
            raise ValueError("flir.lower_c: must be below flir.upper_c")

    @property
    def kelvin_per_count(self) -> float:
        """Scale of the counts [K]."""
        return KELVIN_PER_COUNT.get(self.ir_format, KELVIN_PER_COUNT["TemperatureLinear10mK"])


def aravis() -> tuple[Any, type[Exception]]:
    """Aravis and the exception that it raises. Raises OSError naming the packages to install if it is missing."""
    try:
        import gi

        gi.require_version("Aravis", "0.8")
        from gi.repository import Aravis, GLib
    except (ImportError, ValueError) as error:
        raise OSError(
            f"Aravis 0.8 is not available ({error}): install gir1.2-aravis-0.8 and python3-gi, and make the "
            "virtual environment with --system-site-packages"
        ) from error
    return Aravis, GLib.Error


class FlirLink:
    """Frames from a camera, thinned out to ``rate_hz`` on the multiples of its period, as temperatures."""

    def __init__(self, settings: CameraSettings, clock: Callable[[], float]) -> None:
        """Connect and start the camera. Raises OSError if that fails."""
        self._settings = settings
        self._clock = clock
        self._period = -1
        self._last_frame_s = clock()
        self._aravis, self._failure = aravis()
        try:
            self._camera = self._aravis.Camera.new(settings.camera or None)
            self._camera.set_pixel_format_from_string("Mono16")
            if settings.ir_format:
                # By name: the integer behind it differs between cameras.
                self._camera.set_string("IRFormat", settings.ir_format)
            # Packet sockets are root's, and silent on some interfaces; ordinary ones do for 10 MB/s.
            self._camera.gv_set_stream_options(self._aravis.GvStreamOption.PACKET_SOCKET_DISABLED)
            if settings.packet_size:
                self._camera.gv_set_packet_size(settings.packet_size)
            self._stream = self._camera.create_stream(None, None)
            self._stream.set_property("socket-buffer", self._aravis.GvStreamSocketBuffer.FIXED)
            self._stream.set_property("socket-buffer-size", SOCKET_BUFFER)
            for _ in range(BUFFERS):
                self._stream.push_buffer(self._aravis.Buffer.new_allocate(self._camera.get_payload()))
            self._camera.start_acquisition()
        except self._failure as error:
            raise ConnectionError(f"thermal camera {settings.camera or '(first found)'}: {error}") from error

    def read(self) -> Reading | None:
        """Wait up to 0.2 s for a frame; its reading if one is due, else None."""
        buffer = self._stream.timeout_pop_buffer(FRAME_WAIT_US)
        now_s = self._clock()
        if buffer is None:
            if now_s - self._last_frame_s > SILENCE_S:
                raise TimeoutError(f"thermal camera: no frame for {SILENCE_S:g} s")
            return None
        self._last_frame_s = now_s
        try:
            return self._measure(buffer, now_s - self._settings.latency_s)
        finally:
            self._stream.push_buffer(buffer)

    def close(self) -> None:
        """Stop the camera and let go of it."""
        # A camera that is gone cannot be stopped.
        with suppress(self._failure):
            self._camera.stop_acquisition()
        del self._stream, self._camera

    def _measure(self, buffer: Any, t_s: float) -> Reading | None:
        if buffer.get_status() != self._aravis.BufferStatus.SUCCESS:
            raise NoReading(f"thermal camera: incomplete frame ({buffer.get_status().value_nick})")
        period = int(t_s * self._settings.rate_hz)
        if period == self._period:
            return None
        self._period = period
        return Reading(self._temperature_k(buffer), t_s)

    def _temperature_k(self, buffer: Any) -> float:
        s = self._settings
        try:
            frame = decode_mono16(buffer.get_data(), buffer.get_image_width(), buffer.get_image_height(), s.byte_order)
            counts = s.region.crop(frame)
        except ValueError as error:
            raise NoReading(f"thermal camera: {error}") from error
        if (why := implausible(counts, s.kelvin_per_count, s.lower_k, s.upper_k)) is not None:
            raise NoReading(f"thermal camera: {why}")
        return strip_temperature_k(counts, s.kelvin_per_count, s.statistic)
