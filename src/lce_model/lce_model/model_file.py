# SPDX-License-Identifier: Apache-2.0
"""Model files: one YAML file a model, made to be edited by hand and compared by diff."""

import math
import os
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Final

import msgspec
import yaml
from msgspec import UNSET, Meta, Struct, UnsetType

from lce_data.errors import LceError, did_you_mean
from lce_data.files import write_atomically
from lce_data.schema import checked, read_yaml
from lce_data.yaml_text import Dumper
from lce_model.effects import find_trusted
from lce_model.model import Model, Value, default_model
from lce_model.trust import UntrustedEffect
from lce_model.variation import RunValue, Variation

FORMAT: Final = "lce-model-1"


class ParameterEntry(Struct, frozen=True, forbid_unknown_fields=True):
    """A parameter in the file. What is left out keeps the default of the parameter.

    ``unit`` has to be the unit of the parameter: it guards against a value in another one. ``standard_error`` and
    ``determined`` are written after a fit.
    """

    value: float
    unit: str | None = None
    bounds: list[float] | UnsetType = UNSET
    fixed: bool | UnsetType = UNSET
    standard_error: float | UnsetType | None = UNSET
    determined: bool | UnsetType | None = UNSET


class RunValueEntry(Struct, frozen=True, forbid_unknown_fields=True):
    """The value of a parameter in one run, in the unit of the parameter."""

    value: float
    standard_error: float | None = None


class VariationEntry(Struct, frozen=True, forbid_unknown_fields=True):
    """How a parameter differs from run to run, in the unit of the parameter."""

    unit: str | None = None
    spread: Annotated[float, Meta(ge=0)] | None = None
    runs: dict[str, RunValueEntry] = {}


class ModelFile(Struct, frozen=True, forbid_unknown_fields=True):
    """The content of a model file: what is read is checked against it, and it is what is written.

    Attributes
    ----------
    effects : names, or paths of files of the user's own as seen from the model file.
    parameters : by term and name; those left out have their defaults.
    varies : by TERM.PARAM, what differs from run to run.
    fit : record of the identification, in any form.
    """

    format: str
    thermal: str = "none"
    deformation: str = "none"
    effects: list[str] | None = None
    parameters: dict[str, dict[str, ParameterEntry] | None] | None = None
    varies: dict[str, VariationEntry | None] | UnsetType | None = UNSET
    fit: dict[str, Any] | UnsetType | None = UNSET


def load_model(path: str | os.PathLike[str]) -> Model:
    """Read a model file.

    Parameters
    ----------
    path : the YAML file. It finds effect files of the user's own in its folder or below it, or by their whole paths.
        They run only if their content is trusted (:mod:`lce_model.trust`), or if this process ran them before.

    Returns
    -------
    Model
        Parameters that the file leaves out have their default values.

    Raises
    ------
    LceError
        If the file cannot be read, or has an unknown key, a unit that does not fit or a value outside its bounds;
        names the file, the key and the value.
    UntrustedEffect
        If an effect file is not trusted; it was not run.

    Examples
    --------
    >>> load_model("strip.yaml")["lumped.tau"]  # doctest: +SKIP
    18.0
    """
    path = Path(path)
    content = read_yaml(path)
    if isinstance(content, dict):
        _only(content, ModelFile.__struct_fields__, f"{path}: the file")
    file = checked(path, content, ModelFile)
    try:
        return _model(file, path.parent)
    except LceError as error:
        kind = UntrustedEffect if isinstance(error, UntrustedEffect) else LceError
        raise kind(f"{path}: {error}") from None


def save_model(model: Model, path: str | os.PathLike[str]) -> None:
    """Write a model file; a file that stood there is replaced in one step, never left half-written.

    Parameters
    ----------
    model : it reads back as it is. Effect files of the user's own are listed by their path from the model file, or by
        their whole path if they lie elsewhere than in its folder.
    path : the YAML file.

    Raises
    ------
    LceError
        If the file cannot be written.

    Examples
    --------
    >>> save_model(default_model(), "strip.yaml")  # doctest: +SKIP
    """
    path = Path(path)
    document = msgspec.to_builtins(_content(model, path.resolve().parent))
    for group in document["parameters"].values():
        for name, entry in group.items():
            group[name] = _Line(entry)
    for variation in document.get("varies", {}).values():
        variation["runs"] = {name: _Line(entry) for name, entry in variation["runs"].items()}
    write_atomically(path, yaml.dump(document, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=120))


def _content(model: Model, folder: Path) -> ModelFile:
    parameters: dict[str, dict[str, ParameterEntry] | None] = {v.term: {} for v in model.values}
    for v in model.values:
        group = parameters[v.term]
        assert group is not None
        group[v.name] = _entry(v)
    return ModelFile(
        format=FORMAT,
        thermal=model.thermal,
        deformation=model.deformation,
        effects=[_listed(e, folder) for e in model.effects],
        parameters=parameters,
        varies={key: _variation_entry(model, key) for key in model.varies} or UNSET,
        fit=_plain(model.fit) if model.fit else UNSET,
    )


