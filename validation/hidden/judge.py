# SPDX-License-Identifier: Apache-2.0
"""One case of the hidden suite: make the strip's runs, fit, diagnose, and note what the gates need.

How large an error is, is told from the noise that was put in: RMS of measured minus modelled over RMS of measured minus
what an ideal sensor would have shown. Displacements within a quarter of a second of a jump of the strip do not count:
on which side of it one is hangs on a millikelvin, and a single one can outweigh the rest of a run. How visible a hidden
effect is does not come from the diagnosis either:

* with an exact base, what the fitted base leaves beyond the noise, √(rms²/noise² - 1), in the worse sensor;
* with an imperfect base, which leaves something anyway, the change that the effect makes to the ideal readings under
  the same power, less what the fitted base can follow of it by small changes of its free parameters (least squares on
  its first-order response, in which both sensors count alike): its RMS over the noise, in the worse sensor; no more
  than what the fitted base leaves in all.
"""

import math
import time
import traceback
from collections.abc import Mapping
from typing import Any

import numpy as np
from campaign import Case, campaign
from families import ALL
from numpy.typing import NDArray
from stages import Floats

from lce_analysis.diagnosis import diagnose
from lce_analysis.experiment_design import design
from lce_analysis.identification import fit
from lce_analysis.options import DesignOptions, FitOptions
from lce_analysis.prediction import predict, predict_from, simulation_input, start_temperature
from lce_data.channels import DISPLACEMENT, Channel
from lce_data.errors import LceError
from lce_data.run import Run
from lce_model import Model, default_model
from lce_model.effects import library

Ideal = Mapping[str, Mapping[Channel, Floats]]
"""What sensors without noise would have shown, by run."""
TOLD = ("effect", "stage", "standing", "reason", "actual_fall", "strength", "held_out", "aliases")
"""What is noted of each candidate that was judged on data left out."""
STEP = 1e-4
"""Of a parameter, in parts of itself, to differentiate the base's response."""
JUMP, AROUND_S = 20.0, 0.25
"""A strip jumps where it moves by so many times the sensor's noise from sample to sample; how far that reaches [s]."""


def judge(case: Case) -> dict[str, Any]:
    """Everything that the gates need to know of one case; with "failed", the message, if it raised."""
    record = {
        "case": case.name,
        "family": case.family,
        "hidden": list(case.hidden),
        "level": case.level,
        "library": case.library,
    }
    try:
        return record | _judged(case)
    except Exception as error:  # noqa: BLE001, whatever it is: the suite counts the case as a failure
        return record | {"failed": f"{type(error).__name__}: {error}", "traceback": traceback.format_exc()}


def _judged(case: Case) -> dict[str, Any]:
    family = ALL[case.family]
    train, test = campaign(case)
    ideal = {run.name: case.ideal(run) for run in (*train, *test)}
    began = time.perf_counter()
    model = fit(default_model("lumped", family.base), train, FitOptions(seed=case.seed)).model
    fitted = time.perf_counter()
    effects = [e for e in library().values() if case.library == "whole" or e.name not in case.hidden]
    found = diagnose(model, train, test, effects)
    seconds = time.perf_counter() - fitted
    record = found.as_json()
    base = over_noise(model, train, ideal)
    advised = found.other_base
    after = advised.model if advised else found.model
    steps = [*found.steps, *(advised.steps if advised else ())]
    differing = [f"{key} by run" for key in record["varies"]]  # nothing does: each one is a false addition
    result = {
        "misfit": max(math.copysign(math.sqrt(abs(x * x - 1.0)), x - 1.0) for x in base.values()),
        "verdict": record["verdict"],
        "advised": advised.deformation if advised else "",
        "added": [*(step.added for step in steps), *differing],
        "sets": [*(list(step.alias_set) for step in steps), *([name] for name in differing)],
        "before": over_noise(model, test, ideal),
        "after": over_noise(after, test, ideal),
        "after_on_every_sample": over_noise(after, test, ideal, at_jumps=True),
        "leader": record["candidates"][0]["effect"] if record["candidates"] else "",
        "tried": [{key: c[key] for key in TOLD} for c in record["candidates"] if c["held_out"]],
        "fingerprint": record["fingerprint"],
        "fit_s": round(fitted - began, 1),
        "diagnose_s": round(seconds, 1),
    }
    result["visible"] = result["misfit"]
    if not family.exact:
        result["visible"] = min(result["misfit"], unabsorbed(case, model, train, ideal))
    if family.exact and len(case.hidden) == 1 and len(result["sets"]) == 1 and len(result["sets"][0]) > 1:
        result["resolved"] = _resolved(case, found.model, result["sets"][0], model, train)
    return result


