# SPDX-License-Identifier: Apache-2.0
"""Identification of a model from runs: stage by stage, then all together.

1. The thermal stage, by Levenberg–Marquardt on the temperatures; a Hammerstein–Wiener one from the lumped one.
2. The deformation stage on the displacements, driven by the thermal state of 1 (or the measured temperature,
   smoothed): Levenberg–Marquardt from several starts for the equilibrium model (§4.5), the two-step strategy for the
   dynamic one (§5.3): differential evolution on one run, then Levenberg–Marquardt on all.
3. Every parameter of both stages at once, each output weighted by the misfit that 1 and 2 left.
"""

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Self

import numpy as np
from numpy.typing import NDArray

from lce_analysis.identification.bounds import reaching
from lce_analysis.identification.coarse import coarse, is_long
from lce_analysis.identification.first_guess import search_box, thinned, with_curves_guess, with_thermal_guess
from lce_analysis.identification.least_squares import (
    EPSILON,
    SLOW,
    TOLERANCE,
    Optimum,
    evolve,
    levenberg_marquardt,
    scattered,
)
from lce_analysis.identification.parallel import each
from lce_analysis.identification.problem import Problem, observed_series, start_conditions, with_thermal_state
from lce_analysis.identification.random_effects import settle
from lce_analysis.identification.result import FitResult
from lce_analysis.identification.stages import MECHANICAL_STAGES, acts_on_temperature, thermal_stage
from lce_analysis.inputs import check_inputs
from lce_analysis.options import FitOptions
from lce_analysis.prediction import (
    MECHANICAL,
    STATE,
    SimulationInput,
    excited,
    measured_drive,
    simulation_input,
    with_ambient_at_rest,
)
from lce_data.channels import SENSORS, TEMPERATURE, Channel
from lce_data.errors import LceError
from lce_data.noise import sensor_noise
from lce_data.progress import CancelToken, Progress, silent, watched
from lce_data.run import Run
from lce_model import Model, default_model
from lce_model.terms import STAGES, Stage

Floats = NDArray[np.float64]

ASTRAY = 0.1
"""Share of the spread of a series: a search that leaves more is begun again once, from other guesses."""
SPINODAL, RUNS_ON, JUMPS = "dynamic.spinodal", 0.01, 100.0
"""A parameter of the dynamic model, and values of it [1/K] in its two valleys."""
HALVING = ((40, 5), (8, 15), (4, 200))
"""Rounds of the least squares from several starts: how many of the best go on, for how many steps.

This shares out the work; the last round runs to the end whatever the first two were. Those that lead before it are
often in one valley, and a better one is among the next."""
HOP, HOP_STEPS = (0.03, 0.3), 30
"""Shortest and longest hop, as a standard deviation in each of the search variables; steps back down from it.

Of the 3.14 between the bounds of a parameter: from a hundredth of them to a tenth."""
REFINING = 12
"""Steps from a member of a population; the best go on, beside all runs."""


def fit(
    model: Model,
    runs: Sequence[Run],
    options: FitOptions = FitOptions(),
    progress: Progress = silent,
    cancel: CancelToken | None = None,
) -> FitResult:
    """Identify the free parameters of a model from all runs together: one parameter set.

    Parameters
    ----------
    model : what to fit; its values are where the search begins.
    runs : with the series that the model needs.
    options : seed, what drives the deformation, and how long to search.
    progress : called after each step, with the error reached.
    cancel : ends the fit, as Ctrl-C does, with the best values so far (``FitResult.interrupted``).

    Returns
    -------
    FitResult
        The model with its values, standard errors, and what the data leave open.

    Raises
    ------
    LceError
        If the runs do not hold what the model needs.

    Examples
    --------
    >>> import lce_analysis as lce
    >>> runs = lce.read_runs(["runs/pulse", "runs/stairs"])  # doctest: +SKIP
    >>> result = lce.fit(lce.default_model("lumped", "equilibrium"), runs)  # doctest: +SKIP
    >>> lce.save_model(result.model, "m.yaml")  # doctest: +SKIP
    """
    return _Search.of(model, runs, options, watched(progress, cancel)).result()