def _listed(effect: str, folder: Path) -> str:
    """An effect as the model file of a folder lists it."""
    path = Path(effect)
    inside = effect.endswith(".py") and path.is_relative_to(folder)
    return str(path.relative_to(folder)) if inside else effect


def _reference(effect: str, folder: Path) -> str:
    """An effect that the model file of a folder lists: its file is run here, if it may, and never by this name alone.

    Raises LceError if it leaves the folder other than by a whole path, and UntrustedEffect if it may not run.
    """
    if not effect.endswith(".py"):
        return effect
    if not Path(effect).is_absolute() and ".." in Path(effect).parts:
        raise LceError(f"effects: {effect} lies outside the folder of the model file; name it by its whole path")
    try:
        return find_trusted(folder / effect).reference
    except UntrustedEffect as error:
        raise UntrustedEffect(f"effects: {error}") from None


def _entry(v: Value) -> ParameterEntry:
    fitted = v.determined is not None
    error = None if v.standard_error is None else float(v.standard_error)
    return ParameterEntry(
        value=float(v.value),
        unit=v.unit,
        bounds=[float(v.lower), float(v.upper)],
        fixed=v.fixed if v.fixed or v.parameter.fixed else UNSET,
        standard_error=error if fitted else UNSET,
        determined=v.determined if fitted else UNSET,
    )


def _variation_entry(model: Model, key: str) -> VariationEntry:
    variation = model.varies[key]
    runs = {
        name: RunValueEntry(float(own.value), None if own.standard_error is None else float(own.standard_error))
        for name, own in variation.by_run.items()
    }
    spread = None if variation.spread is None else float(variation.spread)
    return VariationEntry(model.values[model.index(key)].unit, spread, runs)


def _model(content: ModelFile, folder: Path) -> Model:
    if content.format != FORMAT:
        raise LceError(f"format: {content.format!r} is not {FORMAT!r}")
    effects = tuple(_reference(effect, folder) for effect in content.effects or ())
    model = default_model(content.thermal, content.deformation, effects)
    groups = content.parameters or {}
    _only(groups, dict.fromkeys(v.term for v in model.values), "parameters")
    values = []
    for v in model.values:
        group = groups.get(v.term) or {}
        _only(group, [w.name for w in model.values if w.term == v.term], f"parameters.{v.term}")
        values.append(_value(v, group[v.name]) if v.name in group else v)
    model = model.with_values(tuple(values), content.fit or {})
    return model.varying({key: _variation(model, key, entry) for key, entry in (content.varies or {}).items()})


def _variation(model: Model, key: str, entry: VariationEntry | None) -> Variation:
    unit = model.values[model.index(key)].unit
    if entry is None:
        return Variation()
    if entry.unit != unit:
        raise LceError(f"varies.{key}.unit: {entry.unit!r} does not fit; this parameter is in {unit!r}")
    return Variation(entry.spread, {name: RunValue(own.value, own.standard_error) for name, own in entry.runs.items()})


def _value(default: Value, entry: ParameterEntry) -> Value:
    where = f"parameters.{default.key}"
    if entry.unit != default.unit:
        raise LceError(f"{where}.unit: {entry.unit!r} does not fit; this parameter is in {default.unit!r}")
    bounds = [default.lower, default.upper] if entry.bounds is UNSET else entry.bounds
    if len(bounds) != 2:
        raise LceError(f"{where}.bounds: {bounds!r} is not [lower, upper]")
    error = None if entry.standard_error is UNSET else entry.standard_error
    for key, numbers in (("value", [entry.value]), ("bounds", bounds), ("standard_error", [error or 0.0])):
        for number in numbers:
            if not math.isfinite(number):
                raise LceError(f"{where}.{key}: {number!r} is not a finite number")
    return replace(
        default,
        value=entry.value,
        lower=bounds[0],
        upper=bounds[1],
        fixed=default.fixed if entry.fixed is UNSET else entry.fixed,
        standard_error=error,
        determined=None if entry.determined is UNSET else entry.determined,
    )


def _only(found: Iterable[str], known: Iterable[str], where: str) -> None:
    known = tuple(known)
    for key in found:
        if key not in known:
            raise LceError(f"{where}: unknown key {key!r}{did_you_mean(str(key), known)}; known: {', '.join(known)}")


def _plain(value: Any) -> Any:
    """Mappings and sequences of any kind as the dicts and lists that YAML writes."""
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    return value


class _Dumper(Dumper):
    """Block style for the file, one line for each parameter."""


class _Line(dict[str, Any]):
    """A mapping that is written on one line."""


def _number(x: float) -> str:
    """Shortest text that reads back to the same float, in a form that YAML takes for a float."""
    if not math.isfinite(x):
        return ".nan" if math.isnan(x) else ".inf" if x > 0 else "-.inf"
    text = repr(x)
    return text.replace("e", ".0e") if "e" in text and "." not in text else text


_Dumper.add_representer(_Line, lambda d, data: d.represent_mapping("tag:yaml.org,2002:map", data, flow_style=True))
_Dumper.add_representer(float, lambda d, x: d.represent_scalar("tag:yaml.org,2002:float", _number(x)))
