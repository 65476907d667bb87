# SPDX-License-Identifier: Apache-2.0
"""Try out an effect of the user's own before it is used."""

from __future__ import annotations

import numpy as np

from lce_data.channels import AMBIENT
from lce_data.errors import LceError
from lce_data.waveforms import RATE_HZ
from lce_model import default_model, simulate
from lce_model.effects import Effect
from lce_model.terms import inputs_of


def try_effect(effect: Effect) -> None:
    """Simulate an effect at its null and at its typical strength under 25 s of light.

    Optional inputs that it reads rise: the load and what a user named from 0 to 1, the room by 5 K.

    Raises
    ------
    LceError
        If the effect changes something at its null value, or nothing at its typical one, or gives what is not finite.

    Examples
    --------
    >>> from lce_model.effects import find
    >>> try_effect(find("./my_effect.py"))  # doctest: +SKIP
    """
    time = np.arange(0.0, 60.0, 1.0 / RATE_HZ)
    power = np.where(time < 25.0, 1.5, 0.0)
    rise = np.linspace(0.0, 1.0, time.size)
    inputs = {c: 300.0 + 5.0 * rise if c is AMBIENT else rise for c in inputs_of((effect,))}
    bare = default_model()
    null = bare.add(effect.reference)
    without, there, typical = (
        simulate(m, time, power, inputs=inputs).signals
        for m in (bare, null, null.set({effect.strength_key: effect.typical}))
    )
    predicted = [n for n in without if np.isfinite(without[n]).all()]
    changed = [n for n in predicted if not np.array_equal(without[n], there[n])]
    if changed:
        raise LceError(f"{effect.path}: at {effect.strength} = {effect.null:g} it changes {', '.join(changed)}")
    if not all(np.isfinite(typical[n]).all() for n in typical if n in predicted or n in effect.outputs):
        raise LceError(f"{effect.path}: at {effect.strength} = {effect.typical:g} it gives what is not a number")
    if all(np.array_equal(without[n], typical[n], equal_nan=True) for n in without):
        raise LceError(f"{effect.path}: at {effect.strength} = {effect.typical:g} it changes nothing")
