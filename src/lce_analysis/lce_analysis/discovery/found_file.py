# SPDX-License-Identifier: Apache-2.0
"""A function that was found, written as an effect file: what `lce add`, `lce diagnose --effect` and the page take."""

import inspect
import textwrap
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

from lce_analysis.discovery.curve import Curve
from lce_analysis.discovery.formulas import Formula, bounds_of
from lce_analysis.unknown_function import Candidate
from lce_model.closures import closure
from lce_model.closures.forms import Meaning

WIDEST: Final = 100.0
"""The strength may be so many times what was found."""
TIMES: Final = (0.5, 1.0, 2.0)
"""Of what was found: where a diagnosis looks for a number again."""
GUARDED: Final = frozenset({"order", "displacement", "lagged_displacement"})
"""Covariates that are not known at the beginning, and never in a model without deformation."""


@dataclass(frozen=True)
class _Following:
    """How a covariate is followed: signals it reads, states, and the lines that update these and set z."""

    reads: tuple[str, ...]
    lines: tuple[str, ...]
    states: tuple[str, ...] = ()
    first: tuple[str, ...] = ()


def _lagged(signal: str, late: bool = False) -> _Following:
    before = signal if signal == "power" else "before"
    lines = (
        f"memory = {signal} if math.isnan(memory) else lag(memory, {before}, {signal}, dt, tau)",
        f"before = {signal}",
        "z = memory" if late else f"z = {signal} - memory",
    )
    return _Following((signal,), lines, ("memory", "before"), ("math.nan", "math.nan"))


FOLLOWING: Final[dict[str, _Following]] = {
    "temperature": _Following(("temperature",), ("z = temperature",)),
    "rate": _Following(("warming",), ("z = 0.0 if math.isnan(warming) else warming",)),
    "power": _Following(("power",), ("z = power",)),
    "order": _Following(("order",), ("z = order",)),
    "displacement": _Following(("displacement",), ("z = displacement",)),
    "time": _Following(("elapsed_time",), ("z = elapsed_time",)),
    "dose": _Following(("power",), ("memory = memory + power * dt", "z = memory"), ("memory",), ("0.0",)),
    "path": _Following(
        ("temperature",),
        ("memory = memory + abs(temperature - before)", "before = temperature", "z = memory"),
        ("memory", "before"),
        ("0.0", "temperature"),
    ),
    "displacement_path": _Following(
        ("displacement",),
        (
            "memory = 0.0 if math.isnan(memory) or math.isnan(before) else memory + abs(displacement - before)",
            "before = displacement",
            "z = memory",
        ),
        ("memory", "before"),
        ("math.nan", "math.nan"),
    ),
    "branch": _Following(
        ("direction", "warming"),
        ("z = -1.0 if (warming if math.isnan(direction) else direction) < 0.0 else 1.0",),
    ),
    "cycle": _Following(
        ("direction", "warming"),
        (
            "heating_now = warming if math.isnan(direction) else direction",
            "memory = memory + 1.0 if heating_now > 0.0 and before < 0.0 else memory",
            "before = heating_now if heating_now != 0.0 else before",
            "z = memory",
        ),
        ("memory", "before"),
        ("0.0", "math.nan"),
    ),
    "lagged_temperature": _lagged("temperature"),
    "lagged_power": _lagged("power"),
    "lagged_displacement": _lagged("displacement"),
    "late_power": _lagged("power", late=True),
}
NAMES: Final[dict[Meaning, str]] = {
    "place": "from_x",
    "width": "width",
    "exponent": "exponent",
    "period": "period",
    "activation": "activation",
}
"""What a number of a form is called in the file."""


@dataclass(frozen=True)
class _Function:
    """The function in the file: its text, the call of it, its parameters as text, and where they are tried out."""

    definition: str
    call: str
    parameters: tuple[str, ...]
    arguments: tuple[str, ...]
    strength: str
    typical: float
    grid: tuple[str, ...]


def name_of(candidate: Candidate, formula: Formula | None) -> str:
    """Name of the effect: place, covariate, and form."""
    form = formula.form.name if formula else "curve"
    return f"found_{candidate.place.name}_{candidate.covariate.name}_{form}"


def effect_file(curve: Curve, formula: Formula | None, weights: Sequence[float], runs: Sequence[str]) -> str:
    """Text of the effect file of a function: its formula, or the curve itself where no formula describes it.

    Parameters
    ----------
    curve : for the docstring and the comments.
    formula : the best one; None writes the curve.
    weights : (K,) of the whole curve, with what the model absorbs.
    runs : names of those it was found in.
    """
    candidate = curve.candidate
    function = _of_formula(formula) if formula else _of_curve(candidate, weights)
    return "\n\n\n".join(
        [
            _head(curve, formula, runs, function),
            function.definition,
            _steps(candidate, function),
            _declaration(candidate, formula, function),
        ]
    )


