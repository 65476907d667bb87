# SPDX-License-Identifier: Apache-2.0
"""The cases of `make control`, and a small part of it: the model-based mode meets its bars."""

import numpy as np
import pytest
from control_cases import MODES, follower, known, play, steps, trajectory

from lce_bringup import graph
from lce_control.metrics import step_metrics


def test_a_case_has_its_targets_in_time() -> None:
    case = steps("two", (1.0, 2.0), hold_s=10.0)
    np.testing.assert_allclose(case.target_m(np.array([0.0, 9.99, 10.0, 19.0])), [1e-3, 1e-3, 2e-3, 2e-3])
    ramp = trajectory("ramp", lambda t: 1e-3 + 1e-4 * t, 2.0)
    np.testing.assert_allclose(ramp.target_m(np.array([0.0, 0.39, 1.99])), [1e-3, 1.036e-3, 1.196e-3])


def test_every_mode_of_the_bench_is_compared() -> None:
    assert set(MODES) == set(graph.CONTROLLERS)
    for mode in MODES:
        follower(mode, known())


@pytest.mark.parametrize("target_mm", [1.0, 2.5])
def test_by_the_model_the_bars_are_met(target_mm: float) -> None:
    case = steps("one", (target_mm,), hold_s=40.0)
    best, loop = play(case, "limit", 0), play(case, "model", 1)
    limit, figures = (step_metrics(x.time_s, x.displacement_m, 1e-3 * target_mm) for x in (best, loop))
    assert figures.rise_time_s <= 1.3 * limit.rise_time_s
    assert figures.overshoot <= 0.01 and figures.rmse_after_30s <= 0.005


def test_a_strip_that_is_not_the_model_is_held_all_the_same() -> None:
    case = steps("off", (2.0,), hold_s=40.0, settings={"kinetic.barrier": 0.9 * known()["kinetic.barrier"]})
    loop = play(case, "model", 1)
    assert step_metrics(loop.time_s, loop.displacement_m, 2e-3).rmse_after_30s < 0.005
