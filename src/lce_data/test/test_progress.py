# SPDX-License-Identifier: Apache-2.0
import doctest
import threading

import pytest

from lce_data import progress, run, schema
from lce_data.errors import Cancelled
from lce_data.progress import CancelToken, silent, watched


@pytest.mark.parametrize("module", [progress, run, schema])
def test_the_examples_of_the_docstrings_are_right(module: object) -> None:
    found = doctest.testmod(module, optionflags=doctest.ELLIPSIS)  # type: ignore[arg-type]
    assert found.attempted and not found.failed


def test_a_token_stops_the_work_at_its_next_step() -> None:
    steps: list[int] = []
    token = CancelToken()
    watch = watched(lambda label, done, total, rms: steps.append(done), token)
    watch("fit", 1, 3, float("nan"))
    other = threading.Thread(target=token.cancel)
    other.start()
    other.join()
    with pytest.raises(Cancelled, match="cancelled"):
        watch("fit", 2, 3, float("nan"))
    assert steps == [1]


def test_without_a_token_the_progress_is_as_it_was() -> None:
    assert watched(silent, None) is silent
