# SPDX-License-Identifier: Apache-2.0
"""What every effect of the library has to keep: nothing at its null value, something at its typical one, and order.

One kernel that holds all of them serves most tests, each effect switched on by its strength: as the diagnosis does it.
"""

from functools import cache

import numpy as np
import pytest

from lce_data.channels import AMBIENT, LOAD
from lce_data.errors import LceError
from lce_data.waveforms import RATE_HZ, SHAPES
from lce_model import Model, Trajectory, default_model, simulation
from lce_model.effects import Effect, find, library
from lce_model.kernel.generate import RECORDED
from lce_model.terms import SIGNALS, STAGES

EFFECTS = tuple(library().values())
BASES = ("equilibrium", "dynamic", "kinetic")
CAMERA_K, DISTANCE_M = 0.06, 4e-6

each = pytest.mark.parametrize("effect", EFFECTS, ids=lambda e: e.name)


def _wave() -> np.ndarray:
    """Two pulses with rests, then a staircase [W]."""
    pulse = SHAPES["pulse"].power_w({"amp": (0.4,), "th": (8.0,), "offset": (1.7,), "rest": (10.0,)})
    stairs = SHAPES["stairs"].power_w({"low": (0.5,), "high": (2.0,), "steps": (3.0,), "hold": (5.0,), "rest": (6.0,)})
    return np.concatenate([pulse, pulse, stairs])


POWER = _wave()
TIME = np.arange(POWER.size) / RATE_HZ


def simulate(
    model: Model, time_s: np.ndarray, power_w: np.ndarray, temperature_k: np.ndarray | None = None
) -> Trajectory:
    """A strip under a load that sways, in a room that warms up."""
    inputs = {LOAD: 0.05 + 0.03 * np.sin(time_s / 4.0), AMBIENT: 300.0 + 2.0 * np.sin(time_s / 30.0)}
    return simulation.simulate(model, time_s, power_w, temperature_k=temperature_k, inputs=inputs)


def reversible() -> Model:
    """The equilibrium model with both branches alike: without the jump at a reversal, all is smooth in the step."""
    model = default_model("lumped", "equilibrium")
    pairs = {f"{name}_c": f"{name}_r" for name in ("c", "t_star", "a1", "a3")}
    return model.set({f"equilibrium.{c}": model[f"equilibrium.{r}"] for c, r in pairs.items()})


@cache
def with_all(deformation: str) -> Model:
    model = reversible() if deformation == "reversible" else default_model("lumped", deformation)
    return model.configured({e.strength_key: e.null for e in EFFECTS})


def on(model: Model, effect: Effect) -> Model:
    return model.set({effect.strength_key: effect.typical})


def columns(run: Trajectory) -> np.ndarray:
    return np.array(list(run.signals.values()))


def test_the_library_is_that_of_the_design() -> None:
    assert len(EFFECTS) >= 22
    assert {e.stage for e in EFFECTS} == set(STAGES)
    assert [e.name for e in EFFECTS] == sorted(e.name for e in EFFECTS)


@each
def test_an_effect_explains_itself(effect: Effect) -> None:
    assert effect.equation
    assert effect.title and len(effect.title) < 40
    assert effect.meaning and len(effect.meaning) < 80 and not effect.meaning.endswith(".")
    assert effect.step_sizes and all(size > 0.0 for size in effect.step_sizes)
    assert effect.strength_key == f"{effect.name}.{effect.strength}"
    assert any(not p.fixed for p in effect.parameters)
    for parameter in effect.parameters:
        assert parameter.unit
        assert parameter.description
        assert parameter.source


@pytest.mark.slow
@pytest.mark.parametrize(
    ("deformation", "rounding"),
    [("equilibrium", 0.0), ("dynamic", 0.0), ("prandtl_ishlinskii", 0.0), ("none", 0.0), ("kinetic", 1e-10)],
)
def test_at_their_null_values_all_effects_together_change_nothing(deformation: str, rounding: float) -> None:
    """Not a bit, but for kinetic: the compiler adds its fronts in any order, on some processors another per kernel."""
    model = default_model("lumped", deformation)
    bare, null = columns(simulate(model, TIME, POWER)), columns(simulate(with_all(deformation), TIME, POWER))
    np.testing.assert_allclose(null, bare, rtol=rounding, atol=rounding * 1e-6)


