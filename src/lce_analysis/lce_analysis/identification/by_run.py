# SPDX-License-Identifier: Apache-2.0
"""What a value for each run would take of the error, read off the Jacobian: nothing is refitted.

All is taken as linear, and the other variables are re-estimated. A QR factorisation first reduces each run to as many
rows as there are columns. This leaves the least squares as they are, and every parameter can be asked for in
milliseconds, however many samples the runs have.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_analysis.identification.problem import PARAMETER_STEP, Problem
from lce_data.channels import DISPLACEMENT
from lce_model.effects import library

Floats = NDArray[np.float64]

ZERO_KEY: Final = "strip.zero"


def may_vary(problem: Problem) -> tuple[str, ...]:
    """Parameters of the base model that might differ from run to run and do not yet: the free ones, and the zero of d.

    The zero is the one that every run may have set anew, so it is tried although one for all runs is not fitted.
    """
    values = [problem.model.values[i] for i in problem.free]
    if ZERO_KEY in problem.model and any(series.channel is DISPLACEMENT for series in problem.observed):
        values.append(problem.model.values[problem.model.index(ZERO_KEY)])
    effects = {*library(), *problem.model.effect_names}
    found = dict.fromkeys(v.key for v in values if v.term not in effects)
    return tuple(key for key in found if key not in problem.model.varies)


class ByRun:
    """The columns of a problem at its least squares, and those of what may vary, run by run.

    keys : the parameters that can be asked for, :func:`may_vary`.
    """

    def __init__(self, problem: Problem, jacobian: Floats, residual: Floats) -> None:
        """``jacobian`` (N, variables) and ``residual`` (N,) of the problem where it stands."""
        self.keys = may_vary(problem)
        self._variables = jacobian.shape[1]
        self._residual = residual
        self._run_of = np.concatenate([np.full(series.size, series.run) for series in problem.observed])
        extra = [key for key in self.keys if problem.model.index(key) not in problem.free]
        self._columns = np.column_stack([jacobian, *(_column(problem, key) for key in extra)])
        self._place = {key: problem.free.index(problem.model.index(key)) for key in self.keys if key not in extra}
        self._place |= {key: self._variables + i for i, key in enumerate(extra)}
        self._reduced = [
            np.linalg.qr(np.column_stack([self._columns, residual])[self._run_of == i]).R
            for i in range(len(problem.inputs))
        ]
        self._without = self._solved([])[1]

    def gain(self, key: str) -> tuple[float, Floats]:
        """What the squared residual would fall by with a value of the parameter for each run.

        The second are the changes (runs,) of the values, on the scale of the search and up to a number that all share.
        """
        step, left = self._solved([key])
        return max(0.0, self._without - left), step[self._variables :]

    def rest(self, keys: Sequence[str]) -> Floats:
        """What would be left of the residual (N,) with a value for each run of all these parameters."""
        step, _ = self._solved(keys)
        found = self._residual + self._columns[:, : self._variables] @ step[: self._variables]
        for key, own in zip(keys, step[self._variables :].reshape(len(keys), -1), strict=True):
            found += self._columns[:, self._place[key]] * own[self._run_of]
        return np.asarray(found)

    def _solved(self, keys: Sequence[str]) -> tuple[Floats, float]:
        """The best step of the variables, and behind them of each key in each run; the squared residual it leaves."""
        runs = len(self._reduced)
        rows = []
        for i, reduced in enumerate(self._reduced):
            apart = np.zeros((reduced.shape[0], len(keys), runs))
            apart[:, :, i] = reduced[:, [self._place[key] for key in keys]]
            rows.append(
                np.column_stack([reduced[:, : self._variables], apart.reshape(reduced.shape[0], len(keys) * runs)])
            )
        columns, residual = np.vstack(rows), np.concatenate([reduced[:, -1] for reduced in self._reduced])
        norm = np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
        step = -np.linalg.lstsq(columns / norm, residual, rcond=1e-6)[0] / norm
        left = residual + columns @ step
        return step, float(left @ left)


def _column(problem: Problem, key: str) -> Floats:
    """Slopes (N,) of the residuals over a parameter that is not free."""
    rows = np.repeat(problem.model.vector[None], 2, axis=0)
    rows[1, problem.model.index(key)] += PARAMETER_STEP
    response = problem.response(rows)
    return np.asarray((response[1] - response[0]) / PARAMETER_STEP)
