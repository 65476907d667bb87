# SPDX-License-Identifier: Apache-2.0
"""Which terms a named model is made of."""

from typing import Final

from lce_data.errors import LceError, did_you_mean
from lce_model.deformation.bouc_wen import BOUC_WEN
from lce_model.deformation.branch import BRANCH
from lce_model.deformation.dynamic import DYNAMIC
from lce_model.deformation.equilibrium import EQUILIBRIUM
from lce_model.deformation.kinetic import KINETIC
from lce_model.deformation.prandtl_ishlinskii import PRANDTL_ISHLINSKII
from lce_model.deformation.stretch import NETWORK, STRETCH, STRIP
from lce_model.effects import find
from lce_model.surroundings import AMBIENT
from lce_model.terms import STAGES, Term, reads
from lce_model.thermal.hammerstein_wiener import HAMMERSTEIN_WIENER
from lce_model.thermal.lumped import LUMPED

THERMAL: Final[dict[str, tuple[Term, ...]]] = {
    "none": (),
    "lumped": (AMBIENT, LUMPED),
    "hammerstein_wiener": (AMBIENT, HAMMERSTEIN_WIENER),
}
"""P→T models. ``none``: the temperature is given (a bare T–d loop)."""

DEFORMATION: Final[dict[str, tuple[Term, ...]]] = {
    "none": (),
    "equilibrium": (BRANCH, EQUILIBRIUM, STRETCH, STRIP),
    "dynamic": (BRANCH, DYNAMIC, STRETCH, STRIP),
    "kinetic": (BRANCH, KINETIC, NETWORK, STRIP),
    "prandtl_ishlinskii": (BRANCH, PRANDTL_ISHLINSKII, STRIP),
    "bouc_wen": (BRANCH, BOUC_WEN, STRIP),
}
"""T→d models. ``none``: only the temperature is modelled (a plain heater)."""

PUBLISHED: Final[dict[str, dict[str, float]]] = {
    "equilibrium": {},
    "dynamic": {"stretch_law.alpha": 4.5, "lumped.gain": 73.0},
}
"""Published values of a deformation model that differ from the defaults of the terms that it shares: (5.10) of Wu
(2021), and a gain that takes the strip to the 390 K of §5.4."""


def terms(thermal: str, deformation: str, effects: tuple[str, ...] = ()) -> tuple[Term, ...]:
    """The model as a tuple of terms in the order of evaluation.

    An effect stands before the first base term of its stage that takes what it writes from it (a heat loss before the
    heat balance, a lag of the temperature before the branch that follows it), or else behind them all. Several of them
    stand there by their ``place``, then by name: the order of ``effects`` does not matter.

    Raises LceError if a model or an effect does not exist, if both stages are 'none', or if two terms have one name.
    """
    for kind, name, known in (("thermal", thermal, THERMAL), ("deformation", deformation, DEFORMATION)):
        if name not in known:
            raise LceError(f"{kind}: unknown model {name!r}{did_you_mean(name, known)}; one of {', '.join(known)}")
    if thermal == deformation == "none":
        raise LceError("thermal and deformation are both 'none'; choose at least one")
    base = THERMAL[thermal] + DEFORMATION[deformation]
    added = sorted((find(effect) for effect in effects), key=lambda e: (e.place, e.name))
    names = [t.name for t in (*base, *added)]
    if doubled := [e for e in added if names.count(e.name) > 1]:
        last = max(doubled, key=lambda e: e.path)
        raise LceError(f"{last.reference}: the model has a term {last.name} already")
    ordered: list[Term] = []
    for stage in STAGES:
        own = [t for t in base if t.stage == stage]
        extra = [t for t in added if t.stage == stage]
        for i, term in enumerate(own):
            feeding = [e for e in extra if _feeds(e, term) and not any(_feeds(e, t) for t in own[:i])]
            ordered += [*feeding, term]
        placed = {t.name for t in ordered}
        ordered += [e for e in extra if e.name not in placed]
    return tuple(ordered)


def _feeds(effect: Term, term: Term) -> bool:
    return any(reads(term, name) and name not in term.outputs for name in effect.outputs)
