# SPDX-License-Identifier: Apache-2.0
"""A few of the interrupts of `make interrupts`."""

import pytest
from interrupts import all_cases, interrupts


@pytest.mark.alone
def test_ctrl_c_at_any_moment_of_the_start_gives_no_traceback() -> None:
    wanted = ("simulator", "simulator, compiling", "recorder", "lce run")
    cases = [case for case in all_cases() if case.name in wanted]
    assert len(cases) == len(wanted)
    tallies = interrupts(cases, 4, seed=1)
    assert [(one.case.name, one.at_s, one.problem, one.printed) for t in tallies.values() for one in t.problems] == []
