# SPDX-License-Identifier: Apache-2.0
"""From a tuple of terms to one compiled loop.

The terms' ``step`` functions are called in order, each argument bound by name, from a generated function that numba
compiles once and keeps in a cache folder: ``$LCE_CACHE_DIR``, else ``$XDG_CACHE_HOME/lce``, else ``~/.cache/lce``. The
name of the cached file is a hash of everything that went into it, so a changed term is compiled anew.
"""

import hashlib
import importlib.util
import inspect
import os
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any, Final

import numba
import numpy as np
from numba import float64
from numba.core.errors import NumbaError
from numba.core.types import Number

from lce_data.errors import LceError
from lce_model.terms import SENSOR_INPUT, SIGNALS, Stage, Term

AT_STAGE: Final[dict[Stage, tuple[str, ...]]] = {
    "surroundings": ("ambient = temperature",),
    "light": ("light = power",),
    "heat": (
        "temperature_before = temperature",
        "temperature_midway = temperature + 0.5 * dt * warming",
        "heating = 0.0",
        "heat_capacity = 1.0",
    ),
    "order": (
        "warming = (temperature - temperature_before) / dt if dt > 0.0 else warming",
        "order_temperature = temperature",
        "transition_spread = 0.0",
    ),
    "strain": ("order = fraction * well_order",),
    "sensor": tuple(f"{output} = {measured or 'NAN'}" for output, measured in SENSOR_INPUT.items()),
}
"""The value of each signal before the terms of a stage change it."""

RECORDED: Final[tuple[str, ...]] = ("temperature", "displacement", "order", "direction", *SENSOR_INPUT)
"""The signals that a simulation returns, in the order of their columns."""


@dataclass(frozen=True)
class Kernel:
    """The compiled functions of one tuple of terms.

    run(time_s, power_w, drive_k, start_k, deadband_k, p, out) fills ``out`` (n, len(RECORDED)); a ``drive_k`` of
    length n replaces the thermal stage, one of length 0 leaves it in place.
    run_many(…, P, out) does the same for parameter rows P (m, k) into out (m, n, len(RECORDED)).
    begin(start_k, deadband_k, p, state), advance(power_w, dt_s, p, state) step a state vector kept by the caller; its
    first entries are the signals, in the order of SIGNALS.
    """

    run: Callable[..., None]
    run_many: Callable[..., None]
    begin: Callable[..., None]
    advance: Callable[..., None]
    state_size: int


SIGNAL_INDEX: Final[dict[str, int]] = {name: i for i, name in enumerate(SIGNALS)}


def _call(term: Term, initial: bool) -> list[str]:
    """Generated code: results = function(arguments).

    The call is skipped at run time while the term is idle, unless the term alone says what a sensor reports.
    """
    kind = "start" if initial and term.start is not None else "step"
    names = [*(p.name for p in term.parameters), *term.states, *dict(term.arrays), *dict(term.vectors)]
    own = {name: f"{term.name}__{name}" for name in names}
    arguments = ", ".join(own.get(a, a) for a in inspect.signature(getattr(term, kind)).parameters)
    targets = ", ".join([own[s] for s in term.states] + list(term.outputs))
    call = f"{targets} = {term.name}_{kind}({arguments})"
    if initial or not term.idle_at or any(SENSOR_INPUT.get(name, name) is None for name in term.outputs):
        return [call]
    return [f"if {' or '.join(f'{own[name]} != {value!r}' for name, value in term.idle_at.items())}:", f"    {call}"]


def _body(terms: tuple[Term, ...], initial: bool) -> list[str]:
    lines: list[str] = []
    for stage, defaults in AT_STAGE.items():
        lines += defaults
        members = [t for t in terms if t.stage == stage]
        if stage == "heat" and initial:
            # The strip starts at the temperature given, whatever the heat balance says of it.
            members = [t for t in members if t.start is not None]
        calls = [line for t in members for line in _call(t, initial)]
        if stage == "heat" and not initial:
            calls = ["if forced:", "    temperature = drive_next", "else:", *(f"    {c}" for c in calls or ["pass"])]
        lines += calls
    return lines


