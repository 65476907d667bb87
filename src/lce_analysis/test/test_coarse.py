# SPDX-License-Identifier: Apache-2.0
"""A coarser grid for searching: the same light, and a simulation that differs by less than the sensors can tell."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from lce_analysis.identification.coarse import STEP_S, coarse
from lce_analysis.jumps import away_from, discontinuities
from lce_analysis.prediction import COLUMN, SimulationInput, simulation_input
from lce_data.channels import DISPLACEMENT, TEMPERATURE
from lce_data.run import Run, Series
from lce_model import Model

Floats = NDArray[np.float64]
NOISE = {TEMPERATURE: 0.06, DISPLACEMENT: 4e-6}


def _levels(time: Floats) -> Floats:
    """Power [W] that jumps at times that are on no grid of 0.1 s."""
    return np.select([time < 1.03, time < 13.01, time < 20.02, time < 33.04], [0.0, 1.4, 0.3, 1.1], 0.0)


def _wave(time: Floats) -> Floats:
    return 0.7 - 0.7 * np.cos(0.4 * time)


def _energy(run_input: SimulationInput) -> float:
    return float(run_input.power_w[:-1] @ np.diff(run_input.time_s))


@pytest.mark.parametrize("power", [_levels, _wave])
def test_the_energy_of_the_light_is_kept(
    strip: Model, recorded: Callable[..., Run], power: Callable[[Floats], Floats]
) -> None:
    fine = simulation_input(recorded(power=power, duration_s=45.0), strip)
    found = coarse(fine)
    assert found.time_s.size < 0.3 * fine.time_s.size
    assert np.diff(found.time_s).max() < STEP_S + 1e-9
    assert (found.time_s[0], found.time_s[-1]) == (fine.time_s[0], fine.time_s[-1])
    assert _energy(found) == pytest.approx(_energy(fine), rel=1e-12)


def test_the_light_jumps_where_it_did(strip: Model, recorded: Callable[..., Run]) -> None:
    found = coarse(simulation_input(recorded(power=_levels, duration_s=45.0), strip))
    jumps = found.time_s[1:][np.abs(np.diff(found.power_w)) > 0.02]
    assert jumps == pytest.approx([1.03, 13.01, 20.02, 33.04], abs=0.0101)
    assert set(found.power_w.round(9)) == {0.0, 1.4, 0.3, 1.1}


@pytest.mark.parametrize("power", [_levels, _wave])
def test_the_simulation_differs_by_less_than_a_tenth_of_the_noise(
    strip: Model, recorded: Callable[..., Run], power: Callable[[Floats], Floats]
) -> None:
    fine = simulation_input(recorded(power=power, duration_s=45.0), strip)
    found = coarse(fine)
    start = np.array([strip["ambient.t_env"]])
    outputs = {id(p): p.simulate(strip, strip.vector[None], start)[0] for p in (fine, found)}
    for channel, noise in NOISE.items():
        series = found.run.series[channel]
        assert np.diff(series.time_s).min() > STEP_S - 1e-9
        shown = found.sampling[channel](outputs[id(found)][:, COLUMN[channel]])
        modelled = outputs[id(fine)][:, COLUMN[channel]]
        # Where the temperature turns inside the loop the model jumps, on the coarse grid up to a step sooner or later.
        away = away_from(discontinuities(fine.time_s, modelled, noise), series.time_s)
        assert away.mean() > 0.9
        error = (shown - np.interp(series.time_s, fine.time_s, modelled))[away]
        assert np.sqrt(np.mean(error**2)) < 0.1 * noise


def test_the_samples_that_stay_are_those_that_were_measured(strip: Model, recorded: Callable[..., Run]) -> None:
    run = recorded(duration_s=45.0)
    found = coarse(simulation_input(run, strip)).run
    for channel, series in found.measured.items():
        where = np.searchsorted(run.series[channel].time_s, series.time_s)
        np.testing.assert_array_equal(run.series[channel].value[where], series.value)


def test_a_run_that_is_coarse_already_stays_as_it_is(strip: Model, recorded: Callable[..., Run]) -> None:
    run = recorded(duration_s=45.0)
    run = Run.of("coarse", *(Series(s.time_s[::10], s.value[::10]) for s in run.series.values()), sha256="0" * 64)
    run_input = simulation_input(run, strip)
    assert coarse(run_input) is run_input
