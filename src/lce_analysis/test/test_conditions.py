# SPDX-License-Identifier: Apache-2.0
"""Branches, holds, cycles, and the shares of the error in them."""

import numpy as np
import pytest
from numpy.typing import NDArray

from lce_analysis.comparison.conditions import OperatingConditions, error_shares, operating_conditions, spans
from lce_data.units import KELVIN

Floats = NDArray[np.float64]

TIME = np.arange(0.0, 100.0, 0.01)


def _conditions(temperature_c: Floats, power_w: Floats | None = None) -> OperatingConditions:
    return operating_conditions(TIME, temperature_c + KELVIN, np.zeros_like(TIME) if power_w is None else power_w)


@pytest.fixture(scope="module")
def triangles() -> OperatingConditions:
    """Two cycles between 30 and 70 °C, 50 s each, linear."""
    return _conditions(70.0 - 1.6 * np.abs(TIME % 50.0 - 25.0))


def test_branches_and_cycles_of_triangles(triangles: OperatingConditions) -> None:
    away = np.abs(TIME % 25.0 - 12.5) < 12.4  # a turn is a sample or two wide
    assert np.array_equal(triangles.heating[away], (TIME % 50.0 < 25.0)[away])
    assert np.array_equal(triangles.cycle[away], (1 + (TIME > 50.0))[away])
    assert not triangles.hold[away].any()
    assert triangles.rate_k_s[100] == pytest.approx(1.6)


def test_flicker_below_two_kelvin_is_no_turn() -> None:
    rough = _conditions(30.0 + 0.4 * TIME + 0.9 * np.sin(20.0 * TIME))
    assert rough.heating.all()
    assert set(rough.cycle) == {1}


def test_a_run_that_cools_first_is_on_the_cooling_branch_from_its_start() -> None:
    assert not _conditions(70.0 - 0.3 * TIME).heating[1:].any()


def test_a_plateau_is_held_and_belongs_to_the_branch_that_led_to_it() -> None:
    found = _conditions(np.interp(TIME, [0.0, 20.0, 60.0, 80.0, 100.0], [30.0, 70.0, 70.0, 30.0, 30.0]))
    plateau = (TIME > 21.0) & (TIME < 59.0)
    assert found.hold[plateau].all() and found.heating[plateau].all()
    assert not found.hold[(TIME > 1.0) & (TIME < 19.0)].any()
    end = TIME > 81.0
    assert found.hold[end].all() and not found.heating[end].any()


def test_a_temperature_that_never_changes_is_held() -> None:
    assert _conditions(np.full_like(TIME, 25.0)).hold.all()


def test_an_operating_condition_at_other_times_holds_the_power_and_interpolates_the_temperature() -> None:
    found = _conditions(30.0 + 0.4 * TIME, np.floor(TIME)).at(np.array([0.505, 1.0, 50.995, 99.99]))
    assert found.temperature_c == pytest.approx(30.0 + 0.4 * np.array([0.505, 1.0, 50.995, 99.99]))
    assert found.power_w.tolist() == [0.0, 1.0, 50.0, 99.0]


def test_every_group_of_shares_adds_up_to_one(triangles: OperatingConditions) -> None:
    rng = np.random.default_rng(0)
    members = [(name, triangles, scale * rng.standard_normal(TIME.size)) for name, scale in (("a", 1.0), ("b", 2.0))]
    found = error_shares(members)
    cycles = [share for by_cycle in found.cycles.values() for share in by_cycle.values()]
    groups = [
        found.conditions,
        cycles,
        *(g.values() for g in (found.quarters, found.branches, found.holds, found.runs)),
    ]
    for group in groups:
        assert sum(s.error_share for s in group) == pytest.approx(1.0)
        assert sum(s.sample_share for s in group) == pytest.approx(1.0)
    assert len(found.conditions) == 4 * 2 * 2
    assert found.runs["b"].error_share == pytest.approx(0.8, abs=0.02)
    assert found.runs["b"].rms == pytest.approx(2.0, abs=0.05)
    assert found.holds["hold"].sample_share < 1e-3


