# SPDX-License-Identifier: Apache-2.0
"""Identification of a model from runs: stage by stage, then all together.

1. The thermal stage, by Levenberg–Marquardt on the temperatures; a Hammerstein–Wiener one from the lumped one.
2. The deformation stage on the displacements, driven by the thermal state of 1 (or the measured temperature,
   smoothed): Levenberg–Marquardt from several starts for the equilibrium model (§4.5), the two-step strategy for the
   dynamic one (§5.3): differential evolution on one run, then Levenberg–Marquardt on all.
3. Every parameter of both stages at once, each output weighted by the misfit that 1 and 2 left.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from lce_analysis.identification.first_guess import search_box, thinned, with_curves_guess, with_thermal_guess
from lce_analysis.identification.least_squares import (
    EPSILON,
    TOLERANCE,
    Optimum,
    evolve,
    levenberg_marquardt,
    scattered,
)
from lce_analysis.identification.parallel import each
from lce_analysis.identification.problem import Problem, observed_series, start_conditions, with_thermal_state
from lce_analysis.identification.result import FitResult
from lce_analysis.prediction import (
    CAMERA,
    DISTANCE,
    TEMPERATURE,
    Drive,
    SimulationInput,
    excited,
    measured_drive,
    simulation_input,
)
from lce_data.errors import LceError
from lce_data.noise import noise_floor
from lce_data.progress import Progress, silent
from lce_data.run import Run
from lce_model import Model, default_model
from lce_model.effects import find
from lce_model.terms import reads

Floats = NDArray[np.float64]

HEAT_STAGES = frozenset({"surroundings", "light", "heat"})
GUESSED, GUESSES = 2000, 20
"""Random parameter sets tried, and how many of the best become starts of the least squares (§4.5)."""
EVOLUTIONS, FOUND_AGAIN = 6, 0.02
"""Populations that the two-step strategy tries at most (step 3 of §5.3.2: start again where a search went astray); two
that end at the same error, within 2 %, have found the same minimum, and are enough."""
HALVING = ((20, 8), (5, 25), (2, 200))
"""Rounds of the least squares from several starts: how many of the best go on, for how many steps."""
REFINED = 6
"""Members of each population that are refined by least squares."""
REWEIGHTED = 3
"""Rounds of the joint fit."""
NEGLIGIBLE = 0.05
"""The joint fit ends at a step that changes the sum of squares, in units of the misfit, by less: a fifth of a standard
error."""
NOISE_LEVEL = 1.05
"""RMS residual in units of the noise at which a search is over."""


def fit(
    model: Model,
    runs: Sequence[Run],
    drive: Drive = "model",
    progress: Progress = silent,
    seed: int = 0,
) -> FitResult:
    """Identify the free parameters of ``model`` from all ``runs`` together, one parameter set.

    Parameters
    ----------
    drive : what drives the T→d stage; with "measured" the stages are identified one after the other only.
    seed : of the random starts and populations; the same seed gives the same result.

    A KeyboardInterrupt ends the fit with the best values so far. LceError where the runs do not hold what the model
    needs.
    """
    if not runs:
        raise LceError("no runs to fit")
    check_runs(model, runs)
    inputs = [simulation_input(run, model) for run in runs]
    search = _Search(model, inputs, drive, progress, seed)
    return search.result()


def fit_each(
    model: Model, runs: Sequence[Run], drive: Drive = "model", progress: Progress = silent, seed: int = 0
) -> tuple[FitResult, ...]:
    """One parameter set for each run, as in the dissertation's tables."""
    tasks = [partial(_fit_one, model, run, drive, seed) for run in runs]
    return tuple(each(tasks, "one fit for each run", progress))


def _fit_one(model: Model, run: Run, drive: Drive, seed: int, progress: Progress) -> FitResult:
    return fit(model, [run], drive, lambda label, *rest: progress(f"{run.name}: {label}", *rest), seed)


