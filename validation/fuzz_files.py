# SPDX-License-Identifier: Apache-2.0
"""The good files that `make fuzz` changes: runs, a model, a wave, an effect, and what the page keeps."""

import json
import struct
from pathlib import Path
from typing import Any, Final

import numpy as np
from mcap.writer import CompressionType, Writer
from rosbags.typesys import Stores, get_typestore

from lce_data.bag.message_types import message_type
from lce_data.bag.writer import BagWriter
from lce_data.units import KELVIN
from lce_model import default_model, save_model, simulate

EFFECT: Final = '''"""A lag of the camera."""
from lce_model.effects import Effect
from lce_model.terms import Parameter


def start(measured_temperature):
    return measured_temperature, measured_temperature


def step(measured_temperature, seen, dt, share, tau):
    seen = seen + dt / (tau + dt) * (measured_temperature - seen)
    return seen, measured_temperature + share * (seen - measured_temperature)


EFFECT = Effect(
    name="late",
    stage="sensor",
    equation="tau dT_s/dt = T - T_s",
    parameters=(
        Parameter("share", "1", 0.0, 0.0, 1.0, "share of it", "a test"),
        Parameter("tau", "s", 1.0, 0.1, 9.0, "time constant", "a test", "log"),
    ),
    states=("seen",),
    outputs=("measured_temperature",),
    start=start,
    step=step,
    strength="share",
    typical=0.5,
    grid=(("tau", (0.5, 2.0)),),
)
'''
EXPERIMENT: Final = """format: lce-experiment-1
protocol: pulse:amp=0.4,th=20
mode: fast
plant: simulated
seed: 1
model: {file: null, sha256: null, set: {lumped.gain: 40.0}}
conditions: {ambient_temperature_c: 27.5, strip_length_m: 0.01, load_n: 0.1, specimen: A3, day: 2026-03-01, note: [a]}
software: {lce: 0.2.0, python: 3.11.7}
started: '2026-03-01T10:00:00.000+00:00'
messages: {/lce/laser/power: 400, /lce/temperature: 400}
lost: {/lce/temperature: 0}
outcome: complete
"""
SESSION: Final = """format: lce-workbench-1
roles: {run.csv: train, bag: test}
models:
- {number: 1, how: from m.yaml, parent: null, command: ''}
- {number: 2, how: by hand, parent: 1, command: lce fit run.csv --out model.yaml}
current: 2
"""
WAVE: Final = {
    "between": ["creep", "phase_kinetics"],
    "protocol": "pulse",
    "separation": 7.5,
    "hottest_c": 61.0,
    "command": "lce design --model m.yaml --between creep,phase_kinetics --out wave.csv",
    "sentences": ["pulse, scaled to the limits."],
}
FLOAT64, TEMPERATURE = "std_msgs/msg/Float64", "sensor_msgs/msg/Temperature"
TOPICS: Final = {"/lce/laser/power": FLOAT64, "/lce/temperature": TEMPERATURE, "/lce/displacement": FLOAT64}
FOREVER: Final = {"sec": 9223372036, "nsec": 854775807}
QOS: Final = {
    "history": "keep_last",
    "depth": 10,
    "reliability": "reliable",
    "durability": "volatile",
    "deadline": FOREVER,
    "lifespan": FOREVER,
    "liveliness": "automatic",
    "liveliness_lease_duration": FOREVER,
    "avoid_ros_namespace_conventions": False,
}
PERIOD_NS: Final = 50_000_000


def write_good_files(folder: Path) -> None:
    """Write them all into an empty folder."""
    time_s = np.arange(0.0, 20.0, PERIOD_NS * 1e-9)
    power = np.where((time_s > 1.0) & (time_s < 10.0), 1.2, 0.0)
    made = simulate(default_model(), time_s, power)
    measured = np.column_stack([time_s, power, made.temperature_k - KELVIN, made.displacement_m])
    rows = [f"{t:.2f},{p:.3f},{c:.3f},{d:.7f}" for t, p, c, d in measured.tolist()]
    head = ["# specimen: A3", "time_s,power_w,temperature_c,displacement_m"]
    (folder / "run.csv").write_text("\n".join([*head, *rows, ""]))
    (folder / "run.yaml").write_text(EXPERIMENT)
    (folder / "wave.csv").write_text("time_s,power_w\n0,0\n1,0.8\n3,0.2\n4,0\n")
    (folder / "late.py").write_text(EFFECT)
    messages = list(_messages(measured))
    _write_bag(folder / "bag", messages)
    _write_compressed(folder / "compressed.mcap", messages)
    save_model(default_model().add("creep"), folder / "m.yaml")
    place = folder / "workbench"
    place.mkdir()
    (place / "session.yaml").write_text(SESSION)
    for number in (1, 2):
        save_model(default_model(), place / f"model-{number}.yaml")
    (place / "wave-1.json").write_text(json.dumps(WAVE))
    (place / "wave-1.csv").write_text("time_s,power_w\n0,0\n1,0.8\n")


def _messages(measured: np.ndarray) -> list[tuple[str, int, bytes]]:
    """Topic, time [ns] and CDR of each message."""
    store = get_typestore(Stores.ROS2_JAZZY)
    header, stamp = store.types["std_msgs/msg/Header"], store.types["builtin_interfaces/msg/Time"]
    found: list[tuple[str, int, bytes]] = []
    for i, (_, *values) in enumerate(measured.tolist()):
        now_ns = 10**9 + i * PERIOD_NS
        for (topic, kind), value in zip(TOPICS.items(), values, strict=True):
            data = b"\x00\x01\x00\x00" + struct.pack("<d", value)
            if kind == TEMPERATURE:
                seconds = stamp(now_ns // 10**9, now_ns % 10**9)
                message: Any = store.types[kind](header(seconds, "strip"), value, 0.0)
                data = bytes(store.serialize_cdr(message, kind))
            found.append((topic, now_ns, data))
    return found


def _write_bag(folder: Path, messages: list[tuple[str, int, bytes]]) -> None:
    """A recording of ours, beside it what is known of it."""
    writer = BagWriter(folder)
    for topic, kind in TOPICS.items():
        writer.add_topic(topic, kind, [QOS])
    for i, (topic, now_ns, data) in enumerate(messages):
        writer.write(topic, now_ns, now_ns, data)
        if i % 100 == 99:
            writer.flush()
    writer.close()
    (folder / "experiment.yaml").write_text(EXPERIMENT)


def _write_compressed(file: Path, messages: list[tuple[str, int, bytes]]) -> None:
    """A recording as another recorder would write it, in compressed chunks."""
    with file.open("wb") as stream:
        writer = Writer(stream, chunk_size=4096, compression=CompressionType.ZSTD)
        writer.start(profile="ros2", library="another")
        channels = {}
        for topic, kind in TOPICS.items():
            schema = writer.register_schema(kind, "ros2msg", message_type(kind).definition.encode())
            channels[topic] = writer.register_channel(topic, "cdr", schema)
        for topic, now_ns, data in messages:
            writer.add_message(channels[topic], now_ns, data, now_ns)
        writer.finish()
