# SPDX-License-Identifier: Apache-2.0
"""Progress bars of the analysis commands, on stderr."""

from __future__ import annotations

import math
from types import TracebackType

from tqdm import tqdm


class FitBar:
    """What an identification is doing, and its error falling: the `progress` of lce_analysis.identification.

    ``form`` is how the error is shown.
    """

    def __init__(self, form: str = "residual {:.3g} σ") -> None:
        self._form = form
        self._bar: tqdm[None] | None = None
        self._shown = -1.0

    def __enter__(self) -> FitBar:
        """Nothing is shown before there is something to show."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close it, whatever happened."""
        if self._bar is not None:
            self._bar.close()

    def __call__(self, label: str, done: int, total: int, rms: float) -> None:
        """Show ``done`` of ``total`` steps of ``label`` and the weighted RMS residual reached."""
        if self._bar is None:
            self._bar = _bar()
        bar = self._bar
        bar.total, bar.n = total, done
        bar.set_description_str(label, refresh=False)
        bar.set_postfix_str(self._form.format(rms) if math.isfinite(rms) else "", refresh=False)
        bar.update(0)
        if bar.format_dict["elapsed"] - self._shown > 0.1:
            self._shown = bar.format_dict["elapsed"]
            bar.refresh()


def _bar() -> tqdm[None]:
    form = "{desc}: {percentage:3.0f}%|{bar}| {postfix} [{elapsed}]"
    return tqdm((), unit="step", dynamic_ncols=True, leave=False, bar_format=form)