def check_runs(model: Model, runs: Sequence[Run]) -> None:
    """Raise LceError where a run has nothing to say of the model, or the runs are not of one strip."""
    lengths = {run.name: run.strip_length_m for run in runs if run.strip_length_m is not None}
    if len(set(lengths.values())) > 1:
        told = ", ".join(f"{name}: {length} m" for name, length in lengths.items())
        raise LceError(f"runs of strips of different length cannot share one parameter set ({told})")
    for run in runs:
        if model.deformation == "none" and run.temperature is None:
            raise LceError(f"{run.name}: no temperature was measured, and the model has only a thermal stage")
        if model.deformation != "none" and run.displacement is None and run.power is None:
            raise LceError(f"{run.name}: nothing in it says anything of this model")
        if run.power is not None and model.thermal != "none" and not excited(run):
            raise LceError(
                f"{run.name}: the laser power is {run.power.value[0]:g} W throughout; nothing can be identified from it"
            )
    if model.deformation != "none" and all(run.displacement is None for run in runs):
        raise LceError("no run has a displacement; fit with --deformation none")


def _thermal_stage(model: Model) -> Model:
    """The P→T stage by itself, which is the faster to simulate; the whole model where the strip acts back on it.

    Stages stand in their order: its values are the first ones of the whole model, at the same places.
    """
    effects = [find(e) for e in model.effects]
    kept = tuple(e.reference for e in effects if e.stage in HEAT_STAGES or "measured_temperature" in e.outputs)
    alone = default_model(model.thermal, "none", kept)
    names = {t.name for t in alone.terms}
    behind = {"order", *(signal for t in model.terms if t.name not in names for signal in t.outputs)}
    if any(reads(t, signal) for t in alone.terms for signal in behind):
        return model
    own = {v.key: v for v in model.values}
    return alone.with_values(tuple(own[v.key] for v in alone.values), {})


