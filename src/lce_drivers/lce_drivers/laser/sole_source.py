# SPDX-License-Identifier: Apache-2.0
"""Whether a topic that the laser obeys has one publisher."""

from typing import Final

HOLD_S: Final = 1.0
"""A publisher that was silent for so long [s] has let go of the topic; another one may take it over."""


class SoleSource:
    """Notices a second publisher of a topic by its first messages.

    rclpy does not say who sent a message, but every publisher numbers its own: 1, 2, 3, … A number that does not rise
    less than HOLD_S after the message before it is of somebody else. What counts is who speaks: a publisher that is
    silent, or was killed and not yet forgotten by the middleware, is no rival.
    """

    def __init__(self, topic: str) -> None:
        self._topic = topic
        self._last: tuple[int, float] | None = None
        self._rival_s: float | None = None

    def heard(self, number: int | None, now_s: float) -> str | None:
        """Take in a message by its publisher's ``number`` at ``now_s`` [s]; returns the fault, or None."""
        if number is None:
            return f"the middleware does not number the messages of {self._topic}; use rmw_fastrtps_cpp"
        last, self._last = self._last, (number, now_s)
        if last is None or number > last[0] or not 0.0 <= now_s - last[1] < HOLD_S:
            return None
        self._rival_s = now_s
        return f"a second node publishes {self._topic}"

    def obstacle(self, now_s: float) -> str | None:
        """What forbids a reset at ``now_s`` [s]: two publishers within the last HOLD_S."""
        if self._rival_s is not None and 0.0 <= now_s - self._rival_s < HOLD_S:
            return f"two nodes still publish {self._topic}"
        return None
