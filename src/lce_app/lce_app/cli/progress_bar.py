# SPDX-License-Identifier: Apache-2.0
"""Progress bars of the commands, on stderr."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from types import TracebackType
from typing import Self

from tqdm import tqdm


class _Bar:
    """A context that closes its tqdm bar. Nothing is shown before there is something to show."""

    def __init__(self) -> None:
        self._bar: tqdm[None] | None = None

    def __enter__(self) -> Self:
        """The bar itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the bar, whatever happened."""
        self.close()

    def close(self) -> None:
        """End the bar that is shown, if any."""
        if self._bar is not None:
            self._bar.close()
        self._bar = None


class FitBar(_Bar):
    """The step of an analysis and the error it has reached: a :class:`lce_data.progress.Progress`.

    ``form`` is how the error is shown.
    """

    def __init__(self, form: str = "residual {:.3g} σ") -> None:
        super().__init__()
        self._form = form
        self._shown = -1.0

    def __call__(self, label: str, done: int, total: int, rms: float) -> None:
        """Show ``done`` of ``total`` steps of ``label`` and the weighted RMS residual reached."""
        if self._bar is None:
            form = "{desc}: {percentage:3.0f}%|{bar}| {postfix} [{elapsed}]"
            self._bar = tqdm((), unit="step", dynamic_ncols=True, leave=False, bar_format=form)
        bar = self._bar
        bar.total, bar.n = total, done
        bar.set_description_str(label, refresh=False)
        bar.set_postfix_str(self._form.format(rms) if math.isfinite(rms) else "", refresh=False)
        bar.update(0)
        if bar.format_dict["elapsed"] - self._shown > 0.1:
            self._shown = bar.format_dict["elapsed"]
            bar.refresh()


class RecordingBar(_Bar):
    """The seconds played of each recording: a :class:`lce_data.progress.Progress`, with a bar for each label."""

    def __init__(self) -> None:
        super().__init__()
        self._label = ""

    def __call__(self, label: str, done: int, total: int, rms: float) -> None:
        """Show ``done`` of ``total`` seconds of ``label``."""
        if label != self._label:
            self.close()
            self._label = label
        if self._bar is None:
            self._bar = tqdm(
                (),
                total=total,
                desc=label,
                unit="s",
                file=sys.stderr,
                bar_format="{desc}: {percentage:3.0f}%|{bar}| {n:.0f}/{total:.0f} s [{elapsed}<{remaining}]",
                mininterval=0.1 if sys.stderr.isatty() else 2.0,
            )
        self._bar.update(done - self._bar.n)

    def finished(self, folder: Path) -> None:
        """End the bar of a recording and print its path on stdout."""
        self.close()
        print(folder, flush=True)
