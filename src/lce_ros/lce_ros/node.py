# SPDX-License-Identifier: Apache-2.0
"""The base of every node, and the one way in and out of a node's process."""

import gc
import re
import sys
from collections.abc import Callable, Sequence
from typing import Any, ClassVar, Final

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rclpy.signals import SignalHandlerOptions
from rclpy.subscription import Subscription
from rclpy.task import Future
from rclpy.timer import Timer
from rclpy.utilities import try_shutdown

from lce_data.errors import LceError, did_you_mean
from lce_data.topics import DIAGNOSTICS
from lce_ros.health import STARTED, Health, Level, node_of
from lce_ros.parameters import Rule
from lce_ros.parent import when_parent_ends
from lce_ros.qos import LATCHED, LATCHED_LISTENERS, STREAM
from lce_ros.repeats import Repeats
from lce_ros.signals import stop_signals

USE_SIM_TIME: Final = "use_sim_time"
QOS_OVERRIDES: Final = "qos_overrides"


class Stop(Future):
    """The future that ends a node.

    For every callback that it handles, rclpy's executor adds one to the future that it spins until. They all wake the
    executor, so one is kept: a node that runs for days would keep millions.
    """

    def __init__(self) -> None:
        super().__init__()
        self._wakes = False

    def add_done_callback(self, callback: Callable[[Future], None]) -> None:
        """Keep the first callback; call every one if the node has ended."""
        if self.done() or not self._wakes:
            self._wakes = True
            super().add_done_callback(callback)


class NodeFault(RuntimeError):
    """The node cannot go on: its process ends in order, with this one line and status 1."""


class CountingPublisher(Publisher):
    """A publisher that enters what it publishes in its node's ``published``."""

    counts: dict[str, int]
    counted_as: str

    def publish(self, msg: Any) -> None:
        """Count and publish."""
        self.counts[self.counted_as] += 1
        super().publish(msg)


