# SPDX-License-Identifier: Apache-2.0
import math
from pathlib import Path

import numpy as np
import pytest

from lce_data.errors import LceError
from lce_data.settings import parse_settings
from lce_drivers.simulation.strip import Drive, strip_model
from lce_model import default_model, save_model


def energy_j(pieces: list[tuple[float, float]]) -> float:
    return sum(power * dt for power, dt in pieces)


def started(timeout_s: float = 0.1) -> Drive:
    drive = Drive(timeout_s)
    assert list(drive.advance(0.0)) == []
    return drive


def test_a_power_counts_from_the_time_it_was_sent() -> None:
    drive = started()
    drive.put(2.0, 0.004)
    assert list(drive.advance(0.01)) == [(0.0, 0.004), (2.0, pytest.approx(0.006))]


def test_a_power_sent_at_the_tick_counts_after_it_whatever_came_first() -> None:
    early, late = started(), started()
    early.put(1.0, 0.01)
    assert list(early.advance(0.01)) == list(late.advance(0.01)) == [(0.0, 0.01)]
    late.put(1.0, 0.01)
    assert list(early.advance(0.02)) == list(late.advance(0.02)) == [(1.0, pytest.approx(0.01))]


def test_the_pieces_add_up_to_the_time_that_passed() -> None:
    random = np.random.default_rng(3)
    drive, now = started(), 0.0
    for _ in range(300):
        for t in np.sort(random.uniform(now, now + 0.05, random.integers(0, 4))):
            drive.put(random.uniform(0.0, 2.0), float(t))
        pieces = list(drive.advance(now + 0.05))
        assert sum(dt for _, dt in pieces) == pytest.approx(0.05)
        assert all(0.0 < dt <= 0.01 + 1e-9 for _, dt in pieces)
        now += 0.05


def test_a_stale_power_counts_as_zero_after_exactly_the_time_out() -> None:
    drive = started()
    drive.put(1.0, 0.0)
    assert energy_j(list(drive.advance(3.0))) == pytest.approx(0.1)
    assert drive.power_w == 0.0


def test_a_power_that_waited_in_the_queue_is_as_old_as_it_is() -> None:
    drive = started()
    assert energy_j(list(drive.advance(1.0))) == 0.0
    drive.put(2.0, 0.5)
    assert energy_j(list(drive.advance(2.0))) == 0.0


@pytest.mark.parametrize("power", [math.nan, math.inf, -math.inf, -1.0])
def test_what_is_not_a_power_counts_as_zero(power: float) -> None:
    drive = started()
    drive.put(power, 0.0)
    assert energy_j(list(drive.advance(0.05))) == 0.0


def test_a_clock_that_was_set_only_sets_the_time() -> None:
    drive = started()
    drive.put(1.0, 0.0)
    assert list(drive.advance(1.7e9)) == []
    assert list(drive.advance(5.0)) == []
    assert sum(dt for _, dt in drive.advance(5.01)) == pytest.approx(0.01)


def test_what_was_sent_before_the_clock_was_set_back_is_dark() -> None:
    drive = started()
    drive.put(1.0, 100.0)
    drive.put(1.0, 100.01)
    assert list(drive.advance(100.005 - 60.0)) != [] and list(drive.advance(100.005)) != []
    assert list(drive.advance(5.0)) == []
    drive.put(0.0, 5.0)
    assert energy_j(list(drive.advance(6.0))) == 0.0


def test_settings_change_the_model() -> None:
    model = strip_model("", parse_settings(["lumped.gain=40.0", "", " lumped.tau = 12"]))
    assert (model["lumped.gain"], model["lumped.tau"]) == (40.0, 12.0)


@pytest.mark.parametrize("text", ["lumped.gain", "lumped.gain=", "lumped.gain=big", "nothing.like=1.0"])
def test_a_setting_that_does_not_fit_is_named(text: str) -> None:
    with pytest.raises(LceError, match=text.split("=")[0]):
        strip_model("", parse_settings([text]))


def test_a_setting_outside_its_bounds_names_the_range() -> None:
    with pytest.raises(LceError, match=r"lumped.gain: -1 K/W is outside \["):
        strip_model("", {"lumped.gain": -1.0})


def test_any_model_file_runs(tmp_path: Path) -> None:
    save_model(default_model(deformation="dynamic").set({"lumped.gain": 55.0}), tmp_path / "m.yaml")
    model = strip_model(tmp_path / "m.yaml", {"lumped.tau": 9.0})
    assert (model.deformation, model["lumped.gain"], model["lumped.tau"]) == ("dynamic", 55.0, 9.0)
