# SPDX-License-Identifier: Apache-2.0
"""The job under way: what it does, how far it is, its error falling, and the button that ends it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

from nicegui import ui

from lce_app.workbench.figures import Figures
from lce_app.workbench.jobs import Job
from lce_app.workbench.state import WorkbenchState

if TYPE_CHECKING:
    from lce_report import Block


class JobStatusBar:
    """A line at the foot of the page; ``follow`` brings it up to date."""

    def __init__(self, state: WorkbenchState) -> None:
        self._state, self._drawn = state, 0
        self._job: Job | None = None
        with ui.element("section").classes("job").props('aria-label="job under way"') as self._place:
            self._line = ui.label().props("role=status").mark("job")
            self._bar = ui.linear_progress(0.0, show_value=False).props('aria-label="progress of the job"')
            ui.button("Cancel", on_click=state.cancel).props("outline no-caps").mark("cancel")
            self._course = ui.element("div").classes("course")
        self._warnings = ui.label().classes("warnings").props("role=status").mark("job warnings")
        self._failed = ui.label().classes("bad failed").props("role=alert").mark("job failed")

    def follow(self) -> None:
        """Show the job as it is now."""
        job = self._state.job
        self._place.visible = self._state.working
        self._failed.visible = job is not None and job.state in ("failed", "cancelled")
        self._warnings.visible = job is not None and job.state == "done" and bool(job.warnings)
        if job is None:
            return
        self._warnings.text = "\n".join(f"{job.name}: {warning}" for warning in job.warnings)
        ended = "was stopped; what was recorded is among the runs" if job.gentle else "was cancelled"
        self._failed.text = f"{job.name}: {job.error}" if job.error else f"{job.name} {ended}"
        if not self._state.working:
            return
        if job is not self._job:
            self._begin(job)
        if not job.steps:
            return
        new = [p for p in job.steps[self._drawn :] if math.isfinite(p.rms)]
        self._drawn = len(job.steps)
        if new:
            self._figures.extend({job.measure: [[p.seconds for p in new], [p.rms for p in new]]})
        now = job.steps[-1]
        number = f", {job.measure} {now.rms:.3g} σ" if math.isfinite(now.rms) else ""
        self._line.text = f"{job.name}: {now.label} {now.done}/{now.total}{number} · {job.seconds:.0f} s"
        self._bar.value = now.done / now.total if now.total else 0.0

    def _begin(self, job: Job) -> None:
        """A figure for the number that the job reports; a gentle one reports none."""
        self._job, self._drawn = job, 0
        self._line.text, self._bar.value = f"{job.name}: starting", 0.0
        self._course.clear()
        if not job.gentle:
            with self._course:
                self._figures = Figures(partial(_course, job.measure))


def _course(measure: str) -> Sequence[Block]:
    from lce_app.workbench import drawings

    return drawings.course(measure)
