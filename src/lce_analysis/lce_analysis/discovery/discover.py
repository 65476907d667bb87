# SPDX-License-Identifier: Apache-2.0
"""What no library holds: which function of what is missing where, as a curve, as formulas, and as an effect file."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any, Literal

import numpy as np

from lce_analysis.diagnosis.diagnosis import Column, ErrorTable, errors
from lce_analysis.diagnosis.disturbed import outside
from lce_analysis.diagnosis.held_out import DataLeftOut
from lce_analysis.diagnosis.misfit import JudgedRuns, share_removed
from lce_analysis.diagnosis.stage_problem import Data, StagedFit, StageProblem, carried, refit_stages
from lce_analysis.discovery.closure import Closure, contenders, judged, refitted
from lce_analysis.discovery.closures import Examination, examine
from lce_analysis.discovery.curve import Curve, curve
from lce_analysis.discovery.formulas import Formula, formulas, with_formula
from lce_analysis.discovery.found_file import effect_file, name_of
from lce_analysis.discovery.random_walk import Walk, disturbances
from lce_analysis.discovery.words import in_words
from lce_analysis.identification.coarse import STEP_S
from lce_analysis.identification.identify import check_runs
from lce_analysis.options import DiscoverOptions, Drive
from lce_analysis.prediction import MECHANICAL, simulation_input, with_ambient_at_rest
from lce_analysis.signatures.catalogue import signatures
from lce_analysis.signatures.series import residual_series
from lce_analysis.signatures.signature import OF_SENSOR, Signature
from lce_data.channels import SENSORS, TEMPERATURE
from lce_data.errors import LceError
from lce_data.progress import CancelToken, Progress, silent, watched
from lce_data.run import Run
from lce_model import Model
from lce_model.closures import PLACES
from lce_model.closures import closure as closure_of

Verdict = Literal["found", "disturbance", "nothing"]


@dataclass(frozen=True)
class Found:
    """A function that is worth having.

    closure : the curve, refitted and judged.
    curve : what the data show of it.
    formulas : those that describe it, the best first; empty if none of the dictionary does.
    """

    closure: Closure
    curve: Curve
    formulas: tuple[Formula, ...]

    @property
    def name(self) -> str:
        """Name of the effect in its file."""
        return name_of(self.closure.candidate, self.formulas[0] if self.formulas else None)

    def effect_file(self, runs: Sequence[str]) -> str:
        """Text of an effect file: the simplest formula, or the curve where no formula describes it."""
        return self._file(self.formulas[0] if self.formulas else None, runs)

    def rival_file(self, runs: Sequence[str]) -> str | None:
        """Text of an effect file with the next formula, for an experiment that tells them apart; None without one."""
        return self._file(self.formulas[1], runs) if len(self.formulas) > 1 else None

    def _file(self, formula: Formula | None, runs: Sequence[str]) -> str:
        return effect_file(self.curve, formula, self.closure.weights.tolist(), runs)


@dataclass(frozen=True)
class Discovery:
    """What no library holds, and how that was found.

    Attributes
    ----------
    verdict : "found" (a function of a covariate is missing), "disturbance" (something that does not repeat), "nothing".
    given, before, model : as given, refitted, and with what was found, which its closures hold.
    signatures : what the residual of the refitted model shows, strongest first.
    found : the functions, in the order in which they were found: the heat, then the deformation.
    tried : every function that was refitted, with what speaks against it.
    examinations : what every function promised, by part of the model.
    walks : parameters that would have to change during the runs to explain what is left after that.
    train, test : errors of the three models on the runs and on those held out.
    explained : a sensor whose RMS error is within so many times its noise is explained.
    drive : what drove the deformation when the models were judged.
    runs, held_out : names.
    seconds : how long it took [s].
    """

    verdict: Verdict
    given: Model
    before: Model
    model: Model
    signatures: tuple[Signature, ...]
    found: tuple[Found, ...]
    tried: tuple[Closure, ...]
    examinations: tuple[Examination, ...]
    walks: tuple[Walk, ...]
    explained: float
    drive: Drive
    train: ErrorTable
    test: ErrorTable
    runs: tuple[str, ...]
    held_out: tuple[str, ...]
    seconds: float

    @property
    def largest(self) -> float:
        """The largest RMS error of a sensor that the final model leaves in the runs, in units of its noise."""
        return max(self.train.misfit["after"].rms.values())

    @property
    def heat_unexplained(self) -> bool:
        """Does the final model leave the temperature beyond its noise, so that the deformation was not searched?"""
        rms = self.train.misfit["after"].rms
        return TEMPERATURE in rms and len(rms) > 1 and rms[TEMPERATURE] > self.explained

    @property
    def sentences(self) -> tuple[str, ...]:
        """The answer in words."""
        return tuple(in_words(self))

    def as_json(self) -> dict[str, Any]:
        """The contract's record: all keys always there, numbers in SI or °C."""
        strongest = sorted(self.found, key=lambda f: -f.closure.examined.ln_evidence)
        return {
            "verdict": self.verdict,
            "signatures": [one.as_json() for one in self.signatures],
            "closures": [_closure_json(f) for f in strongest],
            "formulas": [_formula_json(i, f, one) for i, f in enumerate(strongest) for one in f.formulas],
            "error": {
                name: {column: dict(values) for column, values in table.nrmse.items() if column != "given"}
                for name, table in (("train", self.train), ("test", self.test))
            },
            "error_over_noise": {
                name: {column: {c.name: m.rms.get(c) for c in SENSORS} for column, m in table.misfit.items()}
                for name, table in (("train", self.train), ("test", self.test))
            },
            "seconds": self.seconds,
        }


