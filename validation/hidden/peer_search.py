# SPDX-License-Identifier: Apache-2.0
"""The peer of the diagnosis: petab-select adds effects one by one while Schwarz's criterion (BIC) falls.

petab-select (PEtab-dev/petab_select, BSD-3) is a published tool for model selection. Models that are not SBML take the
route of its example "other model types": it proposes the models, the user's code calibrates them, and gets the
criterion back. Here the user's code is least squares on the very simulator, runs and library of the diagnosis.

* Model space: the base model with any subset of the library. Each effect is one *metaparameter*: all its parameters go
  from fixed to estimated in one step, and each of them counts in the criterion.
* Method ``forward`` with ``max_steps: 1``, criterion ``BIC``. It begins with the base model and ends when no single
  effect lowers the criterion; the default would go on to pairs, 210 of them.
* Calibration, with iid or autoregressive noise: :mod:`peer_calibration`.
"""

from __future__ import annotations

import json
import math
import tempfile
import time
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import petab_select
from peer_calibration import Calibrated, Floats, Noise, calibrate, calibrated_base, polished
from petab_select.constants import CANDIDATE_SPACE, ESTIMATE, TERMINATE, UNCALIBRATED_MODELS, Criterion

from lce_analysis.identification.problem import Problem
from lce_analysis.identification.stages import acts_on_temperature
from lce_analysis.prediction import predict
from lce_data.channels import Channel
from lce_data.noise import sensor_noise
from lce_data.run import Run
from lce_model import Model
from lce_model.effects import Effect, library

Tell = Callable[[str], None]


class OutOfBudget(Exception):
    """Time or the number of calibrations is used up."""


FILES = {
    "observables.tsv": "observableId\tobservableFormula\tnoiseFormula\ny\t1\t1\n",
    "conditions.tsv": "conditionId\nruns\n",
    "dummy.xml": '<sbml xmlns="http://www.sbml.org/sbml/level3/version2/core" level="3" version="2"><model/></sbml>\n',
    "petab.yaml": """\
format_version: 1
parameter_file: parameters.tsv
problems:
- condition_files: [conditions.tsv]
  measurement_files: [measurements.tsv]
  observable_files: [observables.tsv]
  sbml_files: [dummy.xml]
""",
    "select.yaml": """\
format_version: 1.0.0
criterion: BIC
method: forward
model_space_files: [model_space.tsv]
candidate_space_arguments: {max_steps: 1}
""",
}
"""Of the PEtab problem petab-select reads which parameters there are and how many measurements. The rest are dummies,
as in its own example."""


def select_problem(folder: Path, base: Problem, effects: Sequence[Effect], noise: Noise) -> petab_select.Problem:
    """The model space of a base model and its candidates, written to a folder and read by petab-select."""
    members = {e.name: [f"{e.name}__{p.name}" for p in e.parameters if not p.fixed] for e in effects}
    always = [base.model.values[i].key.replace(".", "__") for i in base.free]
    always += [f"start_k_{i}" for i in base.free_starts]
    if noise == "iid":
        always += [f"sigma_{channel.name}" for channel in dict.fromkeys(s.channel for s in base.observed)]
    parameters = [(name, 1) for name in always] + [(name, 0) for group in members.values() for name in group]
    head = "parameterId parameterScale lowerBound upperBound nominalValue estimate"
    options = ["0;estimate"] * len(members)
    space = [["model_subspace_id", "model_subspace_petab_yaml", *members], ["M", "petab.yaml", *options]]
    tables = {
        "parameters.tsv": [head.split(), *([name, "lin", "0", "1", "0", str(free)] for name, free in parameters)],
        "measurements.tsv": [["observableId", "simulationConditionId", "time", "measurement"]]
        + [["y", "runs", "0", "0"]] * base.size,
        "model_space.tsv": space,
    }
    files = FILES | {name: "".join("\t".join(row) + "\n" for row in rows) for name, rows in tables.items()}
    files["select.yaml"] += f"metaparameters: {json.dumps(members)}\n"
    for name, text in files.items():
        (folder / name).write_text(text)
    return petab_select.Problem.from_yaml(folder / "select.yaml")


