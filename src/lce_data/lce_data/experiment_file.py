# SPDX-License-Identifier: Apache-2.0
"""`experiment.yaml` beside a bag, `run.yaml` beside `run.csv`: what was asked of which strip, and how it ended.

Every key may be missing: launch files leave some out, and other people's recordings hold what they like. Keys that are
not known here are kept.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Any, Final, TypeGuard

import msgspec
from msgspec import Meta, Struct

from lce_data.channels import AMBIENT, Channel
from lce_data.errors import LceError
from lce_data.files import write_atomically
from lce_data.schema import checked, read_yaml
from lce_data.software import software

FILE_NAME: Final = "experiment.yaml"
FORMAT: Final = "lce-experiment-1"


class Table(Struct, frozen=True, kw_only=True):
    """A table of the file: what it knows, and under ``other``, by key, what it does not."""

    other: dict[str, Any] = {}


class Conditions(Table, frozen=True, kw_only=True):
    """What is one number or word for a whole run.

    Parameters
    ----------
    ambient_temperature_c, ambient_c : temperature of the surroundings; the simulated bench writes the first.
    strip_length_m : length of the strip between its clamps, cold.
    load_n : force on the strip, pulling is positive.
    specimen, day : which strip, and when.
    other : ``notes`` and whatever else was stated, and ``input_NAME``, the one value of an input that a user named.
    """

    ambient_temperature_c: float | None = None
    strip_length_m: Annotated[float, Meta(gt=0)] | None = None
    ambient_c: float | None = None
    load_n: float | None = None
    specimen: str | int | None = None
    day: str | int | None = None

    def value(self, channel: Channel) -> float | None:
        """The one number [recorded unit] of an optional input for the whole run, None if there is none."""
        value = getattr(self, channel.column, self.other.get(channel.column))
        if value is None and channel is AMBIENT:
            return self.ambient_temperature_c
        return float(value) if isinstance(value, int | float) else None


class ModelUsed(Table, frozen=True, kw_only=True):
    """The model of the simulated strip: its file, None for the bench's own, and what was set in it (TERM.PARAM)."""

    file: str | None = None
    sha256: str | None = None
    set: dict[str, float] = {}


class Experiment(Table, frozen=True, kw_only=True):
    """The content of the file.

    Parameters
    ----------
    protocol : what was played, in the words of ``lce run``.
    mode : ``realtime``, ``fast``, ``launch``, or ``recorder`` if others ran what was recorded.
    plant : ``simulated`` or ``hardware``.
    seed : of the simulated sensors' noise.
    software : versions by name.
    started, ended : UTC, ISO 8601.
    messages, lost : how many messages of each topic were recorded, and how many the recorder missed.
    outcome : ``complete``, ``interrupted`` or ``failed``.
    """

    format: str | None = None
    protocol: str | None = None
    mode: str | None = None
    plant: str | None = None
    seed: int | None = None
    model: ModelUsed | None = None
    conditions: Conditions = Conditions()
    software: dict[str, Any] | None = None
    started: str | None = None
    ended: str | None = None
    messages: dict[str, int] | None = None
    lost: dict[str, int] | None = None
    outcome: str | None = None

    def with_entries(self, **entries: Any) -> Experiment:
        """The same experiment, with other values of some fields."""
        return msgspec.structs.replace(self, **entries)


def experiment_of(content: object, where: Path | str = FILE_NAME) -> Experiment:
    """Check the plain content of a file. Raises LceError that names ``where``, the key and the value."""
    if not isinstance(content, Mapping):
        raise LceError(f"{where}: the content is not keys with values")
    tables: dict[str, type[Table]] = {"model": ModelUsed, "conditions": Conditions}
    gathered = _gathered(content, Experiment)
    for key, kind in tables.items():
        if isinstance(gathered.get(key), Mapping):
            gathered[key] = _gathered(gathered[key], kind)
    return checked(where, gathered, Experiment)


def content_of(table: Table) -> dict[str, Any]:
    """An experiment, or its conditions, as plain values in the order of the file; keys without a value are left out."""
    content: dict[str, Any] = {}
    for key in table.__struct_fields__:
        value = getattr(table, key)
        if key != "other" and (value is not None or isinstance(table, ModelUsed)):
            content[key] = content_of(value) if isinstance(value, Table) else value
    return {**content, **table.other}


