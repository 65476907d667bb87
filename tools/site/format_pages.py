# SPDX-License-Identifier: Apache-2.0
"""The page of the file formats, from the types that the files are checked against."""

import inspect
import re
import typing
from collections.abc import Iterable
from typing import Any

import msgspec

from lce_data.channels import CHANNELS
from lce_data.experiment_file import Conditions, Experiment, ModelUsed
from lce_model.model_file import ModelFile, ParameterEntry, RunValueEntry, VariationEntry

HEAD = """# File formats

What the bench reads and writes, key by key. The tables come from the types that files are checked against: an unknown
key of a model file, a unit that does not fit or a value outside its bounds is refused in one line.

## Recordings

A recording is a rosbag2 folder (MCAP) or a CSV. The topics and columns that are read:

| quantity | topic | message | unit | CSV column | unit |
|---|---|---|---|---|---|
"""
CSV = """
A CSV begins with `time_s` [s], strictly increasing. An empty cell is no sample; a column that was not measured is left
out. A column `input_NAME` (topic `input/NAME`) holds an input of your own in any unit.

```text
time_s,power_w,temperature_c,displacement_m
0.00,0.4,27.912,0.000001
0.01,0.4,,0.000003
```

Waves for `lce run` and `lce simulate` are CSV files with the columns `time_s,power_w`.
"""
TAIL = """
Next: [import other tables](../tutorials/your-own-data.md), [read the JSON of a report](json.md).
"""
FILES = (
    ("experiment.yaml and run.yaml", "Beside a bag, and beside `run.csv`.", (Experiment, Conditions, ModelUsed)),
    ("Model file", "Hand-editable YAML.", (ModelFile, ParameterEntry, VariationEntry, RunValueEntry)),
)


def formats_page() -> str:
    """Columns and topics of recordings, keys of the YAML files."""
    rows = [
        f"| {c.name} | `{c.topic}` | `{c.message}` | {c.recorded.symbol} | `{c.column}` | {c.recorded.symbol} |"
        for c in CHANNELS
    ]
    texts = [HEAD.rstrip("\n"), *rows, CSV]
    for title, about, kinds in FILES:
        texts += [f"## {title}", "", about, "", *(line for kind in kinds for line in _table(kind))]
    return "\n".join([*texts, TAIL])


def _table(kind: type[msgspec.Struct]) -> Iterable[str]:
    doc = inspect.getdoc(kind) or ""
    lead, _, _ = doc.partition("\n\n")
    meaning = _meanings(doc)
    yield from (
        f"### {kind.__name__}",
        "",
        " ".join(lead.split()),
        "",
        "| key | type | default | |",
        "|---|---|---|---|",
    )
    for field in msgspec.structs.fields(kind):
        if field.name != "other":
            default = "" if field.default in (None, msgspec.NODEFAULT, msgspec.UNSET) else f"`{field.default}`"
            yield f"| `{field.encode_name}` | {_type(field.type)} | {default} | {meaning.get(field.name, '')} |"
    yield ""


def _meanings(doc: str) -> dict[str, str]:
    """What a docstring says of each field: lines ``name, name : meaning``, which may go on indented."""
    found: dict[str, str] = {}
    for names, text in re.findall(r"^([\w, ]+?) : (.+(?:\n {4}.+)*)", doc, re.MULTILINE):
        found |= dict.fromkeys((name.strip() for name in names.split(",")), " ".join(text.split()))
    return found


def _type(kind: Any) -> str:
    """A type in words: what may be left out goes without saying."""
    if typing.get_origin(kind) is typing.Annotated:
        return _type(typing.get_args(kind)[0])
    parts = [a for a in typing.get_args(kind) if a not in (type(None), msgspec.UnsetType)]
    if typing.get_origin(kind) is dict:
        return f"table of {_type(parts[1])}"
    if typing.get_origin(kind) is list:
        return f"list of {_type(parts[0])}"
    if parts:
        return " or ".join(_type(part) for part in parts)
    words = {float: "number", int: "whole number", str: "text", bool: "true or false", Any: "any"}
    return words.get(kind, getattr(kind, "__name__", str(kind)))