class Search:
    """Calibrated models by the effects they have, and how much may be spent on more of them."""

    def __init__(
        self, base: Calibrated, effects: Sequence[Effect], noise: Noise, budget: tuple[float, float], tell: Tell
    ) -> None:
        self.effects, self.noise, self.tell = {e.name: e for e in effects}, noise, tell
        self.known: dict[frozenset[str], Calibrated] = {frozenset(): base}
        self.most, self.end = budget[0], time.monotonic() + budget[1]

    def calibrated(self, names: frozenset[str], present: Sequence[str]) -> Calibrated:
        """The model with these effects, one more than ``present``. Raises OutOfBudget."""
        if names not in self.known:
            if len(self.known) > self.most or time.monotonic() > self.end:
                raise OutOfBudget
            (added,) = names.difference(present)
            self.tell(" + ".join([*present, f"{added}?"]))
            self.known[names] = calibrate(self.known[frozenset(present)], self.effects[added], self.noise)
        return self.known[names]

    def calibrate_all(self, asked: Sequence[frozenset[str]], present: Sequence[str]) -> None:
        """Calibrate what one step needs; the best of it, from which the next step goes on, to the last digit."""

        def penalised(names: frozenset[str]) -> float:
            found = self.calibrated(names, present)
            return found.log_likelihood - 0.5 * len(found.problem.free) * math.log(found.problem.size)

        if asked:
            best = max(asked, key=penalised)
            self.known[best] = polished(self.known[best], self.noise)

    def report(self, model: petab_select.Model) -> float:
        """Give a calibrated model its likelihood and, from that, its criterion; which is returned."""
        model.set_criterion(Criterion.LLH, self.known[switched_on(model)].log_likelihood)
        model.compute_criterion(Criterion.BIC)
        return float(model.get_criterion(Criterion.BIC))

    def forward(self, problem: petab_select.Problem) -> tuple[list[str], bool]:
        """Effects in the order in which petab-select adds them; and whether the search came to its end."""
        added: list[str] = []
        base = problem.model_space.model_subspaces["M"].parameters_to_model(dict.fromkeys(self.effects, 0))
        best = self.report(base)
        space = problem.new_candidate_space(predecessor_model=base)
        while True:
            begun = petab_select.ui.start_iteration(problem=problem, candidate_space=space)
            try:
                self.calibrate_all([switched_on(model) for model in begun[UNCALIBRATED_MODELS]], added)
            except OutOfBudget:
                return added, False
            for model in begun[UNCALIBRATED_MODELS]:
                self.report(model)
            ended = petab_select.ui.end_iteration(problem, begun[CANDIDATE_SPACE], begun[UNCALIBRATED_MODELS])
            if ended[TERMINATE]:
                return added, True
            space = ended[CANDIDATE_SPACE]
            chosen = petab_select.ui.get_best(problem, problem.state.models)
            if (criterion := chosen.get_criterion(Criterion.BIC)) < best:
                best = criterion
                added += sorted(switched_on(chosen) - set(added))


def switched_on(model: petab_select.Model) -> frozenset[str]:
    """Names of the effects whose parameters the model estimates."""
    return frozenset(name for name, value in model.parameters.items() if value == ESTIMATE)


def judge(
    train: Sequence[Run],
    test: Sequence[Run],
    base_model: Model,
    noise: Noise = "iid",
    effects: Sequence[Effect] | None = None,
    limit_models: float = math.inf,
    limit_s: float = math.inf,
    tell: Tell = lambda text: None,
) -> dict[str, Any]:
    """What petab-select adds to a model that `lce fit` has fitted to the runs.

    Parameters
    ----------
    train, test : runs to calibrate on, and held out.
    base_model : where the search begins.
    noise : "iid" or "autoregressive", as at the head of this file.
    effects : candidates; by default the whole library. Those that the base model has already are passed over, and
        where it has only a thermal stage those behind it.
    limit_models, limit_s : calibrations and seconds after which no further one begins. A step that was not finished
        adds nothing.
    tell : called with each candidate before it is calibrated.

    Returns
    -------
    dict
        "added": names in the order of addition; "finished": False where a limit was hit; "calibrations"; "seconds";
        "parameters": values of the added effects; "bic_fall": by how much the criterion fell in all; "held_out": RMS
        error on the runs held out, by sensor, in units of its sample-to-sample noise (not with no such run).
    """
    began = time.monotonic()
    chosen = [e for e in (library().values() if effects is None else effects) if e.reference not in base_model.effects]
    if base_model.deformation == "none":
        chosen = [e for e in chosen if acts_on_temperature(e)]
    base = calibrated_base(base_model, train, chosen, noise)
    search = Search(base, chosen, noise, (limit_models, limit_s - (time.monotonic() - began)), tell)
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        # petab reads its tables as pandas 2 wanted; petab-select meets models again at the end of every search.
        warnings.filterwarnings("ignore", module="petab")
        problem = select_problem(Path(folder), base.problem, chosen, noise)
        added, finished = search.forward(problem)
    model = search.known[frozenset(added)].problem.model
    fall = [search.known[frozenset(names)].log_likelihood for names in ((), added)]
    own = [v for v in model.values if v.term in added and not v.fixed]
    return {
        "noise": noise,
        "added": added,
        "finished": finished,
        "calibrations": len(search.known),
        "seconds": round(time.monotonic() - began, 1),
        "parameters": {v.key: float(f"{v.value:.4g}") for v in own},
        "bic_fall": round(2.0 * (fall[1] - fall[0]) - len(own) * math.log(base.problem.size), 1),
        "held_out": held_out(model, test),
    }


def held_out(model: Model, runs: Sequence[Run]) -> dict[str, float]:
    """RMS error of each sensor over the runs, in units of its sample-to-sample noise."""
    errors: dict[Channel, list[Floats]] = {}
    for run in runs:
        for channel, modelled in predict(model, run).at_samples.items():
            errors.setdefault(channel, []).append(modelled - run.series[channel].value)
    noise = sensor_noise(runs, errors)
    return {c.name: round(float(np.sqrt(np.mean(np.concatenate(e) ** 2))) / noise[c], 3) for c, e in errors.items()}
