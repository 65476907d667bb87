# SPDX-License-Identifier: Apache-2.0
"""Exceptions: one for what a user can put right, one for work that was asked to stop."""


class LceError(ValueError):
    """Data, model or request that cannot be used; the message says what, where, and what to do about it.

    The command line prints the message as one line and ends with status 1.
    """


class Cancelled(KeyboardInterrupt):
    """Work was asked to stop, by a cancel token as by Ctrl-C: it ends in order, a fit with its best values so far."""