def describe(
    protocol: str,
    mode: str,
    plant: str,
    seed: int,
    model: Path | None,
    settings: Mapping[str, float],
    conditions: Mapping[str, Any],
) -> Experiment:
    """What is known before the run. `model` None stands for the bench's default strip."""
    return Experiment(
        format=FORMAT,
        protocol=protocol,
        mode=mode,
        plant=plant,
        seed=seed,
        model=ModelUsed(
            file=None if model is None else str(model),
            sha256=None if model is None else _sha256(model),
            set=dict(settings),
        ),
        conditions=conditions_of(conditions),
        software=software(),
    )


def conditions_of(content: Mapping[str, Any]) -> Conditions:
    """Conditions by key. Raises LceError that names a key with a value of the wrong kind."""
    return checked("conditions", _gathered(content, Conditions), Conditions)


def with_provenance(experiment: Experiment) -> Experiment:
    """The same experiment with the versions of the software, and the hash of its model file, if it lacks them.

    A launch file cannot compute these, so the recorder does. The real bench has no model unless a file is named.
    """
    model = experiment.model
    if model is not None and not model.file:
        model = ModelUsed(set=model.set, other=model.other) if experiment.plant != "hardware" else None
    elif model is not None and model.sha256 is None and Path(model.file or "").is_file():
        model = msgspec.structs.replace(model, sha256=_sha256(Path(model.file or "")))
    return experiment.with_entries(model=model, software=experiment.software or software())


def custom_data(experiment: Experiment) -> dict[str, str]:
    """What is known before the run as text by key, ``conditions.specimen`` for example: for the metadata of a bag."""
    found: dict[str, str] = {}

    def take(front: str, table: Mapping[str, Any]) -> None:
        for key, value in table.items():
            if isinstance(value, Mapping):
                take(f"{front}{key}.", value)
            elif value is not None:
                found[f"{front}{key}"] = value if isinstance(value, str) else json.dumps(value)

    take("", content_of(experiment))
    return found


def read(path: Path) -> Experiment:
    """Read an experiment.yaml; an empty file says nothing. Raises LceError naming the file, the key and the value."""
    content = read_yaml(path)
    return Experiment() if content is None else experiment_of(content, path)


def beside(recording: Path) -> Experiment:
    """Read the file of a bag folder or of one of its files: in the folder, or beside it as NAME.experiment.yaml."""
    folder = recording if recording.is_dir() else recording.parent
    for place in (folder / FILE_NAME, folder.parent / f"{folder.name}.{FILE_NAME}"):
        if place.exists():
            return read(place)
    return Experiment()


def beside_csv(recording: Path) -> Experiment:
    """Read the YAML file of the same stem beside a CSV: ``run.yaml`` of ``run.csv``, with ``conditions`` for instance.

    A file without ``conditions`` and ``format: lce-experiment-1`` is another one, a model of that name for example.
    """
    file = recording.with_suffix(".yaml")
    content = read_yaml(file) if file.exists() else None
    return experiment_of(content, file) if _is_experiment(content) else Experiment()


def holds_experiment(file: Path) -> bool:
    """Whether a YAML file holds what is known of a recording; one that cannot be read does not."""
    try:
        return _is_experiment(read_yaml(file))
    except LceError:
        return False


def _is_experiment(content: Any) -> TypeGuard[Mapping[str, Any]]:
    return isinstance(content, Mapping) and ("conditions" in content or content.get("format") == FORMAT)


def write_beside_csv(recording: Path, experiment: Experiment) -> None:
    """Write the YAML file of a CSV that `beside_csv` reads."""
    from lce_data.yaml_text import dump

    write_atomically(recording.with_suffix(".yaml"), dump({"format": FORMAT, **content_of(experiment)}))


def write(folder: Path, experiment: Experiment) -> None:
    """Write experiment.yaml into a bag folder."""
    from lce_data.yaml_text import dump

    write_atomically(folder / FILE_NAME, dump(content_of(experiment)))


def update(folder: Path, **entries: Any) -> None:
    """Set fields of the experiment.yaml of a bag folder. Raises LceError if it cannot be read."""
    write(folder, read(folder / FILE_NAME).with_entries(**entries))


def _sha256(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()


def now() -> str:
    """The present time, UTC, as in the file."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def _gathered(content: Mapping[Any, Any], kind: type[Table]) -> dict[str, Any]:
    """The content with the keys that a table does not know under ``other``, and without those that have no value."""
    known = {key: content[key] for key in kind.__struct_fields__ if key != "other" and content.get(key) is not None}
    other = {str(key): value for key, value in content.items() if key not in kind.__struct_fields__ or key == "other"}
    return {**known, "other": other}
