# SPDX-License-Identifier: Apache-2.0
"""Physics of the light-driven LCE strip: P → T → d, no ROS.

A model is a tuple of terms (:mod:`lce_model.terms`), compiled into one loop (:mod:`lce_model.kernel.compose`).

Examples
--------
>>> import numpy as np
>>> model = default_model("lumped", "kinetic").add("creep").set({"creep.share": 0.1})
>>> time_s = np.arange(0.0, 60.0, 0.01)
>>> run = simulate(model, time_s, np.where(time_s < 20.0, 1.0, 0.0))  # doctest: +SKIP
>>> run.temperature_k.max(), run.displacement_m.max()  # doctest: +SKIP
"""

from lce_model.model import Model, Value, default_model
from lce_model.model_file import load_model, save_model
from lce_model.simulation import Stepper, Trajectory, simulate
from lce_model.variation import RunValue, Variation

__all__ = [
    "Model",
    "RunValue",
    "Stepper",
    "Trajectory",
    "Value",
    "Variation",
    "default_model",
    "load_model",
    "save_model",
    "simulate",
]
