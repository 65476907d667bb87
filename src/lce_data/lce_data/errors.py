# SPDX-License-Identifier: Apache-2.0
"""Exceptions: one for what a user can put right, one for work that was asked to stop."""

from collections.abc import Iterable
from difflib import get_close_matches


class LceError(ValueError):
    """Data, model or request that cannot be used; the message says what, where, and what to do about it.

    The command line prints the message as one line and ends with status 1.
    """


class Cancelled(KeyboardInterrupt):
    """Work was asked to stop, by a cancel token as by Ctrl-C: it ends in order, a fit with its best values so far."""


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """What stands behind a name that is not known, "(did you mean 'creep'?)"; nothing if no known one is like it."""
    nearest = get_close_matches(name, list(known), n=1)
    return f" (did you mean {nearest[0]!r}?)" if nearest else ""
