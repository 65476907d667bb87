# SPDX-License-Identifier: Apache-2.0
"""The double loop in real time: jitter of the commands and latency from sensor to command, beside empty nodes.

    python benchmarks/loop_timing.py [--duration 60] [--json FILE]

Two chains of the same length run at the same time, every node a process, each behind a source that sends another number
every 10 ms and notes which of them comes out at the end and when:

control   displacement → outer_controller → temperature_setpoint → inner_controller → laser/power_command, proportional
          gains alone, so that a command says which displacement it was made of; feedforward and laser run beside it
empty     two rclpy nodes that publish what they receive when they receive it, and nothing else

latency   from sending a number to sending the command that was made of it (stamps of the middleware)
jitter    deviation of the time between two commands from 10 ms
"""

from __future__ import annotations

import argparse
import json
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lce_experiment import registry
from lce_experiment.domain import own_domain
from lce_model import default_model
from lce_model.inverse import InverseChart

PERIOD_S = 0.01
STEPS, STEP_M = 1000, 1e-7
TARGET_M = 1.0e-3
KP_OUT, KP_IN, EXCESS_K = 1.0e4, 0.1, 5.0

COMMON = """
import struct, sys, time
import rclpy
from rclpy.executors import ExternalShutdownException
from std_msgs.msg import Float64
rclpy.init()
node = rclpy.create_node(sys.argv[1])
source, sink = sys.argv[2:4]
PERIOD = 10_000_000

def every_multiple(callback):
    def tick():
        callback(node.get_clock().now().nanoseconds // PERIOD * PERIOD)
    first = PERIOD - node.get_clock().now().nanoseconds % PERIOD
    node.create_timer((first + 0.5) * 1e-9, tick).timer_period_ns = PERIOD
"""
SPIN = """
try:
    rclpy.spin(node)
except (KeyboardInterrupt, ExternalShutdownException):
    pass
"""
DRIVER = f"""{COMMON}
file = open(sys.argv[4], "wb", buffering=1 << 16)
out = node.create_publisher(Float64, source, 10)
count = 0

def send(_):
    global count
    count = (count + 1) % {STEPS}
    file.write(struct.pack("<qd", time.time_ns(), count))
    out.publish(Float64(data=count * {STEP_M}))

def keep(message, info):
    file.write(struct.pack("<qd", -info["source_timestamp"], message.data))

node.create_subscription(Float64, sink, keep, 1000)
every_multiple(send)
{SPIN}file.close()
"""
EMPTY = f"""{COMMON}
out = node.create_publisher(Float64, sink, 10)
node.create_subscription(Float64, source, out.publish, 10)
{SPIN}"""
OPERATOR = f"""{COMMON}
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import Temperature
target = node.create_publisher(
    Float64, source, QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL))
target.publish(Float64(data={TARGET_M}))
camera = node.create_publisher(Temperature, sink, 10)

def show():
    message = Temperature(temperature=float(sys.argv[4]))
    message.header.stamp = node.get_clock().now().to_msg()
    camera.publish(message)

node.create_timer(0.1, show)
{SPIN}"""


