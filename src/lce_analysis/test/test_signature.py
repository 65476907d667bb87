# SPDX-License-Identifier: Apache-2.0
"""What an effect would change in a run is what simulating with it changes."""

from collections.abc import Callable

import numpy as np
import pytest

from lce_analysis.diagnosis import effect_signature
from lce_data.channels import DISPLACEMENT, TEMPERATURE
from lce_data.errors import LceError
from lce_data.run import Run
from lce_model import Model, simulate
from lce_model.effects import find


@pytest.mark.slow  # the code of every effect at once is compiled
def test_the_change_of_each_series(strip: Model, recorded: Callable[..., Run]) -> None:
    run, creep = recorded(duration_s=30.0), find("creep")
    settings = {creep.strength_key: creep.typical}
    found = effect_signature(strip, run, "creep", settings)
    assert run.power is not None and run.displacement is not None
    with_creep = simulate(strip.add("creep").set(settings), run.power.time_s, run.power.value)
    change = with_creep.displacement_m - simulate(strip, run.power.time_s, run.power.value).displacement_m
    assert found[DISPLACEMENT].change == pytest.approx(change, abs=1e-12)
    assert np.ptp(change) > 1e-5
    assert np.std(found[DISPLACEMENT].residual) == pytest.approx(4e-6, rel=0.1)
    assert np.all(found[TEMPERATURE].change == 0.0)  # creep belongs to the strip, not to its heat
    assert found[TEMPERATURE].time_s.shape == found[TEMPERATURE].residual.shape == found[TEMPERATURE].change.shape


def test_an_unknown_effect(strip: Model, recorded: Callable[..., Run]) -> None:
    with pytest.raises(LceError, match="nosuch"):
        effect_signature(strip, recorded(duration_s=10.0), "nosuch", {})
