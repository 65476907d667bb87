# SPDX-License-Identifier: Apache-2.0
"""What the jobs leave for the page, as JSON files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TypeVar

from msgspec import Struct

from lce_analysis.diagnosis.diagnosis import Verdict
from lce_data.errors import LceError
from lce_data.schema import checked

Record = TypeVar("Record", bound=Struct)


class CandidateRecord(Struct, frozen=True):
    """The score test of one effect; ``settings`` are its parameters at the expected strength."""

    effect: str
    evidence: float
    p_value: float
    visibility: float
    predicted_fall: float
    aliases: tuple[str, ...]
    settings: dict[str, float]
    shown: bool


class DiagnosisRecord(Struct, frozen=True):
    """What the page shows of :meth:`lce_analysis.diagnosis.Diagnosis.as_detailed_json`."""

    verdict: Verdict
    sentences: tuple[str, ...]
    added: tuple[str, ...]
    candidates: tuple[CandidateRecord, ...]


class DesignRecord(Struct, frozen=True):
    """A waveform that was designed: what it is worth, and the command that does the same."""

    between: tuple[str, str]
    protocol: str
    separation: float
    hottest_c: float
    command: str
    sentences: tuple[str, ...] = ()


def read_record(file: Path, kind: type[Record]) -> Record:
    """Read what a job wrote. Raises LceError if the file is something else."""
    try:
        return checked(f"{file}: not what the workbench wrote", json.loads(file.read_text(encoding="utf-8")), kind)
    except LceError as error:
        raise LceError(f"{error}; delete it, and begin that job again") from None
    except ValueError:
        raise LceError(f"{file}: not a JSON file; delete it, and begin that job again") from None