def _closure_json(found: Found) -> dict[str, Any]:
    closure, drawn = found.closure, found.curve
    candidate = closure.candidate
    alike = dict.fromkeys((c.place.name, c.covariate.published) for c in closure.alike)
    return {
        "place": candidate.place.name,
        "covariate": candidate.covariate.published,
        "lag_s": candidate.tau_s,
        "set": [list(pair) for pair in alike],
        "ln_evidence": closure.examined.ln_evidence,
        "curve": np.column_stack([drawn.x, drawn.y, drawn.error]).tolist(),
        "words": drawn.words,
    }


def _formula_json(number: int, found: Found, formula: Formula) -> dict[str, Any]:
    return {
        "closure": number,
        "form": formula.form.name,
        "expression": formula.expression,
        "parameters": {name: [value, error] for name, value, error in formula.values},
        "set": [one.form.name for one in found.formulas],
    }


def discover(
    model: Model,
    runs: Sequence[Run],
    test_runs: Sequence[Run] = (),
    options: DiscoverOptions = DiscoverOptions(),
    progress: Progress = silent,
    cancel: CancelToken | None = None,
) -> Discovery:
    """Find an unknown function that a model lacks to explain runs: where it acts, of what it is, and its formula.

    Parameters
    ----------
    model : identified from these or like runs, with the effects that are known to act; it is refitted to all of them.
    runs : what the model is to explain.
    test_runs : held out; they decide whether a function is worth having. Without them each run is left out in turn.
    options : what is tried, and when it counts as found.
    progress : called after each step.
    cancel : stops between two steps and raises Cancelled.

    Returns
    -------
    Discovery
        The functions found, as curves and formulas, and the errors without and with them.

    Raises
    ------
    LceError
        If the runs do not hold what the model needs, or the model predicts no sensor.

    Examples
    --------
    >>> import lce_analysis as lce
    >>> found = lce.discover(model, runs, test_runs)  # doctest: +SKIP
    >>> [one.curve.words for one in found.found]  # doctest: +SKIP
    """
    began = perf_counter()
    search = _Search(model, runs, test_runs, options, watched(progress, cancel))
    search.run()
    seen = signatures(residual_series(search.base.model, runs, search.base.drive))
    return Discovery(
        verdict=_verdict(search, seen),
        given=model,
        before=search.base.model,
        model=search.present.model,
        signatures=seen,
        found=tuple(search.found),
        tried=tuple(search.tried),
        examinations=tuple(search.examinations),
        walks=search.walks,
        explained=options.diagnosis.explained,
        drive=search.present.drive,
        train=search.errors(model, search.data.judged),
        test=search.errors(model, search.tests),
        runs=tuple(run.name for run in runs),
        held_out=tuple(run.name for run in test_runs),
        seconds=perf_counter() - began,
    )


def _verdict(search: "_Search", seen: Sequence[Signature]) -> Verdict:
    """A disturbance is a walk that nothing explains, or a large signature of one."""
    if search.found:
        return "found"
    walks = any(walk.kind == "disturbance" for walk in search.walks)
    return "disturbance" if walks or any(one.name not in OF_SENSOR for one in outside(seen)) else "nothing"


