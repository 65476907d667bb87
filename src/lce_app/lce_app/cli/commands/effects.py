# SPDX-License-Identifier: Apache-2.0
"""`lce effects`: the library of physical effects, or one of them in detail."""

from __future__ import annotations

import argparse
import inspect
import sys
from typing import TYPE_CHECKING

from lce_data.units import after_number

if TYPE_CHECKING:
    from lce_model.effects import Effect
    from lce_model.terms import Parameter

PAGE = """# Effects

What a model may lack. Written by `lce effects --markdown`; `lce effects NAME` shows one.

An effect is a [term](../../src/lce_model/lce_model/terms.py) with a strength. At the null value of the strength the
simulation is that of the model without it (beside `kinetic`, to rounding). Effects combine freely: those of a stage
act before the term that takes what they give, several of them always in the same order, whatever the order in which
they were added.
At 100 samples a second each is as accurate as at 1000, to 1e-4 of what it does, where the model itself does not jump.
[test_effects.py](../../src/lce_model/test/test_effects.py) holds all of this for every effect,
[test_effect_equations.py](../../src/lce_model/test/test_effect_equations.py) solves every equation by other means, and
[test_effect_recovery.py](../../src/lce_analysis/test/test_effect_recovery.py) finds every strength again in noisy data
(that of `emissivity_error` is not determined, and the fit says so).

The recorded temperature and displacement, the bench's sensors and `lce simulate` show `measured_temperature` and
`measured_displacement`, after the effects of the sensors. Where a measured temperature drives the deformation, effects
of the heat balance do not matter. One of your own is [a file of 20 lines](../tutorials/own-effect.md).

`room_temperature`, `load_shift` and `load_stretch` read what was measured beside the strip
([physics.md](../explanation/physics.md#room-and-load-inputs-that-a-run-may-have)). Runs without it leave them out, and
the command says why.

The ranges are those of a strip on this bench. `--bounds creep.tau_v=0.1,50000` widens or narrows one for `lce fit`,
`lce add` and `lce diagnose`, and `bounds` in a model file does so for good; what is never negative stays so.

Steps (`loss_step`, `light_step`, `displacement_step`) happen at the same time after the beginning of every run, so
`lce diagnose` examines them only beside one run and no `--test`.
Rounding of a sensor is no effect: below its quantum a fit cannot tell it from noise, and the noise of a series includes
it.
"""

EXAMPLES = (
    "lce effects creep",
    "lce effects ./my_effect.py",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `lce effects`."""
    parser.add_argument("name", nargs="?", metavar="NAME", help="one effect, or a file of yours, which is tried out")
    parser.add_argument("--markdown", action="store_true", help="the library as docs/reference/effects.md")


def main(args: argparse.Namespace) -> int:
    """Print the library or one effect."""
    from lce_model.effects import find, library

    if args.markdown:
        sys.stdout.write(page())
    elif args.name:
        effect = find(args.name)
        print(_detail(effect))
        if effect.path:
            from lce_app.use_cases.try_effect import try_effect

            print("", *try_effect(effect).sentences, sep="\n")
    else:
        width = max(len(name) for name in library())
        for effect in _by_stage():
            strength = effect.parameter(effect.strength)
            print(f"{effect.stage:12s} {effect.name:{width}s}  {_named(effect)}")
            print(f"{'':12s} {'':{width}s}  {effect.equation}")
            print(f"{'':12s} {'':{width}s}  {strength.name}: {_range(strength)}")
    return 0


def page() -> str:
    """The library as a page of docs."""
    lines = [PAGE, "| stage | effect | meaning | equation | strength |", "|---|---|---|---|---|"]
    for effect in _by_stage():
        strength = effect.parameter(effect.strength)
        equation = effect.equation.replace("|", "\\|")
        link = f"[`{effect.name}`](#{effect.name})"
        row = [effect.stage, link, effect.meaning, f"`{equation}`", f"`{strength.name}`, {_range(strength)}"]
        lines.append(f"| {' | '.join(row)} |")
    for effect in _by_stage():
        file = f"../../src/lce_model/lce_model/effects/{effect.name}.py"
        lines += [
            "",
            f"## {effect.name}",
            "",
            f"**{effect.title}**",
            "",
            _about(effect),
            "",
            f"[{effect.name}.py]({file}), stage {effect.stage}:",
        ]
        lines += ["", "```text", effect.equation, "```", ""]
        lines += ["| parameter | meaning | default (range) | source |", "|---|---|---|---|"]
        lines += [f"| `{p.name}` | {_meaning(effect, p)} | {_range(p)} | {p.source} |" for p in effect.parameters]
    return "\n".join([*lines, "", "Next: [an effect of your own](../tutorials/own-effect.md).", ""])


def _by_stage() -> list[Effect]:
    from lce_model.effects import library
    from lce_model.terms import STAGES

    return sorted(library().values(), key=lambda e: (STAGES.index(e.stage), e.place, e.name))


def _named(effect: Effect) -> str:
    return effect.meaning if effect.title in effect.meaning else f"{effect.title}: {effect.meaning}"


def _about(effect: Effect) -> str:
    module = inspect.getmodule(effect.step)
    return (inspect.getdoc(module) or "").strip()


def _range(p: Parameter) -> str:
    return f"{p.default:g} ({p.lower:g} to {p.upper:g}){after_number(p.unit)}"


def _meaning(effect: Effect, p: Parameter) -> str:
    if p.name == effect.strength:
        return f"{p.description}; the strength, null at {effect.null:g}"
    return f"{p.description}; not fitted unless told so" if p.fixed else p.description


def _detail(effect: Effect) -> str:
    lines = [
        f"{effect.name}, stage {effect.stage}",
        _named(effect),
        "",
        _about(effect),
        "",
        f"    {effect.equation}",
        "",
    ]
    width = max(len(p.name) for p in effect.parameters)
    for p in effect.parameters:
        lines += [f"{p.name:{width}s}  {_range(p)}", f"{'':{width}s}  {_meaning(effect, p)} [{p.source}]"]
    return "\n".join(lines)