def _head(curve: Curve, formula: Formula | None, runs: Sequence[str], function: _Function) -> str:
    candidate = curve.candidate
    title = f"A function of the {candidate.covariate.words} in {candidate.place.words}, found by `lce discover`."
    told = [f"{curve.words[0].upper()}{curve.words[1:]}.", f"Found in {', '.join(map(_as_text, runs))}."]
    if formula:
        told.append(f"f(z) = {formula.expression}, {_meaning_of_z(candidate)}.")
    else:
        told.append("No formula of the dictionary describes it, so it is a curve through knots.")
    doc = "\n\n".join("\n".join(textwrap.wrap(part, 110)) for part in (title, *told))
    rows = [f"# {x:12.6g}  {y:12.6g}  {e:12.2g}" for x, y, e in zip(curve.x, curve.y, curve.error, strict=True)]
    unit, of = candidate.place.unit, candidate.covariate
    table = "\n".join(
        [f"# The curve: {of.name.replace('_', ' ')} [{of.unit}], value and standard error [{unit}].", *rows]
    )
    imports = ["import math", ""] if "math." in function.definition + _steps(candidate, function) else []
    imports += ["from numba.extending import register_jitable", "", "from lce_model.effects import Effect"]
    imports += ["from lce_model.lag import lag"] if candidate.covariate.lagged else []
    return "\n".join([f'"""{doc}\n"""', "", *imports, "from lce_model.terms import Parameter", "", table])


def _as_text(name: str) -> str:
    """The name of a run, which is that of a file and may hold anything, as text that cannot end a docstring."""
    return "".join(c if c.isprintable() and c not in '"\\' else "_" for c in name)


def _meaning_of_z(candidate: Candidate) -> str:
    of = candidate.covariate
    if of.name == "temperature":
        return f"with T_env = {candidate.reference:.6g} K"
    return f"z being the {of.words}"


def _of_formula(formula: Formula) -> _Function:
    candidate, form, model = formula.candidate, formula.form, formula.fit.problem.model
    term = candidate.term
    strength = model[f"{term}.strength"]
    inner = inspect.getsource(form.function)
    given = {
        "x": f"z - {_number(candidate.reference)}" if candidate.reference else "z",
        "z": "z",
        "z0": _number(candidate.reference),
    }
    given |= {name: NAMES[meaning] for name, meaning in form.numbers.items()}
    call = f"{form.name}({', '.join(given[a] for a in form.arguments)})"
    numbers = {NAMES[m]: (model[f"{term}.{n}"], m, bounds_of(m, candidate)) for n, m in form.numbers.items()}
    parameters = [
        _parameter(
            "c", _unit(formula), 0.0, -WIDEST * abs(strength), WIDEST * abs(strength), "strength", abs(strength) / 10
        )
    ]
    grid = []
    for name, (found, meaning, (lower, upper)) in numbers.items():
        parameters.append(
            _parameter(name, _number_unit(meaning, candidate), found, lower, upper, f"{meaning} of the function")
        )
        tried = (
            [found - 0.1 * (upper - lower), found, found + 0.1 * (upper - lower)]
            if meaning == "place"
            else [found * k for k in TIMES]
        )
        grid.append(f'("{name}", {_tuple(min(max(x, lower), upper) for x in tried)})')
    arguments = ["c", *numbers]
    if candidate.covariate.lagged:
        tau = model[f"{term}.tau"]
        parameters.append(_parameter("tau", "s", tau, tau / 20.0, tau * 20.0, "time constant of the lag", log=True))
        grid.append(f'("tau", {_tuple(tau * k for k in TIMES)})')
        arguments.append("tau")
    return _Function(inner.rstrip(), call, tuple(parameters), tuple(arguments), "c", strength, tuple(grid))


def _of_curve(candidate: Candidate, weights: Sequence[float]) -> _Function:
    definition = textwrap.dedent(f"""\
        LOWER, UPPER = {_number(candidate.lower)}, {_number(candidate.upper)}
        CURVE = {_tuple(weights)}


        @register_jitable
        def curve(z: float) -> float:
            \"\"\"Straight between knots evenly from LOWER to UPPER; the ends hold beyond.\"\"\"
            at = min(max((z - LOWER) / (UPPER - LOWER), 0.0), 1.0) * (len(CURVE) - 1)
            i = min(int(at), len(CURVE) - 2)
            return CURVE[i] + (at - i) * (CURVE[i + 1] - CURVE[i])""")
    parameters = [_parameter("share", "1", 0.0, -WIDEST, WIDEST, "share of the curve that acts", 0.1)]
    arguments = ["share"]
    grid: list[str] = []
    if candidate.tau_s is not None:
        tau = candidate.tau_s
        parameters.append(_parameter("tau", "s", tau, tau / 20.0, tau * 20.0, "time constant of the lag", log=True))
        grid.append(f'("tau", {_tuple(tau * k for k in TIMES)})')
        arguments.append("tau")
    return _Function(definition, "curve(z)", tuple(parameters), tuple(arguments), "share", 1.0, tuple(grid))


