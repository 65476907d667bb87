# SPDX-License-Identifier: Apache-2.0
"""The inverse chart of §6.4."""

import numpy as np
import pytest

from lce_data.errors import LceError
from lce_data.units import KELVIN
from lce_model import default_model, simulate
from lce_model.inverse import InverseChart, OutOfReach


@pytest.fixture(scope="module")
def chart() -> InverseChart:
    return InverseChart(default_model())


def test_mid_branch_temperatures_of_4_21(chart: InverseChart) -> None:
    found = [chart.temperature_k(mm * 1e-3) - KELVIN for mm in (1.0, 1.5, 2.0, 2.5)]
    assert found == pytest.approx([43.6, 46.5, 49.5, 53.2], abs=0.3)


def test_each_branch_inverts_its_own_side_of_the_loop(chart: InverseChart) -> None:
    model = default_model()
    for branch, path in (("heating", [290.0, None]), ("cooling", [290.0, 400.0, None])):
        wanted = chart.temperature_k(1.7e-3, branch)  # type: ignore[arg-type]
        drive = [wanted if t is None else t for t in path]
        d = simulate(model, np.arange(len(drive), dtype=float), None, temperature_k=drive).displacement_m[-1]
        assert d == pytest.approx(1.7e-3, abs=2e-6)


def test_heating_is_hotter_than_cooling_and_the_middle_between(chart: InverseChart) -> None:
    hot, mid, cool = (chart.temperature_k(1.5e-3, b) for b in ("heating", "middle", "cooling"))
    assert cool < mid < hot
    assert mid == pytest.approx(0.5 * (hot + cool))


@pytest.mark.parametrize("wanted_m", [4e-3, -1e-3])
def test_out_of_reach_is_an_error_with_the_range(chart: InverseChart, wanted_m: float) -> None:
    with pytest.raises(OutOfReach, match=r"out of reach: the strip reaches .* mm") as caught:
        chart.temperature_k(wanted_m)
    assert caught.value.lower_m < caught.value.upper_m == pytest.approx(2.996e-3, abs=1e-6)


def test_unknown_branch_is_refused(chart: InverseChart) -> None:
    with pytest.raises(LceError, match="one of middle, heating, cooling"):
        chart.temperature_k(1e-3, "up")  # type: ignore[arg-type]
