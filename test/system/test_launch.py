# SPDX-License-Identifier: Apache-2.0
"""Launch files and configuration name executables and parameters that exist; with ROS launch, they run."""

import ast
import importlib
import importlib.util
import os
import re
import signal
import subprocess
import sys
import types
from collections.abc import Sequence
from pathlib import Path
from typing import Any, ClassVar

import pytest
import yaml
from ament_index_python.packages import get_package_prefix
from run_command import experiment, read, started
from std_msgs.msg import Float64

from lce_experiment import registry
from lce_ros.parent import PARENT
from lce_ros.testing import Graph

ROOT = Path(__file__).resolve().parents[2]
SHARED = ROOT / "src" / "lce_experiment" / "lce_experiment" / "launching.py"
"""What the launch files share."""
BRINGUP = ROOT / "src" / "lce_bringup"
LAUNCH_FILES = sorted((BRINGUP / "launch").glob("*.launch.py"))
CONFIG_FILES = sorted((BRINGUP / "config").glob("*.yaml"))
CONTROLLERS = tuple(dict.fromkeys(spec for mode in registry.CONTROLLERS.values() for spec in mode))
NODES = (*registry.BENCH, *CONTROLLERS, registry.RECORDER, registry.PLAYER)


def _console_scripts() -> dict[str, dict[str, str]]:
    """Executables of each package of the workspace: name to module:object, out of its setup.py."""
    found: dict[str, dict[str, str]] = {}
    for file in sorted(ROOT.glob("src/*/setup.py")):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Constant) and (entry := re.fullmatch(r"(\w+) = ([\w.]+:\w+)", str(node.value))):
                found.setdefault(file.parent.name, {})[entry[1]] = entry[2]
    return found


class _Action:
    """Stands for whatever a launch file imports from launch and launch_ros; keeps what it was made with."""

    made: ClassVar[list[dict[str, Any]]] = []

    def __init__(self, *args: Any, **words: Any) -> None:
        self.made.append({**words, "args": args})


def _nodes(file: Path, monkeypatch: pytest.MonkeyPatch) -> set[tuple[str, str]]:
    """Package and executable of every node that a launch file describes; ROS's launch need not be installed."""
    imports = [
        n for f in (SHARED, file) for n in ast.walk(ast.parse(f.read_text("utf-8"))) if isinstance(n, ast.ImportFrom)
    ]
    for name in {tree.module for tree in imports if tree.module and tree.module.startswith("launch")}:
        stub = types.ModuleType(name)
        stub.__dict__.update({alias.name: _Action for tree in imports if tree.module == name for alias in tree.names})
        monkeypatch.setitem(sys.modules, name, stub)
    monkeypatch.setattr(_Action, "made", [])
    monkeypatch.setitem(sys.modules, "lce_experiment.launching", _module(SHARED))
    _module(file).generate_launch_description()
    return {(words["package"], words["executable"]) for words in _Action.made if "executable" in words}


def _module(file: Path) -> types.ModuleType:
    spec = importlib.util.spec_from_file_location("launched", file)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("file", LAUNCH_FILES, ids=lambda file: file.name)
