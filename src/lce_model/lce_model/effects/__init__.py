# SPDX-License-Identifier: Apache-2.0
"""The library of candidate physical effects: each one a term in a file of its own, found here by its name.

A file of this folder, or one of the user's, defines ``EFFECT = Effect(...)`` and nothing else has to be edited.
"""

import hashlib
import importlib
import pkgutil
import shlex
import sys
from collections.abc import Mapping
from dataclasses import InitVar, dataclass, replace
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Final

from lce_data.errors import LceError, did_you_mean
from lce_data.files import read_at_most
from lce_model.terms import Parameter, Term
from lce_model.trust import MOST_BYTES, UntrustedEffect, is_trusted

SMALL = 1e-4
"""Step size of the strength of a smooth effect, in parts of its range."""
_LOADED: Final[dict[Path, "Effect"]] = {}
"""Effects of the user's own that this process has run, by their resolved paths."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Effect(Term):
    """A term that may be missing: with its strength at the null value the model is the one without it, exactly.

    Attributes
    ----------
    title : what people call it; the name with spaces if a user's file gives none.
    meaning : what it does, in one line; the first line of the docstring if a user's file gives none.
    strength : name of the parameter that turns it on.
    null : its value at which nothing changes.
    acting_alone : other parameters that act even where the strength is at its null value, unless at their defaults.
    typical : a value at which the effect can be seen.
    grid : for each other parameter that the diagnosis has to try out, its values.
    in_durations : of those, the times whose values are shares of the duration of the longest recording.
    step_sizes : changes of the strength from its null value by which the diagnosis measures the effect. To be given
        for an effect without a derivative there, such as backlash; by default 1e-4 of the range of the strength.
    place : the effects of one stage act in rising order of it, then by name, in whatever order they were added.
    path : of the file, for an effect of the user's own.
    nudges : what ``step_sizes`` was called in effect files written for version 0.1.
    """

    title: str = ""
    meaning: str = ""
    strength: str
    null: float = 0.0
    acting_alone: tuple[str, ...] = ()
    typical: float
    grid: tuple[tuple[str, tuple[float, ...]], ...] = ()
    in_durations: tuple[str, ...] = ()
    step_sizes: tuple[float, ...] = ()
    place: int = 0
    path: str = ""
    nudges: InitVar[tuple[float, ...]] = ()

    def __post_init__(self, nudges: tuple[float, ...]) -> None:
        # super() does not work in a dataclass with slots.
        Term.__post_init__(self)
        names = [p.name for p in self.parameters]
        for name in (*self.amplitudes, *(key for key, _ in self.grid), *self.in_durations):
            if name not in names:
                raise LceError(
                    f"effect {self.name}: no parameter {name!r}{did_you_mean(name, names)}; it has {', '.join(names)}"
                )
        strength = self.parameter(self.strength)
        if strength.default != self.null:
            raise LceError(
                f"effect {self.name}: {self.strength} is {strength.default:g} by default, not at its null {self.null:g}"
            )
        strength.check(self.typical)
        for name, values in self.grid:
            for value in values:
                self.parameter(name).check(value)
        smooth = (SMALL * (strength.upper - self.null),)
        object.__setattr__(self, "step_sizes", self.step_sizes or nudges or smooth)

    def parameter(self, name: str) -> Parameter:
        """The parameter of that name."""
        return next(p for p in self.parameters if p.name == name)

    def grid_of(self, duration_s: float) -> dict[str, tuple[float, ...]]:
        """The grid for recordings of ``duration_s`` [s], each value in the unit of its parameter."""
        scale = dict.fromkeys(self.in_durations, duration_s)
        return {name: tuple(x * scale.get(name, 1.0) for x in values) for name, values in self.grid}

    @property
    def amplitudes(self) -> tuple[str, ...]:
        """Parameters each of which can turn it on: the strength, and those that act alone."""
        return self.strength, *self.acting_alone

    @property
    def at_default_only(self) -> tuple[str, ...]:
        """Parameters that the score test leaves at their defaults: free ones that do not act alone, without a grid."""
        tried = {*self.amplitudes, *(name for name, _ in self.grid)}
        return tuple(p.name for p in self.parameters if p.name not in tried and not p.fixed)

    def bounded(self, bounds: Mapping[str, tuple[float, float]]) -> "Effect":
        """A copy whose parameters of these names are searched between (lower, upper).

        Raises LceError if a parameter does not exist, or cannot have these bounds: the null value stays within them.
        """
        names = [p.name for p in self.parameters]
        for name in bounds:
            if name not in names:
                raise LceError(
                    f"effect {self.name}: no parameter {name!r}{did_you_mean(name, names)}; it has {', '.join(names)}"
                )
        parameters = tuple(p.bounded(*bounds[p.name]) if p.name in bounds else p for p in self.parameters)
        return replace(self, parameters=parameters)

    @property
    def idle_at(self) -> dict[str, float]:
        """The defaults of its parameters, with the strength at its null value."""
        return {p.name: p.default for p in self.parameters}

    @property
    def reference(self) -> str:
        """The text that stands for it in a model file: its name, or the path of the user's file."""
        return self.path or self.name

    @property
    def strength_key(self) -> str:
        """TERM.PARAM of the strength."""
        return f"{self.name}.{self.strength}"


