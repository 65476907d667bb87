# SPDX-License-Identifier: Apache-2.0
"""What happens at a time is found with its time; the recordings are made by scipy."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from lce_analysis.diagnosis import diagnose
from lce_analysis.diagnosis.score import directions
from lce_analysis.identification import fit
from lce_data.run import Run, Series
from lce_model import default_model
from lce_model.effects import find

HOUR_S, NOISE_K, WHEN_S = 3600.0, 0.05, 1332.0


def body(light: float = 1.0, loss: float = 1.0) -> Run:
    """An hour of a body of 150 s, of which at 22 min 12 s the light or the loss becomes so many times as large."""
    time = np.arange(0.0, HOUR_S, 4.0)
    power = np.where((time // 600.0) % 2 == 0, 0.8, 0.15)

    def slope(t: float, y: np.ndarray) -> np.ndarray:
        given = 0.8 if (t // 600.0) % 2 == 0 else 0.15
        factors = (light, loss) if t > WHEN_S else (1.0, 1.0)
        return np.asarray((60.0 * factors[0] * given - factors[1] * (y - 296.0)) / 150.0)

    found = solve_ivp(slope, (0.0, HOUR_S), [296.0], t_eval=time, max_step=4.0, rtol=1e-8).y[0]
    noise = NOISE_K * np.random.default_rng(2).standard_normal(time.size)
    return Run.of("hour", Series(time, power), Series(time, found + noise), sha256=f"{light}{loss}")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "change", "run"), [("loss_step", 1.4, body(loss=2.4)), ("light_step", -0.2, body(light=0.8))]
)
def test_a_step_is_found_with_its_time(name: str, change: float, run: Run) -> None:
    found = diagnose(fit(default_model("lumped", "none"), [run]).model, [run])
    assert name in found.model.effects
    assert found.model[f"{name}.change"] == pytest.approx(change, abs=0.02)
    assert found.model[f"{name}.time"] == pytest.approx(WHEN_S, abs=4.0)


def test_times_are_tried_out_as_shares_of_the_recording() -> None:
    loss = find("loss_step")
    times = [d.settings["loss_step.time"] for d in directions(loss, 200.0)]
    assert times == pytest.approx([20.0 * i for i in range(1, 10)])
    assert [d.settings for d in directions(find("creep"), 200.0)] == [
        d.settings for d in directions(find("creep"), 7.0)
    ]
