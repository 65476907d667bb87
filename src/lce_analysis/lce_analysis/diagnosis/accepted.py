# SPDX-License-Identifier: Apache-2.0
"""Changes of the model that a search has accepted: an effect added, or a parameter that differs from run to run."""

from dataclasses import dataclass, replace
from typing import Self

from lce_analysis.diagnosis.held_out import HeldOut
from lce_analysis.diagnosis.linearized_fit import gained
from lce_analysis.diagnosis.misfit import Misfit, reduction
from lce_analysis.diagnosis.stage_problem import StagedFit
from lce_analysis.diagnosis.strength import strengths_of
from lce_analysis.diagnosis.trial import Trial
from lce_analysis.diagnosis.variation import VariationTrial


@dataclass(frozen=True)
class Change:
    """One change of the model that was accepted.

    without, with_it : the model refitted without and with it, all stages.
    train : errors of these two on the runs; held_out : on what was left out.
    trial : what was found in its stage.
    """

    without: StagedFit
    with_it: StagedFit
    train: tuple[Misfit, Misfit]
    held_out: HeldOut
    trial: Trial | VariationTrial

    @property
    def predicted_reduction(self) -> float:
        """Share of the error above the noise, in the sensors of its stage, that was promised before the refit."""
        return self.trial.predicted_reduction

    @property
    def actual_reduction(self) -> float:
        """The share that went, of the two models simulated."""
        return reduction(*self.train, self.trial.stage.channels)

    def between(self, without: StagedFit, with_it: StagedFit, train: tuple[Misfit, Misfit], held_out: HeldOut) -> Self:
        """The same change between two other models."""
        return replace(self, without=without, with_it=with_it, train=train, held_out=held_out)


@dataclass(frozen=True)
class VariationStep(Change):
    """One parameter found to differ from run to run."""

    trial: VariationTrial

    @property
    def key(self) -> str:
        """TERM.PARAM of the parameter."""
        return self.trial.key

    @property
    def label(self) -> str:
        """What was changed."""
        return f"{self.key} by run"

    @property
    def alias_set(self) -> tuple[str, ...]:
        """What was changed; nothing is known to look like it."""
        return (self.label,)


@dataclass(frozen=True)
class Step(Change):
    """One effect accepted; ``alias_set`` is its name, and those of effects that explain the same."""

    trial: Trial
    alias_set: tuple[str, ...]

    @property
    def added(self) -> str:
        """Name of the effect."""
        return self.trial.effect.name

    @property
    def label(self) -> str:
        """What was changed."""
        return self.added

    def between(self, without: StagedFit, with_it: StagedFit, train: tuple[Misfit, Misfit], held_out: HeldOut) -> Self:
        """The same change between two other models, with the strengths that these show.

        The effect may have been tried beside others that were taken back since.
        """
        step = super().between(without, with_it, train, held_out)
        trial = replace(self.trial, held_out=held_out)
        before, after = without.stage(trial.stage.part), with_it.stage(trial.stage.part)
        if before is not None and after is not None and set(before.channels) <= set(after.channels):
            found = strengths_of(after.fit, trial.effect)
            if found is not None:
                trial = replace(trial, stage=before, fit=after.fit, gain=gained(before.fit, after.fit), strengths=found)
        return replace(step, trial=trial)


Accepted = Step | VariationStep
"""A change of the model that was accepted."""
