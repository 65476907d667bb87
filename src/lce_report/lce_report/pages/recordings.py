# SPDX-License-Identifier: Apache-2.0
"""The report of `lce import`: what was understood of each file."""

from __future__ import annotations

from collections.abc import Sequence

from lce_data.importing.recording import Recording
from lce_report.blocks import Section
from lce_report.figures.recording import recording_figures, recording_table
from lce_report.html.render import render
from lce_report.pages.footer import WRITTEN_BY


def render_recordings(recordings: Sequence[Recording]) -> str:
    """Foreign recordings as they were understood, one self-contained HTML file."""
    sections = tuple(
        Section(recording.path.name, (recording_table(recording), *recording_figures(recording)))
        for recording in recordings
    )
    answer = f"{len(recordings)} file{'s' if len(recordings) > 1 else ''} understood as below."
    return render("Imported recordings", (answer,), sections, (WRITTEN_BY,))
