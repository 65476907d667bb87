# SPDX-License-Identifier: Apache-2.0
"""Node `feedforward`: which temperature gives a wanted displacement (§6.4).

Serves      inverse_temperature  lce_interfaces/srv/InverseTemperature, m → °C
Parameters  model_file           path of a model file; empty: the default model
            branch               middle | heating | cooling, the branch of the chart that answers; live

A displacement out of reach is refused with the reachable range and a temperature of NaN, never clipped.
"""

import math
import sys
from typing import Any

from lce_interfaces.srv import InverseTemperature
from lce_model import LceError, default_model, load_model
from lce_model.inverse import BRANCHES, InverseChart
from lce_ros.conversions import to_celsius
from lce_ros.health import Level
from lce_ros.node import BenchNode, run


class Feedforward(BenchNode):
    """Answers from the chart of one model."""

    def __init__(self, **options: Any) -> None:
        super().__init__("feedforward", **options)
        model_file = self.declare("model_file", "", "model file, empty: the default model", read_only=True)
        self.declare("branch", "middle", "branch of the chart that answers", choices=BRANCHES)
        self._chart = InverseChart(load_model(model_file) if model_file else default_model())
        self._answered = self._refused = 0
        self.create_service(InverseTemperature, "inverse_temperature", self._answer)
        self._tell()
        self.every(1.0, self._tell)

    def _answer(
        self, request: InverseTemperature.Request, response: InverseTemperature.Response
    ) -> InverseTemperature.Response:
        branch = self.value("branch")
        try:
            response.temperature = to_celsius(self._chart.temperature_k(request.displacement, branch))
        except LceError as error:
            response.success, response.message, response.temperature = False, str(error), math.nan
            self._refused += 1
        else:
            response.success, response.message = True, f"{branch} branch"
            self._answered += 1
        return response

    def _tell(self) -> None:
        lower_m, upper_m = self._chart.reach_m(self.value("branch"))
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
