# SPDX-License-Identifier: Apache-2.0
"""A control loop whose constants are live parameters of a node."""

from collections.abc import Callable

from lce_control.cascade import Loop
from lce_control.filters import LowPass
from lce_control.pid import PID, Gains, Limits
from lce_ros.node import LceNode


def declare_loop(node: LceNode, gains: Gains, limits: Callable[[], Limits], unit: str, per: str) -> Loop:
    """A loop that follows the parameters of a node. New gains do not move its output.

    Declares kp, ki, kd, n, setpoint_weight, derivative_weight, filter_gain, filter_s and horizon_s.

    Parameters
    ----------
    node : declares the parameters.
    gains : their defaults.
    limits : reads the limits of the output from parameters that the node has declared before.
    unit, per : units of the output and of the input, as text.
    """

    def declare(name: str, default: float, description: str, of: str, upper: float, lower: float = 0.0) -> None:
        node.declare(name, default, description, unit=of, lower=lower, upper=upper)

    declare("kp", gains.kp, "proportional gain", f"{unit}/{per}", 1e6)
    declare("ki", gains.ki, "integral gain", f"{unit}/({per} s)", 1e6)
    declare("kd", gains.kd, "derivative gain", f"{unit} s/{per}", 1e6)
    declare("n", gains.n, "filter coefficient of the derivative", "1/s", 1e4, lower=0.01)
    declare("setpoint_weight", gains.setpoint_weight, "share of the setpoint that the proportional term sees", "", 1.0)
    declare("derivative_weight", gains.derivative_weight, "share of the setpoint that the derivative sees", "", 1.0)
    declare("filter_gain", 1.0, "K_f of the filter of the measured value", "", 10.0, lower=0.1)
    declare("filter_s", 0.1, "T_f of the filter of the measured value", "s", 10.0)
    declare("horizon_s", 0.2, "how long a sample is extrapolated along its slope; 0: it is held", "s", 1.0)
    loop = Loop(PID(gains, limits()), LowPass())

    def follow() -> None:
        pid, feedback = loop.pid, loop.feedback
        names = ("kp", "ki", "kd", "n", "setpoint_weight", "derivative_weight")
        pid.gains = Gains(*(node.value(name) for name in names))
        pid.limits, pid.horizon_s = limits(), node.value("horizon_s")
        feedback.time_constant_s, feedback.gain = node.value("filter_s"), node.value("filter_gain")

    follow()
    node.add_post_set_parameters_callback(lambda _: follow())
    return loop


def gains_text(loop: Loop, unit: str, per: str) -> str:
    """The gains of a loop with their units, for the log."""
    gains = loop.pid.gains
    return f"kp {gains.kp:g} {unit}/{per}, ki {gains.ki:g} {unit}/({per} s), kd {gains.kd:g} {unit} s/{per}"
