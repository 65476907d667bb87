# SPDX-License-Identifier: Apache-2.0
"""From a tuple of terms to one compiled loop.

numba compiles the generated modules (:mod:`lce_model.kernel.generate`) once and keeps them in a cache folder:
``$LCE_CACHE_DIR``, else ``$XDG_CACHE_HOME/lce``, else ``~/.cache/lce``. The name of the cached file is a hash of
everything that went into it, so a changed term is compiled anew.
"""

import hashlib
import importlib.util
import inspect
import os
import re
import sys
import tempfile
import threading
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from types import ModuleType
from typing import Any, Final

import numba
import numpy as np
from numba import float64
from numba.core.errors import NumbaError
from numba.core.types import Number

from lce_data.channels import Channel
from lce_data.errors import LceError
from lce_model.kernel.generate import source_of_runs, source_of_steps, state_size
from lce_model.terms import SIGNALS, Term, inputs_of


@dataclass(frozen=True)
class Kernel:
    """The compiled functions of one tuple of terms, each compiled when it is first asked for.

    run(time_s, power_w, drive_k, u, start_k, deadband_k, p, out) fills ``out`` (n, len(RECORDED)); a ``drive_k`` of
    length n replaces the thermal stage, one of length 0 leaves it in place; ``u`` (n, len(inputs)) are the optional
    inputs at the times, NaN where they are not known; a ``start_k`` of NaN is the temperature of the surroundings.
    run_many(…, P, out) does the same for parameter rows P (m, k) into out (m, n, len(RECORDED)).
    begin(start_k, deadband_k, u, p, state), advance(power_w, dt_s, u, p, state) step a state vector kept by the
    caller, with the inputs ``u`` (len(inputs),) at the end of the step; its first entries are the signals, in the order
    of SIGNALS.

    Asking for a function raises LceError if a term cannot be compiled, and names the file and the function.
    """

    terms: tuple[Term, ...]

    @cached_property
    def state_size(self) -> int:
        """Length of the state vector."""
        return state_size(self.terms)

    @cached_property
    def inputs(self) -> tuple[Channel, ...]:
        """The optional inputs that the terms read."""
        return inputs_of(self.terms)

    @cached_property
    def _of_runs(self) -> tuple[Callable[..., None], Callable[..., None]]:
        module = _compiled(self.terms, source_of_runs(self.terms))
        return module.run, module.run_many

    @cached_property
    def _of_steps(self) -> tuple[Callable[..., None], Callable[..., None]]:
        module = _compiled(self.terms, source_of_steps(self.terms))
        return module.begin, module.advance

    @property
    def run(self) -> Callable[..., None]:
        """A whole run of one row of parameters."""
        return self._of_runs[0]

    @property
    def run_many(self) -> Callable[..., None]:
        """A whole run of many rows of parameters."""
        return self._of_runs[1]

    @property
    def begin(self) -> Callable[..., None]:
        """The beginning of a strip that is stepped."""
        return self._of_steps[0]

    @property
    def advance(self) -> Callable[..., None]:
        """A step of it."""
        return self._of_steps[1]


SIGNAL_INDEX: Final[dict[str, int]] = {name: i for i, name in enumerate(SIGNALS)}
_COMPILING: Final = threading.Lock()
_COLOUR: Final = re.compile(r"\x1b\[[0-9;]*m")
"""Numba colours its messages where colorama is installed."""


def cache_folder() -> Path:
    """Where compiled kernels are kept."""
    if chosen := os.environ.get("LCE_CACHE_DIR"):
        return Path(chosen) / "kernels"
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "lce" / "kernels"


def _fingerprint(terms: tuple[Term, ...], text: str) -> str:
    """Hash of everything that goes into the compiled code: the terms' files and what they may call in this package."""
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
    """What is wrong with the first of these terms that does not compile by itself; empty if each of them does."""
    for term in terms:
        arrays = {**dict(term.arrays), **dict(term.vectors)}
        for kind, function in term.functions.items():
            where = f"{inspect.getfile(function)}: {kind}"
            compiled = numba.njit(error_model="numpy")(function)
            try:
                compiled.compile(
                    tuple(float64[::1] if a in arrays else float64 for a in inspect.signature(function).parameters)
                )
            except NumbaError as error:
                plain = _COLOUR.sub("", str(error))
                told = (line for line in plain.splitlines() if not line.startswith(("Failed in", "During:")))
                return f"{where} cannot be compiled: {next(told, plain)}"
            given = compiled.nopython_signatures[0].return_type
            wanted = (*term.states, *term.outputs)
            values = getattr(given, "types", (given,))
            if len(values) != len(wanted) or not all(isinstance(v, Number) for v in values):
                return f"{where} returns {given}, but has to return a number each for {', '.join(wanted)}"
    return ""


@cache
def _jitted(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function as a kernel calls it; numba compiles it once in a process, however many kernels do."""
    compiled: Callable[..., Any] = numba.njit(error_model="numpy")(function)
    return compiled


def _compiled(terms: tuple[Term, ...], text: str) -> ModuleType:
    """The module of this text, compiled, or loaded as an earlier process compiled it.

    Of threads that ask for it at once, the first compiles it. Raises LceError if a term cannot be compiled, naming its
    file and its function.
    """
    with _COMPILING:
        return _compiled_once(terms, text)


@cache
def _compiled_once(terms: tuple[Term, ...], text: str) -> ModuleType:
    folder = cache_folder()
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"k{_fingerprint(terms, text)}.py"
    if not path.exists():
        with tempfile.NamedTemporaryFile("w", dir=folder, suffix=".tmp", delete=False, encoding="utf-8") as new:
            new.write(text)
        Path(new.name).replace(path)
    names: dict[str, Any] = {"NAN": np.nan, "STATE_SIZE": state_size(terms), "empty": np.empty}
    names |= {f"{term.name}_{kind}": _jitted(function) for term in terms for kind, function in term.functions.items()}
    try:
        return _import_generated(path, names)
    except NumbaError as error:
        raise LceError(_mistake(terms) or str(error)) from None


@cache
def kernel_of(terms: tuple[Term, ...]) -> Kernel:
    """The kernel of the terms, the same one for all models of them."""
    return Kernel(terms)