def main() -> int:
    """Measure and print the table as Markdown; status 1 where the loop is slower than it may be."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--duration", type=float, default=60.0, metavar="S")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the numbers too")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="lce_loop_") as folder:
        rows = measure(Path(folder), args.duration)
    print(table(rows))
    if args.json:
        args.json.write_text(json.dumps(rows, indent=1), encoding="utf-8")
    return 0 if rows["control"]["latency"][1] <= 1.5 * rows["empty"]["latency"][1] else 1


def measure(folder: Path, duration_s: float) -> dict[str, dict[str, Any]]:
    """Latency and jitter [ms] as p50, p99, max, by chain."""
    feedforward_c = InverseChart(default_model()).temperature_k(TARGET_M) - 273.15
    sources = {"control": ("/lce/displacement", "/lce/laser/power_command"), "empty": ("e0", "e2")}
    with own_domain(), _processes(_commands(feedforward_c - EXCESS_K)):
        time.sleep(5.0)  # processes start and find each other
        drivers = [
            [sys.executable, "-c", DRIVER, f"driver_{name}", *topics, str(folder / name)]
            for name, topics in sources.items()
        ]
        with _processes(drivers):
            time.sleep(duration_s + 4.0)
    return {name: _row(folder / name, duration_s, name == "control") for name in sources}


def _commands(temperature_c: float) -> list[list[str]]:
    """Command lines of all nodes but the drivers."""
    gains = {
        registry.OUTER: {"kp": KP_OUT, "ki": 0.0, "kd": 0.0, "filter_s": 0.0, "horizon_s": 0.0},
        registry.INNER: {"kp": KP_IN, "ki": 0.0, "kd": 0.0, "filter_s": 0.0, "horizon_s": 0.0},
        registry.FEEDFORWARD: {},
        # The camera here has no noise, and a fault would make the commands zero.
        registry.LASER: {
            "frozen_after_s": 0.0,
            "max_tick_gap_s": 1.0,
            "command_fault_s": 5.0,
            "temperature_fault_s": 5.0,
        },
    }
    ours = []
    for spec, values in gains.items():
        words = [word for name, value in values.items() for word in ("-p", f"{name}:={value!r}")]
        ours.append([*spec.command, "--ros-args", "-r", f"__ns:={registry.NAMESPACE}", *words])
    bare = [[sys.executable, "-c", EMPTY, f"empty{k}", f"e{k}", f"e{k + 1}"] for k in range(2)]
    topics = ("/lce/target_displacement", "/lce/temperature")
    return [*ours, *bare, [sys.executable, "-c", OPERATOR, "operator", *topics, repr(temperature_c)]]


@contextmanager
def _processes(commands: list[list[str]]) -> Iterator[None]:
    running = [subprocess.Popen(words, start_new_session=True, stderr=subprocess.DEVNULL) for words in commands]
    try:
        yield
        for process in running:
            if process.poll() is not None:
                raise RuntimeError(f"ended early, status {process.returncode}: {process.args}")
    finally:
        for process in running:
            process.send_signal(signal.SIGINT)
        for process in running:
            process.wait(10)


def _row(file: Path, duration_s: float, controlled: bool) -> dict[str, Any]:
    """Out of a driver's file: time [ns] and number of what was sent, minus time and value of what came out."""
    records = np.fromfile(file, [("t", "<i8"), ("value", "<f8")])
    out = records["t"] < 0
    sent_ns, number = records["t"][~out], records["value"][~out].astype(np.int64)
    came_ns, value = -records["t"][out], records["value"][out]
    if controlled:  # command = KP_IN (feed-forward + KP_OUT (target - displacement) - temperature)
        value = TARGET_M - (value / KP_IN - EXCESS_K) / KP_OUT
    came = np.round(value / STEP_M).astype(np.int64)
    during = came_ns > came_ns[-1] - round(duration_s * 1e9)
    came_ns, came = came_ns[during], came[during]
    latency = []
    for k in np.flatnonzero(np.diff(came, prepend=-1)):  # a number that comes again is the same one held
        before = sent_ns[(number == came[k]) & (sent_ns < came_ns[k])]
        if before.size:  # not a zero, of a moment without a fresh temperature
            latency.append((came_ns[k] - before[-1]) / 1e6)
    jitter = np.abs(np.diff(came_ns) / 1e6 - PERIOD_S * 1e3)
    return {"commands": len(latency), "latency": _quantiles(np.array(latency)), "jitter": _quantiles(jitter)}


def _quantiles(values: NDArray[np.float64]) -> list[float]:
    return [round(float(q), 3) for q in (*np.percentile(values, [50, 99]), values.max())]


def table(rows: dict[str, dict[str, Any]]) -> str:
    """Markdown."""
    titles = {
        "control": "outer and inner controller",
        "empty": "two empty nodes",
    }
    lines = [
        "| 100 Hz, processes | commands | sensor → command p50/p99/max ms | jitter p50/p99/max ms |",
        "|---|---|---|---|",
    ]
    for name, row in rows.items():
        latency, jitter = (" / ".join(f"{v:.2f}" for v in row[key]) for key in ("latency", "jitter"))
        lines.append(f"| {titles[name]} | {row['commands']} | {latency} | {jitter} |")
    ratio = rows["control"]["latency"][1] / rows["empty"]["latency"][1]
    return "\n".join([*lines, "", f"Latency at p99, controllers beside empty nodes: ratio **{ratio:.2f}**."])


if __name__ == "__main__":
    sys.exit(main())
