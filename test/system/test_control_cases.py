# SPDX-License-Identifier: Apache-2.0
"""The cases of `make control`, and a small part of it: every mode meets its bars with the gains of control.yaml."""

import numpy as np
import pytest
import yaml
from control_cases import MODES, follower, known, play, steps, trajectory

from lce_control.step_metrics import step_metrics
from lce_control.tuning.requirements import Requirements, check
from lce_control.tuning.tasks import INNER, OUTER, SINGLE, ModelBench
from lce_experiment import config, registry


def test_a_case_has_its_targets_in_time() -> None:
    case = steps("two", (1.0, 2.0), hold_s=10.0)
    np.testing.assert_allclose(case.target_m(np.array([0.0, 9.99, 10.0, 19.0])), [1e-3, 1e-3, 2e-3, 2e-3])
    ramp = trajectory("ramp", lambda t: 1e-3 + 1e-4 * t, 2.0)
    np.testing.assert_allclose(ramp.target_m(np.array([0.0, 0.39, 1.99])), [1e-3, 1.036e-3, 1.196e-3])


def test_every_mode_of_the_bench_is_compared() -> None:
    assert set(MODES) == set(registry.CONTROLLERS)
    for mode in MODES:
        follower(mode, known())


@pytest.mark.parametrize("target_mm", [1.0, 2.5])
def test_by_the_model_the_bars_are_met(target_mm: float) -> None:
    case = steps("one", (target_mm,), hold_s=40.0)
    best, loop = play(case, "limit", 0), play(case, "model", 1)
    limit, figures = (step_metrics(x.time_s, x.displacement_m, 1e-3 * target_mm) for x in (best, loop))
    assert figures.rise_time_s <= 1.3 * limit.rise_time_s
    assert figures.overshoot <= 0.01 and figures.rmse_after_30s <= 0.005


@pytest.mark.parametrize("mode", ["single", "double"])
def test_with_the_gains_of_control_yaml_the_bars_are_met(mode: str) -> None:
    figures = []
    for target_mm in (1.0, 3.0):
        loop = play(steps("one", (target_mm,)), mode, 1)
        figures.append(step_metrics(loop.time_s, loop.displacement_m, 1e-3 * target_mm))
    assert max(f.overshoot for f in figures) <= 0.05 and max(f.rmse_after_30s for f in figures) <= 0.01
    assert max(f.rise_time_s for f in figures) <= 5.2, "full power all the way takes 5.1 s to 80 % of 3 mm"


def test_the_gains_of_control_yaml_are_those_of_the_default_strip() -> None:
    """They meet what `lce tune` requires of them there."""
    content = yaml.safe_load(config.config_file("control.yaml").read_text(encoding="utf-8"))
    gains = {node: content[f"/**/{node}"]["ros__parameters"] for node in (INNER, OUTER, SINGLE)}
    bench, wanted = ModelBench.of(known(), config.laser_limit_w()), Requirements()
    double, single = bench.double().tuned(gains), bench.single().tuned(gains)
    check(double, wanted)
    check(single, wanted)


def test_a_strip_that_is_not_the_model_is_held_all_the_same() -> None:
    case = steps("off", (2.0,), hold_s=40.0, settings={"kinetic.barrier": 0.9 * known()["kinetic.barrier"]})
    loop = play(case, "model", 1)
    assert step_metrics(loop.time_s, loop.displacement_m, 2e-3).rmse_after_30s < 0.005