def test_shares_by_cycle_are_those_of_the_run(triangles: OperatingConditions) -> None:
    residual = np.where((triangles.cycle == 2) & ~triangles.heating, 1.0, 0.0)
    found = error_shares([("quiet", triangles, np.zeros_like(TIME)), ("loud", triangles, residual)])
    assert found.cycles["loud"][2].error_share == 1.0
    assert found.cycles["loud"][1].error_share == found.cycles["quiet"][2].error_share == 0.0
    assert found.branches["cooling"].error_share == 1.0
    assert found.branches["cooling"].sample_share == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize(("low", "high"), [(30.0, 40.0), (45.0, 57.5), (65.0, 70.0)])
def test_the_stretch_with_most_of_the_error(triangles: OperatingConditions, low: float, high: float) -> None:
    here = ~triangles.heating & (triangles.temperature_c > low) & (triangles.temperature_c < high)
    most = error_shares([("run", triangles, np.where(here, 10.0, 1.0))]).most
    assert (most.branch, most.held) == ("cooling", None)
    assert low - 2.6 <= most.lower_c < most.upper_c <= high + 2.6
    assert most.error_share >= 0.5
    inside = (triangles.temperature_c >= most.lower_c) & (triangles.temperature_c <= most.upper_c)
    assert most.sample_share == pytest.approx(np.mean(inside & ~triangles.heating), abs=0.01)


def test_an_error_on_both_branches_is_not_pinned_to_one(triangles: OperatingConditions) -> None:
    here = (triangles.temperature_c > 50.0) & (triangles.temperature_c < 55.0)
    most = error_shares([("run", triangles, np.where(here, 10.0, 1.0))]).most
    assert most.branch is None and most.held is None
    assert 47.0 < most.lower_c < most.upper_c < 58.0


def test_an_error_while_held_is_said_to_be() -> None:
    stairs = _conditions(
        30.0 + 10.0 * np.interp(TIME % 25.0, [0.0, 20.0, 25.0], [0.0, 0.0, 1.0]) + 10.0 * (TIME // 25.0)
    )
    slow = _conditions(30.0 + 0.4 * TIME)
    most = error_shares([("stairs", stairs, np.where(stairs.hold, 5.0, 1.0)), ("slow", slow, np.ones_like(TIME))]).most
    assert most.held is True


def test_an_empty_condition_has_no_rms() -> None:
    found = error_shares([("run", _conditions(30.0 + 0.4 * TIME), np.ones_like(TIME))])
    assert np.isnan(found.branches["cooling"].rms) and found.branches["cooling"].error_share == 0.0


def test_no_error_at_all_has_shares_of_nothing(triangles: OperatingConditions) -> None:
    found = error_shares([("run", triangles, np.zeros_like(TIME))])
    assert found.most.error_share == 0.0
    assert {s.error_share for s in found.conditions} == {0.0}


def test_the_samples_of_an_operating_condition_are_those_that_its_share_counts(triangles: OperatingConditions) -> None:
    found = error_shares([("run", triangles, np.ones_like(TIME))])
    for share in found.conditions:
        # Not exactly: an edge is in both quarters.
        assert np.mean(share.among(triangles)) == pytest.approx(share.sample_share, abs=1e-3)


def test_spans_are_the_stretches_of_what_is_marked() -> None:
    marked = np.array([True, True, False, False, True, False, True])
    assert spans(np.arange(7.0), marked) == [(0.0, 1.0), (4.0, 4.0), (6.0, 6.0)]
    assert spans(np.arange(7.0), ~marked) == [(2.0, 3.0), (5.0, 5.0)]
    assert spans(np.arange(7.0), np.zeros(7, dtype=bool)) == []
