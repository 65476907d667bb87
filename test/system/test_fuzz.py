# SPDX-License-Identifier: Apache-2.0
"""A few of the cases of `make fuzz`: whatever a file holds, `lce` uses it or refuses it in one line."""

from random import Random

import pytest
from fuzz import KINDS, planned, run
from fuzz_worker import Answer
from mutations import in_bytes, in_mcap, in_program, in_text


@pytest.mark.timeout(300)  # the process of the cases compiles a model first
def test_no_damaged_file_ends_a_command_in_a_traceback_or_hangs_it() -> None:
    cases = list(run(list(planned(75, seed=1)), minutes=4.0))
    assert len(cases) == 75 and {case.kind for case in cases} == set(KINDS)
    assert [(case.kind, case.seed, case.fault) for case in cases if case.fault] == []


@pytest.mark.parametrize("mutation", [in_bytes, in_mcap, in_program, in_text])
def test_a_case_can_be_had_again(mutation: object) -> None:
    assert callable(mutation)
    text = b"a: 1\nb: [2, 3]\n" * 20
    made = [mutation(text, Random(seed)) for seed in range(50)]
    assert made == [mutation(text, Random(seed)) for seed in range(50)]
    assert sum(changed != text for changed in made) > 40
    assert isinstance(mutation(b"", Random(1)), bytes)


@pytest.mark.parametrize(
    ("answer", "is_fault"),
    [
        (Answer(0, ""), False),
        (Answer(1, "lce: run.csv: time does not increase\n"), False),
        (Answer(1, "lce: warning: odd\nlce: run.csv: time does not increase\n"), False),
        (Answer(1, ""), True),
        (Answer(1, "lce: one\nlce: two\n"), True),
        (Answer(1, "", "Traceback\nKeyError: 1"), True),
        (Answer(None, "no answer within 60 s"), True),
        (Answer(0, "", seconds=11.0), True),
        (Answer(2, "usage: lce"), True),
        (Answer(3, ""), True),
    ],
)
def test_what_a_fault_is(answer: Answer, is_fault: bool) -> None:
    assert bool(answer.fault) == is_fault
