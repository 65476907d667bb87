# SPDX-License-Identifier: Apache-2.0
"""The tables of a diagnosis and of an added effect: the command prints them, the report and the page draw them."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from lce_analysis.diagnosis.diagnosis import EVENT
from lce_analysis.diagnosis.misfit import Misfit, share_of
from lce_analysis.diagnosis.strength import Estimate
from lce_analysis.diagnosis.words import BEYOND
from lce_data.channels import SENSORS, Channel
from lce_data.units import after_number, in_head
from lce_model import Model
from lce_model.effects import library
from lce_report.blocks import Table

if TYPE_CHECKING:
    from lce_analysis.comparison.compare import Comparison
    from lce_analysis.diagnosis import Addition, Diagnosis
    from lce_analysis.diagnosis.accepted import Accepted, Step
    from lce_analysis.diagnosis.held_out import HeldOut
    from lce_analysis.diagnosis.ranking import Candidate, Standing
    from lce_analysis.discovery import Discovery
    from lce_model import RunValue

LEADING: Final = 4
"""Candidates whose strengths by run and pictures are shown, at most."""
MEANING: Final = "what it does"
"""The column of the ranking that is too wide for a terminal."""
NAMES: Final = 24
"""Letters that the names of runs may take in a label; more runs are counted."""
NOTHING: Final = "–"
SIDES: Final = ("train", "test")
WITHOUT_WITH: Final = "without → with: on data left out, × noise"


@dataclass(frozen=True)
class DiagnosisTables:
    """What reports show of a diagnosis beside its sentences.

    errors : of the model as given, refitted, and with what was added.
    steps : what each change of the model did; None if nothing was changed.
    varies : the values of each run of what differs from run to run; None if nothing does.
    strengths : of the leading candidates, run by run; None if nothing was tried.
    ranking : the candidates that were tried, sorted by what decides; None if nothing was.
    not_tried : the others, in sentences; empty if there are none.
    evidence : the score test of every candidate.
    """

    errors: Table
    steps: Table | None
    varies: Table | None
    strengths: Table | None
    ranking: Table | None
    not_tried: str
    evidence: Table


@dataclass(frozen=True)
class AdditionTables:
    """What reports show of an added effect beside its sentence.

    errors : of the model as given, refitted, and with the effect, for each run.
    strengths : of the effect, run by run.
    history : the models tried.
    """

    errors: Table
    strengths: Table
    history: Table


def diagnosis_tables(found: Diagnosis) -> DiagnosisTables:
    """Lay out a diagnosis."""
    tried = [c for c in found.candidates if c.trial is not None]
    others = [c.effect.name for c in found.candidates if c.trial is None]
    leaders = [c for c in leading(found) if c.trial and c.trial.strengths]
    return DiagnosisTables(
        errors=error_columns(found, [accepted.label for accepted in found.accepted]),
        steps=_steps(found.accepted) if found.accepted else None,
        varies=values_by_run(found.model) if found.model.varies else None,
        strengths=_strengths([_by_run(c, found.runs) for c in leaders]) if leaders else None,
        ranking=_ranking(tried, found.steps) if tried else None,
        not_tried=" ".join(_not_tried(others, found.not_examined)),
        evidence=Table(
            "The score test of each effect, alone: the last one made, beside what had been added by then",
            ("effect", "stage", "evidence", "p", "visible", "expected strength", "would show from", "looks like"),
            [_evidence(c) for c in found.candidates],
        ),
    )


def _not_tried(promised_little: Sequence[str], not_examined: Mapping[str, str]) -> Iterator[str]:
    if promised_little:
        names = ", ".join(promised_little)
        yield f"Not tried, because they promised too little, or less than those that were: {names}."
    events = [name for name, why in not_examined.items() if why == EVENT]
    own = [name for name in not_examined if name not in events and name not in library()]
    unread = [name for name in not_examined if name not in (*events, *own)]
    if unread:
        yield f"Not examined, because they read what a run did not record or what never changes: {', '.join(unread)}."
    for name in own:
        yield f"Not examined: {not_examined[name]}."
    if events:
        yield f"Not examined, because they begin at a time that several runs do not share: {', '.join(events)}."


def addition_tables(
    addition: Addition, compared: Mapping[str, Comparison], held_out: Collection[str] = ()
) -> AdditionTables:
    """Lay out an added effect.

    Parameters
    ----------
    addition : what adding it did.
    compared : the model as given, refitted, and with the effect, beside the same runs, by what they are called.
    held_out : names of the runs that nothing was fitted to.
    """
    amplitude = addition.amplitude
    return AdditionTables(
        errors=_errors_by_run(compared, held_out),
        strengths=_strengths([(f"{addition.effect}.{amplitude.name}", amplitude.unit, None, addition.strength_by_run)]),
        history=models_tried(addition.model),
    )


def leading(found: Diagnosis) -> tuple[Candidate, ...]:
    """The candidates that are shown in detail: what was added, then the best of what was tried."""
    tried = [c for c in found.candidates if c.trial is not None]
    return tuple(tried[: max(LEADING, len(found.steps))])


def outcome(standing: Standing, reason: str) -> str:
    """What became of a candidate, in words: "trace: it removes too little …"."""
    return f"{standing}: {reason}" if standing in ("missing", "trace") else reason


def estimate(value: float, standard_error: float, unit: str = "1") -> str:
    """A value with its standard error and unit, two digits of the error: "0.1201 ± 0.0012 W"."""
    after = after_number(unit)
    if not (math.isfinite(standard_error) and standard_error > 0.0):
        return f"{value:.3g}{after}".replace("-", "−")
    size = math.floor(math.log10(max(abs(value), standard_error)))
    ten = 0 if -4 < size < 5 else size
    digits = min(max(ten + 1 - math.floor(math.log10(standard_error)), 0), 8)
    scaled, error = (f"{x / 10.0**ten:.{digits}f}".replace("-", "−") for x in (value, standard_error))
    return f"{scaled} ± {error}{after}" if ten == 0 else f"({scaled} ± {error})e{ten}{after}"


def values_by_run(model: Model) -> Table:
    """What differs from run to run: a column for each parameter, a row for each run."""
    values = {key: model.values[model.index(key)] for key in model.varies}
    runs = dict.fromkeys(name for variation in model.varies.values() for name in variation.by_run)
    rows = [(name, *(_own(variation.by_run.get(name)) for variation in model.varies.values())) for name in runs]
    rows += [("another run", *(f"{value.value:.4g}" for value in values.values()))]
    spreads = [v.spread for v in model.varies.values()]
    rows += [("spread from run to run", *(NOTHING if x is None else f"{x:.2g}" for x in spreads))]
    head = ("run", *(in_head(key, value.unit) for key, value in values.items()))
    return Table("What differs from run to run, ± standard error", head, rows)


def models_tried(model: Model) -> Table:
    """NRMSE of the models in the history of a model, on the runs learnt from and on those held out."""
    columns = [(side, channel) for side in SIDES for channel in SENSORS]
    rows = []
    for entry in model.fit["history"]:
        errors = [entry[side].get(f"{channel.name}_nrmse") for side, channel in columns]
        name = " + ".join(x for x in (entry["thermal"], entry["deformation"], *entry["effects"]) if x != "none")
        rows.append((name, *("" if error is None else f"{error:.2%}" for error in errors), entry["verdict"]))
    head = ("model", *(f"{side} {channel.symbol}" for side, channel in columns), "verdict")
    return Table("Models tried (NRMSE)", head, rows)


def error_columns(found: Diagnosis | Discovery, added: Sequence[str]) -> Table:
    """Three columns for each sensor on each set of runs; without an addition the third would be the second."""
    head = ["runs", "sensor", "as given", "refitted"]
    rows = []
    for label, names, table in (("training", found.runs, found.train), ("held out", found.held_out, found.test)):
        given, before, after = (table.misfit[column] for column in ("given", "before", "after"))
        for channel in before.total:
            cells = [_rms(misfit, channel) for misfit in ((given, before, after) if added else (given, before))]
            went = [_went(before.mean_square(channel), after.mean_square(channel))] if added else []
            rows.append((f"{label}: {_few(names)}", channel.symbol, *cells, *went))
    if added:
        head += [f"with {' + '.join(added)}", "went"]
    about = " (went: share of the refitted model's squared error above the noise)" if added else ""
    return Table(f"RMS error, × noise{about}", head, rows)


def _errors_by_run(compared: Mapping[str, Comparison], held_out: Collection[str]) -> Table:
    rows = []
    for runs in zip(*(comparison.runs for comparison in compared.values()), strict=True):
        name = runs[0].run.name
        label = f"{name} (held out)" if name in held_out else name
        for channel in runs[0].channels:
            columns = [run.channels[channel].metrics.over_noise for run in runs]
            went = _went(*(x**2 for x in columns[-2:]))
            rows.append((label, channel.symbol, *(f"{x:.2f}" for x in columns), went))
    about = "RMS error, × noise (went: share of the refitted model's squared error above the noise)"
    return Table(about, ("run", "sensor", *compared, "went"), rows)


def _steps(steps: Sequence[Accepted]) -> Table:
    sensors = [c for c in SENSORS if any(c in step.held_out.before.total for step in steps)]
    head = ("added", "or", "predicted", "went", "judged on", *(f"{c.symbol} without → with" for c in sensors))
    rows = [
        (
            step.label,
            ", ".join(step.alias_set[1:]) or NOTHING,
            percent(step.predicted_reduction),
            percent(step.actual_reduction),
            left_out(step.held_out),
            *(without_with(step.held_out, c) for c in sensors),
        )
        for step in steps
    ]
    about = f"shares of the squared error above the noise; {WITHOUT_WITH}"
    return Table(f"What was added ({about})", head, rows)


def _own(own: RunValue | None) -> str:
    return NOTHING if own is None else estimate(own.value, own.standard_error or math.nan)


ByRun = tuple[str, str, Estimate | None, Mapping[str, Estimate | None]]
"""Name of a strength and its unit, the one from all runs together, and from each."""


def _by_run(candidate: Candidate, runs: Sequence[str]) -> ByRun:
    assert candidate.trial is not None and candidate.trial.strengths is not None
    found, amplitude = candidate.trial.strengths, candidate.amplitude
    by_run = dict(zip(runs, found.by_run, strict=True))
    return f"{candidate.effect.name}.{amplitude.name}", amplitude.unit, found.overall, by_run


def _strengths(found: Sequence[ByRun]) -> Table:
    """A column for each effect, a row for each run."""
    head = ["run"]
    columns: list[list[str]] = []
    for name, unit, overall, by_run in found:
        head.append(in_head(name, unit))
        columns.append([_estimate(e) for e in ([overall] if overall else []) + list(by_run.values())])
    _, _, overall, by_run = found[0]
    runs = [*(["all runs"] if overall else []), *by_run]
    rows = [(run, *(column[i] for column in columns)) for i, run in enumerate(runs)]
    about = "± standard error; of single runs to first order, which may lie beyond the bounds"
    return Table(f"Strength that each run wants ({about})", head, rows)


def _ranking(tried: Sequence[Candidate], steps: Sequence[Step]) -> Table:
    accepted = {step.added: step for step in steps}
    held_out = {c.effect.name: _held_out(c, accepted) for c in tried}
    sensors = [s for s in SENSORS if any(h is not None and s in h.before.total for h in held_out.values())]
    rows = []
    for c in tried:
        step, of = accepted.get(c.effect.name), held_out[c.effect.name]
        actual = c.actual_reduction if step is None else step.actual_reduction
        rows.append(
            (
                c.effect.name,
                c.effect.meaning,
                _estimate(c.strength, c.amplitude.unit),
                percent(c.predicted_reduction),
                NOTHING if actual is None else percent(actual),
                *(NOTHING if of is None else without_with(of, s) for s in sensors),
                outcome(c.standing, c.reason),
            )
        )
    changes = (f"{s.symbol} without → with" for s in sensors)
    head = ("effect", MEANING, "strength", "predicted", "went", *changes, "outcome")
    about = f"{WITHOUT_WITH}, beside the model as it was when the effect was tried"
    return Table(f"The candidates that were tried, sorted by what decides ({about})", head, rows)


def _held_out(c: Candidate, accepted: Mapping[str, Step]) -> HeldOut | None:
    if c.effect.name in accepted:
        return accepted[c.effect.name].held_out
    return c.trial.held_out if c.trial else None


def _evidence(c: Candidate) -> tuple[str, ...]:
    score, unit = c.score, c.score.direction.amplitude.unit
    after = after_number(unit)
    return (
        c.effect.name,
        c.effect.stage,
        f"{score.evidence:.4g}",
        f"{score.p_value:.1e}",
        f"{score.visibility:.1%}",
        f"{score.expected_strength:.3g}{after}",
        f"{score.detectable:.2g}{after}" if score.shown else "not at all",
        ", ".join(c.aliases),
    )


def _few(names: Sequence[str]) -> str:
    """The names of runs, or how many there are."""
    text = ", ".join(names)
    return text if len(text) <= NAMES or len(names) == 1 else f"{len(names)} runs"


def left_out(held_out: HeldOut) -> str:
    """What was left out, in a few words."""
    return _few(held_out.names) if held_out.how == "test runs" else held_out.how


def without_with(held_out: HeldOut, channel: Channel) -> str:
    """RMS errors of a sensor on data left out, × noise: "4.66 → 2.03"."""
    if channel not in held_out.before.total or channel not in held_out.after.total:
        return NOTHING
    return f"{_rms(held_out.before, channel)} → {_rms(held_out.after, channel)}"


def _rms(misfit: Misfit, channel: Channel) -> str:
    return f"{misfit.rms[channel]:.2f}" if channel in misfit.total else NOTHING


def _went(before: float, after: float) -> str:
    """Share of a mean squared error above the noise that went; of next to nothing there is none."""
    return percent(share_of(before, after)) if before > BEYOND**2 else NOTHING


def percent(share: float) -> str:
    """A share in whole percent."""
    return f"{share:z.0%}".replace("-", "−")


def _estimate(found: Estimate | None, unit: str = "1") -> str:
    return NOTHING if found is None else estimate(found.value, found.standard_error, unit)