class LceNode(Node):
    """A node with declared parameters, ticks on multiples of their period, and a diagnosis at 1 Hz.

    Attributes
    ----------
    published, received : messages by resolved topic name; a message counts as received when its callback is
        over. With ``ticks``, the timer callbacks that are over, a lockstep runner sees from them when
        everything is at rest.
    missed_ticks : ticks left out because the node was busy or the clock leapt; reported in /diagnostics.
    tick_s : nominal time [s] of the timer callback that runs: the multiple of its period that was due. Under
        load a callback comes late, its nominal time does not.
    sent_s : time [s] at which the message whose callback runs was published, by its publisher's clock. After a stall
        old messages wait in the queue: they are as old as this says. Simulated time stands still while a message is
        under way, there it is the present.
    sent_number : number of that message among those of its publisher, from 1; None if the middleware counts none.
    reports_on : what the node reports on in /diagnostics: its status is named "/lce/laser: output".
    """

    reports_on: ClassVar[str] = "state"

    def __init__(self, name: str, **options: Any) -> None:
        super().__init__(name, **options)
        self.published: dict[str, int] = {}
        self.received: dict[str, int] = {}
        self.ticks = self.missed_ticks = 0
        self.tick_s = self.sent_s = 0.0
        self.sent_number: int | None = None
        self._rules: dict[str, Rule] = {}
        self._health = Health(self.get_fully_qualified_name(), self.reports_on)
        self._told = (Level.OK, STARTED)
        self.add_on_set_parameters_callback(self._check)
        self._diagnostics = self.advertise(DiagnosticArray, DIAGNOSTICS)
        self.every(1.0, self._publish_health)

    @property
    def on_sim_time(self) -> bool:
        """Whether the node's clock is simulated time."""
        return bool(self.value(USE_SIM_TIME))

    def now_s(self) -> float:
        """Time [s] of the node's clock."""
        return float(self.get_clock().now().nanoseconds) * 1e-9

    def every(self, period_s: float, callback: Callable[[], None], offset_s: float = 0.0) -> Timer:
        """Call back on every multiple of ``period_s`` [s] of the node's clock, or ``offset_s`` [s] after it.

        A missed tick is left out, not made up. All nodes tick together, so a stream passes all of them within one
        tick, in real time as in lockstep.
        """
        period_ns, offset_ns = round(period_s * 1e9), round(offset_s * 1e9)
        last = 0

        def tick() -> None:
            nonlocal last
            number = (self.get_clock().now().nanoseconds - offset_ns) // period_ns
            self.missed_ticks += max(0, number - last - 1) if last else 0
            last = number
            self.tick_s = (number * period_ns + offset_ns) * 1e-9
            callback()
            self.ticks += 1

        first_ns = period_ns - (self.get_clock().now().nanoseconds - offset_ns) % period_ns
        # Half a nanosecond more, or rounding could put every tick just before its multiple.
        timer = self.create_timer((first_ns + 0.5) * 1e-9, tick)
        # The first call stays where it was put; the calls after it follow at the period set here.
        timer.timer_period_ns = period_ns
        return timer

    def listen(
        self, msg_type: Any, topic: str, callback: Callable[[Any], None], *, latched: bool = False
    ) -> Subscription:
        """Call back with each message of ``topic``.

        ``latched`` also brings the last message from before, if its publisher is latched. Publishers that are not are
        heard just as well. The subscription returned is one that matches both.
        """
        name = self.resolve_topic_name(topic)
        self.received.setdefault(name, 0)
        repeats = Repeats()

        def receive(message: Any, info: dict[str, Any]) -> None:
            if latched and repeats.has(info["source_timestamp"]):
                return
            self.sent_s = self.now_s() if self.on_sim_time else info["source_timestamp"] * 1e-9
            self.sent_number = info["publication_sequence_number"]
            callback(message)
            self.received[name] += 1

        if not latched:
            return self.create_subscription(msg_type, topic, receive, STREAM)
        # The first of the two warns of every publisher that is not latched, which the second one hears.
        quiet = SubscriptionEventCallbacks(use_default_callbacks=False)
        return [
            self.create_subscription(msg_type, topic, receive, qos, event_callbacks=quiet) for qos in LATCHED_LISTENERS
        ][-1]

    def listen_for_errors(self, name: str, callback: Callable[[str], None]) -> None:
        """Call back with each error that the node ``name`` of this namespace reports in /diagnostics."""
        full_name = f"{self.get_namespace().rstrip('/')}/{name}"

        def look(message: DiagnosticArray) -> None:
            for status in message.status:
                if node_of(status.name) == full_name and status.level == DiagnosticStatus.ERROR:
                    callback(status.message)

        self.listen(DiagnosticArray, DIAGNOSTICS, look)

    def advertise(self, msg_type: Any, topic: str, *, latched: bool = False) -> CountingPublisher:
        """A publisher on ``topic``."""
        publisher = self.create_publisher(
            msg_type, topic, LATCHED if latched else STREAM, publisher_class=CountingPublisher
        )
        publisher.counts, publisher.counted_as = self.published, publisher.topic_name
        self.published.setdefault(publisher.topic_name, 0)
        return publisher

    def declare(
        self,
        name: str,
        default: Any,
        description: str,
        *,
        unit: str = "",
        lower: float | None = None,
        upper: float | None = None,
        choices: Sequence[str] = (),
        read_only: bool = False,
        only_lower: bool = False,
    ) -> Any:
        """Declare a parameter and return its value; one that is ``only_lower`` can be lowered and never raised.

        Raises ValueError naming a value that is outside its range or choices. The same rule refuses a later ``ros2
        param set`` with the same words.
        """
        lower, upper = (None if bound is None else float(bound) for bound in (lower, upper))
        rule = Rule(name, unit, lower, upper, tuple(choices), only_lower)
        self._rules[name] = rule
        descriptor = ParameterDescriptor(
            description=f"{description} [{unit}]" if unit else description,
            additional_constraints=rule.constraints,
            read_only=read_only,
        )
        if lower is not None and upper is not None:
            if isinstance(default, float):
                descriptor.floating_point_range = [FloatingPointRange(from_value=lower, to_value=upper)]
            else:
                descriptor.integer_range = [IntegerRange(from_value=int(lower), to_value=int(upper))]
        try:
            return self.declare_parameter(name, default, descriptor).value
        except InvalidParameterTypeException as error:
            hint = " (write 2.0, not 2)" if isinstance(default, float) else ""
            raise ValueError(f"{self.get_name()}: {error}{hint}") from None
        except InvalidParameterValueException as error:
            reason = str(error).partition("Reason: ")[2].removesuffix(f": {name}")
            raise ValueError(f"{self.get_name()}: {reason}") from None

    def value(self, name: str) -> Any:
        """Present value of a declared parameter."""
        return self.get_parameter(name).value

    @property
    def hardware_id(self) -> str:
        """Which device the node speaks to, for /diagnostics; "none" without a device."""
        return self._health.hardware_id

    @hardware_id.setter
    def hardware_id(self, name: str) -> None:
        self._health.hardware_id = name

    def report(self, level: Level, message: str, **values: Any) -> None:
        """State the node's present condition and values; /diagnostics reports the worst of every second.

        The log gets a line: at once for a condition worse than the last one logged, else at the end of the second.
        """
        self._health.report(level, message, **values)
        if level > self._told[0]:
            self.tell(level, message)

    def tell(self, level: Level, message: str, *, again: bool = False) -> None:
        """Log a condition, unless it is the one that was logged last; other numbers make no other condition.

        With ``again`` it is logged in any case.
        """
        told, self._told = self._told, (level, re.sub(r"\d+", "", message))
        if told == self._told and not again:
            return
        if level is Level.ERROR:
            self.get_logger().error(message)
        elif level is Level.WARN:
            self.get_logger().warning(message)
        else:
            self.get_logger().info(message)

    def warn_of_unknown_parameters(self) -> None:
        """Log every parameter that was given at the start and that the node does not have: misspelt, it does nothing.

        Those of a device that the node could have are for when it is chosen.
        """
        declared = self.get_parameters_by_prefix("")
        elsewhere = {QOS_OVERRIDES, *(self._rules["device"].choices if "device" in self._rules else ())}
        for name in self._parameter_overrides:
            if name not in declared and name.partition(".")[0] not in elsewhere:
                hint = did_you_mean(name, declared)
                self.get_logger().warning(f"there is no parameter {name}: it is ignored{hint}")

    def close(self) -> None:
        """Put what the node drives into its safe state. ``run`` calls it however the node ends; to be overridden."""

    def _publish_health(self) -> None:
        self._health.values["missed_ticks"] = self.missed_ticks
        self._diagnostics.publish(self._health.message(self.tick_s))
        self.tell(*self._health.present)

    def _check(self, parameters: list[Parameter]) -> SetParametersResult:
        for parameter in parameters:
            if parameter.name == USE_SIM_TIME and parameter.value != self.on_sim_time:
                reason = f"{USE_SIM_TIME} is chosen when the node starts: its timers and its stamps would leap"
                return SetParametersResult(successful=False, reason=reason)
            rule = self._rules.get(parameter.name)
            now = self.value(parameter.name) if self.has_parameter(parameter.name) else None
            if rule is not None and (refusal := rule.refusal(parameter.value, now)) is not None:
                return SetParametersResult(successful=False, reason=refusal)
        return SetParametersResult(successful=True)


