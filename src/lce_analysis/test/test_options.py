# SPDX-License-Identifier: Apache-2.0
"""Options refuse values that cannot be used, and name the field."""

from typing import Any

import pytest

from lce_analysis.options import CompareOptions, DesignOptions, DiagnoseOptions, FitOptions
from lce_data.channels import DISPLACEMENT, SENSORS, TEMPERATURE
from lce_data.errors import LceError


@pytest.mark.parametrize("options", [FitOptions, CompareOptions, DiagnoseOptions, DesignOptions])
def test_the_defaults_can_be_used(options: type[Any]) -> None:
    assert options() == options()


@pytest.mark.parametrize("options", [FitOptions, CompareOptions])
def test_an_unknown_drive(options: type[Any]) -> None:
    with pytest.raises(LceError, match="drive: 'x' is neither 'model' nor 'measured'"):
        options(drive="x")


@pytest.mark.parametrize(
    ("options", "field", "value", "message"),
    [
        (FitOptions, "time_constants", (5.0, 0.0), r"\(5.0, 0.0\) must be above 0"),
        (FitOptions, "starts", 0, "0 is not 1 or more"),
        (FitOptions, "seed", -1, "-1 must be 0 or above"),
        (FitOptions, "negligible", 0.0, "0 must be above 0"),
        (FitOptions, "undetermined", float("nan"), "nan must be above 0"),
        (FitOptions, "strong_correlation", 1.5, r"1.5 must be within \(0, 1\]"),
        (FitOptions, "differing", 1.5, r"1.5 must be within \(0, 1\]"),
        (CompareOptions, "intervals", 0, "0 is not 1 or more"),
        (CompareOptions, "turn_k", -1.0, "-1 must be 0 or above"),
        (CompareOptions, "even", 0.5, "0.5 must be 1 or above"),
        (CompareOptions, "most", 0.0, r"0 must be within \(0, 1\]"),
        (CompareOptions, "longest_lag_s", float("inf"), "inf must be above 0"),
        (DiagnoseOptions, "false_alarm", -1.0, r"-1 must be within \(0, 1\]"),
        (DiagnoseOptions, "max_effects", 0, "0 is not 1 or more"),
        (DiagnoseOptions, "min_likelihood_ratio", 0.1, "0.1 must be 1 or above"),
        (DiagnoseOptions, "jump_size", -2.0, "-2 must be above 0"),
        (DesignOptions, "iterations", 0, "0 is not 1 or more"),
        (DesignOptions, "variations", -1, "-1 must be 0 or above"),
        (DesignOptions, "camera_step", 0, "0 is not 1 or more"),
    ],
)
def test_a_value_outside_of_its_range(options: type[Any], field: str, value: float, message: str) -> None:
    with pytest.raises(LceError, match=f"^{field}: {message}$"):
        options(**{field: value})


def test_a_design_needs_the_noise_of_every_sensor() -> None:
    assert DesignOptions().noise == {channel: channel.noise for channel in SENSORS}
    with pytest.raises(LceError, match="noise: nan m of the displacement must be above 0"):
        DesignOptions(noise={TEMPERATURE: 0.1})
    with pytest.raises(LceError, match="noise: 0 K of the temperature must be above 0"):
        DesignOptions(noise={TEMPERATURE: 0.0, DISPLACEMENT: 1e-6})
