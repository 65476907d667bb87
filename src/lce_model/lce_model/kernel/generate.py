# SPDX-License-Identifier: Apache-2.0
"""From a tuple of terms to the text of a Python module that calls them in order, step by step.

Every signal, parameter and state becomes a local variable: a signal by its name, what belongs to a term as TERM__NAME.
A term's ``step`` is bound by the names of its arguments. :mod:`lce_model.kernel.compose` compiles the module.
"""

import inspect
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

from lce_model.terms import SENSOR_INPUT, SIGNALS, Stage, Term, inputs_of

AT_STAGE: Final[dict[Stage, tuple[str, ...]]] = {
    "surroundings": ("elapsed_time = elapsed_time + dt", "ambient = temperature"),
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

_VECTOR, _MATRIX, _CUBE = "f8[::1]", "f8[:, ::1]", "f8[:, :, ::1]"


class _Code:
    """Lines of Python, indented by the blocks that they stand in."""

    def __init__(self, *lines: str) -> None:
        self._lines = list(lines)
        self._indent = ""

    def add(self, *lines: str) -> None:
        self._lines += [self._indent + line for line in lines]

    @contextmanager
    def block(self, head: str) -> Iterator[None]:
        self.add(head)
        self._indent += "    "
        yield
        self._indent = self._indent[:-4]

    @contextmanager
    def function(self, name: str, arguments: dict[str, str], options: str = ', error_model="numpy"') -> Iterator[None]:
        """A compiled function; ``arguments`` are numba's types by name."""
        self.add("", "", f'@njit("void({", ".join(arguments.values())})", nogil=True, cache=True{options})')
        with self.block(f"def {name}({', '.join(arguments)}):"):
            yield

    def __str__(self) -> str:
        return "\n".join([*self._lines, ""])


def state_size(terms: tuple[Term, ...]) -> int:
    """Length of the state vector ``s``: the signals, then the states of the terms, then their arrays."""
    return len(SIGNALS) + sum(len(t.states) + sum(size for _, size in t.arrays) for t in terms)


def source_of_runs(terms: tuple[Term, ...]) -> str:
    """Text of the module with ``run`` and ``run_many`` of :class:`lce_model.kernel.compose.Kernel`."""
    code = _begun(terms)
    series = {"time_s": _VECTOR, "power_w": _VECTOR, "drive_k": _VECTOR, "u": _MATRIX}
    with code.function("run", {**series, "start_k": "f8", "deadband_k": "f8", "p": _VECTOR, "out": _MATRIX}):
        code.add("s = empty(STATE_SIZE)", "forced = drive_k.size > 0")
        code.add("begin(drive_k[0] if forced else start_k, deadband_k, u[0], p, s)")
        code.add(*_unpack_parameters(terms), *_load_states(terms), *_record("0"))
        with code.block("for i in range(1, time_s.size):"):
            code.add("power = power_w[i - 1]", "dt = time_s[i] - time_s[i - 1]", *_inputs(terms, "u[i, {}]"))
            code.add("drive_next = drive_k[i] if forced else 0.0", *_stages(terms, initial=False), *_record("i"))

    many = {**series, "start_k": _VECTOR, "deadband_k": "f8", "p": _MATRIX, "out": _CUBE}
    with code.function("run_many", many, options=""), code.block("for j in range(p.shape[0]):"):
        code.add("run(time_s, power_w, drive_k, u, start_k[j], deadband_k, p[j], out[j])")
    return str(code)


def source_of_steps(terms: tuple[Term, ...]) -> str:
    """Text of the module with ``begin`` and ``advance`` of :class:`lce_model.kernel.compose.Kernel`.

    Of the heat balance alone, ``terms("lumped", "none")``, ``advance`` is, shortened::

        @njit("void(f8, f8, f8[::1], f8[::1], f8[::1])", nogil=True, cache=True, error_model="numpy")
        def advance(power_w, dt, u, p, s):
            ambient__t_env = p[0]
            lumped__gain = p[1]
            lumped__tau = p[2]
            elapsed_time = s[0]
            power = s[1]
            ...
            power = power_w
            forced, drive_next = False, 0.0
            elapsed_time = elapsed_time + dt
            ambient = temperature
            ambient = ambient_step(ambient__t_env)
            light = power
            ...
            if forced:
                temperature = drive_next
            else:
                temperature, loss_rate = lumped_step(light, ambient, ..., dt, lumped__gain, lumped__tau)
            ...
            measured_temperature = temperature
            s[0] = elapsed_time
            s[1] = power
            ...
    """
    code = _begun(terms)
    with code.function("advance", {"power_w": "f8", "dt": "f8", "u": _VECTOR, "p": _VECTOR, "s": _VECTOR}):
        code.add(*_unpack_parameters(terms), *_load_states(terms), "power = power_w", *_inputs(terms, "u[{}]"))
        code.add("forced, drive_next = False, 0.0", *_stages(terms, initial=False), *_store_states(terms))
    return str(code)


def _begun(terms: tuple[Term, ...]) -> _Code:
    """The head of a module, and its ``begin``."""
    code = _Code(
        f"# generated by lce_model.kernel.generate from: {', '.join(t.name for t in terms)}", "from numba import njit"
    )
    with code.function("begin", {"start_k": "f8", "deadband_k": "f8", "u": _VECTOR, "p": _VECTOR, "s": _VECTOR}):
        code.add(*_unpack_parameters(terms), "s[:] = NAN", *_load_states(terms), *_inputs(terms, "u[{}]"))
        code.add("temperature = start_k", "deadband = deadband_k", "elapsed_time = 0.0")
        code.add("dt = power = warming = 0.0", "fraction = 1.0")
        code.add(*_stages(terms, initial=True), *_store_states(terms))
    return code


def _inputs(terms: tuple[Term, ...], place: str) -> list[str]:
    """Assignments of the inputs that the terms read, from their columns."""
    return [f"{channel.sets} = {place.format(k)}" for k, channel in enumerate(inputs_of(terms))]


def _unpack_parameters(terms: tuple[Term, ...]) -> list[str]:
    """Assignments from the parameter vector ``p``; a vector is a view of it."""
    names = [f"{t.name}__{p.name}" for t in terms for p in t.parameters]
    lines = [f"{name} = p[{i}]" for i, name in enumerate(names)]
    for name, size in ((f"{t.name}__{v}", size) for t in terms for v, size in t.vectors):
        first = names.index(f"{name}_1")
        lines.append(f"{name} = p[{first}:{first + size}]")
    return lines


def _scalars(terms: tuple[Term, ...]) -> list[str]:
    """The variables that are single numbers, in the order of the state vector ``s``."""
    return [*SIGNALS, *(f"{t.name}__{s}" for t in terms for s in t.states)]


def _load_states(terms: tuple[Term, ...]) -> list[str]:
    """Assignments from ``s``; an array is a view of it, which its term changes in place."""
    scalars = _scalars(terms)
    lines = [f"{name} = s[{i}]" for i, name in enumerate(scalars)]
    first = len(scalars)
    for name, size in ((f"{t.name}__{a}", size) for t in terms for a, size in t.arrays):
        lines.append(f"{name} = s[{first}:{first + size}]")
        first += size
    return lines


def _store_states(terms: tuple[Term, ...]) -> list[str]:
    return [f"s[{i}] = {name}" for i, name in enumerate(_scalars(terms))]


def _record(row: str) -> list[str]:
    return [f"out[{row}, {j}] = {name}" for j, name in enumerate(RECORDED)]


def _stages(terms: tuple[Term, ...], initial: bool) -> list[str]:
    """One step, or the start: stage by stage the first values of its signals, then its terms."""
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
        if stage == "surroundings" and initial:
            lines += ["if temperature != temperature:", "    temperature = ambient", "rest_temperature = ambient"]
    return lines


def _call(term: Term, initial: bool) -> list[str]:
    """``results = function(arguments)``, skipped at run time while the term is idle.

    A term that alone says what a sensor reports is never skipped.
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
