# SPDX-License-Identifier: Apache-2.0
"""The simulated strip of a run: its model, its surroundings, and what the bench measures of it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from lce_data.channels import POWER, SENSORS
from lce_data.errors import LceError
from lce_data.units import KELVIN
from lce_drivers.simulation.strip import strip_model
from lce_model import Model


def simulated_strip(model: Path | None, settings: Mapping[str, float]) -> Model:
    """The strip of the simulator: a model file, None for the built-in model, changed by TERM.PARAM settings.

    Raises LceError for a strip that the simulator would refuse.
    """
    strip = strip_model(model or "", settings)
    if strip.thermal == "none":
        raise LceError(f"{model}: has no thermal stage; a strip on the bench is driven by laser power")
    return strip


def conditions(strip: Model) -> dict[str, float]:
    """What experiment.yaml says of the strip's surroundings."""
    found = {}
    if "ambient.t_env" in strip:
        found["ambient_temperature_c"] = round(strip["ambient.t_env"] - KELVIN, 6)
    if "strip.length" in strip:
        found["strip_length_m"] = strip["strip.length"]
    return found


def measured_topics(strip: Model) -> tuple[str, ...]:
    """The laser's power, and the topics of the sensors that have something to measure on the strip."""
    return (POWER.topic, *(channel.topic for channel in SENSORS if strip.predicts(channel)))
