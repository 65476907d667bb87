# SPDX-License-Identifier: Apache-2.0
"""What the jobs leave for the page, as JSON files."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Final, TypeVar

from msgspec import Meta, Struct, to_builtins

from lce_analysis.diagnosis import Diagnosis
from lce_analysis.diagnosis.diagnosis import Verdict
from lce_analysis.diagnosis.ranking import Standing
from lce_analysis.discovery.discover import Verdict as DiscoveryVerdict
from lce_app.use_cases.discover import Written
from lce_app.workbench.kept_blocks import KeptSection, as_plain, from_plain, kept
from lce_data.errors import LceError
from lce_data.files import read_at_most
from lce_data.schema import checked
from lce_model.effects import library
from lce_model.trust import sha256
from lce_report.figures.leading import LeadingCandidate, StrengthByRun, leading_candidates
from lce_report.pages.diagnosis import signature_section
from lce_report.pages.discovery import discovery_sections
from lce_report.tables import AdditionTables, DiagnosisTables, diagnosis_tables

Record = TypeVar("Record", bound=Struct)
MOST_BYTES: Final = 200_000_000
"""Length of a record at most: those of many long runs hold a megabyte or two."""


class CandidateRecord(Struct, frozen=True):
    """What became of one effect; ``settings`` are its parameters as refitted, or as the score test expects them."""

    effect: str
    meaning: str
    standing: Standing
    reason: str
    evidence: float
    p_value: float
    visibility: float
    aliases: tuple[str, ...]
    settings: dict[str, float]
    shown: bool


class OtherBaseRecord(Struct, frozen=True):
    """The base model that explains the displacement better, with all its effects and what differs from run to run."""

    deformation: str
    effects: tuple[str, ...]
    varies: tuple[str, ...]


class DiagnosisRecord(Struct, frozen=True):
    """What the page shows of a diagnosis: its JSON, with the tables and pictures of its report.

    runs, held_out : names of the runs that it was found from and judged on; None if an earlier version did not say.
    files : their files, by role and :func:`from_folder` of the record; None if an earlier version did not say.
    """

    verdict: Verdict
    sentences: tuple[str, ...]
    added: tuple[str, ...]
    candidates: tuple[CandidateRecord, ...]
    tables: DiagnosisTables
    leading: tuple[LeadingCandidate, ...]
    sections: tuple[KeptSection, ...] = ()
    other_base: OtherBaseRecord | None = None
    runs: tuple[str, ...] | None = None
    held_out: tuple[str, ...] | None = None
    files: dict[str, list[str]] | None = None


class FoundRecord(Struct, frozen=True):
    """A function that was found, and its effect file: its name beside the record, and the SHA-256 of its content.

    rival : name of the file with the next formula that describes it as well; "" if there is none.
    """

    effect: str
    file: Annotated[str, Meta(pattern=r"^found[\w-]*\.py$")]
    sha256: str
    rival: Annotated[str, Meta(pattern=r"^(found[\w-]*\.py)?$")]


class DiscoveryRecord(Struct, frozen=True):
    """What the page shows of a discovery: its answer, and the sections of its report that need no run.

    values : TERM.PARAM of the model as refitted with what was found, the parameters of what was found left out.
    """

    verdict: DiscoveryVerdict
    sentences: tuple[str, ...]
    found: tuple[FoundRecord, ...]
    values: dict[str, float]
    sections: tuple[KeptSection, ...]


class AdditionRecord(Struct, frozen=True):
    """What the page shows of an effect added."""

    sentence: str
    tables: AdditionTables
    strength: StrengthByRun


class DesignRecord(Struct, frozen=True):
    """A waveform that was designed: what it is worth, and the command that does the same."""

    between: tuple[str, str]
    protocol: str
    separation: float
    hottest_c: float
    command: str
    sentences: tuple[str, ...] = ()


def diagnosis_record(found: Diagnosis, files: Mapping[str, Sequence[str]] | None = None) -> dict[str, Any]:
    """What :class:`DiagnosisRecord` reads, as plain values."""
    more = {"tables": diagnosis_tables(found), "leading": leading_candidates(found)}
    shown = [kept(signature_section(found.signatures))] if found.signatures else []
    of_runs = {"runs": found.runs, "held_out": found.held_out, "files": files}
    return {**found.as_detailed_json(), **to_builtins(more), **of_runs, "sections": [as_plain(one) for one in shown]}


def read_diagnosis(file: Path) -> DiagnosisRecord:
    """Read a diagnosis. Raises LceError if the file is something else, or was written by an earlier version."""
    content = _json(file)
    if isinstance(content, dict) and "verdict" in content and "tables" not in content:
        raise LceError(f"{file}: made by an earlier version: diagnose again")
    try:
        found = from_plain(content, DiagnosisRecord)
    except LceError as error:
        raise LceError(f"{file}: {error}; delete it, and begin that job again") from None
    for candidate in found.candidates:
        if strange := {candidate.effect, *candidate.aliases} - library().keys():
            raise LceError(f"{file}: {min(strange)!r} is no effect of the library; delete it, and diagnose again")
    return found


def discovery_record(written: Written) -> dict[str, Any]:
    """What :func:`read_discovery` reads, as plain values."""
    found = written.discovery
    functions = [
        FoundRecord(one.name, file.name, sha256(file), rival.name if (rival := written.rivals.get(file)) else "")
        for one, file in zip(found.found, written.effects, strict=True)
    ]
    record = DiscoveryRecord(
        verdict=found.verdict,
        sentences=found.sentences,
        found=tuple(functions),
        values={v.key: v.value for v in found.model.values if v.key in found.given},
        sections=tuple(map(kept, discovery_sections(found))),
    )
    return {**found.as_json(), **as_plain(record)}


def read_discovery(file: Path) -> DiscoveryRecord:
    """Read a discovery. Raises LceError if the file is something else."""
    try:
        return from_plain(_json(file), DiscoveryRecord)
    except LceError as error:
        raise LceError(f"{file}: {error}; delete it, and discover again") from None


def read_record(file: Path, kind: type[Record]) -> Record:
    """Read what a job wrote. Raises LceError if the file is something else."""
    return _record(file, _json(file), kind)


def _json(file: Path) -> object:
    try:
        return json.loads(read_at_most(file, MOST_BYTES))
    except (ValueError, RecursionError):
        raise LceError(f"{file}: not a JSON file; delete it, and begin that job again") from None


def _record(file: Path, content: object, kind: type[Record]) -> Record:
    try:
        return checked(f"{file}: not what the workbench wrote", content, kind)
    except LceError as error:
        raise LceError(f"{error}; delete it, and begin that job again") from None
