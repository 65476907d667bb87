# SPDX-License-Identifier: Apache-2.0
"""Record a bench that somebody else runs: the recorder alone, and nothing that commands."""

from __future__ import annotations

import itertools
import json
import math
import tempfile
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, Final, NoReturn

from lce_data import experiment_file
from lce_data.errors import LceError
from lce_data.given_conditions import check_conditions
from lce_data.progress import Progress, silent
from lce_data.topics import RECORDED
from lce_data.yaml_text import dump
from lce_experiment.plan import folders
from lce_experiment.registry import NAMESPACE, RECORDER
from lce_experiment.runners.processes import Processes

POLL_S: Final = 0.1
"""Time between two looks at the recorder [s]."""
MODE: Final = "recorder"
"""In experiment.yaml, of a recording whose run was started by others."""


def record_topics(
    out: Path, conditions: Mapping[str, Any], topics: Sequence[str] = (), progress: Progress = silent
) -> NoReturn:
    """Record what others run in the ROS domain of the environment, until Ctrl-C or an exception of ``progress``.

    Parameters
    ----------
    out : new folder of the recording.
    conditions : what is to be said of the run: ``specimen``, ``notes`` and others, as of ``lce run``.
    topics : recorded beside those that always are, as "NAME pkg/msg/Type".
    progress : called once a second; its error is NaN.

    Raises
    ------
    LceError
        If the folder or a condition cannot be used, or the recorder fails; experiment.yaml then says so.
    KeyboardInterrupt
        On Ctrl-C. The recording is finished and complete then.
    """
    folders(out, "", [out.name])
    about = experiment_file.Experiment(
        format=experiment_file.FORMAT,
        mode=MODE,
        conditions=experiment_file.conditions_of(check_conditions(conditions)),
    )
    outcome = "complete"
    try:
        with tempfile.TemporaryDirectory(prefix="lce_record_") as folder, Processes(Path(folder)) as nodes:
            nodes.start(RECORDER.name, _command(Path(folder) / "parameters.yaml", out, about, topics))
            _watch(nodes, out.name, progress)
    except LceError:
        outcome = "failed"
        raise
    finally:
        if (out / experiment_file.FILE_NAME).exists():
            with suppress(LceError):  # on a full disk: the error that ended the recorder says more
                experiment_file.update(out, outcome=outcome)


def _command(file: Path, out: Path, about: experiment_file.Experiment, topics: Sequence[str]) -> list[str]:
    """The recorder with its parameters, which are written into a file."""
    parameters = {
        "out": str(out.resolve()),
        "experiment": json.dumps(experiment_file.content_of(about)),
        "topics": [*RECORDED, *topics],
    }
    file.write_text(dump({"/**": {"ros__parameters": parameters}}), encoding="utf-8")
    return [*RECORDER.command, "--ros-args", "-r", f"__ns:={NAMESPACE}", "--params-file", str(file)]


def _watch(nodes: Processes, name: str, progress: Progress) -> NoReturn:
    """Report the seconds, and raise LceError when the recorder ends."""
    began = time.monotonic()
    for second in itertools.count():
        progress(f"recording {name}", second, second + 1, math.nan)
        while time.monotonic() < began + second + 1:
            nodes.check()
            time.sleep(POLL_S)
    raise AssertionError
