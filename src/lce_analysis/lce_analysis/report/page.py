# SPDX-License-Identifier: Apache-2.0
"""From a Comparison to the text of the page."""

import html
import json
from importlib.resources import files
from string import Template
from typing import Any, Final

import numpy as np

from lce_analysis.compare import Comparison, Quantity, RunComparison, Stage
from lce_analysis.report.arrays import Arrays, spread, visible

SCALE: Final[dict[Quantity, tuple[float, str, float, str]]] = {
    "temperature": (1.0, "°C", 1.0, "K"),
    "displacement": (1e3, "mm", 1e6, "µm"),
}
"""Factor and unit of a quantity on the page, and of its residual."""
NAMES: Final[dict[Quantity, str]] = {"temperature": "temperature T", "displacement": "displacement d"}


def render(comparison: Comparison) -> str:
    """The self-contained page: answer first, then tables, then figures of every run."""
    arrays = Arrays()
    runs = [_run(run, arrays) for run in comparison.runs]
    here, uplot = files("lce_analysis.report"), files("uplot") / "static"
    return Template((here / "page.html").read_text(encoding="utf-8")).substitute(
        title=html.escape(f"LCE: {comparison.model.deformation} model against {_count(len(runs), 'run')}"),
        answer="".join(f"<p>{html.escape(s)}</p>" for s in comparison.sentences),
        metrics=_metrics(comparison),
        shares="".join(_shares(comparison, q) for q in comparison.shares),
        parameters=_parameters(comparison),
        style=(uplot / "uPlot.min.css").read_text(encoding="utf-8") + (here / "page.css").read_text(encoding="utf-8"),
        uplot=(uplot / "uPlot.iife.js").read_text(encoding="utf-8").replace("</script", "<\\/script"),
        script=(here / "page.js").read_text(encoding="utf-8"),
        runs=json.dumps(runs).replace("</", "<\\/"),
        numbers=arrays.packed(),
    )


def _count(n: int, noun: str) -> str:
    return f"{n} {noun}" if n == 1 else f"{n} {noun}s"


def _run(run: RunComparison, arrays: Arrays) -> dict[str, Any]:
    """Figures of a run: those over time share their axis, the others stand alone."""
    over_time: list[dict[str, Any]] = []
    others: list[dict[str, Any]] = []
    if run.run.power is not None:
        power = run.run.power
        keep = visible(power.value)
        over_time.append({
            "title": "laser power P", "unit": "W", "step": True,
            "x": arrays.add(power.time_s[keep]),
            "series": [{"label": "P", "kind": "input", "y": arrays.add(power.value[keep])}],
        })
    for stage in run.stages:
        over_time += _over_time(stage, arrays)
    displacement = next((s for s in run.stages if s.quantity == "displacement"), None)
    if displacement is not None:
        others.append(_loop(run, displacement, arrays))
    for stage in run.stages:
        others += _residuals(stage, arrays)
        others.append(_autocorrelation(stage, arrays))
    return {"name": run.run.name, "overTime": over_time, "others": others}


def _over_time(stage: Stage, arrays: Arrays) -> list[dict[str, Any]]:
    factor, unit, fine, fine_unit = SCALE[stage.quantity]
    keep = visible(stage.measured, stage.modelled, stage.residual)
    x = arrays.add(stage.time_s[keep])
    return [
        {
            "title": NAMES[stage.quantity], "unit": unit, "x": x,
            "series": [
                {"label": "measured", "kind": "measured", "y": arrays.add(stage.measured[keep] * factor)},
                {"label": "model", "kind": "model", "y": arrays.add(stage.modelled[keep] * factor)},
            ],
        },
        {
            "title": f"residual of {NAMES[stage.quantity]}, measured − model", "unit": fine_unit, "x": x, "low": True,
            "series": [{"label": "residual", "kind": "residual", "y": arrays.add(stage.residual[keep] * fine)}],
        },
    ]


def _loop(run: RunComparison, stage: Stage, arrays: Arrays) -> dict[str, Any]:
    """Displacement over temperature: the measured one over the measured temperature where there is one."""
    model_t = stage.regime.temperature_c
    measured_t = model_t
    of_temperature = next((s for s in run.stages if s.quantity == "temperature"), None)
    if of_temperature is not None:
        measured_t = np.interp(stage.time_s, of_temperature.time_s, of_temperature.measured)
    keep = spread(stage.time_s.size, 4000)
    return {
        "title": "loop: d over T", "xUnit": "°C", "unit": "mm", "line": True,
        "series": [
            {"label": label, "kind": kind, "x": arrays.add(t[keep]), "y": arrays.add(d[keep] * 1e3)}
            for label, kind, t, d in (
                ("measured", "measured", measured_t, stage.measured), ("model", "model", model_t, stage.modelled)
            )
        ],
    }


