# SPDX-License-Identifier: Apache-2.0
"""The one exception for what a user can put right: a bad file, unit, name or value."""


class LceError(ValueError):
    """Data, model or request that cannot be used; the message says what, where, and what to do about it.

    The command line prints the message as one line and ends with status 1.
    """
