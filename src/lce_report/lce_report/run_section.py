# SPDX-License-Identifier: Apache-2.0
"""A run beside its model as a section of a page."""

from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from lce_analysis.comparison.compare import Quantity, RunComparison, Stage
from lce_analysis.comparison.residuals import Correlation
from lce_report.blocks import Axis, Curve, Figure, Grid, Heat, Lines, Loop, Role, Section, Trace

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Colouring = Literal["nothing", "branch", "cycle"]
"""What colours the measured loop."""

TIME: Final = Axis("time", "s")
TEMPERATURE: Final = Axis("T", "°C")
POWER: Final = Axis("P", "W")
RATE: Final = Axis("dT/dt", "K/s")
NAMES: Final[dict[Quantity, str]] = {"temperature": "temperature\u00a0T", "displacement": "displacement\u00a0d"}
CYCLES: Final[tuple[Role, ...]] = ("residual", "before", "after", "input", "heating", "measured")
OVER: Final = {"temperature": TEMPERATURE, "rate": RATE, "power": POWER}
VALUE: Final[dict[Quantity, tuple[Axis, float]]] = {
    "temperature": (TEMPERATURE, 1.0),
    "displacement": (Axis("d", "mm"), 1e3),
}
RESIDUAL: Final[dict[Quantity, tuple[Axis, float]]] = {
    "temperature": (Axis("residual T", "K"), 1.0),
    "displacement": (Axis("residual d", "µm"), 1e6),
}
"""Axis of a quantity, of its residual, and the factor that takes °C or m there."""


def run_section(run: RunComparison, loop_by: Colouring = "nothing") -> Section:
    """The figures of a run: everything over time, linked; its loop; each residual over what it may depend on."""
    name = run.run.name
    over_time: list[Figure] = []
    if run.run.power is not None:
        power = run.run.power
        curve = Curve("P", power.value, "input", "step")
        over_time.append(Lines("laser power P", TIME, POWER, power.time_s, (curve,), linked=name, height=130))
    for stage in run.stages:
        over_time += _over_time(stage, name)
    beside: list[Figure] = [_loop(run, loop_by)] if run.stage("displacement") else []
    beside += [_over(stage, "temperature", name, 280) for stage in run.stages]
    conditions = run.run.conditions.get("protocol")
    about = [f"Protocol: {conditions}."] if conditions else []
    return Section(
        f"Run {name}",
        (
            *about,
            Grid((tuple(over_time), tuple(beside)), (3, 2)),
            *(Grid(_residuals(stage, name), (1, 1, 1, 1)) for stage in run.stages),
            *(_map(stage) for stage in run.stages),
        ),
    )


def _over_time(stage: Stage, linked: str) -> list[Figure]:
    (axis, factor), (fine, fine_factor) = VALUE[stage.quantity], RESIDUAL[stage.quantity]
    overlay = (
        Curve("measured", stage.measured * factor, "measured"),
        Curve("model", stage.modelled * factor, "model"),
    )
    noise = np.full_like(stage.residual, 2.0 * stage.metrics.noise * fine_factor)
    beside_noise = f"{fine.name} beside ±2 σ of the sensor noise"
    residual = Curve("measured − model", stage.residual * fine_factor, "residual", low=-noise, high=noise)
    return [
        Lines(NAMES[stage.quantity], TIME, axis, stage.time_s, overlay, linked=linked, height=200),
        Lines(beside_noise, TIME, fine, stage.time_s, (residual,), linked=linked, height=150),
    ]


def _loop(run: RunComparison, by: Colouring) -> Loop:
    """Displacement over temperature: the measured one over the measured temperature, where there is one."""
    stage, thermal = run.stage("displacement"), run.stage("temperature")
    assert stage is not None
    model_t = measured_t = stage.regime.temperature_c
    if thermal is not None:
        measured_t = np.interp(stage.time_s, thermal.time_s, thermal.measured)
    axis, factor = VALUE["displacement"]
    at, measured = stage.time_s, stage.measured * factor
    traces = [
        Trace(label, np.where(here, measured_t, np.nan), np.where(here, measured, np.nan), role, "line", at=at)
        for label, here, role in _parts(stage, by)
    ]
    traces.append(
        Trace("model", model_t, stage.modelled * factor, "model" if by == "nothing" else "quiet", "line", at=at)
    )
    return Loop("hysteresis loop: d over T", TEMPERATURE, axis, traces, linked=run.run.name, height=400)


def _parts(stage: Stage, by: Colouring) -> list[tuple[str, Flags, Role]]:
    """Parts of a run that get a colour each: label, which samples, colour."""
    here = stage.regime
    if by == "branch":
        return [("heating", here.heating, "heating"), ("cooling", ~here.heating, "cooling")]
    if by == "cycle":
        cycles = enumerate(np.unique(here.cycle))
        return [(f"cycle {n}", here.cycle == n, CYCLES[i % len(CYCLES)]) for i, n in cycles]
    return [("measured", np.ones_like(here.heating), "measured")]


def _map(stage: Stage) -> Heat:
    """Mean residual by temperature, cycle and branch."""
    axis, factor = RESIDUAL[stage.quantity]
    found = stage.map
    return Heat(
        f"mean {axis.name} [{axis.unit}], by temperature, cycle and branch",
        "°C",
        [f"{0.5 * (a + b):.0f}" for a, b in zip(found.edges_c[:-1], found.edges_c[1:], strict=True)],
        [f"{cycle} {branch}" for cycle, branch in found.rows],
        found.mean * factor,
        ".3f" if stage.quantity == "temperature" else ".0f",
        diverging=True,
    )


def _over(stage: Stage, over: str, linked: str, height: int = 200) -> Loop:
    """The residual over temperature, rate or power: a cloud and its mean on each branch."""
    axis, factor = RESIDUAL[stage.quantity]
    here, found = stage.regime, stage.profiles[over]
    values = {"temperature": here.temperature_c, "rate": here.rate_k_s, "power": here.power_w}[over]
    clouds, means = [], []
    branches: tuple[tuple[Role, Flags, Floats], ...] = (
        ("heating", here.heating, found.heating),
        ("cooling", ~here.heating, found.cooling),
    )
    for branch, which, mean in branches:
        if which.any():
            cloud = values[which], stage.residual[which] * factor
            clouds.append(Trace(branch, *cloud, branch, at=stage.time_s[which]))
        seen = np.flatnonzero(np.isfinite(mean))
        if seen.size:
            span = slice(seen[0], seen[-1] + 1)
            means.append(Trace("its mean", found.centre[span], mean[span] * factor, branch, "line"))
    return Loop(
        f"{axis.name} over {OVER[over].name}", OVER[over], axis, (*clouds, *means), linked=linked, height=height
    )


def _residuals(stage: Stage, linked: str) -> tuple[Figure, ...]:
    name = RESIDUAL[stage.quantity][0].name
    drive = "P" if stage.quantity == "temperature" else "T"
    return (
        _over(stage, "rate", linked),
        _over(stage, "power", linked),
        _correlation(f"autocorrelation of {name}", "lag", stage.autocorrelation, "±1.96/√N"),
        _correlation(
            f"correlation of {name} with {drive}", f"lag after {drive}", stage.input_correlation, "95% of chance"
        ),
    )


def _correlation(title: str, lag: str, found: Correlation, band: str) -> Lines:
    edge = np.full_like(found.value, found.band)
    return Lines(
        title,
        Axis(lag, "s"),
        Axis("correlation", "1"),
        found.lag_s,
        (Curve(band, np.zeros_like(edge), "quiet", "dashed", -edge, edge), Curve("residual", found.value, "residual")),
        height=200,
    )
