# SPDX-License-Identifier: Apache-2.0
"""Protocols: the waveforms are what (4.20) and the names say, and a bad request is one clear line."""

from pathlib import Path

import numpy as np
import pytest

from lce_data.errors import LceError
from lce_data.waveforms import SHAPES, prbs_bits
from lce_experiment import protocols


def test_pulse_is_equation_4_20() -> None:
    wave = protocols.one("pulse:amp=0.2,th=30,rest=10")
    t = wave.time_s
    expected = np.where(t < 30, 0.2 * np.sin(np.pi / 60 * t) + 1.5, 0.0)
    np.testing.assert_allclose(wave.power_w, expected, atol=1e-12)
    assert wave.duration_s == 40.0
    assert wave.name == "pulse_amp0.2_th30_rest10"


def test_every_shape_has_100_samples_a_second_and_ends_dark() -> None:
    for text in [*SHAPES, *protocols.CAMPAIGNS["campaign"]]:
        wave = protocols.one(text)
        np.testing.assert_allclose(np.diff(wave.time_s), 0.01, atol=1e-9)
        assert wave.time_s[0] == 0 and wave.power_w[-1] == 0
        assert np.isfinite(wave.power_w).all() and wave.power_w.min() >= 0 and wave.power_w.max() > 1


def test_stairs_go_up_and_down_again() -> None:
    wave = protocols.one("stairs:low=0.5,high=1.5,steps=3,hold=1,rest=1")
    levels = [wave.power_w[round(100 * t)] for t in (0.5, 1.5, 2.5, 3.5, 4.5, 5.5)]
    np.testing.assert_allclose(levels, [0.5, 1.0, 1.5, 1.0, 0.5, 0.0])


def test_hold_takes_several_levels() -> None:
    wave = protocols.one("hold:power=0.5/1.5,hold=2,rest=1")
    np.testing.assert_allclose(wave.power_w[[0, 199, 200, 300, 499, 500]], [0.5, 0.5, 0, 1.5, 1.5, 0])


@pytest.mark.parametrize("order", range(3, 12))
def test_prbs_is_of_maximal_length(order: int) -> None:
    bits = prbs_bits(order, seed=3)
    windows = {tuple(np.roll(bits, -k)[:order]) for k in range(bits.size)}
    assert len(windows) == bits.size == 2**order - 1


def test_prbs_seeds_shift_the_same_sequence() -> None:
    first, second = prbs_bits(6, seed=1), prbs_bits(6, seed=2)
    assert not np.array_equal(first, second)
    assert any(np.array_equal(np.roll(first, k), second) for k in range(first.size))


def test_campaign_is_several_runs_with_different_names() -> None:
    waves = protocols.load("campaign")
    assert len({wave.name for wave in waves}) == len(waves) > 10
    assert [wave.text for wave in protocols.load("chapter5")] == [f"pulse:amp=0.4,th={t}" for t in range(16, 22)]


def test_a_campaign_is_not_one_run() -> None:
    with pytest.raises(LceError, match="campaign is 15 runs, not one; name one of them, such as pulse"):
        protocols.one("campaign")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("puls:amp=1", "unknown protocol 'puls:amp=1' (did you mean 'pulse'?); it is one of pulse, stairs"),
        ("pulse:ampl=1", "pulse: unknown option 'ampl=1' (did you mean 'amp'?); it has amp, th"),
        ("pulse:amp", "unknown option 'amp'"),
        ("pulse:amp=much", "amp = 'much' is not a number"),
        ("pulse:amp=nan", "amp = nan is outside -100 .. 100 W"),
        ("pulse:th=0", "th = 0 is outside 0.1 .. 36000 s"),
        ("pulse:amp=-2", "power falls to -0.5 W"),
        ("pulse:amp=1,amp=2", "given twice"),
        ("stairs:steps=2.5", "steps = 2.5 is not a whole number"),
        ("cycles:count=10000,period=30000", "is longer than 86400 s"),
        ("missing.csv", "missing.csv: No such file"),
    ],
)
def test_a_bad_protocol_is_one_line_that_says_what_is_allowed(text: str, said: str) -> None:
    with pytest.raises(LceError) as caught:
        protocols.load(text)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def _wave(folder: Path, text: str) -> str:
    path = folder / "wave.csv"
    path.write_text(text)
    return str(path)


def test_a_wave_file_is_held_between_its_rows(tmp_path: Path) -> None:
    wave = protocols.one(_wave(tmp_path, "time_s,power_w\n0.05,1.5\n0.10,0.5\n0.20,0\n"))
    np.testing.assert_allclose(wave.power_w[[0, 4, 5, 9, 10, 19, 20]], [0, 0, 1.5, 1.5, 0.5, 0.5, 0])
    assert wave.power_w[-1] == 0


def test_a_wave_written_by_a_spreadsheet_is_read(tmp_path: Path) -> None:
    wave = protocols.one(_wave(tmp_path, "\ufefftime_s, power_w ,note\r\n0,1,a\r\n1,0,b\r\n\r\n"))
    assert wave.power_w[50] == 1.0


def test_a_protocol_written_as_a_wave_file_comes_back(tmp_path: Path) -> None:
    wave = protocols.one("pulse:th=3,rest=1")
    rows = "\n".join(f"{t:.2f},{p!r}" for t, p in zip(wave.time_s, wave.power_w.tolist(), strict=True))
    again = protocols.one(_wave(tmp_path, f"time_s,power_w\n{rows}\n"))
    np.testing.assert_array_equal(again.power_w[: wave.power_w.size], wave.power_w)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "no column time_s, power_w"),
        ("time_s,watt\n0,1\n", "no column power_w"),
        ("time_s,power_w\n", "no rows"),
        ("time_s,power_w\n0,1\n1,\n", "line 3"),
        ("time_s,power_w\n0,1\n1\n", "line 3"),
        ("time_s,power_w\n0,nan\n", "line 2: '0,nan' is not finite"),
        ("time_s,power_w\n0,-1\n", "line 2: power_w = -1 W"),
        ("time_s,power_w\n0,1\n2,1\n1,1\n", "time does not increase: 1 s after 2 s"),
        ("time_s,power_w\n0,1\n0,1\n", "time does not increase"),
        ("time_s,power_w\n-1,1\n0,1\n", "must not be negative"),
        ("time_s,power_w\n0,1\n1e9,0\n", "longer than"),
    ],
)
def test_a_bad_wave_file_names_itself_and_the_line(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(LceError, match=r"wave\.csv") as caught:
        protocols.one(_wave(tmp_path, text))
    assert said in str(caught.value)


def test_a_binary_file_is_no_wave(tmp_path: Path) -> None:
    path = tmp_path / "wave.csv"
    path.write_bytes(b"\x89MCAP0\r\n\xff\xfe")
    with pytest.raises(LceError, match="not a CSV text file"):
        protocols.one(str(path))


def test_help_explains_every_protocol() -> None:
    text = protocols.explain()
    assert all(name in text for name in [*SHAPES, *protocols.CAMPAIGNS, "time_s,power_w"])
