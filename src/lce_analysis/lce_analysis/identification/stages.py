# SPDX-License-Identifier: Apache-2.0
"""Which part of a model decides the temperature, and which the displacement."""

from typing import Final

from lce_data.channels import TEMPERATURE
from lce_model import Model, default_model
from lce_model.effects import Effect, find
from lce_model.terms import STAGES, Stage, Term, reads

HEAT_STAGES: Final = frozenset[Stage]({"surroundings", "light", "heat"})
MECHANICAL_STAGES: Final = frozenset(STAGES) - HEAT_STAGES


def acts_on_temperature(term: Term) -> bool:
    """Does the term change the temperature, or what the camera shows of it?"""
    return term.stage in HEAT_STAGES or TEMPERATURE.output in term.outputs


def acts_back(effect: Effect, model: Model) -> bool:
    """Does the effect change the temperature by what happens behind it in the model: order or displacement?"""
    alone = default_model(model.thermal, "none")
    names = {t.name for t in alone.terms}
    behind = {"order", *(signal for t in model.terms if t.name not in names for signal in t.outputs)}
    known = {signal for t in alone.terms for signal in t.outputs} | set(effect.outputs)
    return acts_on_temperature(effect) and any(reads(effect, signal) for signal in behind - known)


def thermal_stage(model: Model) -> Model:
    """The P→T stage by itself, which is the faster to simulate; the whole model where the strip acts back on it.

    Stages stand in their order: the values of the heat are the first ones of both models, those of sensors the last.
    """
    effects = [find(e) for e in model.effects]
    kept = tuple(e.reference for e in effects if acts_on_temperature(e))
    alone = default_model(model.thermal, "none", kept)
    names = {t.name for t in alone.terms}
    behind = {"order", *(signal for t in model.terms if t.name not in names for signal in t.outputs)}
    if any(reads(t, signal) for t in alone.terms for signal in behind):
        return model
    own = {v.key: v for v in model.values}
    varies = {key: v for key, v in model.varies.items() if key in alone}
    return alone.with_values(tuple(own[v.key] for v in alone.values), {}).varying(varies)
