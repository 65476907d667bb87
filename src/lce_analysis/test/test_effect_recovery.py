# SPDX-License-Identifier: Apache-2.0
"""Every effect is found again from noisy data made with it, the parameters of the strip free beside it."""

import numpy as np
import pytest

from lce_analysis.identification import FitResult, fit
from lce_analysis.prediction import predict
from lce_data.channels import AMBIENT, DISPLACEMENT, LOAD, TEMPERATURE
from lce_data.run import Run, Series
from lce_data.waveforms import RATE_HZ, SHAPES
from lce_model import Model, default_model, simulate
from lce_model.effects import find, library

pytestmark = pytest.mark.slow

CAMERA_K, DISTANCE_M = 0.06, 4e-6
STRIP = default_model("lumped", "equilibrium")
WAVES = {
    "pulse": {"amp": 0.8, "th": 16.0, "offset": 1.7, "rest": 30.0},
    "stairs": {"low": 0.5, "high": 2.2, "steps": 4.0, "hold": 8.0, "rest": 20.0},
}
STRONGER = {
    "clamp_conduction": {"clamp_conduction.conductance": 3e-4, "clamp_conduction.tau": 30.0},
    "residual_strain": {"residual_strain.share": 0.1, "residual_strain.saturation": 0.01},
}
"""Where the typical strength takes longer runs than these to be told."""
FIRST_VALUE = {
    "displacement_clip": {"displacement_clip.inverse": 560.0},
    "temperature_clip": {"temperature_clip.inverse": 0.019},
}
"""Where the null value has no slope to begin by: a sensor that ends beyond all that it sees."""
MASKED = "emissivity_error"
"""The gain and every temperature of the model take its place."""


def _run(kind: str, strip: Model) -> Run:
    power = SHAPES[kind].power_w({name: (value,) for name, value in WAVES[kind].items()})
    time = np.arange(power.size) / RATE_HZ
    noise = np.random.default_rng(len(kind))
    inputs = {LOAD: 0.05 + 0.03 * np.sin(time / 5.0), AMBIENT: 301.15 + 2.0 * np.sin(time / 15.0)}
    true = simulate(strip, time, power, inputs=inputs)
    temperature = true.measured_temperature_k[::10] + CAMERA_K * noise.standard_normal(time[::10].size)
    displacement = true.measured_displacement_m + DISTANCE_M * noise.standard_normal(time.size)
    series = Series(time, power), Series(time[::10], temperature), Series(time, displacement)
    run = Run.of(kind, *series, sha256=kind)
    for channel, value in inputs.items():
        run = run.with_series(channel, Series(time, value))
    return run


def _hidden(name: str) -> Model:
    """The strip with the effect."""
    effect = find(name)
    return STRIP.add(name).set({effect.strength_key: effect.typical} | STRONGER.get(name, {}))


def _fitted(name: str, runs: list[Run]) -> FitResult:
    """What a fit makes of the runs from the null value of the effect."""
    return fit(STRIP.add(name).set(FIRST_VALUE.get(name, {})), runs)


@pytest.mark.parametrize("name", [name for name in library() if name != MASKED])
def test_the_strength_of_an_effect_is_recovered(name: str) -> None:
    key, strip = find(name).strength_key, _hidden(name)
    runs = [_run(kind, strip) for kind in WAVES]
    result = _fitted(name, runs)
    found = result.model.values[result.model.index(key)]
    assert found.standard_error is not None
    assert found.standard_error < 0.2 * strip[key]
    assert found.value == pytest.approx(strip[key], abs=4.0 * found.standard_error)
    for run in runs:
        assert run.temperature is not None
        assert run.displacement is not None
        said = predict(result.model, run)
        assert np.std(said.at_samples[TEMPERATURE] - run.temperature.value) < 1.1 * CAMERA_K
        assert np.std(said.at_samples[DISPLACEMENT] - run.displacement.value) < 1.1 * DISTANCE_M


def test_an_effect_that_the_strip_itself_can_take_the_place_of_is_told_as_undetermined() -> None:
    result = _fitted(MASKED, [_run(kind, _hidden(MASKED)) for kind in WAVES])
    value = result.model.values[result.model.index(find(MASKED).strength_key)]
    assert value.determined is False
    assert result.identifiability is not None
    assert any(find(MASKED).strength_key in sentence for sentence in result.identifiability.sentences)
