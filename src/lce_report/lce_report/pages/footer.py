# SPDX-License-Identifier: Apache-2.0
"""The foot of a report: from which model, data and software it was made."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from lce_data import __version__

if TYPE_CHECKING:
    from lce_analysis.options import Drive
    from lce_data.run import Run
    from lce_model import Model

DRIVES: Final[dict[Drive, str]] = {
    "model": "the model's own temperature drives its displacement",
    "measured": "the measured temperature, smoothed, drives the displacement",
}
WRITTEN_BY: Final = f"Written by lce {__version__}."


def model_name(model: Model) -> str:
    """The model in words."""
    stages = " + ".join(name for name in (model.thermal, model.deformation) if name != "none")
    effects = f" with {', '.join(model.effect_names)}" if model.effects else ""
    return f"{stages} model{effects}"


def provenance(model: Model, runs: Sequence[Run], drive: Drive = "model") -> tuple[str, ...]:
    """Lines on the model, what drives its deformation, the data and the software."""
    data = "; ".join(f"{run.name} {run.sha256[:12]}" for run in runs)
    fitted = ", ".join(str(entry["name"]) for entry in model.fit.get("runs", ()))
    return (
        f"Model: {model_name(model)}{f', fitted to {fitted}' if fitted else ''}. Drive: {DRIVES[drive]}.",
        f"Data (SHA-256): {data}.",
        WRITTEN_BY,
    )
