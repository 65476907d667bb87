# SPDX-License-Identifier: Apache-2.0
"""Pieces of work that do not depend on each other: one after the other here, or side by side on a cluster.

Which of the two is chosen at the edge, by ``joblib.parallel_config``. Here means in this very process: the threads of
:mod:`lce_analysis.identification.problem` keep its cores busy with the runs of one piece already, and nothing has to be
started.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

from lce_data.progress import Progress, silent

Result = TypeVar("Result")


def each(tasks: Sequence[Callable[[Progress], Result]], label: str, progress: Progress) -> Iterator[Result]:
    """The results of ``tasks``, in their order, as they come; each task takes a progress.

    On a cluster tasks and results are pickled, and the progress counts whole tasks, under ``label``.
    """
    # Imports of a third of a second that most commands have no use for.
    from joblib import Parallel, delayed
    from joblib.parallel import get_active_backend

    _, workers = get_active_backend()
    here = workers in (None, 1)
    results = Parallel(return_as="generator")(delayed(task)(progress if here else silent) for task in tasks)
    for done, result in enumerate(results, start=1):
        if not here:
            progress(label, done, len(tasks), math.nan)
        yield result
