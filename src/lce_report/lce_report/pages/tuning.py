# SPDX-License-Identifier: Apache-2.0
"""The report of `lce tune`: the steps, the Bode diagrams of the open loops, and the margins."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from lce_control.tuning.linear import OMEGA, Complex
from lce_control.tuning.requirements import Requirements, Step, Tuned
from lce_control.tuning.tasks import TuningPlant
from lce_report.blocks import Axis, Curve, Grid, Lines, Section, Table
from lce_report.figures.axes import TIME
from lce_report.html.render import render
from lce_report.pages.footer import WRITTEN_BY

HEAD: Final = (
    "loop",
    "rise to 80 % [s]",
    "settling in 2 % [s]",
    "overshoot",
    "undershoot",
    "ITAE",
    "power ripple [W]",
    "gain margin [dB]",
    "phase margin [°]",
)
NOTES: Final = (
    "Figures are those of the worst step; ITAE is ∫ t |e| dt / ∫ t dt, e in fractions of the step. The margins are "
    "those of the loops linearised at the power that holds the middle target, where displacement over temperature "
    "is steepest, samples counted as old as they are; what the controller extrapolates is left out. On the model "
    "the double loop has a feed-forward that is {error_k:g} K wrong, up and down in turn."
)
FREQUENCY: Final = Axis("lg ω", "lg rad/s")


def rows(found: Sequence[Tuned]) -> list[tuple[str, ...]]:
    """The worst figures of each controller as text, in the columns of ``HEAD``."""
    lines: list[tuple[str, ...]] = []
    for tuned in found:
        worst = tuned.worst()
        lines.append(
            (
                tuned.name,
                _or(worst["rise_s"], "{:.2f}", "never"),
                _or(worst["settling_s"], "{:.2f}", "never"),
                f"{worst['overshoot']:.2%}",
                f"{worst['undershoot']:.2%}",
                f"{tuned.itae:.2%}",
                f"{worst['power_ripple_w']:.3f}",
                _or(_decibel(worst["gain_margin"]), "{:.1f}", "∞"),
                _or(worst["phase_margin_deg"], "{:.0f}", "∞"),
            )
        )
    return lines


def render_tuning(found: Sequence[Tuned], wanted: Requirements, plant: TuningPlant, about: Sequence[str]) -> str:
    """Tuned controllers as one self-contained HTML file.

    Parameters
    ----------
    found : the inner loop alone, the double loop and the single one, in this order.
    wanted : what was required of them.
    plant : the model on which they were tuned.
    about : lines for the foot of the page.

    Returns
    -------
    str
        The text of the file.
    """
    targets = ", ".join(f"{1e3 * target_m:.2f}" for target_m in plant.targets_m)
    answer = (
        f"Gains of the double and the single loop, tuned on steps to {targets} mm.",
        f"Required: {', '.join(_required(wanted))}.",
    )
    sections = [
        Section("Figures", (Table("", HEAD, rows(found)), NOTES.format(error_k=plant.options.feedforward_error_k))),
        Section("Gains", (Table("", ("node", "parameter", "value"), _gains(found)),)),
        Section("Margins", (Table("", ("loop", "gain [dB]", "phase [°]", "crossover [rad/s]"), _margins(found)),)),
    ]
    sections += [Section(_heading(tuned), (_steps(tuned), *_bodes(tuned))) for tuned in found]
    return render("lce tune", answer, sections, (*about, WRITTEN_BY))


def _required(wanted: Requirements) -> list[str]:
    times = (("rise", wanted.rise_s), ("settling", wanted.settling_s))
    return [
        f"overshoot ≤ {wanted.overshoot:.1%}",
        f"undershoot ≤ {wanted.undershoot:.1%}",
        *(f"{name} ≤ {limit:g} s" for name, limit in times if math.isfinite(limit)),
        f"power ripple ≤ {wanted.power_ripple_w:g} W",
        f"gain margin ≥ {_decibel(wanted.gain_margin):.1f} dB",
        f"phase margin ≥ {wanted.phase_margin_deg:g}°",
    ]


def _gains(found: Sequence[Tuned]) -> list[tuple[str, ...]]:
    _, *modes = found
    return [
        (node, name, f"{value:g}")
        for tuned in modes
        for node, own in tuned.parameters.items()
        for name, value in own.items()
    ]


def _margins(found: Sequence[Tuned]) -> list[tuple[str, ...]]:
    return [
        (
            f"{tuned.name}: {name}" if name != tuned.name else name,
            _or(_decibel(m.gain), "{:.1f}", "∞"),
            _or(m.phase_deg, "{:.0f}", "∞"),
            _or(m.crossover_rad_s, "{:.2f}", "none"),
        )
        for tuned in found
        for name, m in tuned.margins.items()
    ]


def _heading(tuned: Tuned) -> str:
    return {"inner": "Inner loop alone, temperature", "double": "Double loop", "single": "Single loop"}[tuned.name]


def _steps(tuned: Tuned) -> Grid:
    return Grid(tuple(_step(step, tuned.name) for step in tuned.steps))


def _step(step: Step, name: str) -> Lines:
    percent = Curve("reached", 100.0 * step.reached / step.setpoint, "measured")
    target = Curve("setpoint", np.full(step.time_s.size, 100.0), "model", "dashed")
    title = f"step of {step.setpoint:.1f} K" if name == "inner" else f"step to {1e3 * step.setpoint:.2f} mm"
    return Lines(title, TIME, Axis("reached", "%"), step.time_s, (percent, target), name)


def _bodes(tuned: Tuned) -> tuple[Grid, ...]:
    return tuple(_bode(name, f"{tuned.name} {name} Bode", loop) for name, loop in tuned.open_loops.items())


def _bode(name: str, linked: str, loop: Complex) -> Grid:
    """Magnitude and phase over the frequency; the dashed lines are where a margin is read off."""
    decades = np.log10(OMEGA)
    phase = np.degrees(np.unwrap(np.angle(loop)))
    decibels = Curve("L", 20.0 * np.log10(np.abs(loop)), "measured")
    degrees = Curve("L", np.maximum(phase, -360.0), "measured")
    unity = Curve("0 dB", np.zeros(OMEGA.size), "quiet", "dashed")
    half_turn = Curve("-180°", np.full(OMEGA.size, -180.0), "quiet", "dashed")
    return Grid(
        (
            Lines(f"open {name} loop, magnitude", FREQUENCY, Axis("|L|", "dB"), decades, (decibels, unity), linked),
            Lines(f"open {name} loop, phase", FREQUENCY, Axis("∠L", "°"), decades, (degrees, half_turn), linked),
        ),
        (1, 1),
    )


def _decibel(factor: float) -> float:
    return 20.0 * math.log10(factor)


def _or(value: float, form: str, otherwise: str) -> str:
    return form.format(value) if math.isfinite(value) else otherwise
