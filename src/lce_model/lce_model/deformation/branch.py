# SPDX-License-Identifier: Apache-2.0
"""Which branch the strip is on, and how far its temperature path has advanced along it.

The models of Wu (2021) are functions of the temperature and of its direction. A measured temperature is noisy, so a
reversal counts only once it exceeds ``deadband``; with ``deadband = 0`` (a simulated temperature) every change of sign
counts.
"""

from lce_model.terms import Term


def start(order_temperature: float) -> tuple[float, float, float, float]:
    """At rest before the first heating."""
    return order_temperature, 1.0, order_temperature, order_temperature


def step(
    order_temperature: float, deadband: float, extreme: float, direction: float
) -> tuple[float, float, float, float]:
    """Advance the running extreme of the branch, or turn when the path has come back by more than ``deadband``."""
    ahead = (order_temperature - extreme) * direction
    if ahead >= 0.0:
        return order_temperature, direction, extreme, order_temperature
    if -ahead > deadband:
        return order_temperature, -direction, extreme, order_temperature
    return extreme, direction, extreme, extreme


BRANCH = Term(
    name="branch",
    stage="order",
    equation="direction = sign(dT), held where dT = 0",
    parameters=(),
    states=("extreme",),
    outputs=("direction", "path_from", "path_to"),
    start=start,
    step=step,
)
