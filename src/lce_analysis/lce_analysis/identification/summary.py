# SPDX-License-Identifier: Apache-2.0
"""An identified model as text for people."""

from lce_analysis.identification.identifiability import Identifiability
from lce_data.channels import SENSORS
from lce_data.units import after_number
from lce_model import Model, Value


def summary(model: Model, report: Identifiability | None) -> str:
    """Parameters with standard errors, what the data leave open, and the error of each run.

    Parameters
    ----------
    model : as a fit left it, with its record.
    report : what the data say of the parameters, None if the fit was interrupted.
    """
    lines = [f"{v.key:24s} {v.value:12.6g}{after_number(v.unit):6s} {_known(v, model)}".rstrip() for v in model.values]
    if report is not None:
        pairs = [f"{one} and {other} ({rho:+.3f})" for one, other, rho in report.strong_correlations()]
        lines += ["", f"Strongly correlated: {', '.join(pairs)}."] if pairs else []
        lines += ["", "What the data leave open:", *(f"- {s}" for s in report.sentences)] if report.sentences else []
    return "\n".join([*lines, "", *_errors(model)])


def _known(value: Value, model: Model) -> str:
    """How well a parameter is known."""
    if value.fixed:
        return "fixed"
    if value.standard_error is not None:
        note = f"± {value.standard_error:.2g}"
    else:
        note = "" if value.determined is None else "not determined"
    return f"{note}  differs from run to run".strip() if value.key in model.varies else note


def _errors(model: Model) -> list[str]:
    """The error of each run and sensor, as lines of a table."""
    lines = [" ".join([f"{'run':24s}", *(f"{f'{channel.symbol} NRMSE':>8s}" for channel in SENSORS)])]
    for entry in model.fit["runs"]:
        errors = [entry.get(f"{channel.name}_nrmse") for channel in SENSORS]
        cells = ["       –" if error is None else f"{error * 100:7.2f}%" for error in errors]
        lines.append(" ".join([f"{entry['name']:24s}", *cells]))
    return lines