def over_noise(model: Model, runs: list[Run], ideal: Ideal, at_jumps: bool = False) -> dict[str, float]:
    """RMS error over RMS noise of each sensor, over all the runs, away from jumps of the strip or there as well."""
    predicted = {run.name: predict(model, run).at_samples for run in runs}
    found = {}
    for channel in next(iter(ideal.values())):
        error, noise = [], []
        for run in runs:
            series, true = run.series[channel], ideal[run.name][channel]
            of_sensor = series.value - true
            away = channel is DISPLACEMENT and not at_jumps
            counts = _away_from_jumps(series.time_s, true, _rms(of_sensor)) if away else slice(None)
            error.append((series.value - predicted[run.name][channel])[counts])
            noise.append(of_sensor[counts])
        found[channel.name] = _rms(np.concatenate(error)) / _rms(np.concatenate(noise))
    return found


def _away_from_jumps(time_s: Floats, ideal: Floats, noise: float) -> NDArray[np.bool_]:
    """Which samples (n,) of an ideal reading lie away from its jumps."""
    at = time_s[1:][np.abs(np.diff(ideal)) > JUMP * noise]
    return np.all(np.abs(time_s[:, None] - at) > AROUND_S, axis=1)


def unabsorbed(case: Case, model: Model, runs: list[Run], ideal: Ideal) -> float:
    """RMS over the noise, in the worse sensor, of what the hidden effects change and the model cannot follow."""
    if not case.hidden:
        return 0.0
    sensors = list(ideal[runs[0].name])
    noise = {c: _rms(np.concatenate([r.series[c].value - ideal[r.name][c] for r in runs])) for c in sensors}
    size = {c: sum(r.series[c].value.size for r in runs) for c in sensors}
    laid_out = {run.name: simulation_input(run, model) for run in runs}

    def stacked(of_run: Mapping[str, Mapping[Channel, Floats]]) -> Floats:
        return np.concatenate([of_run[r.name][c] / (noise[c] * math.sqrt(size[c])) for c in sensors for r in runs])

    def response(now: Model) -> Floats:
        return stacked({n: predict_from(i, start_temperature(i, now), now).at_samples for n, i in laid_out.items()})

    change = stacked(ideal) - stacked({r.name: case.ideal(r, hidden=False) for r in runs})
    here, columns = response(model), []
    for value in (v for v in model.values if not v.fixed):
        step = STEP * max(abs(value.value), 1e-3 * (value.upper - value.lower))
        step = step if value.value + step <= value.upper else -step
        column = response(model.set({value.key: value.value + step})) - here
        columns += [column / np.linalg.norm(column)] if column.any() else []
    basis = np.column_stack(columns)
    left = change - basis @ np.linalg.lstsq(basis, change, rcond=1e-10)[0]
    return max(float(np.linalg.norm(part)) for part in np.split(left, [size[sensors[0]]]))


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _resolved(case: Case, model: Model, alias: list[str], base: Model, train: list[Run]) -> bool:
    """Does the experiment that the tool asks for leave the hidden effect alone in its set?"""
    try:
        wanted = design(model, (alias[0], alias[1]), DesignOptions(case.strip.body.top_w, 400.0, 150.0))
    except LceError:
        return False
    again = diagnose(base, [*train, case.record("designed", wanted.power_w)]).as_json()
    return bool(again["steps"]) and again["steps"][0]["set"] == list(case.hidden)