class _Search:
    """The heat first, on the temperature alone, then the deformation: of each the best function worth having."""

    def __init__(
        self,
        model: Model,
        runs: Sequence[Run],
        test_runs: Sequence[Run],
        options: DiscoverOptions,
        progress: Progress,
    ) -> None:
        if not runs:
            raise LceError("no runs to learn from")
        check_runs(model, runs)
        model = with_ambient_at_rest(model, runs)
        self.options, self.progress = options, progress
        self.data = Data(JudgedRuns.of(runs), tuple(simulation_input(run, model) for run in runs))
        self.coarse = self.data.coarse(STEP_S)
        self.tests = JudgedRuns.of(test_runs)
        self.left_out = DataLeftOut(self.data.judged, self.tests, progress)
        self.found: list[Found] = []
        self.tried: list[Closure] = []
        self.examinations: list[Examination] = []
        self.walks: tuple[Walk, ...] = ()
        self.base = self.present = self._refitted(model)

    def run(self) -> None:
        """Search the heat, and where that is explained the deformation; refit what was found on every sample."""
        if stage := self._unexplained("heat"):
            self._search(stage)
        if not self._unexplained("heat") and (stage := self._unexplained("deformation")):
            self._search(stage)
        self.walks = disturbances(self.present, progress=self.progress)
        data = self.data
        self.base = refit_stages(self.base.model, data, (), self.options.diagnosis, self.progress)
        if self.found:
            self.present = refit_stages(self.present.model, data, (), self.options.diagnosis, self.progress)
        else:
            self.present = self.base

    def errors(self, given: Model, judged_runs: JudgedRuns) -> ErrorTable:
        """Errors of the three models."""
        models: dict[Column, Model] = {"given": given, "before": self.base.model, "after": self.present.model}
        drive = self.present.drive
        return ErrorTable(
            {column: judged_runs.misfit(model, drive) for column, model in models.items()},
            {column: errors(model, judged_runs.runs, drive) for column, model in models.items()},
        )

    def _refitted(self, model: Model) -> StagedFit:
        """The model refitted, with the closures that it lacks beside it."""
        lacking = [c for c in (closure_of(place.name) for place in PLACES) if c.reference not in model.effects]
        return refit_stages(model, self.coarse, lacking, self.options.diagnosis, self.progress)

    def _unexplained(self, part: str) -> StageProblem | None:
        """The part of the model, if it leaves its sensor beyond the noise."""
        stage = self.present.deformation if part == "deformation" else next(iter(self.present.heat[-1:]), None)
        if stage is None:
            return None
        own = MECHANICAL if part == "deformation" else (TEMPERATURE,)
        levels = [x for channel, x in stage.fit.mean_squares.items() if channel in own]
        return stage if levels and max(levels) > self.options.diagnosis.explained**2 else None

    def _search(self, stage: StageProblem) -> None:
        examination = examine(stage, self.options, self.progress)
        self.examinations.append(examination)
        least = np.log(max(len(examination.examined), 1) / self.options.false_alarm)
        chosen = [c for c in contenders(examination, self.options) if c[0].ln_evidence > least]
        tried = [refitted(examination, one, alike, self.progress) for one, alike in chosen]
        tried = [self._judged(one) for one in sorted(tried, key=lambda c: -c.gain)]
        self.tried += tried
        best = next((one for one in tried if not one.objection), None)
        if best is not None:
            self._accept(self._with_rivals(best, tried, examination), examination)

    def _judged(self, one: Closure) -> Closure:
        """What speaks against the function; it has to explain most of what a sensor of its part shows."""
        found = judged(one, self.left_out, self.options)
        if found.objection or found.held_out is None:
            return found
        before, after = found.held_out.errors.judged_before, found.held_out.errors.judged_after
        shares = [share_removed(before, after, c) for c in found.stage.channels if c in before.total]
        return found if max(shares, default=0.0) >= self.options.diagnosis.most else replace(found, objection="part")

    def _with_rivals(self, best: Closure, tried: Sequence[Closure], examination: Examination) -> Closure:
        """The same, with the functions that were refitted as well in its set."""
        allowed = 2.0 * np.log(self.options.diagnosis.min_likelihood_ratio) * examination.variance
        left = best.fit.error
        if left > self.options.diagnosis.near**2 * best.fit.residual.size:
            # Where much is left, the form of the function is not settled, and errors are no likelihoods.
            allowed = max(allowed, left)
        close = [one for one in tried if one is not best and not one.objection and best.gain - one.gain < allowed]
        return replace(best, alike=tuple(dict.fromkeys([*best.alike, *(c for one in close for c in one.alike)])))

    def _accept(self, best: Closure, examination: Examination) -> None:
        described = formulas(best, examination, self.options, self.progress)
        self.found.append(Found(best, curve(best), described))
        model = self.present.model.add(closure_of(best.candidate.place.name))
        problem = described[0].fit.problem if described else best.fit.problem
        model = carried(model, problem.model) if not described else with_formula(model, described[0])
        self.present = self._refitted(model)
