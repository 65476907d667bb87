# SPDX-License-Identifier: Apache-2.0
"""Several models over one run: how large the error of each is, and all of them beside what was measured."""

from collections.abc import Mapping, Sequence
from itertools import cycle, product
from typing import Final

from lce_analysis.comparison.metrics import nrmse, rms_error
from lce_analysis.prediction import predict
from lce_data.channels import Channel
from lce_data.noise import noise_floor
from lce_data.run import Floats, Run
from lce_model import Model
from lce_report.blocks import Block, Curve, Form, Grid, Lines, Role, Table
from lce_report.figures.axes import TIME, residual_axis, title, value_axis

LOOKS: Final[tuple[tuple[Form, Role], ...]] = tuple(
    product(("line", "dashed"), ("model", "residual", "after", "before", "input"))
)
"""What tells the models apart; after ten of them it begins again."""


def several_models(run: Run, models: Mapping[str, Model]) -> Sequence[Block]:
    """Several models over one run.

    Parameters
    ----------
    run : what was measured.
    models : by the names that the figures give them.

    Returns
    -------
    Sequence[Block]
        A table with the RMS error of each model, in the channel's unit of differences and over the noise of the sensor,
        and its fit, 1 - NRMSE of (4.24); then two figures for each channel that a model predicts, linked by the name of
        the run: the values, and the residuals.

    Raises
    ------
    LceError
        If the run lacks what a model needs.
    """
    predicted = {name: predict(model, run).at_samples for name, model in models.items()}
    channels = [c for c in run.measured if any(c in found for found in predicted.values())]
    looks = dict(zip(models, cycle(LOOKS), strict=False))
    columns = []
    for channel in channels:
        series, axis = run.series[channel], residual_axis(channel)
        residuals = {name: series.value - found[channel] for name, found in predicted.items() if channel in found}
        modelled = {name: found[channel] for name, found in predicted.items() if channel in found}
        measured = Curve("measured", channel.display.from_si(series.value), "measured")
        values = {name: channel.display.from_si(value) for name, value in modelled.items()}
        differences = {name: e * channel.difference.factor for name, e in residuals.items()}
        axes = (f"{title(channel)} of each model", value_axis(channel)), (f"{axis.name} of each model", axis)
        curves = (measured, *_curves(values, looks)), tuple(_curves(differences, looks))
        columns.append(
            tuple(
                Lines(name, TIME, y_axis, series.time_s, of, linked=f"models {run.name}", height=220)
                for (name, y_axis), of in zip(axes, curves, strict=True)
            )
        )
    return [_errors(run, channels, predicted), Grid(columns, (1,) * len(columns))]


def _curves(values: Mapping[str, Floats], looks: Mapping[str, tuple[Form, Role]]) -> list[Curve]:
    return [Curve(name, value, looks[name][1], looks[name][0]) for name, value in values.items()]


def _errors(run: Run, channels: Sequence[Channel], predicted: Mapping[str, Mapping[Channel, Floats]]) -> Table:
    head = ["model"]
    for channel in channels:
        unit = channel.difference.symbol
        head += [f"{channel.symbol}: RMS error [{unit}]", f"{channel.symbol}: × noise", f"{channel.symbol}: fit"]
    rows = []
    for name, found in predicted.items():
        row = [name]
        for channel in channels:
            row += _error(run, channel, found[channel]) if channel in found else ["", "", ""]
        rows.append(tuple(row))
    return Table(f"Models over {run.name} (fit: 1 − NRMSE; 100% is no error at all)", head, rows)


def _error(run: Run, channel: Channel, modelled: Floats) -> list[str]:
    """RMS error, the same over the noise, and the fit."""
    series = run.series[channel]
    rms = rms_error(modelled, series.value)
    fit = 1.0 - nrmse(modelled, series.value)
    return [f"{rms * channel.difference.factor:.3g}", f"{rms / noise_floor(series):.2f}", f"{fit:.1%}"]
