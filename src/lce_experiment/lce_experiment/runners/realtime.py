# SPDX-License-Identifier: Apache-2.0
"""A run in real time: every node a process of its own, as on the bench."""

from __future__ import annotations

import os
import re
import selectors
import tempfile
from pathlib import Path
from typing import Final

from lce_data.progress import Progress
from lce_experiment.plan import Plan
from lce_experiment.runners.processes import Processes

_LOOK_S = 0.01
NUMBER: Final = re.compile(rb"[0-9.e+-]+")
"""The seconds played; with RCUTILS_LOGGING_USE_STDOUT=1 the log stands among them."""


def run_realtime(plan: Plan, progress: Progress) -> None:
    """Play and record `plan`; `progress` receives the seconds played.

    Raises LceError naming a node that ended early. However the run ends, the player ends first and the recorder last,
    so that the laser's last zero is recorded and the bag is finished.
    """
    with tempfile.TemporaryDirectory(prefix="lce_run_") as folder, Processes(Path(folder)) as nodes:
        arguments = plan.ros_arguments(Path(folder) / "parameters.yaml")
        for spec in reversed(plan.nodes[1:]):
            nodes.start(spec.name, [*spec.command, *arguments])
        player = nodes.start(plan.player.name, [*plan.player.command, *arguments], pipe=True)
        assert player.stdout is not None
        with selectors.DefaultSelector() as selector:
            selector.register(player.stdout, selectors.EVENT_READ)
            rest = b""
            while True:
                if selector.select(_LOOK_S):
                    data = os.read(player.stdout.fileno(), 4096)
                    if not data:
                        break
                    *lines, rest = (rest + data).split(b"\n")
                    for line in lines:
                        if NUMBER.fullmatch(line):
                            plan.report(progress, float(line))
                nodes.check(but=plan.player.name)
        nodes.stop(plan.player.name, after_s=5.0)
        nodes.check()
