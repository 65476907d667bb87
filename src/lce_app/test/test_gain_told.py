# SPDX-License-Identifier: Apache-2.0
"""What `lce add` says was gained is what two model files give when `lce compare` simulates them."""

import json
from collections.abc import Mapping, Sequence
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from lce_app.cli.main import main as lce
from lce_app.use_cases.add_effect import Added, add_effect
from lce_data.units import KELVIN
from lce_model import Model, default_model, save_model, simulate
from lce_model.effects import find, library
from lce_model.terms import inputs_of

pytestmark = pytest.mark.slow

BASE = default_model("lumped", "equilibrium")
HEATED = [effect.name for effect in library().values() if not inputs_of([effect])]
"""What runs tell of that hold no load and no room temperature."""
EVERYTHING = default_model("lumped", "equilibrium", tuple(library()))
"""With every effect at its null value: a diagnosis has compiled it already."""
SENSORS = ("temperature", "displacement")
LEVELS_W = {"pulse": (2.3, 2.3, 0.0), "stairs": (1.0, 2.2, 1.2)}
STEP_S = {"temperature": 0.1, "displacement": 0.02}


def _recorded(folder: Path, strip: Model, seed: int) -> list[Path]:
    """Two runs of 30 s as CSV files: camera at 10 Hz, distance at 50 Hz, white noise."""
    files = []
    for i, (name, levels) in enumerate(LEVELS_W.items()):
        rng = np.random.default_rng((seed, i))
        time = np.arange(0.0, 30.0, STEP_S["displacement"])
        power = np.select([time < 7.0, time < 13.0, time < 19.0], levels, 0.0)
        made = simulate(strip, time, power)
        temperature = made.measured_temperature_k - KELVIN + 0.06 * rng.standard_normal(time.size)
        displacement = made.measured_displacement_m + 4e-6 * rng.standard_normal(time.size)
        rows = [
            f"{t:.2f},{p:.3f},{f'{k:.4f}' if n % 5 == 0 else ''},{d:.9f}"
            for n, (t, p, k, d) in enumerate(zip(time, power, temperature, displacement, strict=True))
        ]
        files.append(folder / f"{name}.csv")
        files[-1].write_text("\n".join(["time_s,power_w,temperature_c,displacement_m", *rows]) + "\n")
    return files


def _drawn(seed: int) -> tuple[str, Model, Model]:
    """An effect of the library, a strip that has it and another one at some strength, and a base of random values."""
    rng = np.random.default_rng(seed)
    names = [str(name) for name in rng.choice(HEATED, size=2, replace=False)]
    strengths = {}
    for effect in map(find, names):
        strengths[effect.strength_key] = effect.null + rng.uniform(0.2, 1.0) * (effect.typical - effect.null)
    ranges = {"lumped.gain": 0.1, "lumped.tau": 0.1, "stretch_law.alpha": 0.05}
    base = BASE.set({key: BASE[key] * rng.uniform(1.0 - span, 1.0 + span) for key, span in ranges.items()})
    return names[0], EVERYTHING.set(strengths), base


def _mean_squares(model: Path, runs: Sequence[Path], drive: str) -> dict[str, float]:
    """Mean squared error of each sensor over all samples of all runs, in units of the noise, from `lce compare`."""
    numbers = model.with_suffix(".json")
    assert lce(["compare", *map(str, runs), "--model", str(model), "--json", str(numbers), "--drive", drive]) == 0
    compared = json.loads(numbers.read_text(encoding="utf-8"))["runs"]
    squares = {}
    for sensor in SENSORS:
        samples = [len(run[sensor]["series"]["measured"]) for run in compared]
        squares[sensor] = np.average([run[sensor]["rms_over_noise"] ** 2 for run in compared], weights=samples)
    return squares


def _gone(before: Mapping[str, float], after: Mapping[str, float], sensors: Sequence[str]) -> float:
    """Share of what was above the noise that went, every sensor with the same weight."""
    above = sum(max(before[s] - 1.0, 0.0) for s in sensors)
    return 1.0 - sum(max(after[s] - 1.0, 0.0) for s in sensors) / above if above > 0.0 else 0.0


def _added(name: str, strip: Model, base: Model, folder: Path, seed: int) -> tuple[Added, list[Path], Path]:
    """The effect added to the base; the runs, and the file of the model with it."""
    runs, given, after = _recorded(folder, strip, seed), folder / "given.yaml", folder / "after.yaml"
    save_model(base, given)
    return add_effect(name, runs, given, after), runs, after


def _check(name: str, strip: Model, base: Model, folder: Path, seed: int) -> None:
    """Errors and gain of the addition are those of its two models, written to files and simulated."""
    found, runs, after = _added(name, strip, base, folder, seed)
    addition, before = found.addition, folder / "before.yaml"
    save_model(addition.before, before)
    drive = addition.model.fit["drive"]
    old, new = (_mean_squares(model, runs, drive) for model in (before, after))
    for misfit, simulated in ((addition.train.misfit["before"], old), (addition.train.misfit["after"], new)):
        assert {c.name: misfit.mean_square(c) for c in misfit.total} == pytest.approx(simulated, rel=1e-6)
    # The gain is told over the sensors of the stage in which the effect was judged.
    stages = [sensors for count in (1, 2) for sensors in combinations(SENSORS, count)]
    assert any(addition.actual_reduction == pytest.approx(_gone(old, new, s), abs=1e-6) for s in stages)
    assert f"{addition.actual_reduction:.1%}" in addition.sentence


@pytest.mark.parametrize("seed", [0, 1, 3, 4, 8, 10])
def test_what_is_told_is_what_the_model_files_give(seed: int, tmp_path: Path) -> None:
    """Some additions bring the error to the noise, some a part of it, some make it worse."""
    _check(*_drawn(seed), tmp_path, seed)


def test_it_is_so_where_the_heat_alone_finds_another_strength_than_both_stages(tmp_path: Path) -> None:
    """In 30 s a droop of the laser and its time constant are hardly told apart."""
    _check("laser_droop", EVERYTHING.set({"laser_droop.delta": 0.044}), BASE, tmp_path, seed=8)


def test_what_is_not_there_is_told_to_gain_nothing(tmp_path: Path) -> None:
    found, _, _ = _added("creep", BASE, BASE, tmp_path, seed=7)
    assert found.addition.actual_reduction <= 0.05
    assert not found.addition.confirmed
    assert "not confirmed" in found.addition.sentence
