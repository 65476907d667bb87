# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from lce_drivers.camera.radiometry import Region, decode_mono16, implausible, strip_temperature_k, to_kelvin


def frame(kelvin: float, shape: tuple[int, int] = (240, 320)) -> np.ndarray:
    return np.full(shape, round(kelvin / 0.01), dtype=np.uint16)


def test_counts_are_hundredths_or_tenths_of_a_kelvin() -> None:
    counts = np.array([[0, 29315]], dtype=np.uint16)
    assert to_kelvin(counts, 0.01).tolist() == [[0.0, pytest.approx(293.15)]]
    assert strip_temperature_k(np.array([[2931, 2932]], dtype=np.uint16), 0.1, "mean") == pytest.approx(293.15)


def test_rows_columns_and_both_byte_orders() -> None:
    counts = np.arange(6, dtype=np.uint16).reshape(2, 3) + 300
    assert (decode_mono16(counts.astype("<u2").tobytes(), 3, 2, "little") == counts).all()
    assert (decode_mono16(counts.astype(">u2").tobytes(), 3, 2, "big") == counts).all()


def test_a_buffer_of_another_size_is_refused() -> None:
    with pytest.raises(ValueError, match="has 12 bytes, not 11"):
        decode_mono16(bytes(11), 3, 2, "little")


def test_the_region_is_what_is_looked_at() -> None:
    counts = frame(300.0)
    counts[100:110, 50:70] = 35000
    region = Region(50, 100, 20, 10)
    assert region.crop(counts).shape == (10, 20)
    assert strip_temperature_k(region.crop(counts), 0.01, "mean") == pytest.approx(350.0)
    assert Region().crop(counts).shape == (240, 320)
    assert Region(x=300).crop(counts).shape == (240, 20)


@pytest.mark.parametrize("region", [Region(310, 0, 20, 10), Region(0, 235, 10, 10), Region(400, 0), Region(320, 0)])
def test_a_region_outside_the_frame_is_refused_with_both(region: Region) -> None:
    with pytest.raises(ValueError, match="within 320 x 240 pixels"):
        region.crop(frame(300.0))


def test_a_negative_region_is_refused() -> None:
    with pytest.raises(ValueError, match="width: -1"):
        Region(width=-1)


def test_the_statistics() -> None:
    counts = np.array([[30000, 30000, 36000]], dtype=np.uint16)
    found = [strip_temperature_k(counts, 0.01, s) for s in ("mean", "median", "max")]
    assert found == pytest.approx([320.0, 300.0, 360.0])


def test_temperatures_are_plausible_and_a_hot_pixel_is_no_fault() -> None:
    counts = frame(300.0)
    counts[0, 0] = 65535
    assert implausible(counts, 0.01, 253.15, 623.15) is None


def test_swapped_bytes_are_found_and_named() -> None:
    counts = frame(300.0).byteswap()
    why = implausible(counts, 0.01, 253.15, 350.0)
    assert why is not None and "change byte_order" in why


def test_what_swapping_does_not_mend_is_not_called_swapped() -> None:
    why = implausible(np.zeros((4, 4), dtype=np.uint16), 0.01, 253.15, 350.0)
    assert why == "a median of 0.0 K is not within [253.15, 350] K"
