# SPDX-License-Identifier: Apache-2.0
"""A parameter at a bound is told, with what the data want beyond it; the data are made by scipy."""

import numpy as np
import pytest
from scipy.signal import lsim

from lce_analysis.identification import fit
from lce_analysis.identification.at_bounds import at_bounds, left
from lce_data.channels import TEMPERATURE
from lce_data.run import Run, Series
from lce_model import default_model

AMBIENT_K, GAIN, TAU_S, LAG_S = 296.0, 60.0, 150.0, 30.0


def late_heater() -> Run:
    """A heater whose sensor is 30 s late, under a power that is switched five times."""
    time = np.arange(0.0, 1000.0, 1.0)
    power = np.where((time // 200.0) % 2 == 0, 0.6, 0.1)
    _, rise, _ = lsim(([GAIN], [TAU_S * LAG_S, TAU_S + LAG_S, 1.0]), power, time, interp=False)
    noise = 0.05 * np.random.default_rng(1).standard_normal(time.size)
    return Run.of("late", Series(time, power), Series(time, AMBIENT_K + rise + noise), sha256="late")


def test_what_the_data_want_beyond_a_bound_and_what_it_brings() -> None:
    model = default_model("lumped", "none", ("camera_lag",)).fix(["camera_lag.delay"])
    result = fit(model, [late_heater()])
    (found,) = at_bounds(result.problem)
    assert (found.key, found.side, found.bound) == ("camera_lag.tau", "upper", 2.0)
    # The bound is moved out ten times, to 20 s, and the data want 30.
    assert found.at_end and found.wider == (0.0, 20.0)
    assert found.after[TEMPERATURE] < 0.6 * found.before[TEMPERATURE]
    assert "the data want more than 20 s" in found.sentence
    assert "--bounds camera_lag.tau=0,20" in found.sentence
    wider = fit(model.hold({"camera_lag.tau": (0.0, 100.0)}), [late_heater()])
    assert at_bounds(wider.problem) == ()
    assert wider.model["camera_lag.tau"] == pytest.approx(LAG_S, abs=0.5)


def test_a_lower_bound_of_a_temperature() -> None:
    model = default_model("lumped", "none", ("second_mass",)).hold({"ambient.t_env": (300.0, 320.0)})
    (found,) = at_bounds(fit(model, [late_heater()]).problem)
    assert (found.key, found.side) == ("ambient.t_env", "lower")
    assert found.wanted == pytest.approx(AMBIENT_K, abs=0.2)
    assert found.wider == (280.0, 320.0)


def test_a_strength_at_its_null_value_is_not_told() -> None:
    result = fit(default_model("lumped", "none", ("second_mass", "clamp_conduction")), [late_heater()])
    assert [bound.key for bound in at_bounds(result.problem)] in ([], ["clamp_conduction.tau"])


def test_the_share_that_is_left_is_that_of_the_spread_of_all_runs() -> None:
    run = late_heater()
    result = fit(default_model("lumped", "none"), [run])
    assert run.temperature is not None
    rms = result.problem.series_rms(result.problem.first(), TEMPERATURE)
    assert left(result.problem)[TEMPERATURE] == pytest.approx(rms / np.std(run.temperature.value))
    assert left(result.problem)[TEMPERATURE] == pytest.approx(
        result.model.fit["runs"][0]["temperature_nrmse"], abs=1e-4
    )
