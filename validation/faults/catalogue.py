# SPDX-License-Identifier: Apache-2.0
"""The faults: what is done to the bench, and by when there has to be no light."""

import functools
import signal
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Literal

from bench import Bench
from sensor_msgs.msg import Temperature
from std_msgs.msg import Float64

from lce_ros.conversions import to_stamp
from lce_ros.node import LceNode

Where = Literal["loop", "by hand"]
PROCESS_S: Final = 0.2
"""Of a process or a sensor."""
WATCHDOG_S: Final = 2.1
"""Where only the device's own watchdog is left."""
READBACK_S: Final = 1.2
"""The device is read back each second."""
FROZEN_S: Final = 1.2
"""As long as a reading must stand still to be no reading."""


@dataclass(frozen=True)
class Fault:
    """A fault and its cure.

    name : what happens, as the table says it.
    where : "loop": all nodes are processes and follow a target; "by hand": the camera and the commander are ours.
    limit_s : by then it has to be dark [s].
    strike : what is done; what it returns is called when darkness has been seen, so that the cause goes away.
    """

    name: str
    where: Where
    limit_s: float
    strike: Callable[[Bench], Callable[[], object] | None]


def _killed(name: str) -> Callable[[Bench], None]:
    return lambda bench: bench.signal(name, signal.SIGKILL)


def _ended(name: str) -> Callable[[Bench], None]:
    return lambda bench: bench.signal(name, signal.SIGINT)


def _stopped(name: str) -> Callable[[Bench], Callable[[], object]]:
    def strike(bench: Bench) -> Callable[[], object]:
        bench.signal(name, signal.SIGSTOP)
        return functools.partial(bench.signal, name, signal.SIGCONT)

    return strike


def _camera(show: Callable[[Bench], Callable[[], None] | None]) -> Callable[[Bench], None]:
    def strike(bench: Bench) -> None:
        bench.show = show(bench)
        if bench.show is not None:
            bench.show()

    return strike


def _commander(command: Callable[[Bench], Callable[[], None] | None]) -> Callable[[Bench], None]:
    def strike(bench: Bench) -> None:
        bench.command = command(bench)

    return strike


def _frozen(bench: Bench) -> Callable[[], None]:
    return lambda: bench.measured(40.0)


def _rival_camera(bench: Bench) -> Callable[[], object]:
    rival: LceNode = bench.graph.probe("second_camera")
    publisher = rival.advertise(Temperature, "temperature")

    def show() -> None:
        message = Temperature(temperature=40.0 + float(bench.rng.standard_normal()))
        message.header.stamp = to_stamp(rival.now_s())
        publisher.publish(message)

    bench.graph.until(lambda: publisher.get_subscription_count() > 0, what="a laser that listens")
    rival.every(0.1, show)
    show()
    return functools.partial(_leave, bench, rival)


def _rival_commander(bench: Bench) -> Callable[[], object]:
    rival: LceNode = bench.graph.probe("second_commander")
    publisher = rival.advertise(Float64, "laser/power_command")
    bench.graph.until(lambda: publisher.get_subscription_count() > 0, what="a laser that listens")
    rival.every(0.01, lambda: publisher.publish(Float64(data=2.0)))
    return functools.partial(_leave, bench, rival)


def _leave(bench: Bench, node: LceNode) -> None:
    bench.graph.executor.remove_node(node)
    bench.graph.nodes.remove(node)
    node.destroy_node()


def _reset_connection(bench: Bench) -> None:
    bench.device.resets = 1


def _mute(bench: Bench) -> None:
    bench.device.mute = True


def _foreign_output(bench: Bench) -> None:
    bench.device.stuck[1000] = 0


FAULTS: Final = (
    Fault("`kill -9` of the thermal camera", "loop", PROCESS_S, _killed("thermal_camera")),
    Fault("`kill -9` of the distance sensor, in closed loop", "loop", PROCESS_S, _killed("distance_sensor")),
    Fault("`kill -9` of the inner controller", "loop", PROCESS_S, _killed("inner_controller")),
    Fault("`kill -9` of the outer controller", "loop", PROCESS_S, _killed("outer_controller")),
    Fault("Ctrl-C for the inner controller", "loop", PROCESS_S, _ended("inner_controller")),
    Fault("Ctrl-C for the laser", "loop", PROCESS_S, _ended("laser")),
    Fault("`kill -9` of the laser", "loop", WATCHDOG_S, _killed("laser")),
    Fault("the thermal camera stopped, then continued", "loop", PROCESS_S, _stopped("thermal_camera")),
    Fault("the distance sensor stopped, then continued", "loop", PROCESS_S, _stopped("distance_sensor")),
    Fault("the inner controller stopped, then continued", "loop", PROCESS_S, _stopped("inner_controller")),
    Fault("the laser stopped, then continued", "loop", WATCHDOG_S, _stopped("laser")),
    Fault("a camera that falls silent", "by hand", PROCESS_S + 0.1, _camera(lambda bench: None)),
    Fault("a camera that is frozen", "by hand", FROZEN_S, _camera(_frozen)),
    Fault("a camera that says -300 °C", "by hand", PROCESS_S, _camera(lambda b: lambda: b.measured(-300.0))),
    Fault("a camera that says 130 °C", "by hand", PROCESS_S, _camera(lambda b: lambda: b.measured(130.0))),
    Fault("a camera that says NaN", "by hand", PROCESS_S, _camera(lambda b: lambda: b.measured(float("nan")))),
    Fault("stamps 0.1 s in the future", "by hand", PROCESS_S + 0.1, _camera(lambda b: lambda: b.measured(None, 0.1))),
    Fault("a second camera", "by hand", PROCESS_S, _rival_camera),
    Fault("a second commander, of 2 W", "by hand", PROCESS_S, _rival_commander),
    Fault("a commander that falls silent", "by hand", PROCESS_S, _commander(lambda bench: None)),
    Fault("a command of NaN", "by hand", PROCESS_S, _commander(lambda b: lambda: b.commanded(float("nan")))),
    Fault("the connection to the LabJack is reset", "by hand", PROCESS_S, _reset_connection),
    Fault("a LabJack that answers no more", "by hand", WATCHDOG_S, _mute),
    Fault("a LabJack whose output reads otherwise", "by hand", READBACK_S, _foreign_output),
)