@each
@pytest.mark.parametrize("deformation", BASES)
def test_at_its_null_value_an_effect_changes_nothing_whatever_its_other_parameters(
    deformation: str, effect: Effect
) -> None:
    null = with_all(deformation)
    rng = np.random.default_rng(1)
    others = {
        f"{effect.name}.{p.name}": rng.uniform(p.lower, p.upper)
        for p in effect.parameters
        if p.name not in effect.amplitudes
    }
    off = columns(simulate(null, TIME, POWER))
    np.testing.assert_array_equal(columns(simulate(null.set(others), TIME, POWER)), off)
    for name in effect.acting_alone:
        alone = null.set({f"{effect.name}.{name}": 0.5 * effect.parameter(name).upper})
        assert not np.array_equal(columns(simulate(alone, TIME, POWER)), off)


@each
@pytest.mark.parametrize("deformation", BASES)
def test_an_effect_at_its_typical_strength_can_be_seen(deformation: str, effect: Effect) -> None:
    null = with_all(deformation)
    without, with_it = simulate(null, TIME, POWER), simulate(on(null, effect), TIME, POWER)
    temperature = with_it.measured_temperature_k - without.measured_temperature_k
    displacement = with_it.measured_displacement_m - without.measured_displacement_m
    assert np.isfinite(columns(with_it)).all()
    seen = max(np.sqrt(np.mean(temperature**2)) / CAMERA_K, np.sqrt(np.mean(displacement**2)) / DISTANCE_M)
    assert seen > 2.0
    if effect.stage in ("order", "strain") or effect.outputs == ("measured_displacement",):
        assert not temperature.any()
    if effect.outputs == ("measured_temperature",):
        assert not displacement.any()


@pytest.mark.parametrize("deformation", BASES)
def test_all_effects_at_once_give_numbers_anywhere_within_their_bounds(deformation: str) -> None:
    rng = np.random.default_rng(2)
    for _ in range(20):
        drawn = {
            f"{e.name}.{p.name}": rng.choice([p.lower, p.upper, rng.uniform(p.lower, p.upper)])
            for e in EFFECTS
            for p in e.parameters
        }
        run = simulate(with_all(deformation).set(drawn), TIME, POWER)
        assert np.isfinite(columns(run)).all()
        assert 200.0 < run.temperature_k.min() < run.temperature_k.max() < 700.0


@pytest.mark.parametrize("name", ["radiation", "photochemical_order", "backlash", "camera_lag"])
def test_an_effect_alone_is_what_it_is_among_the_others(name: str) -> None:
    alone = simulate(on(reversible().add(name), find(name)), TIME, POWER)
    among = simulate(on(with_all("reversible"), find(name)), TIME, POWER)
    np.testing.assert_array_equal(columns(alone), columns(among))


@pytest.mark.parametrize(
    "pair", [("creep", "backlash"), ("thermal_gradient", "photochemical_order"), ("camera_lag", "emissivity_error")]
)
def test_a_pair_does_not_depend_on_the_order_in_which_it_was_added(pair: tuple[str, str]) -> None:
    one, other = reversible().add(pair[0]).add(pair[1]), reversible().add(pair[1]).add(pair[0])
    assert one.terms == other.terms
    assert np.isfinite(columns(simulate(on(on(one, find(pair[0])), find(pair[1])), TIME, POWER))).all()


def test_the_order_of_the_effects_in_their_stages() -> None:
    names = [t.name for t in with_all("equilibrium").terms]
    for first, then in (
        ("laser_saturation", "photobleaching"),  # the laser, then the dye
        ("radiation", "lumped"),  # a loss feeds the heat balance
        ("thermal_gradient", "photochemical_order"),  # light acts where the temperature has arrived
        ("photochemical_order", "branch"),
        ("transition_distribution", "equilibrium"),
        ("equilibrium", "phase_kinetics"),
        ("thermal_expansion", "strip"),
        ("strip", "creep"),
        ("creep", "backlash"),  # the strip creeps, its mount has play
        ("second_mass", "emissivity_error"),
        ("emissivity_error", "camera_lag"),
    ):
        assert names.index(first) < names.index(then)