def rough_fit(model: Model, runs: Sequence[Run], options: FitOptions, progress: Progress) -> Model:
    """The stages identified one after the other on the grids of their searches: where a refit may begin.

    Raises KeyboardInterrupt where :func:`fit` would end with what it has.
    """
    search = _Search.of(model, runs, options, progress)
    search.stages()
    if search.interrupted:
        raise KeyboardInterrupt
    return search.model


def fit_each(
    model: Model,
    runs: Sequence[Run],
    options: FitOptions = FitOptions(),
    progress: Progress = silent,
    cancel: CancelToken | None = None,
) -> tuple[FitResult, ...]:
    """One parameter set for each run, as in the tables of Wu (2021); see :func:`fit`.

    After Ctrl-C those of the runs before, and the present one as far as it is.
    """
    tasks = [partial(_fit_one, model, run, options) for run in runs]
    found: list[FitResult] = []
    try:
        for result in each(tasks, "one fit for each run", watched(progress, cancel)):
            found.append(result)
            if result.interrupted:
                break
    except KeyboardInterrupt:
        if not found:
            raise
    return tuple(found)


def _fit_one(model: Model, run: Run, options: FitOptions, progress: Progress) -> FitResult:
    return fit(model, [run], options, lambda label, *rest: progress(f"{run.name}: {label}", *rest))


def check_runs(model: Model, runs: Sequence[Run], options: FitOptions = FitOptions()) -> None:
    """Raise LceError if a run says nothing of the model, a sensor is stuck, or the runs are not of one strip."""
    lengths = {run.name: run.strip_length_m for run in runs if run.strip_length_m is not None}
    if len(set(lengths.values())) > 1:
        listed = ", ".join(f"{name}: {length} m" for name, length in lengths.items())
        raise LceError(f"runs of strips of different length cannot share one parameter set ({listed})")
    mechanical = [channel for channel in MECHANICAL if model.predicts(channel)]
    check_sensors(model, runs)
    for run in runs:
        if not mechanical and run.temperature is None:
            raise LceError(f"{run.name}: no temperature was measured, and the model has only a thermal stage")
        if mechanical and run.power is None and not any(channel in run.series for channel in mechanical):
            raise LceError(f"{run.name}: nothing in it says anything of this model")
        if run.power is not None and model.thermal != "none" and not excited(run, options):
            raise LceError(
                f"{run.name}: the laser power is {run.power.value[0]:g} W throughout; nothing can be identified from it"
            )
    if model.deformation != "none" and not any(channel in run.series for run in runs for channel in mechanical):
        names = " or ".join(channel.name for channel in mechanical)
        raise LceError(f"no run has a {names}; fit with --deformation none")


def check_sensors(model: Model, runs: Sequence[Run]) -> None:
    """Raise LceError if a sensor that the model predicts never changes: no error relative to its spread exists."""
    for run in runs:
        for channel, series in run.measured.items():
            if model.predicts(channel) and np.ptp(series.value) == 0.0:
                value = f"{channel.display.from_si(float(series.value[0])):g} {channel.display.symbol}"
                raise LceError(
                    f"{run.name}: the {channel.name} is {value} throughout, as of a sensor that is stuck; leave the "
                    "run out, or record it again"
                )


def _astray(problem: Problem, variables: Floats) -> bool:
    """Is a series left with so large an error that the search has probably ended in a poor minimum?"""
    channels = dict.fromkeys(series.channel for series in problem.observed)
    spread = {c: max(float(np.std(s.measured)) for s in problem.observed if s.channel is c) for c in channels}
    return any(problem.series_rms(variables, c) > ASTRAY * spread[c] for c in channels)


