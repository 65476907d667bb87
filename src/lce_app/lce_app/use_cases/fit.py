# SPDX-License-Identifier: Apache-2.0
"""Identify a model from recorded runs and write its file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Final

import lce_analysis.identification as identification
from lce_analysis.identification import FitResult
from lce_analysis.identification.at_bounds import AtBound, at_bounds
from lce_analysis.identification.bootstrap import Bootstrap, bootstrap
from lce_analysis.identification.homogeneity import differing
from lce_analysis.identification.judgement import ChannelJudgement, judge
from lce_analysis.identification.profile import Profile, profiles
from lce_analysis.options import FitOptions
from lce_app.cluster import Cluster
from lce_app.errors import ContradictoryOptions
from lce_app.use_cases.loading import load_model_and_effects, load_runs
from lce_data.errors import LceError
from lce_data.progress import CancelToken, Progress, silent, watched
from lce_data.run import Run
from lce_model import Model, Variation, default_model, save_model


@dataclass(frozen=True)
class ModelChoice:
    """Which model is fitted, and the values from which the search begins.

    Parameters
    ----------
    thermal, deformation : base model of each stage; None stands for that of ``start``, without it for ``lumped`` and
        ``equilibrium``.
    effects : names of the library, or paths of effect files.
    start : model file with the values to begin with.
    settings : values to begin with, by TERM.PARAM, in the units of the model.
    ranges : bounds of the search, by TERM.PARAM.
    fixed : parameters that are not fitted.
    varies : parameters with a value for each run.
    """

    thermal: str | None = None
    deformation: str | None = None
    effects: tuple[str, ...] = ()
    start: Path | None = None
    settings: Mapping[str, float] = field(default_factory=dict)
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    fixed: tuple[str, ...] = ()
    varies: tuple[str, ...] = ()


@dataclass(frozen=True)
class Options:
    """How the model is fitted, and what is asked of the result.

    Parameters
    ----------
    search : of the identification itself: what drives the deformation, the seed, how long to search.
    per_run : fit one parameter set to each run instead of one to all of them.
    homogeneity : say whether one value of a parameter serves all runs; not done with ``per_run``.
    judged : say where the model does not describe the data, and compare built-in models on data left out if so; with
        ``per_run`` they are not compared.
    profile : compute the profile likelihood of every parameter, which takes minutes.
    bootstrap_draws : fits to resampled residuals; 0 for none.
    cluster : where fits run that do not depend on each other.
    """

    search: FitOptions = field(default_factory=FitOptions)
    per_run: bool = False
    homogeneity: bool = True
    judged: bool = True
    profile: bool = False
    bootstrap_draws: int = 0
    cluster: Cluster = field(default_factory=Cluster)


@dataclass(frozen=True)
class FittedModel:
    """A fit, the file that holds its model, what is wrong with it, and the intervals that were asked for.

    at_bounds : parameters that the search left at a bound.
    judgements : channels that the model does not describe.
    """

    result: FitResult
    file: Path
    profiles: tuple[Profile, ...] = ()
    bootstrap: Bootstrap | None = None
    at_bounds: tuple[AtBound, ...] = ()
    judgements: tuple[ChannelJudgement, ...] = ()

    @property
    def faults(self) -> tuple[str, ...]:
        """A sentence for each parameter at a bound, and some for each channel that the model does not describe."""
        judged = (sentence for judgement in self.judgements for sentence in judgement.sentences)
        return (*(bound.sentence for bound in self.at_bounds), *judged)


@dataclass(frozen=True)
class Fits:
    """What was fitted: one model, or one for each run.

    warnings : a sentence for each stage that the runs say nothing of, and one if a value does not serve all runs.
    """

    models: tuple[FittedModel, ...]
    warnings: tuple[str, ...]

    @property
    def interrupted(self) -> bool:
        """Was the search ended early? The files then hold the best values so far."""
        return any(fitted.result.interrupted for fitted in self.models)


LENGTH: Final = "strip.length"
DEFAULT_CHOICE = ModelChoice()
DEFAULTS = Options()


def fit(
    run_files: Sequence[Path],
    out: Path,
    choice: ModelChoice = DEFAULT_CHOICE,
    options: Options = DEFAULTS,
    progress: Progress = silent,
    cancel: CancelToken | None = None,
) -> Fits:
    """Identify a model from runs and write the model file.

    Parameters
    ----------
    run_files : bag folders, MCAP files or CSV files.
    out : model file to write; with ``options.per_run`` one file for each run, ``STEM-RUN.yaml``.
    choice : which model, and the values to begin with.
    options : how to fit, and what to compute beside the standard errors.
    progress : called after each step.
    cancel : stops between two steps; the file then holds the best values so far, as after Ctrl-C.

    Returns
    -------
    Fits
        The fits, their files, and warnings.

    Raises
    ------
    LceError
        If a run or the model cannot be used.
    ContradictoryOptions
        If ``choice`` names another base model than its ``start`` has.

    Examples
    --------
    >>> from pathlib import Path
    >>> fits = fit([Path("runs/pulse"), Path("runs/stairs")], Path("model.yaml"))  # doctest: +SKIP
    >>> print(fits.models[0].result.model["lumped.tau"])  # doctest: +SKIP
    """
    progress = watched(progress, cancel)
    start = _start_model(choice)
    runs = load_runs(run_files)
    model, warnings = choose_model(choice, runs, start)
    with options.cluster.used():
        results = _results(model, runs, options, progress)
        files = [_named(out, run) for run in runs] if options.per_run else [out]
        pairs = list(zip(results, files, strict=False))  # fewer results than runs after Ctrl-C
        for result, file in pairs:
            save_model(result.model, file)
        interrupted = any(result.interrupted for result in results)
        if options.homogeneity and not options.per_run and not interrupted:
            warnings += differing(results[0].problem, options.search)
        models = tuple(_with_intervals(result, file, options, progress) for result, file in pairs)
        for fitted in models:
            save_model(fitted.result.model, fitted.file)
        models = tuple(_judged(fitted, options, progress) for fitted in models)
    for fitted in models:
        save_model(fitted.result.model, fitted.file)
    return Fits(models, warnings)


def choose_model(choice: ModelChoice, runs: Sequence[Run], start: Model | None = None) -> tuple[Model, tuple[str, ...]]:
    """The model to fit, and a sentence for each stage that is left out, and for a length that the runs do not tell.

    A strip is as long as the runs say.
    """
    warnings: tuple[str, ...] = ()
    thermal, deformation = choice.thermal or "lumped", choice.deformation or "equilibrium"
    if start is not None:
        thermal, deformation = start.thermal, start.deformation
    if thermal != "none" and all(run.power is None for run in runs):
        thermal = "none"
        warnings += ("no run has a laser power: fitting the deformation alone",)
    if deformation != "none" and all(run.displacement is None for run in runs):
        if start is not None:
            raise LceError(
                f"no run has a displacement, and {choice.start} has the deformation stage {deformation}: "
                "start from a model without one"
            )
        deformation = "none"
        warnings += ("no run has a displacement: fitting the thermal stage alone",)
    model = default_model(thermal, deformation) if start is None else start
    for effect in choice.effects:
        model = model.add(effect)
    lengths = {run.strip_length_m for run in runs if run.strip_length_m is not None}
    if start is None and LENGTH in model and LENGTH not in choice.settings:
        if len(lengths) == 1:
            model = model.configured({LENGTH: lengths.pop()})
        elif not lengths:
            warnings += (
                f"no run says how long its strip is: fitting one of {model[LENGTH]:g} m (--set {LENGTH}=METRES)",
            )
    model = model.configured(choice.settings).hold(choice.ranges).fix(choice.fixed)
    return model.varying({**model.varies, **{key: Variation() for key in choice.varies}}), warnings


def _start_model(choice: ModelChoice) -> Model | None:
    """The model of ``choice.start``. Raises ContradictoryOptions if another base model was asked for."""
    if choice.start is None:
        return None
    start, _ = load_model_and_effects(choice.start, choice.effects)
    for stage, asked, given in (
        ("thermal", choice.thermal, start.thermal),
        ("deformation", choice.deformation, start.deformation),
    ):
        if asked not in (None, given):
            raise ContradictoryOptions(
                stage, f"{asked} contradicts the start model {choice.start}, whose {stage} stage is {given}"
            )
    return start


def _results(model: Model, runs: Sequence[Run], options: Options, progress: Progress) -> tuple[FitResult, ...]:
    if options.per_run:
        return identification.fit_each(model, runs, options.search, progress)
    return (identification.fit(model, runs, options.search, progress),)


def _named(out: Path, run: Run) -> Path:
    name = run.name.replace("/", "-")  # runs of one name have the name of their folder in front
    return out.with_name(f"{out.stem}-{name}{out.suffix}")


def _judged(fitted: FittedModel, options: Options, progress: Progress) -> FittedModel:
    """The fit with what is wrong with it, in its record, too; Ctrl-C ends the search for it and leaves the fit."""
    result = fitted.result
    if result.interrupted:
        return fitted
    record = dict(result.model.fit)
    runs = [run_input.run for run_input in result.problem.inputs]
    try:
        bounds = at_bounds(result.problem, progress)
        record["at_bounds"] = [bound.sentence for bound in bounds]
        fitted = replace(fitted, at_bounds=bounds)
        if options.judged:
            found = judge(result, runs, options.search, progress, compared=not options.per_run)
            record["not_described"] = [judgement.as_json() for judgement in found]
            fitted = replace(fitted, judgements=found)
    except KeyboardInterrupt:
        pass
    return replace(fitted, result=replace(result, model=replace(result.model, fit=MappingProxyType(record))))


def _with_intervals(result: FitResult, file: Path, options: Options, progress: Progress) -> FittedModel:
    """The fit with the intervals that were asked for; none after Ctrl-C."""
    if result.interrupted:
        return FittedModel(result, file)
    draws, seed = options.bootstrap_draws, options.search.seed
    return FittedModel(
        result,
        file,
        profiles(result.problem, progress, options=options.search) if options.profile else (),
        bootstrap(result.problem, draws, seed, progress, options.search) if draws > 0 else None,
    )
