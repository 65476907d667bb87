# SPDX-License-Identifier: Apache-2.0
"""Model files: one YAML file a model, made to be edited by hand and compared by diff."""

import math
import os
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import yaml

from lce_data.errors import LceError
from lce_data.files import write_atomically
from lce_model.model import Model, Value, default_model

FORMAT: Final = "lce-model-1"
_TOP: Final = ("format", "thermal", "deformation", "effects", "parameters", "fit")
_ENTRY: Final = ("value", "unit", "bounds", "fixed", "standard_error", "determined")


def load_model(path: str | os.PathLike[str]) -> Model:
    """Read a model file; LceError names the file, the key and the value that do not fit."""
    path = Path(path)
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise LceError(f"{path}: cannot be read ({error.strerror})") from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        where = getattr(error, "problem_mark", None)
        line = f", line {where.line + 1}" if where else ""
        raise LceError(f"{path}{line}: not a YAML file") from None
    try:
        return _model(_mapping(content, "the file"), path.parent)
    except LceError as error:
        raise LceError(f"{path}: {error}") from None


def save_model(model: Model, path: str | os.PathLike[str]) -> None:
    """Write a model file; a file that stood there is replaced in one step, never left half-written.

    Effect files of the user's own are listed by their path from the model file, which finds them there.
    """
    path = Path(path)
    document = _document(model, path.resolve().parent)
    write_atomically(path, yaml.dump(document, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=120))


class _Dumper(yaml.SafeDumper):
    """Block style for the file, one line for each parameter."""


class _Line(dict[str, Any]):
    """A mapping that is written on one line."""


_Dumper.add_representer(_Line, lambda d, data: d.represent_mapping("tag:yaml.org,2002:map", data, flow_style=True))
_Dumper.add_representer(float, lambda d, x: d.represent_scalar("tag:yaml.org,2002:float", _number(x)))


def _number(x: float) -> str:
    """Shortest text that reads back to the same float, in a form that YAML takes for a float."""
    if not math.isfinite(x):
        return ".nan" if math.isnan(x) else ".inf" if x > 0 else "-.inf"
    text = repr(x)
    return text.replace("e", ".0e") if "e" in text and "." not in text else text


def _document(model: Model, folder: Path) -> dict[str, Any]:
    parameters: dict[str, dict[str, _Line]] = {}
    for v in model.values:
        entry = _Line(value=float(v.value), unit=v.unit, bounds=[float(v.lower), float(v.upper)])
        if v.fixed or v.parameter.fixed:
            entry["fixed"] = v.fixed
        if v.determined is not None:
            entry["standard_error"] = None if v.standard_error is None else float(v.standard_error)
            entry["determined"] = v.determined
        parameters.setdefault(v.term, {})[v.name] = entry
    document: dict[str, Any] = {
        "format": FORMAT,
        "thermal": model.thermal,
        "deformation": model.deformation,
        "effects": [os.path.relpath(e, folder) if e.endswith(".py") else e for e in model.effects],
        "parameters": parameters,
    }
    return document | ({"fit": _plain(model.fit)} if model.fit else {})


def _plain(value: Any) -> Any:
    """Mappings and sequences of any kind as the dicts and lists that YAML writes."""
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    return value


def _mapping(value: Any, where: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise LceError(f"{where}: expected keys and values, found {type(value).__name__}")
    return value


def _only(found: Iterable[str], known: Iterable[str], where: str) -> None:
    known = tuple(known)
    for key in found:
        if key not in known:
            raise LceError(f"{where}: unknown key {key!r}; known: {', '.join(known)}")


def _model(content: dict[str, Any], folder: Path) -> Model:
    _only(content, _TOP, "the file")
    if content.get("format") != FORMAT:
        raise LceError(f"format: {content.get('format')!r} is not {FORMAT!r}")
    effects = content.get("effects") or []
    if not isinstance(effects, list) or not all(isinstance(e, str) for e in effects):
        raise LceError(f"effects: {effects!r} is not a list of names")
    found = tuple(str(folder / e) if e.endswith(".py") else e for e in effects)
    model = default_model(str(content.get("thermal", "none")), str(content.get("deformation", "none")), found)
    given = _mapping(content.get("parameters") or {}, "parameters")
    _only(given, dict.fromkeys(v.term for v in model.values), "parameters")
    values = []
    for v in model.values:
        group = _mapping(given.get(v.term) or {}, f"parameters.{v.term}")
        _only(group, [w.name for w in model.values if w.term == v.term], f"parameters.{v.term}")
        values.append(_value(v, group[v.name]) if v.name in group else v)
    return model.with_values(tuple(values), _mapping(content.get("fit") or {}, "fit"))


def _value(default: Value, entry: Any) -> Value:
    where = f"parameters.{default.key}"
    entry = _mapping(entry, where)
    _only(entry, _ENTRY, where)
    if "value" not in entry:
        raise LceError(f"{where}: no value")
    if (unit := entry.get("unit")) != default.unit:
        raise LceError(f"{where}.unit: {unit!r} does not fit; this parameter is in {default.unit!r}")
    bounds = entry.get("bounds", [default.lower, default.upper])
    if not isinstance(bounds, list) or len(bounds) != 2:
        raise LceError(f"{where}.bounds: {bounds!r} is not [lower, upper]")
    error = entry.get("standard_error")
    return replace(
        default,
        value=_float(entry["value"], f"{where}.value"),
        lower=_float(bounds[0], f"{where}.bounds"),
        upper=_float(bounds[1], f"{where}.bounds"),
        fixed=_flag(entry.get("fixed", default.fixed), f"{where}.fixed"),
        standard_error=None if error is None else _float(error, f"{where}.standard_error"),
        determined=None if entry.get("determined") is None else _flag(entry["determined"], f"{where}.determined"),
    )


def _float(value: Any, where: str) -> float:
    # YAML 1.1 reads 1e-22 as text; people write it all the same.
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise LceError(f"{where}: {value!r} is not a number") from None
    if isinstance(value, bool) or not math.isfinite(number):
        raise LceError(f"{where}: {value!r} is not a finite number")
    return number


def _flag(value: Any, where: str) -> bool:
    if not isinstance(value, bool):
        raise LceError(f"{where}: {value!r} is not true or false")
    return value
