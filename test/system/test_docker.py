# SPDX-License-Identifier: Apache-2.0
"""docker/ without an engine: the files agree with the workspace, and the services' commands make a recording."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml
from ament_index_python.packages import get_package_prefix
from run_command import read, until

from lce_experiment import registry
from lce_ros.testing import Graph

DOCKER = Path(__file__).resolve().parents[2] / "docker"
SOURCES = DOCKER.parent / "src"
JOB = "experiment_player"
"""The one service that ends by itself."""


def compose(file: str = "compose.yaml") -> dict[str, Any]:
    """A compose file, its variables at their defaults."""
    text = re.sub(r"\$\{\w+:-([^}]*)\}", r"\1", (DOCKER / file).read_text(encoding="utf-8"))
    assert "${" not in text
    loaded: dict[str, Any] = yaml.safe_load(text)
    return loaded


def test_there_is_a_service_for_every_node() -> None:
    specs = {
        *registry.BENCH,
        registry.RECORDER,
        registry.PLAYER,
        *(spec for mode in registry.CONTROLLERS.values() for spec in mode),
    }
    services, nodes = set(compose()["services"]), {spec.name for spec in specs}
    assert nodes <= services, f"docker/compose.yaml has no service {', '.join(sorted(nodes - services))}"
    assert services <= nodes, f"the registry has no node {', '.join(sorted(services - nodes))} of docker/compose.yaml"


@pytest.mark.parametrize("mode", registry.CONTROLLERS)
def test_a_profile_starts_the_controllers_of_its_mode(mode: str) -> None:
    own = {name for name, service in compose()["services"].items() if mode in service.get("profiles", [])}
    assert own == {spec.name for spec in registry.CONTROLLERS[mode]} - {"feedforward"}


@pytest.mark.parametrize("name", compose()["services"])
def test_a_service_has_no_more_rights_than_it_needs(name: str) -> None:
    service = compose()["services"][name]
    assert service["read_only"] and service["init"] and service["cap_drop"] == ["ALL"]
    assert service["restart"] == "no", "a laser that has ended stays dark"
    assert service["environment"]["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"
    assert not service.get("privileged")
    assert service["user"] == "1000:1000", "of the host, by HOST_UID and HOST_GID; never root"


def test_one_service_builds_the_image_that_all_use() -> None:
    services = compose()["services"]
    assert [name for name, service in services.items() if "build" in service] == ["laser"]
    assert len({service["image"] for service in services.values()}) == 1
    assert "profiles" not in services["laser"], "it is built whatever is started"


def test_recordings_go_to_a_folder_that_the_user_has_made() -> None:
    (runs,) = (place for place in compose()["services"]["recorder"]["volumes"] if isinstance(place, dict))
    assert (runs["source"], runs["target"]) == ("../runs", "/bench/runs")
    assert not runs["bind"]["create_host_path"], "Docker would make it root's"


@pytest.mark.parametrize("name", sorted(set(compose()["services"]) - {JOB}))
def test_health_is_what_the_node_says_of_itself(name: str) -> None:
    assert compose()["services"][name]["healthcheck"]["test"][-1] == f"/lce/{name}"


def test_the_hardware_is_laid_over_services_that_exist() -> None:
    assert set(compose("compose.hardware.yaml")["services"]) <= set(compose()["services"])


def test_the_stages_follow_one_another_and_no_package_is_forgotten() -> None:
    text = (DOCKER / "Dockerfile").read_text(encoding="utf-8")
    assert re.findall(r"^FROM (\S+) AS (\S+)$", text, re.M) == [
        ("ros:jazzy", "base"),
        ("base", "test"),
        ("base", "run"),
    ]
    assert set(re.findall(r"^COPY src/(\w+)/package.xml", text, re.M)) == {
        file.parent.name for file in SOURCES.glob("*/package.xml")
    }
    assert re.search(r"^USER (?!0|root)", text, re.M)


@pytest.mark.alone
def test_the_services_commands_record_an_experiment(tmp_path: Path, graph: Graph) -> None:
    """As the containers would run them, in a folder where /bench/runs would be."""

    def words(name: str) -> list[str]:
        _, package, executable, *options = shlex.split(compose()["services"][name]["command"])
        found = [re.sub(r"^/bench/install/(\w+)", lambda m: get_package_prefix(m[1]), word) for word in options]
        return [f"{get_package_prefix(package)}/lib/{package}/{executable}", *found]

    def start(name: str, *more: str) -> "subprocess.Popen[str]":
        environment = os.environ | {"ROS_DOMAIN_ID": str(graph.domain)}
        command = [*words(name), *more]
        with (tmp_path / f"{name}.log").open("w") as log:
            process = subprocess.Popen(command, cwd=tmp_path, env=environment, stdout=log, stderr=log, text=True)
        graph.processes.append(process)
        return process

    (tmp_path / "wave.csv").write_text("time_s,power_w\n0.0,0.2\n1.0,0.0\n")
    always = {name for name, service in compose()["services"].items() if "profiles" not in service}
    running = {name: start(name) for name in always - {JOB}}
    player = start(JOB, "-p", f"protocol:={tmp_path / 'wave.csv'}")
    until(lambda: player.poll() is not None or any(p.poll() is not None for p in running.values()), "the end", 60.0)
    logs = {file.stem: file.read_text() for file in tmp_path.glob("*.log")}
    assert player.poll() == 0, logs
    check = [sys.executable, str(DOCKER / "healthcheck.py"), "/lce/laser"]
    health = subprocess.run(
        check, env=os.environ | {"ROS_DOMAIN_ID": str(graph.domain)}, capture_output=True, text=True, check=False
    )
    assert health.returncode == 0, health.stdout + health.stderr
    for name, process in running.items():
        process.terminate()
        assert process.wait(timeout=10) == 0, logs[name]
    (bag,) = (tmp_path / "runs").iterdir()
    assert {"/lce/laser/power", "/lce/temperature", "/lce/displacement"} <= set(read(bag))
