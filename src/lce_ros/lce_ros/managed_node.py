# SPDX-License-Identifier: Apache-2.0
"""The base of the nodes that hold a device: ROS 2's managed nodes, which others can take through their states."""

import traceback
from collections.abc import Callable
from functools import partial
from typing import Any

from lifecycle_msgs.srv import ChangeState
from rclpy.lifecycle import LifecycleNodeMixin, LifecycleState, TransitionCallbackReturn

from lce_data.errors import LceError
from lce_ros.health import Level
from lce_ros.node import LceNode, NodeFault

EXPECTED = (LceError, NodeFault, OSError, ValueError)
"""What a device that is missing or wrong raises; anything else is a defect."""


class ManagedNode(LifecycleNodeMixin, LceNode):
    """A node with the states unconfigured, inactive, active and finalized.

    ::

        unconfigured ── configure ──► inactive ── activate ────► active
                     ◄─── cleanup ──           ◄─ deactivate ──
        any ── shutdown ──► finalized

    A subclass says what the transitions do: ``open_device``, ``begin``, ``rest``, ``close_device``. If the first two
    raise one of EXPECTED, the transition fails, and the node stays as it was. Every other exception, and any in
    ``rest`` and ``close_device``, is an error: the device is closed, ``failed`` is called, the node is unconfigured.

    With the parameter ``autostart``, the default, a node configures and activates itself when it starts.

    Attributes
    ----------
    active : whether the node is active.
    autostart : whether it is so from its start.
    """

    def __init__(self, name: str, **options: Any) -> None:
        LceNode.__init__(self, name, **options)
        LifecycleNodeMixin.__init__(self)
        self._service_change_state.callback = partial(self._change_state, self._service_change_state.callback)
        self.active = False
        self._failure: Exception | None = None
        self._starting = False
        self.autostart: bool = self.declare(
            "autostart", True, "configure and activate when the node starts", read_only=True
        )

    def start(self) -> None:
        """Configure and activate if ``autostart`` says so; a subclass calls it when it is made.

        Raises what keeps the node from it.
        """
        self._starting = self.autostart
        self.report(Level.OK, "unconfigured")
        for transition in (self.trigger_configure, self.trigger_activate) if self.autostart else ():
            transition()
            if self._failure is not None:
                raise self._failure
        self._starting = False

    def open_device(self) -> None:
        """Open the device and check it; it stays in its safe state."""

    def begin(self) -> None:
        """Begin to work."""

    def rest(self) -> None:
        """Put the device into its safe state, and keep it open."""

    def close_device(self) -> None:
        """Put the device into its safe state and let go of it, if it is open."""

    def failed(self, reason: str) -> None:
        """An error ended the work; the device is closed."""

    def close(self) -> None:
        """Let go of the device, however the node ends."""
        self.active = False
        self.close_device()

    def destroy_node(self) -> None:
        """Let go of the node, and of its states: they would keep it alive, and its log on the old publisher."""
        super().destroy_node()
        self._state_machine.destroy_when_not_in_use()

    def _change_state(
        self, change: Callable[..., ChangeState.Response], request: ChangeState.Request, response: ChangeState.Response
    ) -> ChangeState.Response:
        """Refuse the number of a transition that the state does not have: rclpy would end the process."""
        available = {number for number, *_ in self._state_machine.available_transitions}
        if not request.transition.label and request.transition.id not in available:
            response.success = False
            return response
        return change(request, response)

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Open the device."""
        return self._step("configured", self.open_device, TransitionCallbackReturn.FAILURE)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Begin to work."""

        def begin() -> None:
            self.begin()
            self.active = True

        return self._step("active", begin, TransitionCallbackReturn.FAILURE)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Put the device into its safe state."""
        self.active = False
        return self._step("inactive", self.rest)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Let go of the device."""
        return self._step("unconfigured", self.close_device)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Let go of the device for good."""

        def finish() -> None:
            if self.active:
                self.active = False
                self.rest()
            self.close_device()

        return self._step("finalized", finish)

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Let go of the device; what it was is a fault."""
        reason = str(self._failure)
        self.active = False
        try:
            self.close_device()
        except OSError as error:
            reason = f"{reason}; {error}"
        self.report(Level.ERROR, reason)
        self.failed(reason)
        return TransitionCallbackReturn.SUCCESS

    def _step(
        self,
        reached: str,
        act: Callable[[], None],
        expected: TransitionCallbackReturn = TransitionCallbackReturn.ERROR,
    ) -> TransitionCallbackReturn:
        """Do what a transition does; ``expected`` is what one of EXPECTED makes of it."""
        self._failure = None
        try:
            act()
        except Exception as failure:  # noqa: BLE001  rclpy would drop it without a word
            self._failure = failure
            known = isinstance(failure, EXPECTED)
            self.report(Level.ERROR, f"not {reached}: {failure}")
            if not self._starting:  # whoever starts the node says it
                self.tell(Level.ERROR, f"not {reached}: {failure}")
                if not known:
                    self.get_logger().error(traceback.format_exc())
            return expected if known else TransitionCallbackReturn.ERROR
        if not self.active:  # an active node reports what it does
            self.report(Level.OK, reached)
        return TransitionCallbackReturn.SUCCESS
