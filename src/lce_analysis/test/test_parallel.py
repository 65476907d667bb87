# SPDX-License-Identifier: Apache-2.0
"""Pieces of work come back in their order, here and elsewhere; a real cluster is in test/test_cluster.py."""

from functools import partial

from joblib import parallel_config

from lce_analysis.identification.parallel import each
from lce_data.progress import Progress


def _square(x: int, progress: Progress) -> int:
    progress("squaring", x, 3, 0.5)
    return x * x


TASKS = [partial(_square, x) for x in (3, 1, 2)]


def test_here_every_piece_shows_its_own_progress_as_it_goes() -> None:
    shown: list[tuple[str, int]] = []
    results = each(TASKS, "squares", lambda label, done, total, rms: shown.append((label, done)))
    assert next(results) == 9
    assert shown == [("squaring", 3)]
    assert list(results) == [1, 4]
    assert shown == [("squaring", 3), ("squaring", 1), ("squaring", 2)]


def test_elsewhere_the_pieces_are_counted() -> None:
    shown: list[tuple[str, int, int]] = []
    with parallel_config(backend="threading", n_jobs=2):
        found = list(each(TASKS, "squares", lambda label, done, total, rms: shown.append((label, done, total))))
    assert found == [9, 1, 4]
    assert shown == [("squares", 1, 3), ("squares", 2, 3), ("squares", 3, 3)]
