# SPDX-License-Identifier: Apache-2.0
"""The experiment that tells two effects apart keeps to the limits, for a strip and for a heater alone."""

import numpy as np
import pytest

from lce_analysis.experiment_design import design
from lce_analysis.options import DesignOptions
from lce_data.errors import LceError
from lce_data.units import KELVIN
from lce_model import default_model

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(
    ("deformation", "between"),
    [("equilibrium", ("thermal_gradient", "creep")), ("none", ("radiation", "laser_saturation"))],
)
def test_a_waveform_within_the_limits_that_separates_the_rivals(deformation: str, between: tuple[str, str]) -> None:
    options = DesignOptions(max_power_w=1.5, max_temperature_k=80.0 + KELVIN, duration_s=40.0)
    found = design(default_model("lumped", deformation), between, options)
    assert found.separation > 2.0
    assert found.power_w.min() >= 0.0
    assert found.power_w.max() <= 1.5
    assert found.hottest_k <= 80.0 + KELVIN + 0.05
    assert found.time_s[-1] <= 40.0
    assert np.all(np.diff(found.time_s) > 0.0)


def test_an_effect_is_not_told_from_itself() -> None:
    with pytest.raises(LceError, match="creep and creep are one effect"):
        design(default_model(), ("creep", "creep"), DesignOptions(1.0, 350.0, 30.0))


def test_an_experiment_needs_time() -> None:
    with pytest.raises(LceError, match="a duration of 5 leaves no experiment"):
        DesignOptions(1.0, 350.0, 5.0)
