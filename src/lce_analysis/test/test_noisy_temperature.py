# SPDX-License-Identifier: Apache-2.0
"""T→d driven by a noisy camera: the direction does not flicker, and the displacement stays right."""

import numpy as np
import pytest

from lce_analysis.comparison.metrics import nrmse
from lce_analysis.prediction import predict
from lce_data.channels import DISPLACEMENT
from lce_data.run import Run, Series
from lce_data.waveforms import SHAPES
from lce_model import Model, default_model, simulate

NOISE_K = (0.02, 0.06, 0.1, 0.2, 0.5)
SHORT = {
    "pulse": {"rest": (40.0,)},
    "cycles": {"count": (2.0,), "period": (30.0,), "rest": (30.0,)},
    "stairs": {"hold": (8.0,), "steps": (4.0,), "rest": (30.0,)},
}
GAIN = {"equilibrium": 30.0, "dynamic": 73.0, "kinetic": 50.0}


def recorded(model: Model, noise_k: float, shape: str) -> tuple[Run, int]:
    """A run of the model, its camera at 10 Hz with white noise, and how often the strip really turned."""
    power = SHAPES[shape].power_w(SHORT[shape])
    times = np.arange(power.size) * 0.01
    out = simulate(model, times, power)
    warm = out.temperature_k[::10] + noise_k * np.random.default_rng(1).standard_normal(times[::10].size)
    series = Series(times, power), Series(times[::10], warm), Series(times, out.displacement_m)
    return Run.of(shape, *series), turns(out.direction)


def turns(direction: np.ndarray) -> int:
    return int(np.count_nonzero(np.diff(direction)))


@pytest.mark.parametrize(("noise_k", "shape"), [*((n, "cycles") for n in NOISE_K), (0.5, "pulse"), (0.5, "stairs")])
def test_the_direction_turns_as_often_as_the_strip_did(noise_k: float, shape: str) -> None:
    model = default_model("lumped", "kinetic").set({"lumped.gain": 50.0})
    run, true = recorded(model, noise_k, shape)
    assert turns(predict(model, run, "measured").direction) == true
    bare = default_model("none", "kinetic")
    assert turns(predict(bare, run, "measured").direction) == true


@pytest.mark.parametrize("deformation", ["dynamic", "kinetic"])
def test_the_displacement_stays_right(deformation: str) -> None:
    """At 0.5 K rms, ten times the camera's noise, within 1 % of its spread."""
    model = default_model("lumped", deformation).set({"lumped.gain": GAIN[deformation]})
    run, _ = recorded(model, 0.5, "cycles")
    predicted = predict(model, run, "measured").at_samples[DISPLACEMENT]
    assert predicted is not None and run.displacement is not None
    assert nrmse(predicted, run.displacement.value) < 0.01


def test_the_raw_camera_would_flicker() -> None:
    """What is avoided: the same temperatures taken as they are turn hundreds of times."""
    run, true = recorded(default_model("lumped", "dynamic").set({"lumped.gain": 73.0}), 0.06, "cycles")
    assert run.power is not None and run.temperature is not None
    raw = np.interp(run.power.time_s, run.temperature.time_s, run.temperature.value)
    out = simulate(default_model("none", "dynamic"), run.power.time_s, None, temperature_k=raw)
    assert turns(out.direction) > 20 * true
