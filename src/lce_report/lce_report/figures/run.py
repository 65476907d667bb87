# SPDX-License-Identifier: Apache-2.0
"""A run beside its model: everything over time, loops, and each residual over what it may depend on."""

import math
from dataclasses import replace
from itertools import pairwise
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from lce_analysis.comparison.compare import ChannelComparison, RunComparison
from lce_analysis.comparison.residuals import Correlation
from lce_analysis.comparison.spectrum import spectrum
from lce_data.channels import POWER, TEMPERATURE, Channel
from lce_data.run import Run
from lce_report.blocks import Axis, Curve, Figure, Grid, Heat, Lines, Loop, Role, Section, Trace
from lce_report.figures.axes import RATE, TIME, difference_scale, displayed, residual_axis, title, value_axis

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Colouring = Literal["nothing", "branch", "cycle"]
"""What colours the measured loop."""

CYCLES: Final[tuple[Role, ...]] = ("residual", "before", "after", "input", "heating", "measured")
CONDITIONS: Final = {"temperature": value_axis(TEMPERATURE), "rate": RATE, "power": value_axis(POWER)}
"""Axes of the operating conditions over which residuals have profiles."""


def run_section(run: RunComparison, loop_by: Colouring = "nothing") -> Section:
    """A run beside its model as a section of a page.

    Parameters
    ----------
    run : the run, and what the model says of each channel that it predicts.
    loop_by : what colours the measured loop.

    Returns
    -------
    Section
        Figures over time, linked by the name of the run, beside loops and residuals; then residuals in detail. Axes
        are in the display units of the channels.
    """
    name, channels = run.run.name, run.channels.values()
    over_time: list[Figure] = []
    if run.run.power is not None:
        power = run.run.power
        curve = Curve(POWER.symbol, POWER.display.from_si(power.value), "input", "step")
        over_time.append(
            Lines("laser power P", TIME, value_axis(POWER), power.time_s, (curve,), linked=name, height=130)
        )
    for compared in channels:
        over_time += _over_time(compared, name)
    beside: list[Figure] = [
        _loop(run, compared, loop_by) for compared in channels if compared.channel is not TEMPERATURE
    ]
    beside += [_over(compared, "temperature", name, 280) for compared in channels]
    marks = tuple((marker.time_s, marker.text) for marker in run.run.markers)
    over_time = [replace(figure, marks=marks) if isinstance(figure, Lines) else figure for figure in over_time]
    return Section(
        f"Run {name}",
        (
            *_about(run.run),
            Grid((tuple(over_time), tuple(beside)), (3, 2)),
            *(Grid(_residuals(compared, name), (1, 1, 1, 1)) for compared in channels),
            Grid(tuple(_spectrum(compared) for compared in channels), (1, 1)),
            *(_map(compared) for compared in channels),
        ),
    )


def _about(run: Run) -> list[str]:
    """What was run, on which specimen, with which notes, and what was marked."""
    stated = run.experiment.conditions
    words = {"Protocol": run.experiment.protocol, "Specimen": stated.specimen, "Day": stated.day}
    words |= {"Notes": stated.other.get("notes")}
    words |= {"Marked": ", ".join(f"{marker.text} at {marker.time_s:.1f} s" for marker in run.markers)}
    return [f"{key}: {value}" for key, value in words.items() if value not in (None, "")]


def _over_time(compared: ChannelComparison, linked: str) -> list[Figure]:
    channel, time_s = compared.channel, compared.time_s
    axis, scale = residual_axis(channel), difference_scale(channel)
    overlay = (
        Curve("measured", displayed(channel, compared.measured), "measured"),
        Curve("model", displayed(channel, compared.modelled), "model"),
    )
    noise = np.full_like(compared.residual, 2.0 * compared.metrics.noise * scale)
    beside_noise = f"{axis.name} beside ±2 σ of the sensor noise"
    residual = Curve("measured − model", compared.residual * scale, "residual", low=-noise, high=noise)
    return [
        Lines(title(channel), TIME, value_axis(channel), time_s, overlay, linked=linked, height=200),
        Lines(beside_noise, TIME, axis, time_s, (residual,), linked=linked, height=150),
    ]


def _loop(run: RunComparison, compared: ChannelComparison, by: Colouring) -> Loop:
    """A channel over the temperature: measured over measured, or over the model's if no temperature was measured."""
    channel, thermal = compared.channel, run.channels.get(TEMPERATURE)
    model_t = measured_t = compared.conditions.temperature_c
    if thermal is not None:
        measured_t = np.interp(compared.time_s, thermal.time_s, displayed(TEMPERATURE, thermal.measured))
    at, measured = compared.time_s, displayed(channel, compared.measured)
    traces = [
        Trace(label, np.where(here, measured_t, np.nan), np.where(here, measured, np.nan), role, "line", at=at)
        for label, here, role in _parts(compared, by)
    ]
    role: Role = "model" if by == "nothing" else "quiet"
    traces.append(Trace("model", model_t, displayed(channel, compared.modelled), role, "line", at=at))
    heading = f"hysteresis loop: {channel.symbol} over {TEMPERATURE.symbol}"
    return Loop(heading, value_axis(TEMPERATURE), value_axis(channel), traces, linked=run.run.name, height=400)


