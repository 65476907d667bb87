# SPDX-License-Identifier: Apache-2.0
"""Which part of a model decides the temperature, and which acts back on it."""

import pytest

from lce_analysis.identification.stages import HEAT_STAGES, acts_back, acts_on_temperature, thermal_stage
from lce_model import Model, default_model
from lce_model.effects import find, library
from lce_model.library import DEFORMATION

BASE = default_model("lumped", "equilibrium")


@pytest.mark.parametrize("name", ["radiation", "laser_saturation", "ambient_drift", "camera_lag", "emissivity_error"])
def test_light_heat_surroundings_and_camera_act_on_the_temperature(name: str) -> None:
    assert acts_on_temperature(find(name))


@pytest.mark.parametrize("name", ["creep", "thermal_gradient", "displacement_drift", "backlash"])
def test_strip_and_distance_sensor_do_not(name: str) -> None:
    assert not acts_on_temperature(find(name))


@pytest.mark.parametrize("deformation", [name for name in DEFORMATION if name != "none"])
def test_of_the_library_only_what_follows_the_order_acts_back(deformation: str) -> None:
    model = default_model("lumped", deformation)
    turns = any("fraction" in term.outputs for term in model.terms)
    expected = {"order_dependent_absorption", *(["latent_heat"] if turns else [])}
    assert {name for name, effect in library().items() if acts_back(effect, model)} == expected


@pytest.mark.parametrize("model", [BASE, BASE.add("radiation").add("creep").add("camera_lag")], ids=["base", "added"])
def test_the_thermal_stage_holds_what_decides_the_temperature_with_its_values(model: Model) -> None:
    model = model.set({"lumped.tau": 21.0, "ambient.t_env": 299.0})
    alone = thermal_stage(model)
    assert alone.deformation == "none"
    assert set(alone.effects) == {name for name in model.effects if acts_on_temperature(find(name))}
    assert all(v.value == model[v.key] for v in alone.values)
    # A fit of the heat goes by the positions that its parameters have in the whole model.
    heat = {t.name for t in model.terms if t.stage in HEAT_STAGES}
    assert all(alone.index(v.key) == i for i, v in enumerate(model.values) if v.term in heat)


def test_where_the_strip_acts_back_the_thermal_stage_is_the_whole_model() -> None:
    model = BASE.add("order_dependent_absorption")
    assert thermal_stage(model) is model
