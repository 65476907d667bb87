# SPDX-License-Identifier: Apache-2.0
"""An effect whose gain is what a sensor or a disturbance did is not called missing; all others are left alone."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lce_analysis.diagnosis.disturbed import lives_on, outside
from lce_analysis.signatures import Picture, ResidualSeries, Signature
from lce_analysis.signatures.signature import Name
from lce_data.channels import DISPLACEMENT, TEMPERATURE

Floats = NDArray[np.float64]
TIME_S = np.arange(0.0, 100.0, 0.1)
EXCESS_K = 40.0 * (1.0 - np.exp(-TIME_S / 20.0))
SWING_K = np.sin(2.0 * np.pi * TIME_S / 11.0)


def beside(modelled_k: Floats, measured_k: Floats) -> list[ResidualSeries]:
    """One run of the camera."""
    noise = 0.06 * np.random.default_rng(0).standard_normal(TIME_S.size)
    return [ResidualSeries("run", TEMPERATURE, TIME_S, 298.0 + measured_k + noise, 298.0 + modelled_k, 0.06)]


def seen(name: Name, value: float, share: float = 0.8) -> Signature:
    """A signature of the camera."""
    picture = Picture("", "time", "s", TIME_S, "residual", {}, {})
    return Signature(name, TEMPERATURE, value, "s", None, 0.0, share, "words", "advice", picture)


def test_an_effect_that_follows_a_draught_lives_on_it() -> None:
    before, after = (beside(EXCESS_K + part * SWING_K, EXCESS_K + SWING_K) for part in (0.0, 0.5))
    assert lives_on("creep", [seen("period", 11.0)], before, after)


def test_an_effect_of_its_own_beside_a_draught_is_left_alone() -> None:
    missing = 2.0 * np.sin(EXCESS_K / 8.0)
    before, after = (beside(EXCESS_K + part * missing, EXCESS_K + SWING_K + missing) for part in (0.0, 1.0))
    assert not lives_on("radiation", [seen("period", 11.0)], before, after)


def test_only_the_end_of_the_range_itself_may_gain_where_the_camera_is_clipped() -> None:
    shown = np.minimum(EXCESS_K, 30.0)
    before, after = beside(EXCESS_K, shown), beside(shown, shown)
    found = [seen("clipped", 298.0 + 30.0 - 273.15)]
    assert lives_on("radiation", found, before, after)
    assert not lives_on("temperature_clip", found, before, after)


def test_readings_near_the_end_of_a_range_are_those_of_that_sensor() -> None:
    """The noise of a displacement of the same run, in metres, is a thousandth of that of the temperature."""
    shown = np.minimum(EXCESS_K, 30.0)
    before, after = beside(EXCESS_K, shown), beside(shown, shown)
    both = [ResidualSeries("run", DISPLACEMENT, TIME_S, 0.0 * TIME_S, 0.0 * TIME_S, 4e-6)]
    assert lives_on("radiation", [seen("clipped", 298.0 + 30.0 - 273.15)], [*before, *both], [*after, *both])


def test_a_signature_that_accounts_for_little_is_beside_the_point() -> None:
    small = seen("period", 11.0, share=0.05)
    before, after = (beside(EXCESS_K + part * SWING_K, EXCESS_K + SWING_K) for part in (0.0, 0.5))
    assert outside([small]) == []
    assert not lives_on("creep", [small], before, after)


def test_what_both_sensors_see_is_outside_only_where_it_does_not_repeat() -> None:
    both = seen("both_sensors", 0.8)
    assert outside([replace(both, repeats=False)])
    assert not outside([replace(both, repeats=True)])
