# SPDX-License-Identifier: Apache-2.0
"""A predictive check: quantiles of the measured residual on the bands that a model that is right would give them."""

import numpy as np

from lce_analysis.comparison.conditions import BRANCHES
from lce_analysis.comparison.predictive_check import LEVEL, QUANTILES, ChannelCheck, PredictiveCheck, Regime
from lce_data.channels import TEMPERATURE
from lce_report.blocks import Block, Curve, Grid, Lines, Section, Table
from lce_report.figures.axes import residual_axis, title, value_axis

QUANTILE_NAMES = tuple(f"{quantile:.0%}" for quantile in QUANTILES)


def predictive_check_section(check: PredictiveCheck) -> Section:
    """A predictive check as a section of a report: its sentences, then the bands and the shares."""
    return Section("Predictive check", (*check.sentences, *predictive_check_blocks(check)))


def predictive_check_blocks(check: PredictiveCheck) -> tuple[Block, ...]:
    """Two figures for each sensor, one for each branch, the share of samples inside by run, and how to read it."""
    figures = [bands(found, branch) for found in check.channels.values() for branch in BRANCHES]
    return (
        f"{check.draws} simulations, each with parameters that the noise in the data leaves possible and with noise of "
        f"the sensors. The lines are the {', '.join(QUANTILE_NAMES[:-1])} and {QUANTILE_NAMES[-1]} quantiles of the "
        f"measured residual in parts of the temperature range; on the shaded bands lie {LEVEL:.0%} of the same "
        "quantiles of the simulations. A line that leaves its band shows what noise cannot explain: the middle one a "
        "wrong mean, the outer ones a wrong spread.",
        Grid(figures, (1, 1)),
        shares(check),
    )


def bands(found: ChannelCheck, branch: str) -> Lines:
    """Quantiles of the residual of a sensor over the temperature, on one branch."""
    regimes = [r for r in found.regimes if r.branch == branch]
    axis, scale = residual_axis(found.channel), found.channel.difference.factor

    def values(name: str, k: int) -> np.ndarray:
        return np.array([getattr(r, name)[k] for r in regimes]) * scale

    simulated = [
        Curve(f"simulated {name}", values("middle", k), "model", "dashed", values("low", k), values("high", k))
        for k, name in enumerate(QUANTILE_NAMES)
    ]
    measured = [
        Curve(f"measured {name}", values("observed", k), "measured", "marked") for k, name in enumerate(QUANTILE_NAMES)
    ]
    centres = np.array([_centre(r) for r in regimes])
    heading = f"{axis.name} while {branch}"
    return Lines(heading, value_axis(TEMPERATURE), axis, centres, (*simulated, *measured), height=230)


def _centre(regime: Regime) -> float:
    """Middle of a part of the temperature range, in the display unit of temperatures."""
    middle = TEMPERATURE.recorded.to_si(0.5 * (regime.lower_c + regime.upper_c))
    return float(TEMPERATURE.display.from_si(middle))


def shares(check: PredictiveCheck) -> Table:
    """Samples inside their band: by sensor and run, and as many as there would be if the model were right."""
    runs = dict.fromkeys(name for found in check.channels.values() for name in found.runs)
    rows = [
        (
            title(channel),
            f"{found.inside:.1%}",
            f"{found.expected[0]:.1%} to {found.expected[1]:.1%}",
            *(f"{found.runs[name]:.1%}" if name in found.runs else "–" for name in runs),
        )
        for channel, found in check.channels.items()
    ]
    return Table(f"Samples inside the {LEVEL:.0%} band", ("series", "all", "if the model were right", *runs), rows)
