# SPDX-License-Identifier: Apache-2.0
import math

import pytest

from lce_ros.parameters import Rule


@pytest.mark.parametrize("value", [0.0, 1.0, 2.0, 1])
def test_values_within_the_range_are_taken(value: float) -> None:
    assert Rule("p", "W", 0.0, 2.0).refusal(value) is None


@pytest.mark.parametrize("value", [-0.1, 2.1, math.nan, math.inf, -math.inf, 3])
def test_a_refusal_names_value_range_and_unit(value: float) -> None:
    refusal = Rule("p", "W", 0.0, 2.0).refusal(value)
    assert refusal == f"p: {value:g} W is outside [0, 2] W"


def test_nan_is_refused_without_a_range() -> None:
    assert Rule("p").refusal(math.nan) == "p: nan is outside [-inf, inf]"
    assert Rule("p").refusal(1e300) is None


def test_a_range_may_be_open_on_one_side() -> None:
    assert Rule("seed", lower=-1).refusal(10**9) is None
    assert Rule("seed", lower=-1).refusal(-2) == "seed: -2 is outside [-1, inf]"


def test_choices_are_listed() -> None:
    rule = Rule("device", choices=("simulated", "labjack"))
    assert rule.refusal("labjack") is None
    assert rule.refusal("laserjet") == "device: 'laserjet' is not one of simulated, labjack"


def test_an_empty_range_is_a_mistake() -> None:
    with pytest.raises(ValueError, match="empty"):
        Rule("p", lower=2.0, upper=1.0)


def test_what_can_only_be_lowered_is_not_raised() -> None:
    rule = Rule("p", "W", 0.0, 10.0, only_lower=True)
    assert rule.refusal(9.0) is None, "at the start of its node"
    assert rule.refusal(1.0, now=2.0) is None and rule.refusal(2.0, now=2.0) is None
    assert rule.refusal(2.5, now=2.0) == "p: 2.5 W is above 2 W; it can only be lowered"
    assert rule.constraints == "within [0, 10] W; can only be lowered"
