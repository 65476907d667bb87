# SPDX-License-Identifier: Apache-2.0
"""Launch files and configuration name executables and parameters that exist; with ROS launch, they run."""

import ast
import importlib.util
import os
import subprocess
import sys
import types
from pathlib import Path
from typing import Any, ClassVar

import pytest
import yaml
from run_command import experiment, read

from lce_experiment import registry
from lce_ros.parent import PARENT
from lce_ros.testing import Graph

ROOT = Path(__file__).resolve().parents[2]
BRINGUP = ROOT / "src" / "lce_bringup"
LAUNCH_FILES = sorted((BRINGUP / "launch").glob("*.launch.py"))
CONFIG_FILES = sorted((BRINGUP / "config").glob("*.yaml"))
CONTROLLERS = tuple(dict.fromkeys(spec for mode in registry.CONTROLLERS.values() for spec in mode))
NODES = (*registry.BENCH, *CONTROLLERS, registry.RECORDER, registry.PLAYER)


def _console_scripts() -> dict[str, dict[str, str]]:
    """Executables of each package of the workspace: name to module:function, out of its setup.py."""
    found: dict[str, dict[str, str]] = {}
    for file in sorted(ROOT.glob("src/*/setup.py")):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and ":main" in node.value:
                name, _, target = node.value.partition("=")
                found.setdefault(file.parent.name, {})[name.strip()] = target.strip()
    return found


class _Action:
    """Stands for whatever a launch file imports from launch and launch_ros; keeps what it was made with."""

    made: ClassVar[list[dict[str, Any]]] = []

    def __init__(self, *args: Any, **words: Any) -> None:
        self.made.append({**words, "args": args})


def _nodes(file: Path, monkeypatch: pytest.MonkeyPatch) -> set[tuple[str, str]]:
    """Package and executable of every node that a launch file describes; ROS's launch need not be installed."""
    for tree in [n for n in ast.walk(ast.parse(file.read_text(encoding="utf-8"))) if isinstance(n, ast.ImportFrom)]:
        if tree.module and tree.module.startswith("launch"):
            stub = types.ModuleType(tree.module)
            stub.__dict__.update({alias.name: _Action for alias in tree.names})
            monkeypatch.setitem(sys.modules, tree.module, stub)
    monkeypatch.setattr(_Action, "made", [])
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
        flag, (_, node) = words["ros_arguments"]
        assert (flag, node) == ("--enclave", f"/{words['executable']}")


def test_executables_and_the_modules_of_lce_run_are_the_same() -> None:
    scripts = _console_scripts()
    for spec in NODES:
        assert scripts[spec.package][spec.name] == f"{spec.module}:main"


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
    assert f"choices={[*registry.CONTROLLERS]}".replace("'", '"') in text


@pytest.mark.alone
@needs_launch
def test_an_experiment_is_launched_and_recorded(graph: Graph, tmp_path: Path) -> None:
    """`ros2 launch` for real: the bench comes up, plays, and goes down with a finished bag."""
    done = subprocess.run(
        [
            *("ros2", "launch", "lce_bringup", "experiment.launch.py"),
            *("protocol:=hold:power=1.5,hold=2,rest=1", f"out:={tmp_path / 'bag'}", "seed:=3"),
        ],
        capture_output=True,
        text=True,
        timeout=90,
        env=os.environ | {"ROS_DOMAIN_ID": str(graph.domain)},
        check=False,
    )
    assert done.returncode == 0, done.stderr
    power = [message.data for message in read(tmp_path / "bag")["/lce/laser/power"][1]]
    assert max(power) == 1.5 and power[-1] == 0
    assert experiment(tmp_path / "bag")["protocol"] == "hold:power=1.5,hold=2,rest=1"
