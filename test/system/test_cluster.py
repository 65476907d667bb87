# SPDX-License-Identifier: Apache-2.0
"""Fits on a Dask cluster of two workers give the numbers that they give here."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from lce_app.cli.main import main
from lce_data.units import KELVIN
from lce_data.waveforms import RATE_HZ, SHAPES
from lce_model import default_model, save_model, simulate

distributed = pytest.importorskip("distributed", reason="distributed is an optional package")

WAVES = {
    "pulse": ("pulse", {"amp": 0.8, "th": 12.0, "offset": 1.7, "rest": 20.0}),
    "stairs": ("stairs", {"low": 0.5, "high": 2.2, "steps": 3, "hold": 6.0, "rest": 15.0}),
}


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    """Two worker processes and their scheduler."""
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as found:
        yield found


@pytest.fixture
def options(cluster: Any) -> Iterator[list[str]]:
    """Options by which a command goes to the cluster; it must then have been there."""
    before = cluster.scheduler.transition_counter
    yield ["--backend", "dask", "--scheduler", cluster.scheduler_address]
    assert cluster.scheduler.transition_counter > before


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two runs of a strip that creeps, and a model that does not know it."""
    place = tmp_path_factory.mktemp("runs")
    strip = default_model().add("creep").set({"creep.share": 0.2, "creep.tau_v": 8.0})
    for name, (kind, shape) in WAVES.items():
        power = SHAPES[kind].power_w({k: (float(v),) for k, v in shape.items()})[::4]
        time = np.arange(power.size) * 4 / RATE_HZ
        noise = np.random.default_rng(len(name))
        true = simulate(strip, time, power)
        celsius = true.temperature_k - KELVIN + 0.06 * noise.standard_normal(time.size)
        moved = true.displacement_m + 4e-6 * noise.standard_normal(time.size)
        rows = zip(time, power, celsius, moved, strict=True)
        lines = [f"{t:.2f},{p:.6f},{c:.4f},{d:.8f}" for t, p, c, d in rows]
        (place / f"{name}.csv").write_text("\n".join(["time_s,power_w,temperature_c,displacement_m", *lines]) + "\n")
    save_model(default_model(), place / "m.yaml")
    return place


def test_a_diagnosis(folder: Path, options: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    words = ["diagnose", "pulse.csv", "stairs.csv", "--model", "m.yaml", "--json"]
    assert main([*words, "here.json"]) == 0
    assert main([*words, "there.json", *options]) == 0
    here, there = (json.loads((folder / name).read_text()) for name in ("here.json", "there.json"))
    assert here["added"][0] == "creep"
    del here["seconds"], there["seconds"]
    assert there == here


def test_a_fit_for_each_run(folder: Path, options: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    words = ["fit", "pulse.csv", "stairs.csv", "--deformation", "none", "--per-run", "--out"]
    assert main([*words, "here.yaml"]) == 0
    assert main([*words, "there.yaml", *options]) == 0
    for run in WAVES:
        here, there = (yaml.safe_load((folder / f"{name}-{run}.yaml").read_text()) for name in ("here", "there"))
        assert there == here


def test_a_bootstrap(
    folder: Path, options: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(folder)
    words = ["fit", "pulse.csv", "stairs.csv", "--deformation", "none", "--bootstrap", "6", "--out", "boot.yaml"]
    assert main(words) == 0
    here = capsys.readouterr().out
    assert main([*words, *options]) == 0
    assert "Bootstrap, 95 % of 6 draws:" in here
    assert capsys.readouterr().out == here


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--backend", "dask"], "belong together"),
        (["--scheduler", "tcp://127.0.0.1:1"], "belong together"),
        (["--backend", "dask", "--scheduler", "nowhere"], "no Dask scheduler at nowhere"),
    ],
)
def test_a_cluster_that_is_not_there(
    words: list[str], told: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(folder)
    assert main(["fit", "pulse.csv", "--deformation", "none", "--out", "x.yaml", *words]) == 1
    (line,) = capfd.readouterr().err.strip().splitlines()
    assert told in line
    assert not (folder / "x.yaml").exists()
