# SPDX-License-Identifier: Apache-2.0
"""Topics of a foreign bag as signals: ``temperature=/cam/temp``, ``load=/cell/wrench.wrench.force.z:N``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lce_data.bag.reader import Messages, foreign, read_topics
from lce_data.channels import CHANNELS, STAMPED_NUMBER, TEMPERATURE, Channel, stamped_topic
from lce_data.errors import LceError
from lce_data.importing.headers import TIME, si_unit
from lce_data.importing.plausible import Hints, likely_unit
from lce_data.importing.recording import UNIT, Pick, Recording, Signal
from lce_data.importing.units import CELSIUS, typed, unit_and_sign

Floats = NDArray[np.float64]


def read_bag_topics(path: Path, picks: Sequence[Pick]) -> Recording:
    """Read topics of a bag, timed by their header stamps, or by the log time of the bag if they have none.

    Parameters
    ----------
    picks : the source of each is a topic, with the field behind a dot if the message has several numbers. Channels
        that are not picked are taken from the topics of the bench if the bag has them.

    Raises
    ------
    LceError
        If the bag cannot be read, a topic is not in it, or a message has no such number; names what there is.
    """
    chosen = {pick.source.partition(".")[0] for pick in picks}
    types: dict[str, str] = {}

    def wanted(topic: str, type_name: str) -> bool:
        types[topic] = type_name
        return topic in chosen or _channel_of(topic, type_name) is not None

    found = read_topics(path, wanted)
    there = ", ".join(f"{name} ({kind})" for name, kind in sorted(types.items())) or "none"
    signals = []
    for pick in (*(p for p in picks if p.source), *_of_the_bench(path, picks, types)):
        topic, _, field = pick.source.partition(".")
        if pick.quantity == TIME or topic not in found:
            raise LceError(f"{path}: no topic for {pick}; it has {there}")
        signals.append(_signal(pick, types[topic], *_numbers(path, topic, field, found[topic])))
    if not signals:
        raise LceError(f"{path}: --topic QUANTITY=TOPIC says which topic holds what; it has {there}")
    zero_s = min(signal.time_s[0] for signal in signals)
    signals = [replace(signal, time_s=signal.time_s - zero_s) for signal in signals]
    used = {signal.source.partition(".")[0] for signal in signals}
    return Recording(path, tuple(signals), tuple(sorted(types.keys() - used)))


def _channel_of(topic: str, type_name: str) -> Channel | None:
    """The channel that a topic of the bench holds, in whatever namespace; not what the simulator knows of it."""
    if "/sim/" in topic:
        return None
    for channel in CHANNELS:
        name = channel.stamped_topic if type_name == STAMPED_NUMBER else channel.topic
        if name and f"/{topic}".endswith(f"/{name}") and type_name in (channel.message, STAMPED_NUMBER):
            return channel
    return None


def _of_the_bench(path: Path, picks: Sequence[Pick], types: Mapping[str, str]) -> list[Pick]:
    """Picks of the channels that the user said nothing of: a stamped topic rather than the plain one beside it.

    Raises LceError if two topics may hold one of them.
    """
    said = {pick.quantity for pick in picks}
    found: dict[str, Pick] = {}
    for topic, type_name in sorted(types.items()):
        channel = _channel_of(topic, type_name)
        if channel is None or channel.name in said:
            continue
        if channel.name in found and topic != stamped_topic(found[channel.name].source):
            both = f"{found[channel.name].source} and {topic}"
            raise LceError(f"{path}: {both} may be the {channel.name}; --topic {channel.name}=TOPIC picks one")
        found[channel.name] = Pick(channel.name, topic, typed(channel.recorded))
    return list(found.values())


def _signal(pick: Pick, type_name: str, time_s: Floats, value: Floats) -> Signal:
    if pick.unit:
        unit, sign = unit_and_sign(si_unit(pick.quantity), pick.unit)
        return Signal(pick.quantity, pick.source, unit, sign, (), time_s, value)
    if type_name == TEMPERATURE.message and pick.quantity in ("temperature", "ambient"):  # which defines its unit
        return Signal(pick.quantity, pick.source, CELSIUS, 1.0, (), time_s, value)
    unit = likely_unit(pick.quantity, value, Hints(pick.source))
    return Signal(pick.quantity, pick.source, unit, 1.0, (UNIT,) if si_unit(pick.quantity) else (), time_s, value)


def _numbers(path: Path, topic: str, field: str, messages: Messages) -> tuple[Floats, Floats]:
    """Time [s] and number of each message."""
    from rosbags.typesys import Stores, get_typestore

    if messages.type == STAMPED_NUMBER and field in ("", "value"):
        with foreign(path):
            return _increasing(*messages.by_stamp())
    store = get_typestore(Stores.ROS2_JAZZY)
    if messages.type not in store.types:
        raise LceError(f"{path}: topic {topic} is a {messages.type}, which is no type of ROS 2 Jazzy")
    with foreign(path):
        decoded: list[Any] = [store.deserialize_cdr(cdr, messages.type) for cdr in messages.cdr]
    numbers = _fields(decoded[0])
    if not field and len(numbers) == 1:
        (field,) = numbers
    if field not in numbers:
        raise LceError(
            f"{path}: topic {topic} is a {messages.type}; name a number of it: {topic}.{' or .'.join(numbers)}"
        )
    value = np.array([_field(message, field) for message in decoded])
    stamps = [message.header.stamp for message in decoded if hasattr(message, "header")]
    time_ns = (
        [s.sec * 1_000_000_000 + s.nanosec for s in stamps] if any(s.sec for s in stamps) else messages.log_time_ns
    )
    return _increasing(np.array(time_ns, dtype=np.int64).astype(np.float64) * 1e-9, value)


def _increasing(time_s: Floats, value: Floats) -> tuple[Floats, Floats]:
    """Samples in the order of their times; of several at one instant the last one holds."""
    order = np.argsort(time_s, kind="stable")
    time_s, value = time_s[order], value[order]
    last = np.append(np.diff(time_s) > 0.0, True)
    return time_s[last], value[last]


def _fields(message: Any, front: str = "") -> list[str]:
    """The numbers of a message by their paths, without those of its header, variances and layouts of arrays."""
    names: list[str] = []
    for name in message.__dataclass_fields__:
        value = getattr(message, name)
        if name in ("header", "variance", "layout", "__msgtype__"):
            continue
        if isinstance(value, int | float | bool):
            names.append(f"{front}{name}")
        elif hasattr(value, "__dataclass_fields__"):
            names += _fields(value, f"{front}{name}.")
    return names


def _field(message: Any, path: str) -> float:
    for name in path.split("."):
        message = getattr(message, name)
    return float(message)
