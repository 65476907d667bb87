# SPDX-License-Identifier: Apache-2.0
"""Run a plan on the node graph and record it."""

from __future__ import annotations

import signal
from collections.abc import Callable
from contextlib import ExitStack, suppress
from typing import NoReturn

from lce_data import experiment_file as experiment
from lce_data.errors import LceError
from lce_data.progress import Progress, silent
from lce_experiment.domain import own_domain
from lce_experiment.plan import Plan
from lce_experiment.registry import LASER, NAMESPACE
from lce_ros.domain import only_laser


def record(plan: Plan, progress: Progress = silent) -> None:
    """Run a plan in a ROS domain of its own; experiment.yaml says how it ended.

    Parameters
    ----------
    plan : the run.
    progress : receives the whole seconds played; its error is NaN. If it raises, the run ends in order.

    Raises
    ------
    LceError
        If the user's ROS domain has a laser already, or a node fails. An exception that ends a run carries a note with
        the folder of what was recorded until then.
    KeyboardInterrupt
        On Ctrl-C, and on SIGTERM after :func:`interruptible`.
    """
    plan.report(progress, 0.0)
    try:
        with own_domain() as domain, ExitStack() as laser:
            laser.enter_context(only_laser(domain, f"{NAMESPACE}/{LASER.name}"))
            if not plan.fast:
                laser.close()  # there is none so far; the laser of the run is a process that claims this itself
            _runner(plan)(plan, progress)
    except BaseException as error:
        if (plan.folder / experiment.FILE_NAME).exists():
            error.add_note(f"what was recorded until then is in {plan.folder}")
            with suppress(LceError):  # on a full disk: the error that ended the run says more
                interrupted = isinstance(error, KeyboardInterrupt)
                experiment.update(plan.folder, outcome="interrupted" if interrupted else "failed")
        raise
    experiment.update(plan.folder, outcome="complete")


def interruptible() -> None:
    """Let SIGTERM end a run as Ctrl-C does, and Ctrl-C also where a shell's background job has it ignored."""
    signal.signal(signal.SIGTERM, _terminated)
    signal.signal(signal.SIGINT, signal.default_int_handler)


def _runner(plan: Plan) -> Callable[[Plan, Progress], None]:
    if plan.fast:
        from lce_experiment.runners.fast import run_fast

        return run_fast
    from lce_experiment.runners.realtime import run_realtime

    return run_realtime


def _terminated(number: int, frame: object) -> NoReturn:
    raise KeyboardInterrupt
