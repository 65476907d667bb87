# SPDX-License-Identifier: Apache-2.0
"""What no library holds is found: in a heater whose equation is solved here, by other means."""

import json
import re
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from lce_analysis import DiscoverOptions, discover
from lce_analysis.discovery import Discovery
from lce_data.errors import LceError
from lce_data.run import Run, Series
from lce_model import default_model

Floats = NDArray[np.float64]
Law = Callable[[float, float, float], float]

AMBIENT_K, GAIN, TAU_S, NOISE_K = 297.0, 45.0, 12.0, 0.05
WAVES = {
    "pulse": lambda t: np.where((t > 2.0) & (t < 30.0), 1.3, 0.0),
    "stairs": lambda t: 0.3 * np.floor(t / 14.0) % 1.5,
    "prbs": lambda t: np.where(np.sin(0.41 * t) + np.sin(0.97 * t) > 0.2, 1.4, 0.1),
}
KEYS = {"verdict", "signatures", "closures", "formulas", "error", "error_over_noise", "seconds"}


def nothing(kelvin: float, watt: float, second: float) -> float:
    """The heat balance of the base model is all there is."""
    return 0.0


def radiation(kelvin: float, watt: float, second: float) -> float:
    """Heat lost by T⁴ [K/s]."""
    return -4e-10 * (kelvin**4 - AMBIENT_K**4)


def saturation(kelvin: float, watt: float, second: float) -> float:
    """Light that is not absorbed at a high power, as a heating rate [K/s]."""
    return -GAIN / TAU_S * watt * 0.3 * watt / (1.0 + 0.3 * watt)


def draught(kelvin: float, watt: float, second: float) -> float:
    """A loss that comes and goes [K/s]; its phase is that of the wall clock, another in every run."""
    return -0.25 * (kelvin - AMBIENT_K) / TAU_S * np.sin(2.0 * np.pi * second / 9.0)


def heater(name: str, law: Law, seed: int) -> Run:
    """A run of 80 s: power at 20 Hz, camera at 10 Hz, white noise."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, 80.0, 0.05)
    power, later = WAVES[name](time), 1000.0 * rng.uniform()

    def rate(t: float, y: Floats) -> list[float]:
        watt = float(power[min(int(t / 0.05 + 1e-9), power.size - 1)])
        return [(GAIN * watt - (y[0] - AMBIENT_K)) / TAU_S + law(float(y[0]), watt, t + later)]

    solved = solve_ivp(rate, (0.0, time[-1]), [AMBIENT_K], t_eval=time[::2], max_step=0.05, rtol=1e-6)
    seen = solved.y[0] + NOISE_K * rng.standard_normal(solved.t.size)
    return Run.of(name, power=Series(time, power), temperature=Series(time[::2], seen), sha256=name)


def discovered(law: Law) -> Discovery:
    train, test = [heater("pulse", law, 1), heater("stairs", law, 2)], [heater("prbs", law, 3)]
    model = default_model("lumped", "none").set({"lumped.gain": 40.0, "lumped.tau": 10.0, "ambient.t_env": 296.0})
    return discover(model, train, test)


@pytest.fixture(scope="module")
def radiating() -> Discovery:
    return discovered(radiation)


def test_a_loss_is_found_in_the_heat_over_the_temperature(radiating: Discovery) -> None:
    (found,) = radiating.found
    assert radiating.verdict == "found"
    assert found.closure.candidate.label == "heat × temperature"
    assert radiating.test.misfit["after"].rms.popitem()[1] < 1.1 < radiating.test.misfit["before"].rms.popitem()[1]
    assert "heat balance has too much by" in found.curve.words
    assert found.curve.offset and found.curve.slope  # the base model absorbs both
    assert {"fourth_power", "quadratic", "power"} & {one.form.name for one in found.formulas}


def test_the_curve_is_the_law_but_for_a_straight_line(radiating: Discovery) -> None:
    (found,) = radiating.found
    x, y = found.curve.x, found.curve.y
    law = np.array([radiation(float(k), 0.0, 0.0) for k in x])
    line = np.column_stack([np.ones(x.size), x])
    apart = (y - law) - line @ np.linalg.lstsq(line, y - law, rcond=None)[0]
    bent = law - line @ np.linalg.lstsq(line, law, rcond=None)[0]
    assert np.max(np.abs(apart)) < 0.25 * np.max(np.abs(bent))


def test_the_record_has_the_keys_of_the_contract(radiating: Discovery) -> None:
    record = json.loads(json.dumps(radiating.as_json()))
    assert set(record) >= KEYS
    (told,) = record["closures"]
    assert set(told) == {"place", "covariate", "lag_s", "set", "ln_evidence", "curve", "words"}
    assert told["set"][0] == ["heat", "temperature"] and told["lag_s"] is None
    assert all(len(row) == 3 for row in told["curve"])
    for formula in record["formulas"]:
        assert set(formula) == {"closure", "form", "expression", "parameters", "set"}
        assert formula["form"] in formula["set"] and formula["closure"] == 0
    assert set(record["error"]["test"]) == {"before", "after"}


def test_saturation_of_the_light_is_not_told_from_heat_over_the_power() -> None:
    (found,) = discovered(saturation).found
    pairs = {(c.place.name, c.covariate.name) for c in found.closure.alike}
    assert {("light", "power"), ("heat", "power")} <= pairs


def test_nothing_is_found_where_nothing_is_missing() -> None:
    found = discovered(nothing)
    assert (found.verdict, found.found) == ("nothing", ())
    assert "Nothing is left to be found" in found.sentences[0]


def test_a_draught_is_a_disturbance_and_no_function() -> None:
    found = discovered(draught)
    assert (found.verdict, found.found) == ("disturbance", ())
    assert any(re.search(r"of the heat loss, with a period of (8\.[5-9]|9)", told) for told in found.sentences)


def test_no_runs_and_impossible_options_are_refused() -> None:
    with pytest.raises(LceError, match="no runs to learn from"):
        discover(default_model("lumped", "none"), [])
    with pytest.raises(LceError, match="refitted: 0 is not 1 or more"):
        DiscoverOptions(refitted=0)
    with pytest.raises(LceError, match="lags_s"):
        DiscoverOptions(lags_s=(0.0, 1.0))
