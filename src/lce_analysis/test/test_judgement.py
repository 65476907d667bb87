# SPDX-License-Identifier: Apache-2.0
"""A fit says that its model does not describe the data, and which built-in one would; the data are made by scipy."""

import numpy as np
import pytest
from scipy.signal import lsim

from lce_analysis.identification import fit
from lce_analysis.identification.judgement import ChannelJudgement, Rival, judge, poor_channels
from lce_data.channels import DISPLACEMENT, TEMPERATURE
from lce_data.run import Run, Series
from lce_model import default_model


def tanks(name: str, period_s: float, hot: bool = False) -> Run:
    """Two tanks of 100 s each one behind the other, square waves of the power, the second one measured."""
    time = np.arange(0.0, 1200.0, 2.0)
    power = np.where((time // period_s) % 2 == 0, 0.9, 0.1)
    _, rise, _ = lsim(([40.0], [1e4, 2e2, 1.0]), power, time, interp=False)
    noise = 0.05 * np.random.default_rng(int(period_s)).standard_normal(time.size)
    temperature = (310.0 if hot else 296.0) + rise + noise
    return Run.of(name, Series(time, power), Series(time, temperature), sha256=name)


RUNS = (tanks("slow", 300.0), tanks("middle", 200.0), tanks("fast", 120.0))


@pytest.mark.slow
@pytest.mark.parametrize("runs", [RUNS, RUNS[2:]], ids=["run by run", "block by block"])
def test_a_model_of_the_wrong_order_is_told_with_the_built_in_one_that_does_better(
    runs: tuple[Run, ...], request: pytest.FixtureRequest
) -> None:
    (found,) = judge(fit(default_model("lumped", "none"), runs), runs)
    assert found.channel is TEMPERATURE
    assert found.left > 0.2
    assert found.by in request.node.name
    assert [rival.name for rival in found.rivals] == ["lumped", "lumped + second_mass", "hammerstein_wiener"]
    assert found.best is not None and found.best.name == "lumped + second_mass"
    assert found.best.held_out < 0.05
    assert found.best.option == "--thermal lumped --effect second_mass"
    assert found.as_json()["better"] == "lumped + second_mass"


def test_a_model_that_describes_its_data_is_not_judged_further() -> None:
    result = fit(default_model("lumped", "none", ("second_mass",)), RUNS)
    assert judge(result, RUNS) == ()


def test_runs_that_hardly_move_are_described_by_a_model_that_leaves_their_noise() -> None:
    time = np.arange(0.0, 400.0, 1.0)
    power = np.where(time < 200.0, 1e-3, 0.0)
    noise = 0.05 * np.random.default_rng(0).standard_normal(time.size)
    run = Run.of("still", Series(time, power), Series(time, 296.0 + noise), sha256="still")
    assert poor_channels(fit(default_model("lumped", "none"), [run])) == {}


def test_without_a_comparison_it_is_said_all_the_same() -> None:
    (found,) = judge(fit(default_model("lumped", "none"), RUNS), RUNS, compared=False)
    assert found.rivals == () and found.best is None
    assert len(found.sentences) == 1 and "does not describe the temperature" in found.sentences[0]


def test_a_rival_that_is_hardly_better_is_not_recommended() -> None:
    own, other = Rival("equilibrium", "", 0.30), Rival("kinetic", "--deformation kinetic", 0.28)
    judged = ChannelJudgement(DISPLACEMENT, 0.3, "run by run", (own, other))
    assert judged.best is None
    assert "No built-in model does better" in judged.sentences[-1]
    unfit = Rival("hammerstein_wiener", "", float("inf"))
    assert "hammerstein_wiener –" in ChannelJudgement(TEMPERATURE, 0.3, "run by run", (own, unfit)).sentences[1]


def test_of_two_that_do_equally_well_the_simpler_one_is_named() -> None:
    own, simple, black = Rival("lumped", "", 0.3), Rival("two", "--effect two", 0.102), Rival("black box", "", 0.100)
    found = ChannelJudgement(TEMPERATURE, 0.3, "run by run", (own, simple, black)).best
    assert found is simple
