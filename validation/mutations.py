# SPDX-License-Identifier: Apache-2.0
"""Changes of files that a crash, an editor, another program or an attacker may have made, drawn at random."""

import re
from collections.abc import Callable, Iterator
from random import Random
from typing import Final

WORDS: Final = (
    "", "~", "0", "-1", "1e400", "-1e-400", ".nan", "nan", ".inf", "-.inf", "inf", "9" * 30, "9" * 5000, "0x1F",
    "1:30", "1_000", "true", "no", "'", '"', "text", "[1, 2]", "[]", "{}", "{a: 1}", "{a: {b: [1, {c: ~}]}}", "*a",
    "&a 1", "<<", "!!binary x", "!!set {a}", "!!python/name:os.system", "2020-01-01", "2020-01-01T00:00:00Z", "é",
    "\U0001f9ea", "\x00",    "\\ud800", "%", "?", "- ", ": ", "#", "|", ">", ";", "\t", ",", "1,5",
    "/dev/zero", "../../etc/passwd", "./a.py", "9" * 400, "&a [*a]", "[" * 100, "{a: " * 300, "!!timestamp 1", "{1: 2}",
    "{~: 1}", "? [1]", "{[1]: 2}", "!!int x", "!!float x", "1:99:99", "[.nan, ~, {}]", "-0", "x" * 10_000,
    "1e300", "-1e300", "1e-300",
)  # fmt: skip
"""What stands where a value was."""
NUMBERS: Final = (0, 1, 0x7F, 0xFF, 0xFFFF, 2**31 - 1, 2**31, 2**32 - 1, 2**40, 2**63 - 1, 2**63, 2**64 - 1)
"""What stands where eight bytes were: lengths, times and offsets at their ends."""
LINES: Final = (
    "raise SystemExit(0)", "import sys; sys.exit(3)", "1 / 0", "x = [", "assert False", "EFFECT = None", "step = None",
    "from nowhere import nothing", "raise ValueError", "class Effect: pass", "del EFFECT", "raise StopIteration",
    "raise RecursionError", "import lce_model.nothing", "def step(*args): return args", "def step(): return 1.0",
)  # fmt: skip
"""What stands between the lines of a program."""
MESSAGE, CHUNK = 0x05, 0x06
"""Kinds of records of an MCAP file."""
HEAD: Final = 9
"""Bytes of the kind and the length of a record."""
_SCALAR: Final = re.compile(r"[^\s:,\[\]{}()=]+")


def in_bytes(data: bytes, rng: Random) -> bytes:
    """A few bytes changed, lost, doubled or inserted, or the end cut off."""
    changed = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 4, 16, 100))):
        at = _place(len(changed), rng)
        upto = at + rng.choice((1, 2, 8, 64, 1024))
        match rng.randrange(8):
            case 0 | 1 if changed:
                changed[at] ^= 1 << rng.randrange(8)
            case 2:
                changed[at : at + 8] = rng.choice(NUMBERS).to_bytes(8, rng.choice(("little", "big")))
            case 3:
                del changed[at:upto]
            case 4:
                changed[at:at] = changed[at:upto]
            case 5:
                changed[at:at] = rng.randbytes(rng.choice((1, 4, 64)))
            case 6:
                changed[at:upto] = bytes(len(changed[at:upto]))
            case 7 if rng.random() < 0.3:
                del changed[at:]
    return bytes(changed)


def in_mcap(data: bytes, rng: Random) -> bytes:
    """A few records changed in their first fields, lost, doubled, moved or renamed; or the bytes, whatever they are."""
    if rng.random() < 0.4:
        return in_bytes(data, rng)
    changed = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 4))):
        records = list(_records(changed, 8, len(changed)))
        if not records:
            return in_bytes(bytes(changed), rng)
        rare = [record for record in records if changed[record[0]] != MESSAGE]
        begin, end = rng.choice(rng.choice((records, rare)) or records)
        match rng.randrange(7):
            case 0 | 1:
                at = min(begin + HEAD + rng.randrange(40), end) - 1
                changed[at] = rng.choice((changed[at] ^ 1 << rng.randrange(8), rng.randrange(256)))
            case 2:
                changed[begin + 1 : begin + HEAD] = rng.choice((*NUMBERS, end - begin)).to_bytes(8, "little")
            case 3:
                changed[begin] = rng.randrange(1, 17)
            case 4:
                del changed[begin:end]
            case 5:
                changed[begin:begin] = changed[begin:end]
            case 6:
                other, _ = rng.choice(records)
                changed[other:other] = changed[begin:end]
    return bytes(changed)


def _records(data: bytearray, at: int, upto: int) -> Iterator[tuple[int, int]]:
    """Where records begin and end, those in chunks too if they are not compressed."""
    while at + HEAD <= upto:
        end = at + HEAD + int.from_bytes(data[at + 1 : at + HEAD], "little")
        if data[at] == 0 or end > upto:
            return
        yield at, end
        name = at + HEAD + 28
        if data[at] == CHUNK and data[name : name + 4] == bytes(4):
            yield from _records(data, name + 12, end)
        at = end


def _place(size: int, rng: Random) -> int:
    """A place in a file: its head and its index, which say what the rest is, as often as all the rest."""
    begin, end = rng.choice(((0, size), (0, size), (0, min(size, 2000)), (max(size - 4000, 0), size)))
    return rng.randrange(begin, end) if size else 0


def in_text(data: bytes, rng: Random) -> bytes:
    """A value replaced, a line lost, doubled, moved or indented; now and then the bytes."""
    if rng.random() < 0.15:
        return in_bytes(data, rng)
    lines = data.decode().split("\n")
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        at = rng.randrange(len(lines) if rng.random() < 0.6 else min(5, len(lines)))
        match rng.randrange(10):
            case 8 | 9:
                key, colon, _ = lines[at].partition(": ")
                lines[at] = f"{key}{colon}{rng.choice(WORDS)}"
            case 0 | 1 | 2 | 3:
                values = list(_SCALAR.finditer(lines[at]))
                if values:
                    begin, end = rng.choice(values).span()
                    lines[at] = lines[at][:begin] + rng.choice(WORDS) + lines[at][end:]
            case 4 if len(lines) > 1:
                del lines[at]
            case 5:
                lines.insert(at, lines[rng.randrange(len(lines))])
            case 6:
                lines[at] = " " * rng.randrange(5) + lines[at].lstrip()
            case 7:
                lines.insert(at, rng.choice(WORDS))
    return "\n".join(lines).encode()


def in_program(data: bytes, rng: Random) -> bytes:
    """A text changed, or a statement inserted that breaks it."""
    if rng.random() < 0.6:
        return in_text(data, rng)
    lines = data.decode().split("\n")
    lines.insert(rng.randrange(len(lines) + 1), rng.choice(LINES))
    return "\n".join(lines).encode()


Mutation = Callable[[bytes, Random], bytes]