def _parts(compared: ChannelComparison, by: Colouring) -> list[tuple[str, Flags, Role]]:
    """Parts of a run that get a colour each: label, which samples, colour."""
    here = compared.conditions
    if by == "branch":
        return [("heating", here.heating, "heating"), ("cooling", ~here.heating, "cooling")]
    if by == "cycle":
        cycles = enumerate(np.unique(here.cycle))
        return [(f"cycle {n}", here.cycle == n, CYCLES[i % len(CYCLES)]) for i, n in cycles]
    return [("measured", np.ones_like(here.heating), "measured")]


def _map(compared: ChannelComparison) -> Heat:
    """Mean residual by temperature, cycle and branch."""
    channel, found = compared.channel, compared.map
    axis, edges_c = residual_axis(channel), found.edges_c
    return Heat(
        f"mean {axis.name} [{axis.unit}], by temperature, cycle and branch",
        "°C",
        [f"{0.5 * (a + b):.0f}" for a, b in pairwise(edges_c)],
        [f"{cycle} {branch}" for cycle, branch in found.rows],
        found.mean * difference_scale(channel),
        f".{_decimals(channel)}f",
        diverging=True,
    )


def _decimals(channel: Channel) -> int:
    """Decimals that show two digits of the sensor's noise, in the unit of differences."""
    return max(0, 1 - math.floor(math.log10(channel.noise * channel.difference.factor)))


def _over(compared: ChannelComparison, condition: str, linked: str, height: int = 200) -> Loop:
    """The residual over temperature, rate or power: a cloud and its mean on each branch."""
    axis, scale = residual_axis(compared.channel), difference_scale(compared.channel)
    here, found = compared.conditions, compared.profiles[condition]
    values = {"temperature": here.temperature_c, "rate": here.rate_k_s, "power": here.power_w}[condition]
    clouds, means = [], []
    branches: tuple[tuple[Role, Flags, Floats], ...] = (
        ("heating", here.heating, found.heating),
        ("cooling", ~here.heating, found.cooling),
    )
    for branch, which, mean in branches:
        if which.any():
            cloud = values[which], compared.residual[which] * scale
            clouds.append(Trace(branch, *cloud, branch, at=compared.time_s[which]))
        seen = np.flatnonzero(np.isfinite(mean))
        if seen.size:
            span = slice(seen[0], seen[-1] + 1)
            means.append(Trace("its mean", found.centre[span], mean[span] * scale, branch, "line"))
    over = CONDITIONS[condition]
    return Loop(f"{axis.name} over {over.name}", over, axis, (*clouds, *means), linked=linked, height=height)


def _residuals(compared: ChannelComparison, linked: str) -> tuple[Figure, ...]:
    name = residual_axis(compared.channel).name
    drive = compared.channel.driven_by
    assert drive is not None  # a model predicts no input
    of_input = f"correlation of {name} with {drive.symbol}"
    return (
        _over(compared, "rate", linked),
        _over(compared, "power", linked),
        _correlation(f"autocorrelation of {name}", "lag", compared.autocorrelation, "±1.96/√N"),
        _correlation(of_input, f"lag after {drive.symbol}", compared.input_correlation, "95% of chance"),
    )


def _spectrum(compared: ChannelComparison) -> Lines:
    """At which frequencies the run varies, and at which the model misses it."""
    channel, scale = compared.channel, difference_scale(compared.channel)
    shown: tuple[tuple[str, Floats, Role], ...] = (
        ("measured", compared.measured, "measured"),
        ("model", compared.modelled, "model"),
        ("residual", compared.residual, "residual"),
    )
    found = {label: spectrum(compared.time_s, values) for label, values, _ in shown}
    curves = [Curve(label, found[label].density * scale, role) for label, _, role in shown]
    density = Axis(f"spectral density of {channel.symbol}", f"{channel.difference.symbol}/√Hz", log=True)
    frequency = Axis("frequency", "Hz", log=True)
    heading = f"spectrum of {title(channel)}"
    return Lines(heading, frequency, density, found["measured"].frequency_hz, curves, height=220)


def _correlation(heading: str, lag: str, found: Correlation, band: str) -> Lines:
    edge = np.full_like(found.value, found.band)
    chance = Curve(band, np.zeros_like(edge), "quiet", "dashed", -edge, edge)
    residual = Curve("residual", found.value, "residual")
    return Lines(heading, Axis(lag, "s"), Axis("correlation", "1"), found.lag_s, (chance, residual), height=200)