def test_every_node_of_a_launch_file_is_an_executable(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scripts = _console_scripts()
    nodes = _nodes(file, monkeypatch)
    assert nodes
    for package, executable in nodes:
        assert executable in scripts[package]


def test_the_launch_files_start_the_whole_bench(monkeypatch: pytest.MonkeyPatch) -> None:
    nodes = set().union(*(_nodes(file, monkeypatch) for file in LAUNCH_FILES))
    assert nodes == {(spec.package, spec.name) for spec in NODES}


def test_the_nodes_of_a_launch_end_with_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(PARENT, raising=False)
    _nodes(BRINGUP / "launch" / "bench.launch.py", monkeypatch)
    before_nodes = _Action.made[: next(k for k, words in enumerate(_Action.made) if "executable" in words)]
    assert (PARENT, str(os.getpid())) in [words["args"] for words in before_nodes]


def test_a_launch_stays_on_its_machine_unless_told_otherwise(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ROS_AUTOMATIC_DISCOVERY_RANGE", raising=False)
    for told, expected in (("", "LOCALHOST"), ("SUBNET", "SUBNET")):
        if told:
            monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", told)
        _nodes(BRINGUP / "launch" / "bench.launch.py", monkeypatch)
        assert ("ROS_AUTOMATIC_DISCOVERY_RANGE", expected) in [words["args"] for words in _Action.made]


@pytest.mark.parametrize("file", LAUNCH_FILES, ids=lambda file: file.name)
def test_every_node_of_a_launch_file_has_its_enclave(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _nodes(file, monkeypatch)
    for words in (w for w in _Action.made if "executable" in w):
        flag, (_, node) = words["ros_arguments"][:2]
        assert (flag, node) == ("--enclave", f"/{words['executable']}")


@pytest.mark.parametrize("file", LAUNCH_FILES, ids=lambda file: file.name)
def test_every_argument_has_a_description(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _nodes(file, monkeypatch)
    arguments = {words["args"][0]: words["description"] for words in _Action.made if "default_value" in words}
    assert all(arguments.values())
    assert {"plant", "namespace", "params_file", "use_sim_time", "log_level"} <= set(arguments)
    assert ("record" in arguments) == ("out" in arguments) == (file.name != "bench.launch.py")


@pytest.mark.parametrize("file", LAUNCH_FILES, ids=lambda file: file.name)
def test_every_node_of_a_launch_file_follows_the_common_arguments(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _nodes(file, monkeypatch)
    for words in (w for w in _Action.made if "executable" in w):
        assert words["exec_name"] == words["executable"] and words["on_exit"]
        assert "--log-level" in words["ros_arguments"]
        assert words["parameters"][-1].keys() == {"use_sim_time"}


def test_executables_and_the_modules_of_lce_run_are_the_same() -> None:
    scripts = _console_scripts()
    for spec in NODES:
        module, _, name = scripts[spec.package][spec.name].partition(":")
        found = getattr(importlib.import_module(module), name)
        assert module == spec.module or found.module == spec.module


@pytest.mark.parametrize("file", CONFIG_FILES, ids=lambda file: file.name)
def test_configuration_is_for_nodes_that_exist(file: Path) -> None:
    names = {f"/**/{spec.name}" for spec in NODES}
    content = yaml.safe_load(file.read_text(encoding="utf-8"))
    assert set(content) <= names
    assert all(set(entry) == {"ros__parameters"} for entry in content.values())


@pytest.mark.parametrize("spec", [*registry.BENCH, *CONTROLLERS], ids=lambda spec: spec.name)
def test_configured_parameters_are_declared_and_accepted(graph: Graph, spec: registry.NodeSpec) -> None:
    parameters: dict[str, Any] = {}
    for name in ("bench.yaml", "simulated.yaml", "control.yaml"):
        content = yaml.safe_load((BRINGUP / "config" / name).read_text(encoding="utf-8"))
        parameters |= content.get(f"/**/{spec.name}", {}).get("ros__parameters", {})
    node = graph.add(spec.load(), **parameters)
    for name, value in parameters.items():
        assert node.get_parameter(name).value == value


needs_launch = pytest.mark.skipif(
    importlib.util.find_spec("launch_ros") is None,
    reason="ROS's launch is not among the wheels: colcon build on Ubuntu 24.04 with ROS 2 Jazzy (README)",
)


@needs_launch
@pytest.mark.parametrize("file", LAUNCH_FILES, ids=lambda file: file.name)
def test_a_launch_file_is_a_launch_description(file: Path) -> None:
    from launch import LaunchDescription

    assert isinstance(_module(file).generate_launch_description(), LaunchDescription)


def test_the_launch_file_of_control_knows_every_mode() -> None:
    text = (BRINGUP / "launch" / "control.launch.py").read_text(encoding="utf-8")
    assert f"{[*registry.CONTROLLERS]}".replace("'", '"') in text


PROTOCOL = "protocol:=hold:power=1.5,hold=2,rest=1"


def _launch(words: Sequence[str], domain: int, folder: Path) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(
        ["ros2", "launch", "lce_bringup", "experiment.launch.py", f"out:={folder / 'bag'}", *words],
        capture_output=True,
        text=True,
        timeout=90,
        env=os.environ | {"ROS_DOMAIN_ID": str(domain), "ROS_LOG_DIR": str(folder)},
        check=False,
    )


@pytest.mark.alone
@needs_launch
def test_an_experiment_is_launched_and_recorded(graph: Graph, tmp_path: Path) -> None:
    """`ros2 launch` for real: the bench comes up, plays, and goes down with a finished bag."""
    done = _launch([PROTOCOL, "seed:=3"], graph.domain, tmp_path)
    assert done.returncode == 0, done.stderr
    power = [message.data for message in read(tmp_path / "bag")["/lce/laser/power"][1]]
    assert max(power) == 1.5 and power[-1] == 0
    about = experiment(tmp_path / "bag")
    assert (about["protocol"], about["outcome"]) == ("hold:power=1.5,hold=2,rest=1", "complete")


COLD = "/**/laser: {ros__parameters: {max_temperature_c: 30.0}}"
"""A limit that the strip is above as soon as there is light."""


@pytest.mark.alone
@needs_launch
@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["protocol:=puls"], "[experiment_player-6] unknown protocol 'puls'"),
        ([PROTOCOL, "plant:=hardware"], "[laser-1] labjack.volts_per_watt: 0 V/W"),
        (
            [PROTOCOL, "params_file:={folder}/cold.yaml"],
            "[experiment_player-6] experiment_player: stopped by the laser",
        ),
        ([PROTOCOL, "model:=none.yaml"], "none.yaml"),
        ([PROTOCOL, "out:={folder}"], "exists already"),
    ],
    ids=["bad protocol", "no hardware", "a fault of the laser", "no model", "no place for the recording"],
)
def test_a_launch_that_fails_returns_1(graph: Graph, tmp_path: Path, words: list[str], said: str) -> None:
    (tmp_path / "cold.yaml").write_text(COLD)
    done = _launch([word.format(folder=tmp_path) for word in words], graph.domain, tmp_path)
    assert done.returncode == 1 and "Traceback" not in done.stderr
    assert said in done.stderr + done.stdout
    bag = tmp_path / "bag"
    assert not (bag / "experiment.yaml").exists() or experiment(bag)["outcome"] == "failed"


@pytest.mark.alone
@needs_launch
def test_a_launch_whose_laser_dies_returns_1(graph: Graph, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", str(graph.domain))
    power = graph.collect(Float64, "laser/power", graph.probe())
    launch = ["ros2", "launch", "lce_bringup", "experiment.launch.py"]
    with started("protocol:=hold:power=1,hold=60", f"out:={tmp_path / 'bag'}", command=launch) as run:
        graph.until(lambda: power.data and power.data[-1] > 0.0, 60.0, "light")
        [laser] = run.processes(f"{get_package_prefix('lce_drivers')}/lib/lce_drivers/laser")
        os.kill(laser, signal.SIGKILL)
        assert run.process.wait(30.0) == 1
        assert run.processes() == []
    assert experiment(tmp_path / "bag")["outcome"] == "failed"