def source(terms: tuple[Term, ...]) -> str:
    """The generated module, as text."""
    parameters = [f"{t.name}__{p.name}" for t in terms for p in t.parameters]
    states = [*SIGNALS, *(f"{t.name}__{s}" for t in terms for s in t.states)]
    unpack_p = "".join(f"    {name} = p[{i}]\n" for i, name in enumerate(parameters))
    for name, size in ((f"{t.name}__{v}", size) for t in terms for v, size in t.vectors):
        first = parameters.index(f"{name}_1")
        unpack_p += f"    {name} = p[{first}:{first + size}]\n"
    load = "".join(f"    {name} = s[{i}]\n" for i, name in enumerate(states))
    begin = len(states)
    for name, size in ((f"{t.name}__{a}", size) for t in terms for a, size in t.arrays):
        load += f"    {name} = s[{begin}:{begin + size}]\n"
        begin += size
    store = "".join(f"    s[{i}] = {name}\n" for i, name in enumerate(states))

    def indent(lines: list[str]) -> str:
        return "".join(f"    {line}\n" for line in lines)

    record = "".join(f"    out[{{i}}, {j}] = {name}\n" for j, name in enumerate(RECORDED))
    step = _body(terms, initial=False)
    return f"""# generated by lce_model.kernel.compose from: {", ".join(t.name for t in terms)}
from numba import njit


@njit("void(f8, f8, f8[::1], f8[::1])", nogil=True, cache=True, error_model="numpy")
def begin(start_k, deadband_k, p, s):
{unpack_p}    s[:] = NAN
{load}    temperature = start_k
    deadband = deadband_k
    dt = power = warming = 0.0
    fraction = 1.0
{indent(_body(terms, initial=True))}{store}

@njit("void(f8, f8, f8[::1], f8[::1])", nogil=True, cache=True, error_model="numpy")
def advance(power_w, dt, p, s):
{unpack_p}{load}    power = power_w
    forced, drive_next = False, 0.0
{indent(step)}{store}

@njit("void(f8[::1], f8[::1], f8[::1], f8, f8, f8[::1], f8[:, ::1])", nogil=True, cache=True, error_model="numpy")
def run(time_s, power_w, drive_k, start_k, deadband_k, p, out):
    s = empty(STATE_SIZE)
    forced = drive_k.size > 0
    begin(drive_k[0] if forced else start_k, deadband_k, p, s)
{unpack_p}{load}{record.format(i=0)}    for i in range(1, time_s.size):
        power = power_w[i - 1]
        dt = time_s[i] - time_s[i - 1]
        drive_next = drive_k[i] if forced else 0.0
{indent(indent(step).splitlines())}{indent(record.format(i="i").splitlines())}

@njit("void(f8[::1], f8[::1], f8[::1], f8[::1], f8, f8[:, ::1], f8[:, :, ::1])", nogil=True, cache=True)
def run_many(time_s, power_w, drive_k, start_k, deadband_k, p, out):
    for j in range(p.shape[0]):
        run(time_s, power_w, drive_k, start_k[j], deadband_k, p[j], out[j])
"""


def cache_folder() -> Path:
    """Where compiled kernels are kept."""
    if chosen := os.environ.get("LCE_CACHE_DIR"):
        return Path(chosen) / "kernels"
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "lce" / "kernels"


def _fingerprint(terms: tuple[Term, ...], text: str) -> str:
    """Of everything that goes into the compiled code: the terms' own files, and what they may call in this package."""
    modules = {Path(inspect.getfile(t.step)) for t in terms} | set(Path(__file__).parents[1].rglob("*.py"))
    parts = [text, numba.__version__, np.__version__, sys.version, *(m.read_text("utf-8") for m in sorted(modules))]
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:20]


def _import_generated(path: Path, names: dict[str, Any]) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"lce_kernel_{path.stem}", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    module.__dict__.update(names)
    # numba looks the module up by its name when it loads a compiled function.
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def _mistake(terms: tuple[Term, ...]) -> str:
    """Of terms that do not compile together, the first that is wrong in itself, and what is wrong with it."""
    for term in terms:
        arrays = {**dict(term.arrays), **dict(term.vectors)}
        for function in (term.start, term.step):
            if function is None:
                continue
            where = f"{inspect.getfile(function)}: {function.__name__}"
            compiled = numba.njit(error_model="numpy")(function)
            try:
                compiled.compile(
                    tuple(float64[::1] if a in arrays else float64 for a in inspect.signature(function).parameters)
                )
            except NumbaError as error:
                told = (line for line in str(error).splitlines() if not line.startswith(("Failed in", "During:")))
                return f"{where} cannot be compiled: {next(told, error)}"
            given = compiled.nopython_signatures[0].return_type
            wanted = (*term.states, *term.outputs)
            values = getattr(given, "types", (given,))
            if len(values) != len(wanted) or not all(isinstance(v, Number) for v in values):
                return f"{where} returns {given}, but has to return a number each for {', '.join(wanted)}"
    return ""


@cache
def compile_terms(terms: tuple[Term, ...]) -> Kernel:
    """Compile the terms, or load what an earlier process compiled."""
    text = source(terms)
    size = len(SIGNALS) + sum(len(t.states) + sum(n for _, n in t.arrays) for t in terms)
    folder = cache_folder()
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"k{_fingerprint(terms, text)}.py"
    if not path.exists():
        with tempfile.NamedTemporaryFile("w", dir=folder, suffix=".tmp", delete=False, encoding="utf-8") as new:
            new.write(text)
        Path(new.name).replace(path)
    names: dict[str, Any] = {"NAN": np.nan, "STATE_SIZE": size, "empty": np.empty}
    for term in terms:
        names[f"{term.name}_step"] = numba.njit(error_model="numpy")(term.step)
        if term.start is not None:
            names[f"{term.name}_start"] = numba.njit(error_model="numpy")(term.start)
    try:
        module = _import_generated(path, names)
    except NumbaError as error:
        raise LceError(_mistake(terms) or str(error)) from None
    return Kernel(module.run, module.run_many, module.begin, module.advance, size)