class _Search:
    """The state of one identification: a model that gets better, and the start temperatures that go with it."""

    def __init__(
        self, model: Model, inputs: Sequence[SimulationInput], drive: Drive, progress: Progress, seed: int
    ) -> None:
        self.model, self.inputs, self.drive, self.progress, self.seed = model, inputs, drive, progress, seed
        self.starts = np.array([i.start_k if np.isfinite(i.start_k) else self._ambient() for i in inputs])
        self.evaluations = 0
        self.interrupted = False

    def _ambient(self) -> float:
        return self.model["ambient.t_env"] if self.model.thermal != "none" else float("nan")

    def _free(self, heat: bool, deformation: bool) -> tuple[int, ...]:
        stages = {t.name: t.stage for t in self.model.terms}
        return tuple(
            i
            for i, v in enumerate(self.model.values)
            if not v.fixed
            and (((stages[v.term] in HEAT_STAGES) and heat) or ((stages[v.term] not in HEAT_STAGES) and deformation))
        )

    def _sigma(self, column: int) -> float | None:
        """RMS noise of one output over all runs, None where it was not measured."""
        series = [i.run.temperature if column == CAMERA else i.run.displacement for i in self.inputs]
        floors = [noise_floor(s) for s in series if s is not None]
        return float(np.sqrt(np.mean(np.square(floors)))) if floors else None

    def _polish(self, problem: Problem, label: str, tolerance: float = TOLERANCE) -> Optimum:
        optimum = levenberg_marquardt(problem, problem.first(), label, self.progress, 100, tolerance)
        self._count(optimum)
        return optimum

    def _adopt(self, problem: Problem, variables: Floats) -> None:
        there = problem.at(variables)
        self.model, self.starts = there.model, there.starts_k

    def thermal(self) -> Problem | None:
        """Step 1; the best of several starts."""
        sigma = self._sigma(CAMERA)
        free = self._free(heat=True, deformation=False)
        observed = observed_series(self.inputs, sigma, None)
        if self.model.thermal == "none" or not observed or not free:
            return None
        best: tuple[Problem, Optimum] | None = None
        whole = self.model
        for guess in self._thermal_guesses():
            alone = _thermal_stage(guess)
            problem = Problem(alone, self.inputs, free, self.starts, observed, with_thermal_state(self.inputs))
            optimum = self._polish(problem, "temperature")
            if best is None or optimum.rms < best[1].rms:
                best = problem, optimum
            if self.interrupted:
                break
        assert best is not None
        self._adopt(best[0], best[1].variables)
        self.model = whole.set({v.key: v.value for v in self.model.values})
        return replace(best[0], model=self.model)

    def _thermal_guesses(self) -> Iterator[Model]:
        """Several time constants of a lumped model; a Hammerstein–Wiener model begins as the lumped one that fits."""
        if self.model.thermal == "lumped":
            yield from (with_thermal_guess(self.model, self.inputs, tau) for tau in (5.0, 20.0, 80.0, 320.0))
        else:
            lumped = _Search(default_model("lumped", "none"), self.inputs, self.drive, self.progress, self.seed)
            lumped.thermal()
            self.interrupted |= lumped.interrupted
            yield with_curves_guess(self.model, lumped.model, self.inputs)

    def driven_inputs(self) -> list[SimulationInput]:
        """The runs with a displacement, driven by their temperature."""
        driven = []
        for prepared, start in zip(self.inputs, self.starts, strict=True):
            if prepared.run.displacement is None:
                continue
            if self.drive == "measured":
                driven.append(measured_drive(prepared, self.model, float(start)))
            elif prepared.drive_k.size:
                driven.append(prepared)
            else:
                out = prepared.simulate(self.model, self.model.vector[None], np.array([start]))
                driven.append(replace(prepared, drive_k=np.ascontiguousarray(out[0, :, TEMPERATURE])))
        return driven

    def deformation(self) -> Problem | None:
        """Step 2, on a coarse grid."""
        sigma = self._sigma(DISTANCE)
        free = self._free(heat=False, deformation=True)
        if self.model.deformation == "none" or sigma is None or not free:
            return None
        full = self.driven_inputs()
        coarse = [thinned(i) for i in full]
        problem = Problem(self.model, coarse, free, np.zeros(len(coarse)), observed_series(coarse, None, sigma))
        box = search_box(problem, coarse)
        label = f"{self.model.deformation} model"
        guesses = self._two_step if self.model.deformation == "dynamic" else self._random_guesses
        best = self._best_of(problem, list(guesses(problem, box, label)), label)
        self._adopt_deformation(problem, best.variables)
        return Problem(self.model, full, free, np.zeros(len(full)), observed_series(full, None, sigma))

    def _best_of(self, problem: Problem, guesses: list[Floats], label: str) -> Optimum:
        """Least squares from several starts, those that fall behind given up early."""
        ranked: list[Optimum] = []
        for keep, iterations in HALVING:
            reached = [o.variables for o in ranked] or guesses
            if len(reached) <= HALVING[-1][0] and iterations < HALVING[-1][1]:
                continue
            found = []
            for guess in reached[:keep]:
                optimum = levenberg_marquardt(problem, guess, label, self.progress, iterations)
                self._count(optimum)
                found.append(optimum)
                if self.interrupted or optimum.rms < NOISE_LEVEL:
                    return min(found, key=lambda o: o.rms)
            ranked = sorted(found, key=lambda o: o.rms)
        return ranked[0]

    def _adopt_deformation(self, problem: Problem, variables: Floats) -> None:
        starts = self.starts
        self._adopt(problem, variables)
        self.starts = starts

    def _two_step(self, problem: Problem, box: tuple[Floats, Floats], label: str) -> Iterator[Floats]:
        """The rough solution p_r of §5.3, from the run whose displacement covers most.

        A population that has closed in on a minimum is often in a local one, so its scattered members are refined
        too, and a search that has not come down to the noise is repeated from another population.
        """
        reach = [float(np.ptp(b.measured)) for b in problem.observed]
        block = problem.observed[int(np.argmax(reach))]
        one = replace(
            problem, inputs=[problem.inputs[block.run]], starts_k=np.zeros(1), observed=(replace(block, run=0),)
        )
        samples = self.inputs[block.run].time_s.size
        enough = EPSILON * np.sqrt(samples) * self.model["strip.length"] * block.weight
        best: Optimum | None = None
        reached: list[float] = []
        for attempt in range(EVOLUTIONS):
            mine: Optimum | None = None
            name = f"{label}, evolution {attempt + 1}/{EVOLUTIONS}"
            rough, population = evolve(one, float(enough), name, self.progress, (self.seed, attempt), box)
            self._count(rough, len(self.inputs))
            for guess in scattered(population, REFINED):
                if self.interrupted:
                    break
                fine = levenberg_marquardt(one, guess, f"{name}, refined", self.progress, 100)
                self._count(fine, len(self.inputs))
                if mine is None or fine.rms < mine.rms:
                    mine = fine
            if mine is None:
                break
            if best is None or mine.rms < best.rms:
                best = mine
            if self.interrupted or best.rms < NOISE_LEVEL:
                break
            if any(abs(mine.rms / other - 1.0) < FOUND_AGAIN for other in reached) and mine is best:
                break
            reached.append(mine.rms)
        yield rough.variables if best is None else best.variables

    def _count(self, optimum: Optimum, share: int = 1) -> None:
        self.evaluations += optimum.evaluations // share
        self.interrupted |= optimum.interrupted

    def _random_guesses(self, problem: Problem, box: tuple[Floats, Floats], label: str) -> Iterator[Floats]:
        """The present values, then the best of many random ones."""
        yield problem.first()[: box[0].size]
        low, high = box
        candidates = low + (high - low) * np.random.default_rng(self.seed).random((GUESSED, low.size))
        free = problem.transformation.from_box(candidates)
        self.evaluations += GUESSED
        self.progress(label, 0, 1, float("nan"))
        yield from problem.transformation.to_search(free[np.argsort(problem.rms_of_rows(free))[:GUESSES]])

    def joint(self, thermal: Problem, deformation: Problem) -> Problem:
        """Step 3: each output weighted by the misfit that is left, until the weights no longer change."""
        sigma_t = self._misfit(replace(thermal, model=self.model, starts_k=self.starts), CAMERA)
        sigma_d = self._misfit(deformation, DISTANCE)
        free = self._free(heat=True, deformation=True)
        for _ in range(REWEIGHTED):
            observed = observed_series(self.inputs, sigma_t, sigma_d)
            problem = Problem(
                self.model, self.inputs, free, self.starts, observed, *start_conditions(self.inputs, self.model)
            )
            if self.interrupted:
                return problem
            self._adopt(problem, self._polish(problem, "both stages", NEGLIGIBLE / problem.size).variables)
            problem = replace(problem, model=self.model, starts_k=self.starts)
            before = sigma_t, sigma_d
            sigma_t, sigma_d = self._misfit(problem, CAMERA), self._misfit(problem, DISTANCE)
            if max(abs(sigma_t / before[0] - 1.0), abs(sigma_d / before[1] - 1.0)) < 0.05:
                break
        return problem

    def _misfit(self, problem: Problem, column: int) -> float:
        return max(problem.series_rms(problem.first(), column), self._sigma(column) or 0.0)

    def last_stage(self, deformation: Problem) -> Problem:
        """The deformation alone, on every sample: where only it is fitted, or the measured temperature drives it."""
        if self.interrupted:
            return deformation
        optimum = self._polish(deformation, f"{self.model.deformation} model, all samples")
        self._adopt_deformation(deformation, optimum.variables)
        return replace(deformation, model=self.model)

    def result(self) -> FitResult:
        thermal = self.thermal()
        deformation = None if self.interrupted else self.deformation()
        if thermal is not None and deformation is not None and self.drive == "model":
            problem = self.joint(thermal, deformation)
        elif deformation is not None:
            problem = self.last_stage(deformation)
        elif thermal is not None:
            problem = replace(thermal, model=self.model, starts_k=self.starts)
        else:
            raise LceError("none of the runs holds a series that this model predicts")
        problem = replace(problem, model=self.model)
        runs = [i.run for i in self.inputs]
        return FitResult.from_problem(problem, runs, self.starts, self.drive, self.evaluations, self.interrupted)
