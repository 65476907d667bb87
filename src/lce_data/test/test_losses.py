# SPDX-License-Identifier: Apache-2.0
"""Lost samples are counted and reported; measurements taken while the power is unknown are left out."""

import numpy as np
import pytest

from lce_data.channels import DISPLACEMENT, POWER, TEMPERATURE
from lce_data.experiment_file import Experiment
from lce_data.losses import lost_samples, without_unknown_power
from lce_data.run import Run, Series
from lce_data.suspicions import suspicions

TIME_S = np.arange(2000) * 0.01
LOST = (TIME_S > 3.095) & (TIME_S < 4.995)
"""190 samples, from 3.1 s on."""


def _run(lost: dict[str, int] | None, power_lost: bool = True) -> Run:
    power = Series(TIME_S, np.where(TIME_S % 8.0 < 4.0, 1.0, 0.2))
    if power_lost:
        power = Series(TIME_S[~LOST], power.value[~LOST])
    every = slice(None, None, 10)
    temperature = Series(TIME_S[every], 300.0 + 0.5 * TIME_S[every])
    displacement = Series(TIME_S[~LOST], 1e-5 * TIME_S[~LOST])
    series = {POWER: power, TEMPERATURE: temperature, DISPLACEMENT: displacement}
    return Run("prbs", series, experiment=Experiment(lost=lost))


def test_they_are_told_by_topic_and_time() -> None:
    run = _run(
        {"/lce/laser/power": 190, "/lce/laser/power_command": 188, "/lce/displacement": 190, "/lce/temperature": 0}
    )
    told = (
        "190 of 2000 laser/power samples lost between 3.1 and 5 s, 190 of 2000 displacement samples lost between 3.1 "
        "and 5 s; measurements while the power is not known were left out"
    )
    assert lost_samples(run) == told
    assert f"prbs: {told}" in suspicions(run)


@pytest.mark.parametrize("lost", [None, {}, {"/lce/laser/power": 0}])
def test_nothing_is_told_of_a_recording_without_losses(lost: dict[str, int] | None) -> None:
    run = _run(lost, power_lost=False)
    assert lost_samples(run) == ""
    assert without_unknown_power(run) is run


def test_measurements_under_an_unknown_power_are_left_out() -> None:
    run = without_unknown_power(_run({"/lce/laser/power": 190}))
    assert run.temperature is not None and run.displacement is not None and run.power is not None
    left = run.temperature.time_s
    assert left.size == 200 - 19 and not ((left > 3.095) & (left < 4.995)).any()
    assert run.displacement.time_s.size == 1810, "lost as well: absent already"
    assert run.power.time_s.size == 1810


def test_what_counts_is_the_topic_that_was_read() -> None:
    run = _run({"/lce/laser/power": 190, "/lce/laser/power_stamped": 0}, power_lost=False)
    assert lost_samples(run) == ""
    run = _run({"/lce/laser/power": 0, "/lce/laser/power_stamped": 190})
    assert "190 of 2000 laser/power samples lost" in lost_samples(run)


def test_a_power_that_is_recorded_when_it_changes_is_no_loss() -> None:
    run = _run({"/lce/laser/power": 0})
    assert without_unknown_power(run) is run
