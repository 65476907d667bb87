# SPDX-License-Identifier: Apache-2.0
"""Node `feedforward`: the temperature at which the strip has a wanted displacement (§6.4).

Serves      inverse_temperature  lce_interfaces/srv/InverseTemperature, m → °C
Subscribes  temperature          sensor_msgs/Temperature, °C: history of the strip, for the branch `actual`
Parameters  model_file           path of a model file; empty: the default model
            branch               middle | heating | cooling: of the chart of the major loop (§6.4: middle);
                                 actual: from the state that the temperatures so far have led to; live
            deadband_k           K, reversals of the temperature smaller than this are taken for noise; live

A displacement out of reach is refused with the reachable range and a temperature of NaN, never clipped.
"""

import math
import sys
from collections import deque
from typing import Any, Final

from sensor_msgs.msg import Temperature

from lce_data.channels import TEMPERATURE
from lce_data.errors import LceError
from lce_interfaces.srv import InverseTemperature
from lce_model import default_model, load_model
from lce_model.inverse import BRANCHES, InverseChart, temperature_from_here_k
from lce_ros.conversions import from_stamp, to_celsius, to_kelvin
from lce_ros.health import Level
from lce_ros.node import LceNode, run
from lce_ros.signals import interruptible

ACTUAL: Final = "actual"
HISTORY: Final = 36_000
"""Temperatures that are kept: an hour at 10 Hz."""


class Feedforward(LceNode):
    """Answers from the chart of a model's major loop, or from the present state of the strip."""

    reports_on = "inverse temperature"

    def __init__(self, **options: Any) -> None:
        super().__init__("feedforward", **options)
        model_file = self.declare("model_file", "", "model file, empty: the default model", read_only=True)
        self.declare("branch", "middle", "branch that gives the temperature", choices=(*BRANCHES, ACTUAL))
        self.declare("deadband_k", 0.3, "smaller reversals are noise", unit="K", lower=0.0, upper=10.0)
        self._model = load_model(model_file) if model_file else default_model()
        with interruptible():  # the first time, the kernel of the model is compiled
            self._chart = InverseChart(self._model)
        self._past: deque[tuple[float, float]] = deque(maxlen=HISTORY)
        self._answered = self._refused = 0
        self.listen(Temperature, TEMPERATURE.topic, self._remember)
        self.create_service(InverseTemperature, "inverse_temperature", self._answer)
        self._report_state()
        lower_m, upper_m = self._reach_m()
        self.get_logger().info(
            f"{model_file or 'the default model'} reaches {lower_m * 1e3:.3f} to {upper_m * 1e3:.3f} mm; "
            f"branch {self.value('branch')}"
        )
        self.every(1.0, self._report_state)

    def _answer(
        self, request: InverseTemperature.Request, response: InverseTemperature.Response
    ) -> InverseTemperature.Response:
        branch = self.value("branch")
        try:
            response.temperature = to_celsius(self._temperature_k(request.displacement, branch))
        except LceError as error:
            response.success, response.message, response.temperature = False, str(error), math.nan
            self._refused += 1
        else:
            response.success, response.message = True, f"{branch} branch"
            self._answered += 1
        return response

    def _temperature_k(self, displacement_m: float, branch: Any) -> float:
        if branch != ACTUAL:
            return self._chart.temperature_k(displacement_m, branch)
        times, temperatures = zip(*self._past, strict=True) if self._past else ((), ())
        return temperature_from_here_k(self._model, times, temperatures, displacement_m, self.value("deadband_k"))

    def _remember(self, message: Temperature) -> None:
        t_s = from_stamp(message.header.stamp)
        if self._past and t_s <= self._past[-1][0]:
            self._past.clear()  # the clock was set back, a simulation began again
        if math.isfinite(message.temperature):
            self._past.append((t_s, to_kelvin(message.temperature)))

    def _reach_m(self) -> tuple[float, float]:
        branch = self.value("branch")
        return self._chart.reach_m("middle" if branch == ACTUAL else branch)

    def _report_state(self) -> None:
        lower_m, upper_m = self._reach_m()
        self.report(
            Level.OK,
            "ready",
            reach_mm=f"{lower_m * 1e3:.3f} to {upper_m * 1e3:.3f}",
            answered=self._answered,
            refused=self._refused,
        )


def main(args: list[str] | None = None) -> int:
    """Entry point of the executable; the exit status."""
    return run(Feedforward, args)


if __name__ == "__main__":
    sys.exit(main())