def _steps(candidate: Candidate, function: _Function) -> str:
    following, place = FOLLOWING[candidate.covariate.name], closure(candidate.place.name)
    output, name = place.outputs[0], candidate.covariate.name
    midway = place.stage in ("light", "heat") and "temperature" in following.reads
    signals = list(dict.fromkeys([output, *following.reads, *(["warming"] if midway else [])]))
    arguments = [*signals, "dt", *following.states, *function.arguments]
    change = f"{function.strength} * {function.call}"
    changed = f"{output} * (1.0 + {change})" if place.stage == "light" else f"{output} + {change}"
    lines = ["temperature = temperature if math.isnan(warming) else temperature + 0.5 * dt * warming"] if midway else []
    lines += following.lines
    result = ", ".join([*following.states, changed])
    unchanged = ", ".join([*following.states, output])
    lines += [f"if math.isnan(z):\n        return {unchanged}"] if name in GUARDED else []
    words = ", ".join([*following.states, output]).replace("_", " ")
    body = "\n    ".join([f'"""{words[0].upper()}{words[1:]}."""', *lines, f"return {result}"])
    code = f"@register_jitable\ndef step({_typed(arguments)}):\n    {body}"
    if not following.states:
        return code
    first = dict(zip(following.states, following.first, strict=True)) | {"dt": "0.0"}
    call = ", ".join(first.get(a, a) for a in arguments)
    given = [a for a in arguments if a not in first]
    return f'{code}\n\n\ndef start({_typed(given)}):\n    """Nothing was before."""\n    return step({call})'


def _typed(arguments: Sequence[str]) -> str:
    return ", ".join(f"{a}: float" for a in arguments)


def _declaration(candidate: Candidate, formula: Formula | None, function: _Function) -> str:
    following, place = FOLLOWING[candidate.covariate.name], closure(candidate.place.name)
    said = formula.expression if formula else "share curve(z)"
    lines = [
        "EFFECT = Effect(",
        f'    name="{name_of(candidate, formula)}",',
        f'    stage="{place.stage}",',
        f'    equation="{place.equation}, f(z) = {said}",',
        "    parameters=(",
        *(f"        {p}," for p in function.parameters),
        "    ),",
        f"    states={_texts(following.states)},",
        f'    outputs=("{place.outputs[0]}",),',
        *(["    start=start,"] if following.states else []),
        "    step=step,",
        f'    strength="{function.strength}",',
        f"    typical={_number(function.typical)},",
        f"    grid=({''.join(g + ', ' for g in function.grid)}),",
        ")",
        "",
    ]
    return "\n".join(lines)


def _parameter(
    name: str, unit: str, default: float, lower: float, upper: float, words: str, knee: float = 0.0, log: bool = False
) -> str:
    """The declaration of a parameter; it is searched on a linear axis unless it has a knee or ``log``."""
    scale = f', "asinh", {_number(knee)}' if knee else ', "log"' if log else ""
    numbers = ", ".join(map(_number, (default, lower, upper)))
    return f'Parameter("{name}", "{unit}", {numbers}, "{words}", "lce discover"{scale})'


def _tuple(values: Iterable[float]) -> str:
    return f"({', '.join(map(_number, values))},)"


def _number(value: float) -> str:
    """A number as it stands in the file: six digits, more than the data determine."""
    return repr(float(f"{value:.6g}"))


def _texts(values: Iterable[str]) -> str:
    return f"({''.join(f'{value!r}, ' for value in values)})".replace("'", '"')


def _unit(formula: Formula) -> str:
    """Unit of the strength c."""
    place, of = formula.candidate.place.unit, formula.candidate.covariate.unit
    power = {
        "linear": "",
        "magnitude": "",
        "threshold": "",
        "ceiling": "",
        "dead_zone": "",
        "quadratic": "^2",
        "threshold_squared": "^2",
        "cubic": "^3",
        "fourth_power": "^4",
        "power": "^exponent",
    }.get(formula.form.name)
    if power is None or of == "1":
        return place
    if place == of and not power:
        return "1"
    return f"{place}/{of}{power}" if "/" not in of else f"{place}/({of}){power}"


def _number_unit(meaning: Meaning, candidate: Candidate) -> str:
    if meaning == "exponent":
        return "1"
    return "K" if meaning == "activation" else candidate.covariate.unit
