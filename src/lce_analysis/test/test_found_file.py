# SPDX-License-Identifier: Apache-2.0
"""The effect file of a function that was found does what its closure does."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from lce_analysis.diagnosis.linearized_fit import LinearizedFit
from lce_analysis.discovery.curve import Curve
from lce_analysis.discovery.formulas import Formula
from lce_analysis.discovery.found_file import FOLLOWING, effect_file, name_of
from lce_analysis.identification.problem import Problem
from lce_analysis.unknown_function import Candidate
from lce_model import Model, default_model, simulate
from lce_model.closures import PLACES, closure
from lce_model.closures.covariates import COVARIATES, NUMBER
from lce_model.closures.forms import FORMS, KNOTS
from lce_model.effects import Effect, find
from lce_model.simulation import Trajectory

Floats = NDArray[np.float64]

TIME = np.arange(0.0, 50.0, 0.01)
POWER = np.where((TIME % 25.0 > 2.0) & (TIME % 25.0 < 12.0), 1.4, 0.2)
NUMBER_OF_FORM = {form.name: i for i, form in enumerate(FORMS, start=1)}
CASES = (
    ("heat", "temperature", "fourth_power", -1e-10, {}),
    ("light", "rate", "tanh", 0.1, {"a": 0.7}),
    ("heat", "power", "hyperbolic", -0.3, {"a": 1.7}),
    ("strain", "order", "threshold", 1e-4, {"b": 0.1}),
    ("temperature_sensor", "displacement", "linear", 300.0, {}),
    ("displacement_sensor", "time", "logarithm", 1e-5, {"a": 11.0}),
    ("light", "dose", "saturation", -0.2, {"a": 30.0}),
    ("strain", "path", "curve", 1.0, {}),
    ("order", "branch", "sign", 0.8, {}),
    ("displacement_sensor", "cycle", "step_at", 5e-5, {"b": 0.5}),
    ("temperature_sensor", "lagged_temperature", "linear", -0.3, {}),
    ("light", "lagged_power", "curve", 1.0, {}),
    ("strain", "lagged_displacement", "power", -0.1, {"a": 1.2}),
    ("heat", "late_power", "bell", 0.2, {"a": 0.4, "b": 0.9}),
    ("strain", "displacement_path", "stretched_saturation", 1e-4, {"a": 2e-3, "b": 1.3}),
)
"""Place, covariate, form, strength, numbers: every covariate once."""
RUNS = ["pulse", 'x"""\nraise SystemExit("a name was run")\n"""\\']
"""A run is named after its file, so its name may hold anything."""
TAU_S = 2.5
ENDS = {
    "temperature": (295.0, 340.0),
    "path": (0.0, 60.0),
    "lagged_power": (-1.0, 1.2),
    "displacement_path": (0.0, 0.012),
}


@dataclass(frozen=True)
class Case:
    """A function, as a closure and as an effect file."""

    candidate: Candidate
    form: str
    strength: float
    settings: dict[str, float]
    effect: Effect

    @property
    def strength_in_file(self) -> float:
        return 1.0 if self.form == "curve" else self.strength


def candidate_of(place: str, covariate: str) -> Candidate:
    known = COVARIATES[NUMBER[covariate]]
    ambient = default_model("lumped", "equilibrium")["ambient.t_env"]
    lower, upper = ENDS.get(covariate, (-1.0, 3.0))
    where = next(p for p in PLACES if p.name == place)
    lag = TAU_S if known.lagged else None
    return Candidate(where, known, lag, lower, upper, ambient if covariate == "temperature" else 0.0)


def written(folder: Path, closures: Model) -> Iterator[Case]:
    for place, covariate, form, strength, numbers in CASES:
        candidate = candidate_of(place, covariate)
        size = {"m": 2e-5, "1": 0.05}.get(candidate.place.unit, 0.1)
        weights = size * np.sin(np.arange(KNOTS))
        settings = {**candidate.settings, f"{candidate.term}.strength": strength}
        if form == "curve":
            settings |= dict(zip(candidate.weights, weights.tolist(), strict=True))
        else:
            settings[f"{candidate.term}.form"] = float(NUMBER_OF_FORM[form])
            settings |= {f"{candidate.term}.{name}": x for name, x in numbers.items()}
        zeros = np.zeros(KNOTS)
        curve = Curve(candidate, candidate.knots, weights, zeros, offset=False, slope=False)
        problem = Problem(closures.set(settings), [], (), np.empty(0), ())
        fit = LinearizedFit(problem, np.empty((0, 0)), np.empty(0))
        formula = None if form == "curve" else Formula(candidate, NUMBER_OF_FORM[form], fit, 1.0, 0.0)
        path = folder / f"{name_of(candidate, formula)}.py"
        path.write_text(effect_file(curve, formula, weights.tolist(), RUNS), encoding="utf-8")
        yield Case(candidate, form, strength, settings, find(str(path)))


@pytest.fixture(scope="module")
def closures() -> Model:
    model = default_model("lumped", "equilibrium")
    for place in PLACES:
        model = model.add(closure(place.name))
    return model


@pytest.fixture(scope="module")
def cases(closures: Model, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Case]:
    return {c.candidate.covariate.name: c for c in written(tmp_path_factory.mktemp("found"), closures)}


@pytest.fixture(scope="module")
def with_files(cases: dict[str, Case]) -> Model:
    """The strip with all the files, each at its null value: one kernel serves every test."""
    model = default_model("lumped", "equilibrium")
    for case in cases.values():
        model = model.add(case.effect)
    return model


@pytest.fixture(scope="module")
def strip() -> Trajectory:
    return simulate(default_model("lumped", "equilibrium"), TIME, POWER)


def test_every_covariate_can_be_written() -> None:
    assert {c.name for c in COVARIATES} == set(FOLLOWING) == {case[1] for case in CASES}


@pytest.mark.parametrize("covariate", [case[1] for case in CASES])
def test_a_file_does_what_its_closure_does(
    covariate: str, cases: dict[str, Case], closures: Model, with_files: Model, strip: Trajectory
) -> None:
    case = cases[covariate]
    by_closure = simulate(closures.set(case.settings), TIME, POWER)
    by_file = simulate(with_files.set({case.effect.strength_key: case.strength_in_file}), TIME, POWER)
    for seen in ("measured_temperature_k", "measured_displacement_m"):
        change = getattr(by_closure, seen) - getattr(strip, seen)
        np.testing.assert_allclose(
            getattr(by_file, seen) - getattr(strip, seen), change, atol=1e-4 * np.ptp(change) + 1e-12
        )
    assert np.ptp(by_closure.measured_displacement_m - strip.measured_displacement_m) > 0.0 or (
        case.candidate.place.name == "temperature_sensor"
    )


def test_files_at_their_null_value_change_nothing(with_files: Model, strip: Trajectory) -> None:
    quiet = simulate(with_files, TIME, POWER)
    np.testing.assert_array_equal(quiet.measured_displacement_m, strip.measured_displacement_m)


def test_a_file_says_what_it_is(cases: dict[str, Case]) -> None:
    effect = cases["lagged_displacement"].effect
    text = Path(effect.path).read_text(encoding="utf-8")
    assert effect.name == "found_strain_lagged_displacement_power"
    assert effect.meaning.startswith("A function of the displacement less what it was before in the strain")
    assert "Found in pulse, x____raise SystemExit" in text and "# The curve: lagged displacement [m]" in text
    assert [p.name for p in effect.parameters] == ["c", "exponent", "tau"]
    assert dict(effect.grid)["tau"] == (1.25, 2.5, 5.0)
    assert effect.parameter("c").unit == "m/m^exponent"
