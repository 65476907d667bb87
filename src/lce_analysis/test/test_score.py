# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from scipy.signal import lsim

from lce_analysis.diagnosis.chain import Chain
from lce_analysis.diagnosis.projection import p_value, project
from lce_analysis.diagnosis.score import score_test
from lce_analysis.options import DiagnoseOptions
from lce_data.progress import silent
from lce_data.run import Run, Series
from lce_model import default_model
from lce_model.effects import find

RNG = np.random.default_rng(2)
N = 4000
FREE = RNG.standard_normal((N, 3))
TRUE, OTHER = RNG.standard_normal((2, N))


def _gram(*columns: np.ndarray) -> np.ndarray:
    table = np.column_stack([FREE, *columns])
    return table.T @ table


def test_the_strength_of_a_direction_is_found_whatever_the_free_parameters_absorb() -> None:
    seen = project(_gram(TRUE, OTHER, 0.7 * TRUE + FREE @ [3.0, -2.0, 1.0]), 3)
    assert seen.strength[0] == pytest.approx(0.7)
    assert seen.reduction[0] == pytest.approx(seen.error)
    assert seen.reduction[1] < 0.01 * seen.error


def test_a_direction_that_the_free_parameters_span_is_invisible() -> None:
    seen = project(_gram(FREE @ [1.0, 2.0, 3.0], FREE[:, 0] + 0.1 * TRUE, TRUE), 3)
    assert seen.visibility[0] == 0.0
    assert seen.strength[0] == 0.0
    assert seen.visibility[1] == pytest.approx(0.01, rel=0.2)


def test_a_free_parameter_without_effect_does_no_harm() -> None:
    table = np.column_stack([FREE, np.zeros(N), FREE[:, 0], TRUE, 0.5 * TRUE])
    assert project(table.T @ table, 5).strength[0] == pytest.approx(0.5)


def test_collinearity_is_measured_after_projection() -> None:
    seen = project(_gram(TRUE + 5.0 * FREE[:, 0], TRUE - 4.0 * FREE[:, 1], OTHER, TRUE), 3)
    assert seen.collinearity[0, 1] == pytest.approx(1.0)
    assert seen.collinearity[0, 2] < 0.1


def test_evidence_of_pure_noise_is_chi_squared() -> None:
    evidence = [project(_gram(TRUE, RNG.standard_normal(N)), 3).reduction[0] for _ in range(400)]
    assert np.mean(evidence) == pytest.approx(1.0, abs=0.25)
    assert np.mean([p_value(e, False, 1) < 0.05 for e in evidence]) == pytest.approx(0.05, abs=0.035)


def test_a_search_over_a_grid_and_a_side_enter_the_p_value() -> None:
    assert p_value(6.0, True, 1) == pytest.approx(0.5 * p_value(6.0, False, 1))
    assert p_value(6.0, False, 4) == pytest.approx(4.0 * p_value(6.0, False, 1))
    assert p_value(0.0, False, 4) == 1.0


@pytest.mark.parametrize(("watt", "shown"), [(1.5, True), (0.1, False)])
def test_an_end_of_the_camera_is_shown_where_the_strip_would_pass_one_that_was_tried(watt: float, shown: bool) -> None:
    time = np.arange(0.0, 200.0, 0.5)
    power = watt * ((time // 50.0) % 2)
    _, rise, _ = lsim(([30.0], [12.0, 1.0]), power, time, interp=False)
    noise = 0.05 * np.random.default_rng(3).standard_normal(time.size)
    run = Run.of("square", Series(time, power), Series(time, 296.0 + rise + noise), sha256="square")
    clip = find("temperature_clip")
    (heat,) = Chain(default_model("lumped", "none"), [run], (), (clip,), DiagnoseOptions(), silent).present.heat
    (score,) = score_test(heat.fit, [clip], 20.0).scores
    assert score.shown is shown
    assert not shown or score.detectable in clip.step_sizes
