# SPDX-License-Identifier: Apache-2.0
"""Progress bars of the analysis commands, on stderr."""

from __future__ import annotations

from types import TracebackType

from tqdm import tqdm


class FitBar:
    """What an identification is doing, and its error falling: the `progress` of lce_analysis.fit."""

    def __enter__(self) -> FitBar:
        """Open the bar."""
        self._bar = tqdm(
            unit="step",
            dynamic_ncols=True,
            leave=False,
            bar_format="{desc}: {percentage:3.0f}%|{bar}| {postfix} [{elapsed}]",
        )
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close it, whatever happened."""
        self._bar.close()

    def __call__(self, label: str, done: int, total: int, rms: float) -> None:
        """Show ``done`` of ``total`` steps of ``label`` and the weighted RMS residual reached."""
        self._bar.total, self._bar.n = total, done
        self._bar.set_description_str(label, refresh=False)
        self._bar.set_postfix_str(f"residual {rms:.3g} σ", refresh=False)
        self._bar.update(0)
        if self._bar.format_dict["elapsed"] - getattr(self, "_shown", -1.0) > 0.1:
            self._shown = self._bar.format_dict["elapsed"]
            self._bar.refresh()
