# SPDX-License-Identifier: Apache-2.0
"""Physics of the light-driven LCE strip: P → T → d, no ROS.

A model is a tuple of terms (:mod:`lce_model.terms`), compiled into one loop (:mod:`lce_model.compose`).
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from lce_model.errors import LceError

if TYPE_CHECKING:
    from lce_model.constants import KELVIN
    from lce_model.model import Model, Value, default_model
    from lce_model.model_file import load_model, save_model
    from lce_model.simulation import Stepper, Trajectory, simulate

__version__ = "0.1.0"

__all__ = [
    "KELVIN",
    "LceError",
    "Model",
    "Stepper",
    "Trajectory",
    "Value",
    "default_model",
    "load_model",
    "save_model",
    "simulate",
]

_HOME = {
    "KELVIN": "constants",
    **dict.fromkeys(("Model", "Value", "default_model"), "model"),
    **dict.fromkeys(("load_model", "save_model"), "model_file"),
    **dict.fromkeys(("Stepper", "Trajectory", "simulate"), "simulation"),
}
"""Loaded when they are first asked for: they need the compiler or scipy, and most nodes only an LceError."""


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
