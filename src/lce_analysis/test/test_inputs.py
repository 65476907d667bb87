# SPDX-License-Identifier: Apache-2.0
"""What was measured is used: loads and room temperatures that effects read, and what is said where a run lacks them.

The recordings come from a few lines of their own, which share nothing with the terms of the model.
"""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from lce_analysis.comparison.metrics import nrmse
from lce_analysis.diagnosis import diagnose
from lce_analysis.identification import fit
from lce_analysis.inputs import differs_between_runs_only, lacks, without_noise
from lce_analysis.prediction import predict, simulation_input
from lce_data.channels import AMBIENT, DISPLACEMENT, LOAD, TEMPERATURE, Channel, named_input
from lce_data.errors import LceError
from lce_data.experiment_file import experiment_of
from lce_data.run import Run, Series
from lce_model import Model, default_model, simulate
from lce_model.effects import find

Floats = NDArray[np.float64]
TIME = np.arange(0.0, 90.0, 0.05)
ROOM_K, GAIN, TAU = 298.0, 35.0, 12.0
SHIFT, COMPLIANCE = 60.0, 4e-3
"""K/N and m/N of the recordings."""


def _power(seed: int) -> Floats:
    """Steps of 8 s, dark for the first 5 s [W]."""
    levels = np.random.default_rng(seed).uniform(0.2, 2.2, 12)
    return np.where(TIME < 5.0, 0.0, levels[(TIME // 8.0).astype(int)])


def recorded(name: str, load_n: Floats | float = 0.0, room_k: Floats | float = ROOM_K, seed: int = 1) -> Run:
    """A body of one heat capacity, and a contraction of 3 mm by a sigmoid whose middle rises with the load."""
    power, rng = _power(seed), np.random.default_rng(seed)
    load, room = (np.broadcast_to(np.asarray(x, dtype=np.float64), TIME.shape) for x in (load_n, room_k))
    temperature = np.empty_like(TIME)
    temperature[0] = room[0]
    for i in range(1, TIME.size):
        goal = 0.5 * (room[i - 1] + room[i]) + GAIN * power[i - 1]
        temperature[i] = goal + (temperature[i - 1] - goal) * np.exp(-0.05 / TAU)
    contraction = 3e-3 / (1.0 + np.exp(-(temperature - 325.0 - SHIFT * load) / 6.0)) - COMPLIANCE * load
    series = (
        Series(TIME, power),
        Series(TIME[::2], temperature[::2] + 0.05 * rng.standard_normal(TIME[::2].size)),
        Series(TIME, contraction + 4e-6 * rng.standard_normal(TIME.size)),
    )
    return Run.of(name, *series, sha256=name)


def _with(run: Run, inputs: Mapping[Channel, Floats | float]) -> Run:
    for channel, value in inputs.items():
        run = run.with_series(channel, Series(TIME, np.broadcast_to(np.asarray(value, dtype=np.float64), TIME.shape)))
    return run


def _told(run: Run, **conditions: float) -> Run:
    return replace(run, experiment=experiment_of({"conditions": conditions}))


def _error(model: Model, runs: list[Run], channel: Channel) -> float:
    found = [predict(model, run).at_samples[channel] for run in runs]
    return nrmse(np.concatenate(found), np.concatenate([run.series[channel].value for run in runs]))


def test_a_load_that_varies_is_used() -> None:
    sway = 0.05 + 0.04 * np.sin(TIME / 6.0)
    runs = [_with(recorded("sway", sway), {LOAD: sway}), _told(recorded("heavy", 0.1, seed=2), load_n=0.1)]
    base = default_model("lumped", "prandtl_ishlinskii")
    without = fit(base, runs).model
    found = fit(base.add("load_shift").add("load_stretch"), runs).model
    assert _error(without, runs, DISPLACEMENT) > 0.05
    assert _error(found, runs, DISPLACEMENT) < 0.01
    assert found["load_shift.shift"] == pytest.approx(SHIFT, rel=0.05)
    assert found["load_stretch.compliance"] == pytest.approx(COMPLIANCE, rel=0.1)
    later = _with(recorded("later", 0.02 + 1e-3 * TIME, seed=3), {LOAD: 0.02 + 1e-3 * TIME})
    assert _error(found, [later], DISPLACEMENT) < 0.02 < _error(without, [later], DISPLACEMENT)


@pytest.mark.parametrize("deformation", ["equilibrium", "dynamic"])
@pytest.mark.parametrize("load", [0.05 + 0.04 * np.sin(TIME / 6.0), np.full(TIME.size, 0.08)], ids=["sways", "rests"])
def test_noise_of_a_load_cell_does_not_turn_the_branch(deformation: str, load: Floats) -> None:
    model = default_model("lumped", deformation).configured({"load_shift.shift": 40.0})
    noisy = load + 1e-3 * np.random.default_rng(7).standard_normal(TIME.size)
    true, found, raw = (
        simulate(model, TIME, _power(1), inputs={LOAD: values}).displacement_m
        for values in (load, without_noise(Series(TIME, noisy)), noisy)
    )
    assert np.std(found - true) < 0.1 * np.std(raw - true)


@pytest.mark.parametrize(
    "load",
    [0.05 + 0.04 * np.sin(TIME / 6.0), 0.03 * np.floor(TIME / 20.0) + 0.01, np.full(TIME.size, 0.1), np.ones(5)],
    ids=["sine", "steps", "constant", "few"],
)
def test_an_input_without_noise_stays_as_it_is(load: Floats) -> None:
    np.testing.assert_array_equal(without_noise(Series(TIME[: load.size], load)), load)


def test_a_load_that_changes_as_fast_as_it_is_sampled_is_not_smoothed_away() -> None:
    fast = np.sin(2.0 * np.pi * TIME / 0.5)  # ten samples a period
    noisy = fast + 1e-3 * np.random.default_rng(7).standard_normal(TIME.size)
    assert np.abs(without_noise(Series(TIME, noisy)) - fast).max() < 6e-3


def test_a_room_that_was_measured_is_used() -> None:
    warms = ROOM_K + 6.0 * np.sin(TIME / 20.0)
    cold = ROOM_K - 8.0
    runs = [
        _with(recorded("warms", room_k=warms), {AMBIENT: warms}),
        _told(recorded("cold", room_k=cold, seed=2), ambient_c=cold - 273.15),
    ]
    base = default_model("lumped", "none")
    without, found = fit(base, runs).model, fit(base.add("room_temperature"), runs).model
    assert _error(without, runs, TEMPERATURE) > 0.02
    assert _error(found, runs, TEMPERATURE) < 0.004  # the noise is 0.05 K
    assert found["room_temperature.share"] == pytest.approx(1.0, abs=0.02)
    assert found["lumped.tau"] == pytest.approx(TAU, rel=0.01)


def test_a_run_without_a_measured_temperature_starts_at_that_of_the_room() -> None:
    model = default_model("lumped", "prandtl_ishlinskii", ("room_temperature",)).set({"room_temperature.share": 1.0})
    run = _told(recorded("cold").with_series(TEMPERATURE, None), ambient_c=10.0)
    assert predict(model, run).start_temperature_k == pytest.approx(283.15)


def test_a_fit_without_measured_temperatures_starts_there_too() -> None:
    base = default_model("lumped", "prandtl_ishlinskii", ("room_temperature",)).set({"lumped.tau": TAU})
    model = base.set({"room_temperature.share": 1.0}).fix(["room_temperature.share", "lumped.gain", "lumped.tau"])
    cold = _told(recorded("cold", room_k=288.15).with_series(TEMPERATURE, None), ambient_c=15.0)
    found = fit(model.set({"lumped.gain": GAIN}), [cold])
    assert found.model.fit["runs"][0]["start_temperature_k"] == pytest.approx(288.15)
    assert _error(found.model, [cold], DISPLACEMENT) < 0.01


@pytest.mark.parametrize("deformation", ["equilibrium", "prandtl_ishlinskii"])
def test_inputs_that_no_effect_reads_change_nothing(deformation: str) -> None:
    model, run = default_model("lumped", deformation), recorded("run")
    more = _told(_with(run, {LOAD: 0.1, named_input("input_humidity"): 40.0}), ambient_temperature_c=28.0)
    for channel, bare in predict(model, run).at_samples.items():
        np.testing.assert_array_equal(predict(model, more).at_samples[channel], bare)


def test_a_load_recorded_for_longer_than_the_sensors_does_not_make_the_run_longer() -> None:
    run = recorded("run").with_series(LOAD, Series(np.array([0.0, 500.0]), np.array([0.0, 1.0])))
    found = simulation_input(run, default_model())
    assert found.time_s[-1] == TIME[-1]
    np.testing.assert_allclose(found.inputs[LOAD], TIME / 500.0)


def test_a_run_that_lacks_what_an_effect_reads_is_named() -> None:
    has, lacking = _told(recorded("monday"), load_n=0.1), recorded("tuesday")
    told = (
        "tuesday: no load was recorded, which load_shift reads; "
        "record the topic load, or give a column load_n, or load_n in the conditions"
    )
    model = default_model("lumped", "equilibrium", ("load_shift",))
    with pytest.raises(LceError) as error:
        fit(model, [has, lacking])
    assert str(error.value) == told
    with pytest.raises(LceError) as error:
        predict(model.set({"load_shift.shift": 10.0}), lacking)
    assert str(error.value) == told
    assert predict(model, lacking).displacement_m.size  # at its null value it reads nothing
    assert lacks(find("load_shift"), [has, lacking]) == told


def test_an_input_that_never_changes_says_nothing_of_an_effect() -> None:
    runs = [_told(recorded(name), load_n=0.1, ambient_temperature_c=28.0) for name in ("monday", "tuesday")]
    assert lacks(find("load_stretch"), runs) == "load_stretch needs a load that changes; it is 0.1 N throughout"
    words = "room_temperature needs a room temperature that changes; it is 28 °C throughout"
    assert lacks(find("room_temperature"), runs) == words
    assert not lacks(find("load_stretch"), [runs[0], _told(recorded("wednesday"), load_n=0.2)])
    assert not lacks(find("creep"), [recorded("monday")])


def test_what_differs_between_runs_only_is_told_from_what_changes_within_one() -> None:
    runs = [_told(recorded(name), load_n=load) for name, load in (("monday", 0.1), ("tuesday", 0.2))]
    assert differs_between_runs_only(find("load_shift"), runs)
    assert not differs_between_runs_only(find("load_shift"), [runs[0], _with(runs[1], {LOAD: 0.1 + 1e-3 * TIME})])
    assert not differs_between_runs_only(find("creep"), runs)


@pytest.mark.slow
def test_a_room_that_differs_from_run_to_run_is_named_where_it_was_measured() -> None:
    rooms = (294.0, 297.0, 300.0, 303.0)
    runs = [
        _told(recorded(f"at {room:g} K", room_k=room, seed=i), ambient_c=room - 273.15) for i, room in enumerate(rooms)
    ]
    found = diagnose(default_model("lumped", "none"), runs)
    assert [step.added for step in found.steps] == ["room_temperature"]
    assert not found.model.varies
    assert found.model["room_temperature.share"] == pytest.approx(1.0, abs=0.01)


HUMID = """
from lce_model.effects import Effect
from lce_model.terms import Parameter


def step(measured_displacement, input_humidity, swelling):
    return measured_displacement - swelling * (input_humidity - 40.0)


EFFECT = Effect(
    name="swelling",
    stage="sensor",
    equation="d -> d - s (H - 40 %)",
    parameters=(Parameter("swelling", "m", 0.0, -1e-3, 1e-3, "swelling per percent", "a test"),),
    outputs=("measured_displacement",),
    step=step,
    strength="swelling",
    typical=1e-5,
)
"""


def test_an_effect_reads_what_a_user_named(tmp_path: Path) -> None:
    file = tmp_path / "swelling.py"
    file.write_text(HUMID, encoding="utf-8")
    humidity = 40.0 + 20.0 * np.sin(TIME / 9.0)
    model = default_model("lumped", "prandtl_ishlinskii", (str(file),)).set({"swelling.swelling": 1e-5})
    assert model.inputs == (named_input("input_humidity"),)
    run = _with(recorded("run"), {named_input("input_humidity"): humidity})
    there, without = (predict(m, run).at_samples[DISPLACEMENT] for m in (model, model.set({"swelling.swelling": 0.0})))
    np.testing.assert_allclose(there - without, -1e-5 * (humidity - 40.0), atol=1e-12)
    assert lacks(find(str(file)), [recorded("dry")]).startswith("dry: no input_humidity was recorded")