@cache
def library() -> dict[str, Effect]:
    """All effects that come with the package, by name."""
    names = sorted(m.name for m in pkgutil.iter_modules(__path__))
    found = [_effect_of(importlib.import_module(f"{__name__}.{name}"), name) for name in names]
    return {effect.name: effect for effect in found}


def find(name: str) -> Effect:
    """An effect of the library by its name, or the user's own by the path of its file (``*.py``), which is run.

    The path has to be one that the user named, or that of a model that was loaded; see ``find_trusted`` for all others.
    Raises LceError if there is no such effect, naming those that there are, or if the file is wrong, saying how.
    """
    if name.endswith(".py"):
        return _from_file(Path(name).resolve())
    if name not in library():
        raise LceError(
            f"unknown effect {name!r}{did_you_mean(name, library())}; known: {', '.join(library())}, or a file of "
            "yours, ./my_effect.py"
        )
    return library()[name]


def find_trusted(path: Path) -> Effect:
    """The effect of a file that nobody named, because a model file lists it.

    Raises UntrustedEffect, and does not run the file, unless this process ran it before or its content is trusted.
    """
    return _from_file(path.resolve(), named=False)


def _from_file(path: Path, named: bool = True) -> Effect:
    if path in _LOADED:
        return _LOADED[path]
    if not path.exists():
        raise LceError(f"{path}: no such effect file")
    content = read_at_most(path, MOST_BYTES)
    digest = hashlib.sha256(content).hexdigest()
    if not (named or is_trusted(digest)):
        raise UntrustedEffect(
            f"{path} is a program that was not run: read it, then trust it (lce trust {shlex.quote(str(path))}) "
            "or name it in this command (--effect-file)"
        )
    _LOADED[path] = _run(path, content, digest)
    return _LOADED[path]


def _run(path: Path, content: bytes, digest: str) -> Effect:
    """The effect of a file with this content: exactly these bytes run, not what lies in ``__pycache__`` beside it."""
    # A kernel in the cache names the modules of its functions: the same text has the same name, wherever it lies.
    module = ModuleType(f"lce_effect_{digest[:16]}")
    module.__file__ = str(path)
    sys.modules[module.__name__] = module
    try:
        exec(compile(content, path, "exec", dont_inherit=True), module.__dict__)
        return replace(_effect_of(module, str(path)), path=str(path))
    except LceError as error:
        raise LceError(str(error) if str(path) in str(error) else f"{path}: {error}") from None
    # A user's file may raise anything, SystemExit as well; the user reads one line that says where and what.
    except (Exception, SystemExit) as error:
        raise LceError(f"{path}: cannot be loaded: {type(error).__name__}: {error}") from error


def _effect_of(module: ModuleType, where: str) -> Effect:
    effect = getattr(module, "EFFECT", None)
    if not isinstance(effect, Effect):
        raise LceError(f"{where}: defines no EFFECT = Effect(...)")
    first_line = (module.__doc__ or effect.equation).strip().partition("\n")[0].rstrip(".")
    title = effect.title or effect.name.replace("_", " ")
    return replace(effect, title=title, meaning=effect.meaning or first_line)
