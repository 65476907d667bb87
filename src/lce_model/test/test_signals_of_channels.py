# SPDX-License-Identifier: Apache-2.0
"""What sensors report goes by channel: a new sensor is a row of lce_data.channels and one term."""

import subprocess
import sys
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from lce_data.channels import DISPLACEMENT, POWER, SENSORS, TEMPERATURE
from lce_data.errors import LceError
from lce_model import Stepper, default_model, simulate
from lce_model.effects import library
from lce_model.kernel.generate import RECORDED
from lce_model.library import DEFORMATION, THERMAL
from lce_model.terms import SIGNALS

TIME = np.arange(0.0, 20.0, 0.01)
POWER_W = np.where(TIME < 10.0, 1.0, 0.0)
PAIRS = [pair for pair in product(THERMAL, DEFORMATION) if set(pair) != {"none"}]

FORCE_GAUGE = """
from lce_model.effects import Effect
from lce_model.terms import Parameter


def step(displacement, stiffness):
    return stiffness * displacement


EFFECT = Effect(
    name="force_gauge",
    stage="sensor",
    equation="F = k d",
    parameters=(Parameter("stiffness", "N/m", 0.0, 0.0, 1e3, "stiffness k of the gauge", "a test"),),
    outputs=("measured_force",),
    step=step,
    strength="stiffness",
    typical=20.0,
)
"""

PROGRAM = """
import dataclasses, sys
import numpy as np
from lce_data import channels

FORCE = dataclasses.replace(
    channels.DISPLACEMENT, name="force", unit="N", recorded=channels.Unit("N"), topic="force", output="measured_force"
)
channels.CHANNELS = (*channels.CHANNELS, FORCE)
channels.SENSORS = (*channels.SENSORS, FORCE)

from lce_model import Stepper, default_model, simulate

time_s = np.arange(0.0, 20.0, 0.01)
power_w = np.where(time_s < 10.0, 1.0, 0.0)
bare = default_model()
assert not bare.predicts(FORCE)
assert np.isnan(simulate(bare, time_s, power_w)[FORCE]).all()

gauge = bare.add(sys.argv[1])
assert gauge.predicts(FORCE)
assert (simulate(gauge, time_s, power_w)[FORCE] == 0.0).all()

model = gauge.set({"force_gauge.stiffness": 20.0})
run = simulate(model, time_s, power_w)
np.testing.assert_allclose(run[FORCE], 20.0 * run.displacement_m, rtol=1e-15)
assert np.ptp(run[FORCE]) > 0.0
strip = Stepper(model)
for i in range(1, 100):
    strip.step(power_w[i - 1], time_s[i] - time_s[i - 1])
assert strip.measured(FORCE) == run[FORCE][99]
"""


def test_every_sensor_has_its_signal_and_its_column() -> None:
    outputs = [channel.output for channel in SENSORS]
    assert list(SIGNALS)[-len(outputs) :] == outputs
    assert list(RECORDED)[-len(outputs) :] == outputs


@pytest.mark.slow
def test_a_run_and_a_strip_in_motion_go_by_channel() -> None:
    model = default_model().configured({"camera_lag.tau": 0.3, "displacement_drift.rate": 1e-6})
    run, strip = simulate(model, TIME, POWER_W), Stepper(model)
    for i in range(1, TIME.size):
        strip.step(float(POWER_W[i - 1]), float(TIME[i] - TIME[i - 1]))
    np.testing.assert_array_equal(run[TEMPERATURE], run.measured_temperature_k)
    np.testing.assert_array_equal(run[DISPLACEMENT], run.measured_displacement_m)
    assert strip.measured(TEMPERATURE) == strip.measured_temperature_k == run[TEMPERATURE][-1]
    assert strip.measured(DISPLACEMENT) == strip.measured_displacement_m == run[DISPLACEMENT][-1]


def test_the_power_is_an_input() -> None:
    with pytest.raises(LceError, match="power is an input of the model"):
        simulate(default_model(), TIME, POWER_W)[POWER]


@pytest.mark.parametrize("effects", [(), tuple(library())], ids=["bare", "every effect"])
@pytest.mark.parametrize(("thermal", "deformation"), PAIRS)
def test_a_model_predicts_the_channels_of_its_stages_whatever_its_effects(
    thermal: str, deformation: str, effects: tuple[str, ...]
) -> None:
    model = default_model(thermal, deformation, effects)
    assert model.predicts(TEMPERATURE) == (thermal != "none")
    assert model.predicts(DISPLACEMENT) == (deformation != "none")
    assert not model.predicts(POWER)


@pytest.mark.slow
@pytest.mark.timeout(120)  # a process that compiles three kernels
def test_a_made_up_force_gauge_needs_a_channel_and_a_term(tmp_path: Path) -> None:
    file = tmp_path / "force_gauge.py"
    file.write_text(FORCE_GAUGE, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, str(file)], capture_output=True, text=True, check=False, timeout=100
    )
    assert done.returncode == 0, done.stderr
