# SPDX-License-Identifier: Apache-2.0
"""The node graph in real time: samples missed by topic, latency and jitter, beside a bare rclpy pair.

    python benchmarks/graph.py [--duration 600] [--json FILE]

Every node is a process, as in `lce run`; the bare publisher and subscriber (Float64, 100 Hz, reliable) run at
the same time in a domain of their own, so that both are measured on the same machine in the same minutes.

lost      messages that a publisher sent and the recorder did not get (gaps in the publisher's numbers)
skipped   ticks of 10 ms at which nothing was published (the machine was busy elsewhere)
latency   from the publisher's stamp to the recorder's callback
jitter    deviation of the time between two messages from 10 ms
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from mcap.reader import make_reader
from numpy.typing import NDArray

from lce_experiment.domain import own_domain

PERIOD_S = 0.01
TOPICS = ("laser/power_command", "laser/power", "displacement", "sim/temperature", "sim/displacement")

BARE_PUBLISHER = """
import rclpy
from std_msgs.msg import Float64
rclpy.init()
node = rclpy.create_node("bare_publisher")
out = node.create_publisher(Float64, "bare", 10)
node.create_timer(0.01, lambda: out.publish(Float64(data=1.0)))
try:
    rclpy.spin(node)
except (KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
    pass
"""

BARE_SUBSCRIBER = """
import struct, sys, time
import rclpy
from std_msgs.msg import Float64
rclpy.init()
node = rclpy.create_node("bare_subscriber")
file = open(sys.argv[1], "wb", buffering=1 << 16)

def keep(message, info):
    now = time.time_ns()
    file.write(struct.pack("<qqq", info["publication_sequence_number"], info["source_timestamp"], now))

node.create_subscription(Float64, "bare", keep, 1000)
try:
    rclpy.spin(node)
except (KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
    file.close()
"""


def main() -> int:
    """Measure and print the table as Markdown."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--duration", type=float, default=600.0, metavar="S", help="of the experiment")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the numbers too")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="lce_graph_") as folder:
        rows = measure(Path(folder), args.duration)
    print(table(rows))
    if args.json:
        args.json.write_text(json.dumps(rows, indent=1), encoding="utf-8")
    return 0 if all(row["lost"] == 0 for row in rows) else 1


def measure(folder: Path, duration_s: float) -> list[dict[str, Any]]:
    """One row for each topic at 100 Hz, one for the bare pair, one from command to applied power."""
    half = duration_s / 2
    protocol = f"ramp:high=1.8,up={half},down={half},rest=0"
    with own_domain():
        bare = [
            subprocess.Popen([sys.executable, "-c", code, str(folder / "bare")], start_new_session=True)
            for code in (BARE_SUBSCRIBER, BARE_PUBLISHER)
        ]
        try:
            environment = {key: value for key, value in os.environ.items() if key != "ROS_DOMAIN_ID"}
            words = ["run", protocol, "--seed", "1", "--out", str(folder / "bag")]
            subprocess.run([sys.executable, "-m", "lce_app.cli.main", *words], env=environment, check=True)
        finally:
            for process in bare:
                process.send_signal(signal.SIGINT)
            for process in bare:
                process.wait(10)
    found = _bag(folder / "bag")
    lost = yaml.safe_load((folder / "bag" / "experiment.yaml").read_text(encoding="utf-8"))["lost"]
    played = found["/lce/laser/power_command"][0]
    window = int(played[0]), int(played[-1])
    rows = [_row(topic, *found[f"/lce/{topic}"][:2], lost[f"/lce/{topic}"], window) for topic in TOPICS]
    rows.append(_bare_row(folder / "bare", window))
    hop = _hop(found["/lce/laser/power_command"], found["/lce/laser/power"])
    rows.append({"topic": "command sent → power applied", "lost": 0, "latency": _quantiles(hop * 1e3)})
    return rows


Times = NDArray[np.int64]


def _bag(bag: Path) -> dict[str, tuple[Times, Times, list[bytes]]]:
    """Publish and log times [ns] and raw messages by topic."""
    found: dict[str, tuple[list[int], list[int], list[bytes]]] = {}
    with (bag / "recording.mcap").open("rb") as file:
        for _, channel, message in make_reader(file).iter_messages():
            sent, heard, data = found.setdefault(channel.topic, ([], [], []))
            sent.append(message.publish_time)
            heard.append(message.log_time)
            data.append(message.data)
    return {topic: (np.array(sent), np.array(heard), data) for topic, (sent, heard, data) in found.items()}


def _row(topic: str, sent: Times, heard: Times, lost: int, window: tuple[int, int]) -> dict[str, Any]:
    during = (sent >= window[0]) & (sent <= window[1])  # not while processes start
    sent, heard = sent[during], heard[during]
    steps_s = np.diff(np.sort(sent)) / 1e9
    skipped = int(np.sum(np.maximum(np.round(steps_s / PERIOD_S) - 1, 0)))
    return {
        "topic": topic,
        "messages": int(sent.size),
        "lost": lost,
        "skipped": skipped,
        "latency": _quantiles((heard - sent) / 1e6),
        "jitter": _quantiles(np.abs(steps_s - PERIOD_S) * 1e3),
    }


def _bare_row(file: Path, window: tuple[int, int]) -> dict[str, Any]:
    number, sent, heard = np.fromfile(file, "<i8").reshape(-1, 3).T
    return _row("bare rclpy pair", sent, heard, int(number[-1] - number[0] + 1 - number.size), window)


def _hop(command: tuple[Times, Times, list[bytes]], power: tuple[Times, Times, list[bytes]]) -> NDArray[np.float64]:
    """Time [s] from each command to the first applied power with its value; a ramp repeats none for long."""
    sent = {data: at for at, data in zip(command[0][::-1].tolist(), command[2][::-1], strict=True)}
    applied = {data: at for at, data in zip(power[0][::-1].tolist(), power[2][::-1], strict=True)}
    steps = np.array([applied[data] - at for data, at in sent.items() if data in applied]) / 1e9
    return steps[(steps > 0) & (steps < 1)]


def _quantiles(values: NDArray[np.float64]) -> list[float]:
    return [round(float(q), 3) for q in (*np.percentile(values, [50, 99]), values.max())]


def table(rows: list[dict[str, Any]]) -> str:
    """Markdown."""
    lines = [
        "| 100 Hz, processes | messages | lost | skipped | latency p50/p99/max ms | jitter p50/p99/max ms |",
        "|---|---|---|---|---|---|",
    ]
    for row in rows:
        latency, jitter = (" / ".join(f"{v:.2f}" for v in row.get(key, [])) for key in ("latency", "jitter"))
        counts = [str(row.get(key, "")) for key in ("messages", "lost", "skipped")]
        lines.append(f"| {row['topic']} | {' | '.join(counts)} | {latency} | {jitter} |")
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
