# SPDX-License-Identifier: Apache-2.0
"""Node `inner_controller`: laser power that brings the strip to a temperature, the inner loop of Fig. 6.2.

Subscribes  temperature_setpoint  sensor_msgs/Temperature, °C; NaN: there is none
            temperature           sensor_msgs/Temperature, °C; header.stamp is the time of measurement
Publishes   laser/power_command   std_msgs/Float64, W, 100 Hz
Parameters  kp, ki, kd            W/K, W/(K s), W s/K: (6.11) unless set
            n, setpoint_weight, derivative_weight, filter_gain, filter_s, horizon_s   see PID and LowPass
            max_power_w           W, most that is commanded
            setpoint_timeout_s    s, a setpoint older than this counts as none
            temperature_timeout_s s, a measurement older than this counts as none

All but the topics can be set while it runs. It commands zero power without a fresh setpoint or temperature, starts anew
when both are back, and leaves a zero behind when it ends.
"""

import math
import sys
from typing import Any, Final

from sensor_msgs.msg import Temperature
from std_msgs.msg import Float64

from lce_control.filters import Sample
from lce_control.loop_parameters import declare_loop
from lce_control.pid import Gains, Limits
from lce_ros.conversions import from_stamp, to_celsius, to_kelvin
from lce_ros.health import Level
from lce_ros.held import Held
from lce_ros.node import BenchNode, run

PERIOD_S: Final = 0.01
TUNED: Final = Gains(kp=0.05, ki=0.01, kd=0.001)
"""(6.11)"""


class InnerController(BenchNode):
    """One loop from temperature [K] to power [W]."""

    def __init__(self, **options: Any) -> None:
        super().__init__("inner_controller", **options)
        self.declare("max_power_w", 2.0, "most that is commanded", unit="W", lower=0.0, upper=10.0)
        self.declare("setpoint_timeout_s", 0.1, "age of a setpoint that is none", unit="s", lower=0.02, upper=1.0)
        self.declare("temperature_timeout_s", 0.2, "age of a measurement that is none", unit="s", lower=0.1, upper=5.0)
        self._loop = declare_loop(self, TUNED, lambda: Limits(0.0, self.value("max_power_w")), "W", "K")
        self._setpoint_k: Held[float] = Held()
        self._temperature: Held[Sample] = Held()
        self._command = self.advertise(Float64, "laser/power_command")
        self.listen(Temperature, "temperature_setpoint", self._hear_setpoint)
        self.listen(Temperature, "temperature", self._hear_temperature)
        self.every(PERIOD_S, self._tick)

    def close(self) -> None:
        """Leave the laser with a zero."""
        if self.context.ok():
            self._command.publish(Float64(data=0.0))

    def _tick(self) -> None:
        setpoint_k, shot = self._setpoint_k.get(self.tick_s), self._temperature.get(self.tick_s)
        obstacle = self._obstacle(setpoint_k, shot)
        power_w = 0.0
        if obstacle is not None or setpoint_k is None or shot is None:
            self._loop.reset()
            self.report(*(obstacle or (Level.OK, "no setpoint: zero power")), power_w=0.0)
        else:
            power_w = self._loop.step(self.tick_s, setpoint_k, shot)
            self.report(
                Level.OK,
                "controlling",
                setpoint_c=to_celsius(setpoint_k),
                temperature_c=to_celsius(shot.value),
                power_w=power_w,
            )
        self._command.publish(Float64(data=power_w))

    def _obstacle(self, setpoint_k: float | None, shot: Sample | None) -> tuple[Level, str] | None:
        if setpoint_k is None or not math.isfinite(setpoint_k):
            return Level.OK, "no setpoint: zero power"
        if self._setpoint_k.age(self.now_s()) > self.value("setpoint_timeout_s"):
            return Level.WARN, "the setpoint is stale: zero power"
        if shot is None:
            return Level.ERROR, "no temperature: zero power"
        if self.now_s() - shot.t_s > self.value("temperature_timeout_s"):
            return Level.ERROR, "the temperature is stale: zero power"
        return None

    def _hear_setpoint(self, message: Temperature) -> None:
        self._setpoint_k.put(to_kelvin(message.temperature), self.now_s())

    def _hear_temperature(self, message: Temperature) -> None:
        if math.isfinite(message.temperature):
            shot = Sample(to_kelvin(message.temperature), from_stamp(message.header.stamp))
            self._temperature.put(shot, self.now_s())


def main(args: list[str] | None = None) -> int:
    """Entry point of the executable; the exit status."""
    return run(InnerController, args)


if __name__ == "__main__":
    sys.exit(main())