class _Search:
    """The state of one identification: a model that gets better, and the start temperatures that go with it."""

    def __init__(
        self, model: Model, inputs: Sequence[SimulationInput], options: FitOptions, progress: Progress
    ) -> None:
        self.model, self.options, self.progress = model, options, progress
        self._lay_out(inputs)
        self.starts = np.array([i.start_k if np.isfinite(i.start_k) else self._at_rest_k(i) for i in inputs])
        self.evaluations = 0
        self.interrupted = False

    @classmethod
    def of(cls, model: Model, runs: Sequence[Run], options: FitOptions, progress: Progress) -> Self:
        """Raise LceError if the runs do not hold what the model needs."""
        if not runs:
            raise LceError("no runs to fit")
        check_runs(model, runs, options)
        model = with_ambient_at_rest(reaching(model, runs), runs)
        for run in runs:
            check_inputs(run, model.terms)
        return cls(model, [simulation_input(run, model) for run in runs], options, progress)

    def _lay_out(self, inputs: Sequence[SimulationInput]) -> None:
        """Search on these, with the noise of their sensors."""
        self.inputs, self.noise = inputs, sensor_noise([i.run for i in inputs], SENSORS)

    def _at_rest_k(self, run_input: SimulationInput) -> float:
        if self.model.thermal == "none":
            return float("nan")
        return float(run_input.at_rest_k(self.model, self.model.vector[None])[0])

    def _free(self, stages: Collection[Stage]) -> tuple[int, ...]:
        """Positions of the parameters to fit among those of the terms of some stages."""
        chosen = {t.name for t in self.model.terms if t.stage in stages}
        return tuple(i for i, v in enumerate(self.model.values) if self.model.searches(v) and v.term in chosen)

    def _free_mechanical(self) -> tuple[int, ...]:
        """The same of what is behind the temperature; a lag of the camera is found with the heat."""
        camera = {t.name for t in self.model.terms if acts_on_temperature(t)}
        values = self.model.values
        return tuple(i for i in self._free(MECHANICAL_STAGES) if values[i].term not in camera)

    def _noise(self, channels: Collection[Channel]) -> dict[Channel, float]:
        """RMS noise of those channels that were measured."""
        return {channel: x for channel, x in self.noise.items() if channel in channels}

    def _polish(
        self, problem: Problem, label: str, tolerance: float = TOLERANCE, slow: float = 0.0
    ) -> tuple[Problem, Optimum]:
        found, optimum = settle(problem, label, self.progress, 100, tolerance, slow)
        self._count(optimum)
        return found, optimum

    def _to_the_end(self, problem: Problem, label: str) -> Problem:
        """A last fit, whose errors are in units of the misfit."""
        negligible, slow = self.options.negligible / problem.size, self.options.slow / problem.size
        return self._polish(problem, label, negligible, slow)[0]

    def _adopt(self, there: Problem) -> None:
        self.model, self.starts = there.model, there.starts_k

    def thermal(self) -> Problem | None:
        """Step 1; the best of several starts."""
        if self.model.thermal == "none":
            return None
        observed = observed_series(self.inputs, self._noise([TEMPERATURE]))
        alone = thermal_stage(self.model)
        heat = {t.name for t in alone.terms if acts_on_temperature(t)}
        free = tuple(i for i, v in enumerate(alone.values) if not v.fixed and v.term in heat)
        if not observed or not free:
            return None
        best: tuple[Problem, Optimum] | None = None
        whole = self.model
        for guess in self._thermal_guesses():
            alone = thermal_stage(guess.varying({}))
            problem = Problem(alone, self.inputs, free, self.starts, observed, with_thermal_state(self.inputs))
            found = self._polish(problem, "temperature")
            if best is None or found[1].rms < best[1].rms:
                best = found
            if self.interrupted:
                break
        assert best is not None
        if whole.varies and not self.interrupted:
            varying = thermal_stage(whole).set({v.key: v.value for v in best[0].model.values})
            free_starts, at_ambient = start_conditions(self.inputs, varying)
            own = replace(best[0], model=varying, free_starts=free_starts, at_ambient=at_ambient)
            best = self._polish(own, "temperature, run by run")
        self._adopt(best[0])
        self.model = whole.set({v.key: v.value for v in self.model.values}).varying(
            {**whole.varies, **self.model.varies}
        )
        places = tuple(self.model.index(alone.values[i].key) for i in free)
        return replace(best[0], model=self.model, free=places)

    def _thermal_guesses(self) -> Iterator[Model]:
        """Several time constants of a lumped model; a Hammerstein–Wiener model begins as the lumped one that fits.

        Any other begins at its own values.
        """
        if not self.options.time_constants:
            yield self.model
        elif self.model.thermal == "lumped":
            yield from (with_thermal_guess(self.model, self.inputs, tau) for tau in self.options.time_constants)
        elif self.model.thermal != "hammerstein_wiener":
            yield self.model
        else:
            lumped = _Search(default_model("lumped", "none"), self.inputs, self.options, self.progress)
            lumped.thermal()
            self.interrupted |= lumped.interrupted
            yield with_curves_guess(self.model, lumped.model, self.inputs)

    def driven_inputs(self) -> list[SimulationInput]:
        """The runs in which something behind the temperature was measured, driven by their temperature."""
        driven = []
        for run_input, start in zip(self.inputs, self.starts, strict=True):
            own = self.model.of_run(run_input.run.name, run_input.run.sha256)
            if not any(channel in run_input.run.series for channel in MECHANICAL):
                continue
            if self.options.drive == "measured":
                driven.append(measured_drive(run_input, own, float(start)))
            elif run_input.driven:
                driven.append(run_input)
            else:
                out = run_input.simulate(own, own.vector[None], np.array([start]))
                driven.append(replace(run_input, drive_k=np.ascontiguousarray(out[0, :, STATE["temperature"]])))
        return driven

    def deformation(self) -> Problem | None:
        """Step 2, on a coarse grid."""
        sigma = self._noise([channel for channel in MECHANICAL if self.model.predicts(channel)])
        free = self._free_mechanical()
        if self.model.deformation == "none" or not sigma or not free:
            return None
        full = self.driven_inputs()
        coarse = [thinned(i) for i in full]
        shared = self.model.varying({})  # what differs from run to run comes with the last least squares
        common = tuple(i for i in free if not shared.values[i].fixed)
        problem = Problem(shared, coarse, common, np.zeros(len(coarse)), observed_series(coarse, sigma))
        box = search_box(problem, coarse)
        label = f"{self.model.deformation} model"
        search = self._two_step if self.model.deformation == "dynamic" else self._of_random_guesses
        self._adopt_deformation(problem.at(search(problem, box, label).variables))
        return self._deformation_alone()

    def _deformation_alone(self) -> Problem:
        """The deformation on all samples of the inputs, driven by their temperature."""
        sigma = self._noise([channel for channel in MECHANICAL if self.model.predicts(channel)])
        driven = self.driven_inputs()
        observed = observed_series(driven, sigma)
        return Problem(self.model, driven, self._free_mechanical(), np.zeros(len(driven)), observed)

    def _best_of(self, problem: Problem, guesses: list[Floats], label: str) -> Optimum:
        """Least squares from several starts, those that lag behind given up early."""
        ranked: list[Optimum] = []
        for keep, iterations in HALVING:
            reached = [o.variables for o in ranked] or guesses
            if len(reached) <= HALVING[-1][0] and iterations < HALVING[-1][1]:
                continue
            found = []
            for guess in reached[:keep]:
                optimum = levenberg_marquardt(problem, guess, label, self.progress, iterations, slow=SLOW)
                self._count(optimum)
                found.append(optimum)
                if self.interrupted or optimum.rms < self.options.noise_level:
                    return min(found, key=lambda o: o.rms)
            ranked = sorted(found, key=lambda o: o.rms)
        return ranked[0]

    def _of_both_readings(self, problem: Problem, best: Optimum, label: str) -> Optimum:
        """The better of two valleys: x runs on beyond T* and T1 by the rates of chapter 5, or jumps as §5.1 says."""
        model = problem.at(best.variables).model
        if self.interrupted or SPINODAL not in model or model.index(SPINODAL) not in problem.free:
            return best
        other = model.set({SPINODAL: RUNS_ON if model[SPINODAL] > 1.0 else JUMPS})
        guess = replace(problem, model=other).first()
        name = f"{label}, other reading of §5.1"
        found = levenberg_marquardt(problem, guess, name, self.progress, HALVING[-1][1], slow=SLOW)
        self._count(found)
        return min(best, found, key=lambda optimum: optimum.rms)

    def _hop(self, problem: Problem, best: Optimum, label: str) -> Optimum:
        """Steps away from the best, near and far, and least squares from there; the lowest stays.

        Basin hopping at temperature zero (Wales and Doye 1997, arXiv:cond-mat/9803344).
        """
        rng = np.random.default_rng(self.options.seed)
        for hop in range(self.options.hops):
            if self.interrupted or best.rms < self.options.noise_level:
                break
            length = math.exp(rng.uniform(*np.log(HOP)))
            guess = best.variables + rng.normal(0.0, length, best.variables.size)
            name = f"{label}, hop {hop + 1}/{self.options.hops}"
            found = levenberg_marquardt(problem, guess, name, self.progress, HOP_STEPS, slow=SLOW)
            self._count(found)
            best = min(best, found, key=lambda optimum: optimum.rms)
        return best

    def _adopt_deformation(self, there: Problem) -> None:
        self.model = there.model.varying({**self.model.varies, **there.model.varies})

    def _two_step(self, problem: Problem, box: tuple[Floats, Floats], label: str) -> Optimum:
        """The two-step strategy of §5.3, then what lies around its optimum."""
        best = self._of_both_readings(problem, self._of_populations(problem, box, label), label)
        return self._hop(problem, best, label)

    def _of_populations(self, problem: Problem, box: tuple[Floats, Floats], label: str) -> Optimum:
        """Rough solutions p_r of §5.3, from the run whose series covers most, refined on all runs.

        A population that has closed in on a minimum is often in a local one, or in one that serves its run alone. So
        the search is repeated from another population until all runs are at the noise, or the best minimum of the one
        run has come twice.
        """
        one, enough = self._widest(problem)
        rough: list[Optimum] = []
        best: list[float] = []
        for attempt in range(self.options.evolutions):
            name = f"{label}, evolution {attempt + 1}/{self.options.evolutions}"
            found = self._evolution(one, enough, name, attempt, box)
            rough = sorted([*rough, *found], key=lambda optimum: optimum.rms)
            best.append(min(optimum.rms for optimum in found))
            if self.interrupted or self._came_twice(best):
                break
            if best[-1] < self.options.noise_level:
                refined = self._best_of(problem, [optimum.variables for optimum in rough], label)
                if self.interrupted or refined.rms < self.options.noise_level:
                    return refined
        return self._best_of(problem, [optimum.variables for optimum in rough], label)

    def _came_twice(self, reached: Sequence[float]) -> bool:
        """Has the last population found the best minimum, and for the second time?"""
        *others, last = reached
        return last == min(reached) and any(abs(last / other - 1.0) < self.options.same_minimum for other in others)

    def _widest(self, problem: Problem) -> tuple[Problem, float]:
        """The problem of the series with the widest range alone, and the weighted RMS residual that ends a search."""
        widest = max(problem.observed, key=lambda series: float(np.ptp(series.measured)))
        one = replace(
            problem, inputs=[problem.inputs[widest.run]], starts_k=np.zeros(1), observed=(replace(widest, run=0),)
        )
        name = problem.inputs[widest.run].run.name
        samples = next(i.time_s.size for i in self.inputs if i.run.name == name)
        return one, float(EPSILON * np.sqrt(samples) * self.model["strip.length"] * widest.weight)

    def _evolution(
        self, problem: Problem, enough: float, label: str, attempt: int, box: tuple[Floats, Floats]
    ) -> list[Optimum]:
        """One population: its scattered members after least squares."""
        rough, population = evolve(problem, enough, label, self.progress, (self.options.seed, attempt), box)
        self._count(rough, len(self.inputs))
        refined = []
        for guess in scattered(population, self.options.refined):
            if self.interrupted:
                break
            name = f"{label}, refined"
            refined.append(levenberg_marquardt(problem, guess, name, self.progress, REFINING, slow=SLOW))
            self._count(refined[-1], len(self.inputs))
        return refined or [rough]

    def _count(self, optimum: Optimum, share: int = 1) -> None:
        self.evaluations += optimum.evaluations // share
        self.interrupted |= optimum.interrupted

    def _of_random_guesses(self, problem: Problem, box: tuple[Floats, Floats], label: str) -> Optimum:
        """The best of many random starts; of others once more, where that one is astray."""
        best = self._best_of(problem, list(self._random_guesses(problem, box, label)), label)
        if self.interrupted or not _astray(problem, best.variables):
            return best
        again = self._best_of(problem, list(self._random_guesses(problem, box, label, attempt=1)), label)
        return min(best, again, key=lambda optimum: optimum.rms)

    def _random_guesses(
        self, problem: Problem, box: tuple[Floats, Floats], label: str, attempt: int = 0
    ) -> Iterator[Floats]:
        """The present values, the default ones of the base model, and the best of many random ones.

        At a second attempt the random ones are others.
        """
        yield problem.first()[: box[0].size]
        values = (problem.model.values[i] for i in problem.free)
        base = [v for v in values if v.term == problem.model.deformation]
        default = {v.key: min(max(v.parameter.default, v.lower), v.upper) for v in base}
        yield replace(problem, model=problem.model.set(default)).first()[: box[0].size]
        low, high = box
        seed = (self.options.seed, attempt) if attempt else self.options.seed
        candidates = low + (high - low) * np.random.default_rng(seed).random((self.options.random_guesses, low.size))
        free = problem.transformation.from_box(candidates)
        self.evaluations += self.options.random_guesses
        self.progress(label, 0, 1, float("nan"))
        yield from problem.transformation.to_search(free[np.argsort(problem.rms_of_rows(free))[: self.options.starts]])

    def joint(self, thermal: Problem, deformation: Problem) -> Problem:
        """Step 3: each output weighted by the misfit that is left, until the weights no longer change."""
        sigma = self._misfit(replace(thermal, model=self.model, starts_k=self.starts)) | self._misfit(deformation)
        self._jointly([coarse(i) for i in self.inputs], sigma, "both stages, coarser grid")
        for _ in range(self.options.reweighted):
            problem = self._jointly(self.inputs, sigma, "both stages")
            if self.interrupted:
                return problem
            before, sigma = sigma, self._misfit(problem)
            if max(abs(sigma[channel] / before[channel] - 1.0) for channel in sigma) < self.options.same_weights:
                break
        return problem

    def _jointly(self, inputs: Sequence[SimulationInput], sigma: Mapping[Channel, float], label: str) -> Problem:
        """Every parameter of both stages at once, from where the model stands; unchanged where it was interrupted."""
        observed = observed_series(inputs, sigma)
        conditions = start_conditions(inputs, self.model)
        problem = Problem(self.model, inputs, self._free(STAGES), self.starts, observed, *conditions)
        if not self.interrupted:
            problem = self._to_the_end(problem, label)
            self._adopt(problem)
        return problem

    def _misfit(self, problem: Problem) -> dict[Channel, float]:
        """RMS residual of each channel of a problem, at least its noise."""
        noise, first = self.noise, problem.first()
        channels = dict.fromkeys(series.channel for series in problem.observed)
        return {channel: max(problem.series_rms(first, channel), noise[channel]) for channel in channels}

    def _on_every_sample(
        self, inputs: Sequence[SimulationInput], thermal: Problem | None, deformation: Problem | None
    ) -> tuple[Problem | None, Problem | None]:
        """The stages of a search on a coarser grid, on every sample; where there is only the heat, fitted to them."""
        self._lay_out(inputs)
        if thermal is not None:
            observed = observed_series(inputs, self._noise([TEMPERATURE]))
            thermal = replace(thermal, model=self.model, inputs=inputs, observed=observed)
            if deformation is None:
                thermal, _ = self._polish(thermal, "temperature, every sample")
                self._adopt(thermal)
        return thermal, None if deformation is None else self._deformation_alone()

    def last_stage(self, deformation: Problem) -> Problem:
        """The deformation alone, on every sample: where only it is fitted, or the measured temperature drives it."""
        if self.interrupted:
            return deformation
        found = self._to_the_end(deformation, f"{self.model.deformation} model, all samples")
        self._adopt_deformation(found)
        return replace(found, model=self.model)

    def stages(self) -> tuple[Problem | None, Problem | None]:
        """Steps 1 and 2, on a coarser grid where a run is long."""
        every = self.inputs
        if any(is_long(i) for i in every):
            self._lay_out([coarse(i) if is_long(i) else i for i in every])
        thermal = self.thermal()
        deformation = None if self.interrupted else self.deformation()
        if any(is_long(i) for i in every) and not self.interrupted:
            return self._on_every_sample(every, thermal, deformation)
        return thermal, deformation

    def result(self) -> FitResult:
        thermal, deformation = self.stages()
        together = self.options.drive == "model" and self.options.reweighted > 0
        if thermal is not None and deformation is not None and together:
            problem = self.joint(thermal, deformation)
        elif deformation is not None:
            problem = self.last_stage(deformation)
        elif thermal is not None:
            problem = replace(thermal, model=self.model, starts_k=self.starts)
        else:
            raise LceError("none of the runs holds a series that this model predicts")
        problem = replace(problem, model=self.model)
        runs = [i.run for i in self.inputs]
        return FitResult.from_problem(problem, runs, self.starts, self.options, self.evaluations, self.interrupted)
