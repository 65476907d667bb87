# SPDX-License-Identifier: Apache-2.0
"""Creep of a strip whose law of stretch no base model holds; the strip is made by numpy."""

from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import lsim

from lce_analysis.diagnosis import Diagnosis, diagnose
from lce_analysis.identification import fit
from lce_analysis.options import DiagnoseOptions
from lce_data.channels import DISPLACEMENT
from lce_data.run import Run, Series
from lce_model import default_model
from lce_model.effects import find

Floats = NDArray[np.float64]
CANDIDATES = (
    "creep", "displacement_clip", "thermal_expansion", "residual_strain", "displacement_drift", "backlash",
    "transition_distribution", "phase_kinetics",
)  # fmt: skip


def strip(name: str, seed: int, creep: float) -> Run:
    """A play of 3 K, a contraction that grows in two steps, and a share of it that follows with 12 s."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, 80.0, 0.05)
    power = np.repeat(rng.uniform(0.2, 1.6, 8), time.size // 8) * (time > 2.0) * (time < 70.0)
    _, rise, _ = lsim(([40.0], [8.0, 1.0]), power, time)
    edge = np.empty_like(rise)
    at = -1.5
    for i, excess in enumerate(rise):
        at = edge[i] = min(max(at, excess - 1.5), excess + 1.5)
    strain = 4e-4 * _turned(edge, 18.0, 3.0) + 3e-4 * _turned(edge, 38.0, 4.0)
    _, late, _ = lsim(([1.0], [12.0, 1.0]), strain - strain[0], time)
    displacement = (1.0 - creep) * (strain - strain[0]) + creep * late + 3e-6 * rng.standard_normal(time.size)
    temperature = 298.0 + rise + 0.05 * rng.standard_normal(time.size)
    return Run.of(name, Series(time, power), Series(time, temperature), Series(time, displacement), sha256=name)


def _turned(edge: Floats, middle: float, width: float) -> Floats:
    return np.asarray(1.0 / (1.0 + np.exp(-(edge - middle) / width)))


def diagnosed(
    creep: float, candidates: Sequence[str] = CANDIDATES, options: DiagnoseOptions = DiagnoseOptions()
) -> Diagnosis:
    runs, test = [strip(f"run-{i}", i, creep) for i in range(6)], [strip("held-out", 9, creep)]
    model = fit(default_model("lumped", "equilibrium"), runs).model
    return diagnose(model, runs, test, [find(name) for name in candidates], options)


@pytest.mark.slow
def test_an_effect_that_no_form_of_the_base_model_replaces_is_named() -> None:
    found = diagnosed(0.15)
    assert found.as_json()["added"] == ["creep"]
    assert found.test.misfit["after"].rms[DISPLACEMENT] > 2.0
    errors = found.free_forms["creep"]
    assert errors.after.rms[DISPLACEMENT] < 0.5 * errors.before.rms[DISPLACEMENT]
    assert any("do not replace creep" in sentence for sentence in found.sentences)
    assert found.as_json()["free_forms"]["creep"]["after"]["displacement"] == errors.after.rms[DISPLACEMENT]


@pytest.mark.slow
def test_wrong_forms_alone_are_no_effect() -> None:
    found = diagnosed(0.0)
    assert (found.as_json()["added"], found.free_forms) == ([], {})
    assert found.test.misfit["after"].rms[DISPLACEMENT] > 2.0


@pytest.mark.slow
def test_an_effect_that_is_a_curve_itself_is_not_asked() -> None:
    found = diagnosed(0.15, ["thermal_expansion"])
    assert (found.as_json()["added"], found.free_forms) == ([], {})


@pytest.mark.slow
def test_what_the_final_tables_do_not_bear_out_is_not_named() -> None:
    found = diagnosed(0.15, ["creep"], DiagnoseOptions(worth_share=0.95))
    assert (found.verdict, found.as_json()["added"]) == ("cannot_tell", [])
    (candidate,) = found.candidates
    assert candidate.trial is not None
    assert candidate.trial.objection == "hidden"
    assert "creep" in found.free_forms
    assert any("look for better forms first" in sentence for sentence in found.sentences)
