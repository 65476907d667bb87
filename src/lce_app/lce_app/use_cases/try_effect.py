# SPDX-License-Identifier: Apache-2.0
"""Try out an effect of the user's own before it is used."""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from lce_data.channels import AMBIENT, POWER, SENSORS, TEMPERATURE, Channel
from lce_data.errors import LceError
from lce_data.waveforms import RATE_HZ
from lce_model import Model, Trajectory, default_model, simulate
from lce_model.effects import Effect
from lce_model.model import Floats
from lce_model.terms import inputs_of

HOTTEST_K: Final = 453.15
"""Where the light of the bench at its limit can bring a strip: 180 °C, at which the interlock of the simulated bench
acts."""


@dataclass(frozen=True)
class Conditions:
    """A simulated run that an effect is tried out in.

    Attributes
    ----------
    time_s, power_w : (n,) [s] and [W].
    gain : steady temperature of the strip per laser power [K/W]; that of the default model if None.
    """

    time_s: Floats
    power_w: Floats
    gain: float | None = None

    def simulate(self, effect: Effect) -> tuple[Trajectory, Trajectory, Trajectory]:
        """The strip without the effect, with it at its null value, and at its typical strength.

        Optional inputs that it reads rise: the load and what a user named from 0 to 1, the room by 5 K.
        """
        bare = default_model() if self.gain is None else default_model().set({"lumped.gain": self.gain})
        null = bare.add(effect.reference)
        rise = np.linspace(0.0, 1.0, self.time_s.size)
        inputs = {c: 300.0 + 5.0 * rise if c is AMBIENT else rise for c in inputs_of((effect,))}

        def run(model: Model) -> Trajectory:
            return simulate(model, self.time_s, self.power_w, inputs=inputs)

        return run(bare), run(null), run(null.set({effect.strength_key: effect.typical}))


def _pulses(on_s: float, off_s: float, count: int, power_w: float, gain: float | None = None) -> Conditions:
    time = np.arange(0.0, count * (on_s + off_s), 1.0 / RATE_HZ)
    return Conditions(time, np.where(time % (on_s + off_s) < on_s, power_w, 0.0), gain)


USUAL: Final = _pulses(25.0, 35.0, count=1, power_w=1.5)
FURTHEST: Final = _pulses(120.0, 80.0, count=3, power_w=2.0, gain=76.0)
"""2 W, the limit of the bench, on a strip that it heats to 180 °C; tried only where the usual run shows nothing."""


@dataclass(frozen=True)
class TriedOut:
    """What an effect did at its typical strength.

    Attributes
    ----------
    covered : the range of temperature, power and time of the run that shows the effect, in words.
    beyond : the range in which it did nothing, in words; empty if the usual run showed it.
    changes : largest change of what each sensor reports [SI], by channel.
    """

    covered: str
    beyond: str
    changes: Mapping[Channel, float]

    @property
    def sentences(self) -> Iterator[str]:
        """What was tried, and what it showed."""
        yield (
            f"Tried out {self.covered}: it compiles, changes nothing at its null value, and something at its typical "
            f"one{self._by_how_much}."
        )
        if self.beyond:
            yield f"It changes nothing {self.beyond}. Runs that go no further cannot show it."

    @property
    def _by_how_much(self) -> str:
        amounts = [
            f"{value * c.difference.factor:.3g} {c.difference.symbol} of {c.name}" for c, value in self.changes.items()
        ]
        return f" (up to {' and '.join(amounts)})" if amounts else ""


def try_effect(effect: Effect) -> TriedOut:
    """Simulate an effect at its null and at its typical strength under 25 s of light.

    If that shows nothing, it is tried once more as far as the bench can go: 2 W, 180 °C, 10 min.

    Raises
    ------
    LceError
        If the effect changes something at its null value, or nothing at its typical one, or gives what is not finite.

    Examples
    --------
    >>> from lce_model.effects import find
    >>> tried = try_effect(find("./my_effect.py"))  # doctest: +SKIP
    >>> print(*tried.sentences)  # doctest: +SKIP
    """
    beyond = ""
    for conditions in (USUAL, FURTHEST):
        without, there, typical = conditions.simulate(effect)
        _check(effect, without, there, typical)
        covered = _covered(conditions, without)
        if any(not np.array_equal(without.signals[n], typical.signals[n], equal_nan=True) for n in without.signals):
            return TriedOut(covered, beyond, _changes(without, typical))
        beyond = covered
    raise LceError(
        f"{effect.path}: at {effect.strength} = {effect.typical:g} it changes nothing {beyond}{_why(effect)}"
    )


def _check(effect: Effect, without: Trajectory, there: Trajectory, typical: Trajectory) -> None:
    """Raise LceError if it changes something at its null value, or gives what is not finite."""
    predicted = [n for n, values in without.signals.items() if np.isfinite(values).all()]
    changed = [n for n in predicted if not np.array_equal(without.signals[n], there.signals[n])]
    if changed:
        raise LceError(f"{effect.path}: at {effect.strength} = {effect.null:g} it changes {', '.join(changed)}")
    given = (values for n, values in typical.signals.items() if n in predicted or n in effect.outputs)
    if not all(np.isfinite(values).all() for values in given):
        raise LceError(f"{effect.path}: at {effect.strength} = {effect.typical:g} it gives what is not a number")


def _covered(conditions: Conditions, run: Trajectory) -> str:
    """Where a run went: "from 301 to 335 K (28 to 62 °C), 0 to 1.5 W, within 60 s"."""
    low, high = float(run.temperature_k.min()), float(run.temperature_k.max())
    power, celsius = conditions.power_w, TEMPERATURE.display.from_si
    return (
        f"from {low:.0f} to {high:.0f} K ({celsius(low):.0f} to {celsius(high):.0f} °C), "
        f"{power.min():g} to {power.max():g} {POWER.unit}, within {np.ptp(run.time_s):.0f} s"
    )


def _changes(without: Trajectory, typical: Trajectory) -> dict[Channel, float]:
    found = {c: float(np.max(np.abs(typical[c] - without[c]))) for c in SENSORS if np.isfinite(without[c]).all()}
    return {c: value for c, value in found.items() if value > 0.0}


def _why(effect: Effect) -> str:
    """What may be the reason: a strength that is not read, a parameter at its default, a range not reached."""
    if effect.strength not in inspect.signature(effect.step).parameters:
        return f": its step does not read {effect.strength}"
    others = [f"{p.name} = {p.default:g} {p.unit}".removesuffix(" 1") for p in effect.parameters]
    held = [text for text in others if not text.startswith(f"{effect.strength} = ")]
    at = f", with {', '.join(held)}" if held else ""
    return f"{at}: does it act beyond?"
