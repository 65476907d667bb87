# SPDX-License-Identifier: Apache-2.0
"""Runs and waveforms as CSV files: what is written is what is read."""

from pathlib import Path

import numpy as np
import pytest

from lce_data.channels import DISPLACEMENT, POWER, TEMPERATURE
from lce_data.errors import LceError
from lce_data.read_runs import read_run
from lce_data.run_csv import read_run_csv, write_run_csv
from lce_data.units import KELVIN
from lce_data.wave_file import read_wave, write_wave

TIME_S = 0.1 * np.arange(12)


def test_a_run_is_read_as_it_was_written(tmp_path: Path) -> None:
    temperature_k = 300.0 + np.arange(12) / 7.0
    temperature_k[3] = np.nan
    displacement_m = 1e-6 * np.sin(TIME_S)
    values = {DISPLACEMENT: displacement_m, TEMPERATURE: temperature_k, POWER: np.full(12, 0.5)}
    write_run_csv(tmp_path / "run.csv", TIME_S, values)
    lines = (tmp_path / "run.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0] == "time_s,power_w,temperature_c,displacement_m"
    assert lines[1] == "0,0.5,26.850000,0.000000000e+00"
    assert lines[4].split(",")[2] == ""
    run = read_run(tmp_path / "run.csv")
    assert run.temperature is not None and run.displacement is not None
    assert run.temperature.value == pytest.approx(np.delete(temperature_k, 3), abs=1e-6)
    assert run.displacement.value == pytest.approx(displacement_m, abs=1e-15)


def test_channels_that_were_not_measured_have_no_column(tmp_path: Path) -> None:
    write_run_csv(tmp_path / "run.csv", TIME_S, {TEMPERATURE: np.full(12, KELVIN)})
    assert list(read_run_csv(tmp_path / "run.csv")) == [TEMPERATURE]


def test_a_run_whose_time_does_not_increase_is_not_written(tmp_path: Path) -> None:
    with pytest.raises(LceError, match=r"run\.csv, row 3: time does not increase: 0 s after 0 s"):
        write_run_csv(tmp_path / "run.csv", np.zeros(3), {POWER: np.zeros(3)})
    assert not (tmp_path / "run.csv").exists()


@pytest.mark.parametrize("step_s", [0.01, 0.001, 1 / 3])
def test_a_wave_is_read_as_it_was_written(step_s: float, tmp_path: Path) -> None:
    time_s = step_s * np.arange(200)
    power_w = np.round(np.abs(np.sin(time_s)), 5)
    write_wave(tmp_path / "wave.csv", time_s, power_w)
    again_s, again_w = read_wave(tmp_path / "wave.csv")
    np.testing.assert_allclose(again_s, time_s, atol=1e-9)
    np.testing.assert_allclose(again_w, power_w)


def test_a_wave_at_the_rate_of_the_bench_has_two_decimals(tmp_path: Path) -> None:
    write_wave(tmp_path / "wave.csv", np.array([0.0, 0.01, 0.29]), np.array([0.0, 1.5, 1 / 3]))
    assert (tmp_path / "wave.csv").read_text() == "time_s,power_w\n0.00,0\n0.01,1.5\n0.29,0.333333\n"


@pytest.mark.parametrize(
    ("time_s", "power_w", "told"),
    [
        ([0.0, 1.0], [0.0, np.nan], "not finite"),
        ([0.0, 1.0], [0.0, -0.5], r"power_w = -0\.5 W; a laser gives 0 W or more"),
        ([0.0, 1.0, 1.0], [0.0, 0.0, 0.0], "time does not increase"),
        ([-1.0, 1.0], [0.0, 0.0], "must not be negative"),
        ([0.0, 1e9], [0.0, 0.0], "longer than 86400 s"),
    ],
)
def test_a_wave_that_could_not_be_read_is_not_written(
    time_s: list[float], power_w: list[float], told: str, tmp_path: Path
) -> None:
    with pytest.raises(LceError, match=rf"wave\.csv: .*{told}"):
        write_wave(tmp_path / "wave.csv", np.array(time_s), np.array(power_w))
    assert list(tmp_path.iterdir()) == []
