# SPDX-License-Identifier: Apache-2.0
"""The programs of examples/ do what their first lines say."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from sensor_msgs.msg import Temperature
from std_msgs.msg import Float64

from lce_data.channels import DISPLACEMENT, POWER, TEMPERATURE
from lce_data.run_csv import write_run_csv
from lce_experiment import registry
from lce_experiment.config import config_file
from lce_model import default_model, save_model, simulate
from lce_ros.testing import Graph
from lce_ros.testing.processes import end

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
STRIP = default_model().add("creep").set({"creep.share": 0.15, "creep.tau_v": 8.0})


def example(name: str, *words: str | Path, cwd: Path) -> str:
    """What an example prints."""
    command = [sys.executable, str(EXAMPLES / name), *map(str, words)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, cwd=cwd, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three runs of a strip that creeps, and a model that does not."""
    folder = tmp_path_factory.mktemp("campaign")
    time_s = np.arange(0.0, 40.0, 0.01)
    powers = {
        "pulse": np.where((time_s > 1.0) & (time_s < 16.0), 2.3, 0.0),
        "stairs": np.select([time_s < 10.0, time_s < 18.0, time_s < 26.0], [1.0, 2.2, 1.2], 0.0),
        "prbs": np.select([time_s < 7.0, time_s < 14.0, time_s < 24.0], [2.4, 0.5, 2.0], 0.0),
    }
    for seed, (name, power_w) in enumerate(powers.items()):
        rng = np.random.default_rng(seed)
        made = simulate(STRIP, time_s, power_w)
        seen_k = made.measured_temperature_k + 0.06 * rng.standard_normal(time_s.size)
        seen_m = made.measured_displacement_m + 4e-6 * rng.standard_normal(time_s.size)
        camera_k = np.where(np.arange(time_s.size) % 10 == 0, seen_k, np.nan)
        write_run_csv(folder / f"{name}.csv", time_s, {POWER: power_w, TEMPERATURE: camera_k, DISPLACEMENT: seen_m})
    save_model(STRIP.without("creep"), folder / "model.yaml")
    return folder


def test_fit_and_diagnose(campaign: Path, tmp_path: Path) -> None:
    said = example(
        "fit_and_diagnose.py", campaign / "pulse.csv", campaign / "stairs.csv", "--test", campaign / "prbs.csv",
        "--deformation", "equilibrium", cwd=tmp_path,
    )  # fmt: skip
    assert "creep is missing" in said and (tmp_path / "better.yaml").exists()


def test_the_notebook(campaign: Path, tmp_path: Path) -> None:
    """Its cells of code, one after the other, on these recordings instead of the demo's."""
    cells = json.loads((EXAMPLES / "fit_and_diagnose.ipynb").read_text(encoding="utf-8"))["cells"]
    parameters = [cell for cell in cells if "parameters" in cell["metadata"].get("tags", [])]
    assert len(parameters) == 1
    runs = [str(campaign / f"{name}.csv") for name in ("pulse", "stairs")]
    held_out = [str(campaign / "prbs.csv")]
    parameters[0]["source"] = [f"RUNS, HELD_OUT, DEFORMATION = {runs!r}, {held_out!r}, 'equilibrium'"]
    lines = [line for cell in cells if cell["cell_type"] == "code" for line in "".join(cell["source"]).splitlines()]
    program = "\n".join(line for line in lines if not line.startswith("%"))
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, cwd=tmp_path, check=False)
    assert done.returncode == 0, done.stderr
    assert "creep is missing" in done.stdout
    assert (tmp_path / "diagnosis.pdf").read_bytes().startswith(b"%PDF") and (tmp_path / "better.yaml").exists()


def test_own_effect(campaign: Path, tmp_path: Path) -> None:
    said = example("own_effect.py", campaign / "pulse.csv", "--model", campaign / "model.yaml", cwd=tmp_path)
    assert "glare.b = " in said and said.rstrip().endswith("K/W")


def test_custom_figure(campaign: Path, tmp_path: Path) -> None:
    example("custom_figure.py", campaign / "pulse.csv", "--model", campaign / "model.yaml", cwd=tmp_path)
    assert (tmp_path / "figures" / "displacement.pdf").read_bytes().startswith(b"%PDF")
    assert "d [mm]" in (tmp_path / "figures" / "loop.svg").read_text(encoding="utf-8")


@pytest.mark.slow
def test_discover(campaign: Path, tmp_path: Path) -> None:
    runs = [campaign / "pulse.csv", campaign / "stairs.csv"]
    said = example("discover.py", *runs, "--model", campaign / "model.yaml", cwd=tmp_path)
    assert said.strip() and all(Path(tmp_path / line).exists() for line in said.splitlines() if line.endswith(".svg"))


@pytest.mark.alone
@pytest.mark.parametrize("own", ["controller", "simulator"])
def test_a_node_of_ones_own_beside_those_of_the_bench(
    graph: Graph, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, own: str
) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", str(graph.domain))
    files = [word for name in ("bench", "simulated") for word in ("--params-file", str(config_file(f"{name}.yaml")))]
    ros = ["--ros-args", "-r", f"__ns:={registry.NAMESPACE}"]
    commands = [[*spec.command, *ros, *files] for spec in registry.BENCH if spec.name != own]
    if own == "simulator":
        commands.append([sys.executable, str(EXAMPLES / "own_simulator_node.py"), *ros])
    controller = [sys.executable, str(EXAMPLES / "own_controller_node.py"), *ros, "-p", "target_m:=0.001"]
    probe = graph.probe()
    displacement = graph.collect(Float64, "displacement", probe)
    temperature = graph.collect(Temperature, "temperature", probe)
    log = tmp_path / "log.txt"
    with log.open("w", encoding="utf-8") as lines:
        processes = [subprocess.Popen(command, stdout=lines, stderr=lines) for command in commands]
        try:
            # The bench measures before the controller comes, as its first lines say: light needs a temperature.
            graph.until(lambda: displacement and temperature, 60.0, "a bench that measures")
            processes.append(subprocess.Popen(controller, stdout=lines, stderr=lines))
            graph.until(lambda: displacement.data[-1] > 2e-4, 60.0, "a strip that lifts its weight")
        finally:
            for process in processes:
                end(process)
            print(log.read_text(encoding="utf-8"))