@each
def test_a_hundred_steps_a_second_are_enough(effect: Effect) -> None:
    """Error of the effect, against steps of 1 ms, relative to the largest it does."""
    fine = np.arange((TIME.size - 1) * 10 + 1) / (10.0 * RATE_HZ)
    fine_power = np.repeat(POWER, 10)[: fine.size]
    null = with_all("reversible")
    sensors = [RECORDED.index(s) for s in ("measured_temperature", "measured_displacement")]
    coarse, exact = (
        (columns(simulate(on(null, effect), t, p)) - columns(simulate(null, t, p)))[sensors]
        for t, p in ((TIME, POWER), (fine, fine_power))
    )
    size = np.abs(exact).max(axis=1)
    assert (np.abs(coarse - exact[:, ::10]).max(axis=1) <= 1e-4 * size).all()


@pytest.mark.parametrize("deformation", ["none", "equilibrium"])
def test_a_measured_temperature_leaves_light_and_heat_aside(deformation: str) -> None:
    model = default_model("none" if deformation != "none" else "lumped", deformation)
    temperature = simulate(default_model("lumped", "none"), TIME, POWER).temperature_k
    driven = simulate(model.add("radiation"), TIME, POWER, temperature_k=temperature)
    np.testing.assert_array_equal(driven.temperature_k, temperature)


def test_adding_and_taking_out_keep_the_other_values() -> None:
    model = default_model().set({"lumped.gain": 41.0}).add("creep").set({"creep.share": 0.2}).add("radiation")
    assert model["creep.share"] == 0.2
    assert model["radiation.emissivity"] == 0.0
    assert model.without("radiation").without("creep").values == default_model().set({"lumped.gain": 41.0}).values
    with pytest.raises(LceError, match="has creep already"):
        model.add("creep")
    with pytest.raises(LceError, match="has no effect backlash; it has creep, radiation"):
        model.without("backlash")
    with pytest.raises(
        LceError, match=r"unknown effect 'crep' \(did you mean 'creep'\?\); known: ambient_drift, backlash"
    ):
        model.add("crep")


def test_another_deformation_model_keeps_the_heat_its_bounds_and_the_effects() -> None:
    model = default_model("lumped", "dynamic", ("camera_lag",)).hold({"camera_lag.tau": (0.0, 20.0)})
    model = model.set({"camera_lag.tau": 16.0, "stretch_law.alpha": 3.0})
    other = model.deformed_by("equilibrium")
    assert (other.deformation, other.effects, other["camera_lag.tau"]) == ("equilibrium", model.effects, 16.0)
    assert other["stretch_law.alpha"] == 3.0
    default = default_model("lumped", "equilibrium")
    assert all(other[v.key] == v.value for v in default.values if v.term == "equilibrium")


def test_a_setting_of_an_effect_adds_it() -> None:
    model = default_model().configured({"creep.share": 0.2, "creep.tau_v": 5.0, "lumped.tau": 20.0})
    assert model.effects == ("creep",)
    assert model.configured({"creep.share": 0.3})["creep.share"] == 0.3
    with pytest.raises(LceError, match=r"unknown parameter 'creep\.shar'"):
        default_model().configured({"creep.shar": 0.2})


def test_every_signal_has_a_unit() -> None:
    for name, meaning in SIGNALS.items():
        assert ", " in meaning or name == "direction"


@pytest.mark.parametrize("name", ["thermal_expansion", "elastic_softening"])
@pytest.mark.parametrize("base", BASES)
def test_a_strip_at_rest_has_its_own_length_whatever_the_temperature_of_its_surroundings(name: str, base: str) -> None:
    effect = find(name)
    strip = default_model("lumped", base, (name,)).set({"ambient.t_env": 290.0})
    acting = strip.set({effect.strength_key: effect.typical})

    def moved(start_k: float | None) -> float:
        """What the effect moves the strip by as the run begins [m]."""
        pair = (simulation.simulate(model, TIME, 0.0 * POWER, start_k) for model in (strip, acting))
        without, with_it = (trajectory.displacement_m for trajectory in pair)
        return float(with_it[0] - without[0])

    assert moved(None) == 0.0
    assert abs(moved(330.0)) > 3.0 * DISTANCE_M
