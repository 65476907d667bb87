# SPDX-License-Identifier: Apache-2.0
"""Whether the distance sensor of a closed loop can be believed."""

from typing import Final

from lce_control.filters import Sample

FEWEST_REPEATS: Final = 10
"""Samples in which a sensor has to repeat itself before it counts as frozen."""


class DisplacementWatch:
    """Judges a distance sensor by what it sends, and latches a fault.

    A sensor is silent if nothing came for ``silent_after_s``. It is frozen if it repeats itself bit for bit for
    ``frozen_after_s``: the noise of a sensor that works moves its last digit. 0 is for a sensor without such noise,
    which cannot be judged so.

    Attributes
    ----------
    silent_after_s, frozen_after_s : [s]; may be set at any time.
    fault : what is wrong, empty if nothing is; it stays until `reset`.
    """

    def __init__(self, silent_after_s: float = 0.5, frozen_after_s: float = 0.15) -> None:
        self.silent_after_s, self.frozen_after_s = silent_after_s, frozen_after_s
        self.fault = ""
        self._newest: Sample | None = None
        self._same_since_s = 0.0
        self._repeats = 0

    def take(self, sample: Sample) -> None:
        """Take in a displacement [m] that was sent at its time [s]."""
        last, self._newest = self._newest, sample
        if last is None or sample.value != last.value or sample.t_s < last.t_s:
            self._same_since_s, self._repeats = sample.t_s, 0
        else:
            self._repeats += 1

    def judge(self, now_s: float) -> str:
        """The fault at ``now_s`` [s], none before the first sample; to be asked while the sensor is relied on."""
        if not self.fault and self._newest is not None:
            self.fault = self._cause(self._newest, now_s)
        return self.fault

    def reset(self) -> None:
        """Forget the fault. If its cause is still there, `judge` finds it again at once."""
        self.fault = ""

    def _cause(self, newest: Sample, now_s: float) -> str:
        if now_s - newest.t_s > self.silent_after_s:
            return f"no displacement for {now_s - newest.t_s:.2f} s"
        same_s = newest.t_s - self._same_since_s
        if self._repeats >= FEWEST_REPEATS and same_s >= self.frozen_after_s > 0.0:
            return f"the distance sensor has repeated {newest.value * 1e3:.4f} mm for {same_s:.2f} s; is it frozen?"
        return ""