def _residuals(stage: Stage, arrays: Arrays) -> list[dict[str, Any]]:
    _, _, fine, fine_unit = SCALE[stage.quantity]
    keep = spread(stage.time_s.size)
    heating = stage.regime.heating[keep]
    figures = []
    for name, unit, values in (
        ("T", "°C", stage.regime.temperature_c),
        ("dT/dt", "K/s", stage.regime.rate_k_s),
        ("P", "W", stage.regime.power_w),
    ):
        figures.append({
            "title": f"residual of {NAMES[stage.quantity]} over {name}", "xUnit": unit, "unit": fine_unit,
            "series": [
                {
                    "label": label, "kind": label,
                    "x": arrays.add(values[keep][which]), "y": arrays.add(stage.residual[keep][which] * fine),
                }
                for label, which in (("heating", heating), ("cooling", ~heating))
            ],
        })
    return figures


def _autocorrelation(stage: Stage, arrays: Arrays) -> dict[str, Any]:
    c = stage.autocorrelation
    ends = np.array([0.0, float(c.lag_s[-1])])
    return {
        "title": f"autocorrelation of the residual of {NAMES[stage.quantity]}", "xUnit": "s", "unit": "1", "line": True,
        "series": [
            {"label": "residual", "kind": "residual", "x": arrays.add(c.lag_s), "y": arrays.add(c.value)},
            *(
                {"label": label, "kind": "band", "x": arrays.add(ends), "y": arrays.add(np.full(2, sign * c.band))}
                for label, sign in (("+1.96/√N", 1.0), ("−1.96/√N", -1.0))
            ),
        ],
    }


def _metrics(comparison: Comparison) -> str:
    rows = []
    for run in comparison.runs:
        for stage in run.stages:
            m = stage.metrics
            _, _, fine, unit = SCALE[stage.quantity]
            cells = (
                f"{m.rms * fine:.3g} {unit}", f"{m.rmse_printed * fine:.3g} {unit}", f"{m.nrmse:.2%}", f"{m.smape:.2%}",
                f"{m.noise * fine:.2g} {unit}", f"{m.over_noise:.2f}",
            )
            rows.append(
                f"<tr><th scope=row>{html.escape(run.run.name)}</th><td>{NAMES[stage.quantity]}</td>"
                + "".join(f"<td class=n>{c}</td>" for c in cells) + "</tr>"
            )
    return "".join(rows)


def _shares(comparison: Comparison, quantity: Quantity) -> str:
    """The table of error shares; the tint says how much of the error sits in a cell."""
    found = comparison.shares[quantity]
    quarters = sorted({(s.lower_c, s.upper_c) for s in found})
    head = "".join(f"<th scope=col>{low:.0f}–{high:.0f} °C</th>" for low, high in quarters)
    rows = []
    for branch in ("heating", "cooling"):
        for held in (False, True):
            cells = [
                next(s for s in found if (s.branch, s.held, s.lower_c) == (branch, held, low)) for low, _ in quarters
            ]
            body = "".join(
                f'<td class=n style="--tint:{s.error_share * 100:.0f}%" title="{s.sample_share:.1%} of the samples">'
                f"{s.error_share:.1%}</td>"
                for s in cells
            )
            rows.append(f"<tr><th scope=row>{branch}, {'hold' if held else 'ramp'}</th>{body}</tr>")
    return (
        f"<table class=tinted><caption>Share of the squared error of {NAMES[quantity]}</caption>"
        f"<thead><tr><th></th>{head}</tr></thead><tbody>{''.join(rows)}</tbody></table>"
    )


def _parameters(comparison: Comparison) -> str:
    rows = []
    for v in comparison.model.values:
        known = {True: "yes", False: "no", None: "fixed" if v.fixed else "–"}[v.determined]
        error = "–" if v.standard_error is None else f"{v.standard_error:.2g}"
        rows.append(
            f"<tr><th scope=row>{html.escape(v.key)}</th><td class=n>{v.value:.6g}</td><td class=n>{error}</td>"
            f"<td>{html.escape(v.unit)}</td><td>{known}</td><td>{html.escape(v.parameter.description)}</td></tr>"
        )
    return "".join(rows)
