# SPDX-License-Identifier: Apache-2.0
"""Node `model_controller`: laser power from the identified model of the strip, see ModelController.

Subscribes  target_displacement   std_msgs/Float64, m, latched; a step, or a stream that is a trajectory
            displacement          std_msgs/Float64, m
            temperature           sensor_msgs/Temperature, °C; header.stamp is the time of measurement
            laser/power           std_msgs/Float64, W as applied: input of the model of the strip
            laser/armed           std_msgs/Bool, latched
Publishes   laser/power_command   std_msgs/Float64, W, 100 Hz
Parameters  model_file            path of a model file; empty: the default model
            max_power_w           W, limit of the command
            max_temperature_c     °C, limit of the temperature of the strip
            horizon_s             s, how long a power is planned to be held: longer is calmer
            bias_s                s, time constant of the bias between the displacement and the model
            camera_noise_k        K, standard deviation of the camera's noise
            displacement_timeout_s s, a displacement older than this is ignored
            displacement_fault_s  s, a silence of the displacement that is a fault
            frozen_after_s        s, a displacement that repeats itself bit for bit for so long is a fault; 0: never
            temperature_timeout_s s, a temperature older than this is ignored

The node publishes a command at once after each displacement, and at 100 Hz without any. It refuses a target out of
reach, with the reachable range in the log and in /diagnostics, and keeps the one before. The command is zero without a
target, a fresh displacement or a fresh temperature, while the laser is not armed, and when the node ends. A
displacement that is silent or frozen while a target is followed is a fault: zero until the laser is disarmed.
"""

import math
import sys
from typing import Any

from sensor_msgs.msg import Temperature
from std_msgs.msg import Float64

from lce_control.filters import Sample
from lce_control.model_control import ModelController as Controller
from lce_control.nodes.controller_node import PERIOD_S, PowerControllerNode
from lce_control.nodes.displacement_node import DisplacementInput
from lce_control.nodes.target_node import TOLD_S
from lce_data.channels import POWER, TEMPERATURE
from lce_data.errors import LceError
from lce_data.topics import TARGET
from lce_model import default_model, load_model
from lce_model.inverse import HOTTEST_K, InverseChart
from lce_ros.conversions import from_stamp, to_celsius, to_kelvin
from lce_ros.health import Level
from lce_ros.node import run
from lce_ros.signals import interruptible


class ModelController(PowerControllerNode):
    """One model from displacement [m] and temperature [K] to power [W]."""

    reports_on = "power"

    def __init__(self, **options: Any) -> None:
        super().__init__("model_controller", **options)
        model_file = self.declare("model_file", "", "model file, empty: the default model", read_only=True)
        self.declare("max_power_w", 2.0, "limit of the command", unit="W", lower=0.0, upper=10.0)
        hottest_c = self.declare("max_temperature_c", 110.0, "limit of the temperature of the strip", unit="°C",
                                 lower=30.0, upper=250.0, read_only=True)  # fmt: skip
        settings = {
            "horizon_s": self.declare("horizon_s", 0.3, "how long a power is planned to be held", unit="s",
                                      lower=0.02, upper=2.0, read_only=True),
            "bias_s": self.declare("bias_s", 0.05, "time constant of the bias of the displacement", unit="s",
                                   lower=0.02, upper=10.0, read_only=True),
            "camera_noise_k": self.declare("camera_noise_k", TEMPERATURE.noise,
                                           "standard deviation of the camera's noise", unit="K",
                                           lower=0.001, upper=5.0, read_only=True),
        }  # fmt: skip
        self.declare_temperature_timeout()
        model, hottest_k = load_model(model_file) if model_file else default_model(), to_kelvin(hottest_c)
        with interruptible():  # the first time, the kernel of the model is compiled
            self._chart = InverseChart(model, hottest_k=min(hottest_k, HOTTEST_K))
            # A command is applied at the laser's next tick.
            self._controller = Controller(model, hottest_k=hottest_k, delay_s=PERIOD_S, **settings)
        self._target_m = math.nan
        self._refusal: str | None = None
        self._observed: Sample | None = None
        self._temperature: Sample | None = None
        self._applied_w = self._before_w = 0.0
        self.listen(Float64, TARGET, self._take_target, latched=True)
        self.listen(Float64, POWER.topic, self._take_power)
        self.listen(Temperature, TEMPERATURE.topic, self._take_temperature)
        self._displacement = DisplacementInput(self)
        lower_m, upper_m = self._chart.reach_m()
        self.introduce(
            f"at most {self.value('max_power_w'):g} W and {hottest_c:g} °C; {model_file or 'the default model'} "
            f"reaches {lower_m * 1e3:.3f} to {upper_m * 1e3:.3f} mm"
        )

    def step(self, now_s: float) -> None:
        """Command the power for now."""
        newest = self._displacement.newest
        self._controller.observe(
            now_s, newest if newest is not self._observed else None, self._temperature, self._before_w
        )
        self._observed, self._before_w = newest, self._applied_w
        displacement = self._displacement.at(now_s, not math.isnan(self._target_m))
        temperature, power_w = self._temperature, 0.0
        if not self.laser_armed:
            self.report(Level.OK, "the laser is not armed: zero power", power_w=0.0)
        elif displacement is None:
            self._rest(self._displacement.missing)
        elif not self.is_fresh(temperature, now_s, "temperature_timeout_s"):
            self._rest("no fresh temperature")
        elif math.isnan(self._target_m):
            self.report(Level.OK, "no target: zero power")
        else:
            power_w = self._follow(displacement)
        if self._refusal is not None and displacement is not None:
            self.report(Level.ERROR, self._refusal)
        self.command(power_w)

    def _follow(self, displacement: Sample) -> float:
        self._controller.max_power_w = self.value("max_power_w")
        power_w = self._controller.power_w(self._target_m, self._applied_w)
        assert self._controller.observer is not None  # a temperature has come
        strip = self._controller.observer.strip
        self.report(
            Level.OK,
            "controlling",
            target_mm=self._target_m * 1e3,
            displacement_mm=displacement.value * 1e3,
            temperature_c=to_celsius(strip.temperature_k),
            gain=strip.gain,
            drift_k_s=strip.drift_k_s,
            bias_um=strip.bias_m * 1e6,
            power_w=power_w,
        )
        return power_w

    def _rest(self, why: str) -> None:
        self.report(Level.OK if math.isnan(self._target_m) else Level.ERROR, f"{why}: zero power", power_w=0.0)

    def _take_target(self, message: Float64) -> None:
        try:
            self._chart.temperature_k(message.data)
        except LceError as error:
            there = not math.isnan(self._target_m)
            stays = f"{self._target_m * 1e3:.3f} mm stays the target" if there else "there is no target"
            self._refusal = f"target refused: {error}; {stays}"
            self.tell(Level.ERROR, self._refusal, again=True)
            self.report(Level.ERROR, self._refusal)
        else:
            self._target_m, self._refusal = message.data, None
            self.get_logger().info(f"target {message.data * 1e3:.3f} mm", throttle_duration_sec=TOLD_S)

    def _take_power(self, message: Float64) -> None:
        if math.isfinite(message.data):
            self._applied_w = message.data

    def _take_temperature(self, message: Temperature) -> None:
        if math.isfinite(message.temperature):
            self._temperature = Sample(to_kelvin(message.temperature), from_stamp(message.header.stamp))


def main(args: list[str] | None = None) -> int:
    """Entry point of the executable; the exit status."""
    return run(ModelController, args)


if __name__ == "__main__":
    sys.exit(main())
