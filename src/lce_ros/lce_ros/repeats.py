# SPDX-License-Identifier: Apache-2.0
"""Messages that two subscriptions to one topic deliver twice."""

from typing import Final

LATE_NS: Final = 1_000_000_000
"""Within so long [ns] two subscriptions have both delivered a message."""


class Repeats:
    """Tells a message that was delivered before, by the time of its publication.

    A latched value is subscribed to twice (lce_ros.qos). Each message of a latched publisher then comes twice, and the
    second copy may come after a newer message. A publisher whose clock is behind by more than LATE_NS is believed.

    Example
    -------
    >>> repeats = Repeats()
    >>> [repeats.has(sent_ns) for sent_ns in (10, 10, 20, 10)]
    [False, True, False, True]
    """

    def __init__(self) -> None:
        self._newest_ns: int | None = None

    def has(self, sent_ns: int) -> bool:
        """Whether a message published at ``sent_ns`` [ns], or a newer one, was here less than LATE_NS before."""
        if self._newest_ns is not None and 0 <= self._newest_ns - sent_ns < LATE_NS:
            return True
        self._newest_ns = sent_ns
        return False
