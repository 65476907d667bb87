# SPDX-License-Identifier: Apache-2.0
"""A run on simulated time: the same node classes, in this process, in lockstep."""

from __future__ import annotations

import tempfile
import threading
from pathlib import Path

import rclpy
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import try_shutdown

from lce_data.progress import Progress
from lce_experiment.nodes.player_node import Player
from lce_experiment.plan import Plan
from lce_experiment.runners.lockstep import Lockstep
from lce_ros.node import LceNode
from lce_ros.signals import stop_signals

_REPORT_TICKS = 100
"""Ticks between two reports of progress: a second of simulated time."""
_AFTER_TICKS = 5
"""Ticks after the player's last zero: so long it takes through laser and simulator to the sensors."""


def run_fast(plan: Plan, progress: Progress) -> None:
    """Play and record `plan` as quickly as the machine can; `progress` receives the simulated seconds played.

    A stop signal becomes a KeyboardInterrupt between two ticks: within a call into rclpy it would be another error.
    However the run ends, the recorder is closed last. The same plan gives the same file, byte for byte.
    """
    stopped = threading.Event()
    with tempfile.TemporaryDirectory(prefix="lce_run_") as folder, stop_signals(stopped.set):
        arguments = plan.ros_arguments(Path(folder) / "parameters.yaml")
        # What a node has to say beside the progress is in its exception, or in the recorded /diagnostics.
        rclpy.init(args=[*arguments, "--disable-stdout-logs"], signal_handler_options=SignalHandlerOptions.NO)
        nodes: list[LceNode] = []
        try:
            for spec in plan.nodes:
                nodes.append(spec.load()())  # noqa: PERF401  those made so far are closed if one fails
            _play(plan, nodes, stopped, progress)
        finally:
            for node in nodes:
                node.close()
                node.destroy_node()
            try_shutdown()


def _play(plan: Plan, nodes: list[LceNode], stopped: threading.Event, progress: Progress) -> None:
    player = nodes[0]
    assert isinstance(player, Player)  # a plan names its player first
    steps = Lockstep(nodes)
    try:
        count = 0
        while not player.finished:
            if stopped.is_set():
                raise KeyboardInterrupt
            steps.tick()
            count += 1
            if count % _REPORT_TICKS == 0:
                plan.report(progress, player.played_s)
        plan.report(progress, player.total_s)
        for _ in range(_AFTER_TICKS):
            steps.tick()
    finally:
        steps.close()
