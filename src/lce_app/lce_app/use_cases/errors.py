# SPDX-License-Identifier: Apache-2.0
"""Requests that contradict themselves."""

from lce_data.errors import LceError


class ContradictoryOptions(LceError):
    """Two options that exclude each other; the command line ends with status 2, wrong usage."""
