# SPDX-License-Identifier: Apache-2.0
"""Physics of the light-driven LCE strip: P → T → d, no ROS.

A model is a tuple of terms (:mod:`lce_model.terms`), compiled into one loop (:mod:`lce_model.kernel.compose`).
"""

from lce_model.model import Model, Value, default_model
from lce_model.model_file import load_model, save_model
from lce_model.simulation import Stepper, Trajectory, simulate

__all__ = [
    "Model",
    "Stepper",
    "Trajectory",
    "Value",
    "default_model",
    "load_model",
    "save_model",
    "simulate",
]
