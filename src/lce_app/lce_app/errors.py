# SPDX-License-Identifier: Apache-2.0
"""Options that cannot be used. Their errors name the field; the command line names its flag instead."""

from lce_data.errors import LceError


class OptionError(LceError):
    """An option with a value that cannot be used.

    option : the field of the options, ``hold_s``; ``problem`` goes on from there, ``0.5: must be within [1, 3600] s``.
    """

    def __init__(self, option: str, problem: str) -> None:
        super().__init__(f"{option} {problem}")
        self.option = option
        self.problem = problem


def check_seed(seed: int | None) -> None:
    """Raise OptionError for a negative seed; None stands for a new one."""
    if seed is not None and seed < 0:
        raise OptionError("seed", f"{seed}: must be 0 or more")


class ContradictoryOptions(OptionError):
    """An option that excludes another one; the command line ends with status 2, wrong usage."""
