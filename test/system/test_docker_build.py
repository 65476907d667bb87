# SPDX-License-Identifier: Apache-2.0
"""The test stage of docker/Dockerfile without an engine: its context is made, and its commands run there.

The context is what `.dockerignore` leaves and the COPY lines take. The commands are those of the Dockerfile, with two
differences: this machine's ROS stands for the one in the image, and only a few of the tests run. All tests are
collected, so a file that the context lacks is an error here as it is there.
"""

import os
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

import pytest

build = pytest.importorskip("docker.utils.build", reason="docker is in requirements/venv.in, not in ubuntu.txt")
dockerfile_parse = pytest.importorskip("dockerfile_parse", reason="it is in requirements/venv.in, not in ubuntu.txt")

ROOT = Path(__file__).resolve().parents[2]
DOCKERFILE = ROOT / "docker" / "Dockerfile"
FEW = "test_layouts or test_docs or test_effects_command or test_docker and hardware"
"""The tests that run, as pytest's keywords. Most of them read files outside their own package."""
TESTS = '-m "$TESTS"'
"""How the stage chooses its tests."""
FOREIGN = ("AMENT_", "CMAKE_", "COLCON_", "PYTHON", "PYTEST_")
"""Variables of the calling environment that an image does not know."""


def instructions(stage: str) -> Iterator[tuple[str, str, str]]:
    """Stage, instruction and value of each line of a stage, those of the stages under it first."""
    under, lines = {}, []
    name = ""
    with DOCKERFILE.open("rb") as file:
        for line in dockerfile_parse.DockerfileParser(fileobj=file).structure:
            if line["instruction"] == "FROM":
                base, _, name = line["value"].split()
                under[name] = base
            else:
                lines.append((name, line["instruction"], line["value"]))
    chain = [stage]
    while under[chain[0]] in under:
        chain.insert(0, under[chain[0]])
    for wanted in chain:
        yield from (line for line in lines if line[0] == wanted)


def context() -> list[PurePosixPath]:
    """Files that a builder is sent, relative to the root of the repository."""
    ignored = DOCKERFILE.with_name("Dockerfile.dockerignore").read_text(encoding="utf-8").split()
    paths = build.exclude_paths(str(ROOT), ignored, "docker/Dockerfile")
    return sorted(PurePosixPath(path) for path in paths if (ROOT / path).is_file())


def copy(source: Path, target: Path) -> None:
    """Do what COPY does: a folder's contents into a folder, or a file into one."""
    assert source.exists(), f"COPY {source.name}: there is nothing of that name in the context"
    if source.is_dir():
        shutil.copytree(source, target, dirs_exist_ok=True)
    else:
        target.mkdir(parents=True, exist_ok=True)
        shutil.copy(source, target)


def run(command: str, folder: Path, environment: dict[str, str]) -> str:
    """Run a command of the stage on this machine's ROS and with FEW of its tests; return what it printed."""
    here = command.replace("/opt/ros/$ROS_DISTRO", sys.prefix).replace(TESTS, f"{TESTS} -k '{FEW}'")
    words = ["bash", "-o", "pipefail", "-c", here]
    done = subprocess.run(words, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{command}\n{done.stdout[-5000:]}\n{done.stderr[-5000:]}"
    return done.stdout


def test_the_context_holds_every_file_of_the_repository_that_a_test_may_read() -> None:
    kept = {*map(str, context())}
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False).stdout.split()
    hidden = {name for name in listed if name.startswith(".")}
    assert {name for name in listed if (ROOT / name).is_file()} - hidden <= kept
    assert not any(name.startswith((".git/", ".venv/", "build/", "install/", "log/", "runs/")) for name in kept)


@pytest.mark.slow
@pytest.mark.timeout(1500)  # two minutes by itself, eight on a machine with much else to do
def test_the_test_stage_passes_in_its_own_context(tmp_path: Path) -> None:
    sent, image = tmp_path / "context", tmp_path / "bench"
    for file in context():
        copy(ROOT / file, (sent / file).parent)
    image.mkdir()
    environment = {name: value for name, value in os.environ.items() if not name.startswith(FOREIGN)}
    said = []
    for stage, instruction, value in instructions("test"):
        if instruction == "COPY":
            *sources, target = shlex.split(value)
            for source in sources:
                copy(sent / source, image / target)
        elif instruction in ("ENV", "ARG"):
            environment |= dict(word.split("=", 1) for word in shlex.split(value))
        elif instruction == "RUN" and stage == "test":
            said.append(run(value, image, environment))
    assert len(said) == 2 and "passed" in said[-1].splitlines()[-1]
