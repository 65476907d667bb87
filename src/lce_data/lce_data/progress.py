# SPDX-License-Identifier: Apache-2.0
"""Long work reports its progress, and stops when it is asked to."""

from typing import Protocol

from lce_data.errors import Cancelled


class Progress(Protocol):
    """Watches a piece of work: a progress bar, a page, or `silent`.

    The work calls it after every step. An exception that it raises stops the work.
    """

    def __call__(self, label: str, done: int, total: int, rms: float) -> None:
        """``done`` of ``total`` steps of ``label``; ``rms`` is the error reached, in units of the noise, or NaN.

        May raise Cancelled or KeyboardInterrupt: the work ends in order and leaves no half-written file.
        """


def silent(label: str, done: int, total: int, rms: float) -> None:
    """Show nothing."""


class CancelToken:
    """A request to stop, set by one thread and seen by another.

    Examples
    --------
    >>> token = CancelToken()
    >>> progress = token.watching(silent)
    >>> token.cancel()
    >>> try:
    ...     progress("fit", 1, 10, 2.0)
    ... except Cancelled as reason:
    ...     print(reason)
    cancelled
    """

    def __init__(self) -> None:
        self.cancelled = False

    def cancel(self) -> None:
        """Ask the work to stop at its next step."""
        self.cancelled = True

    def watching(self, progress: Progress) -> Progress:
        """The same progress, which raises Cancelled once this token is cancelled."""

        def watched(label: str, done: int, total: int, rms: float) -> None:
            if self.cancelled:
                raise Cancelled("cancelled")
            progress(label, done, total, rms)

        return watched


def watched(progress: Progress, cancel: CancelToken | None) -> Progress:
    """``progress``, which also raises Cancelled once the cancel token, if there is one, is cancelled."""
    return progress if cancel is None else cancel.watching(progress)