def run(factory: Callable[[], LceNode], args: Sequence[str] | None = None) -> int:
    """Make a node and spin it until something ends it; returns the exit status.

    That is a stop signal, the end of the parent process (lce_ros.parent), a shutdown of ROS or an exception. ``close``
    is called on every one of these ways out, with ROS still up so that it can publish a last word.
    A ValueError of the factory (a parameter outside its range, a model file that cannot be read), a NodeFault and an
    LceError at any time are one line on stderr and status 1; any other exception keeps its traceback. A stop signal
    during the factory waits for its end, except in what is `lce_ros.signals.interruptible`.
    """
    stop = Stop()

    def end() -> None:
        if not stop.done():
            stop.set_result(None)

    with stop_signals(end):
        try:
            with when_parent_ends(end):
                # rclpy's own handlers would take ROS down before close() could publish anything.
                rclpy.init(args=None if args is None else list(args), signal_handler_options=SignalHandlerOptions.NO)
                _spin(_made(factory), stop)
        except (NodeFault, LceError) as fault:
            print(fault, file=sys.stderr)
            return 1
        except KeyboardInterrupt:
            pass
        finally:
            try_shutdown()
    return 0


def _made(factory: Callable[[], LceNode]) -> LceNode:
    try:
        node = factory()
    except ValueError as error:
        raise NodeFault(error) from error
    node.warn_of_unknown_parameters()
    return node


def _spin(node: LceNode, stop: Stop) -> None:
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    # A full collection over what is loaded by now takes tens of ms: ticks would be late.
    gc.collect()
    gc.freeze()
    try:
        executor.spin_until_future_complete(stop)
    except ExternalShutdownException:
        pass
    finally:
        node.close()
        node.destroy_node()
