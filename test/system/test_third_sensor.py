# SPDX-License-Identifier: Apache-2.0
"""What a sensor costs that nobody thought of: a made-up force gauge, added to a copy of the sources by a patch.

The patch is the measure: at most six files, one of them the driver. With it a run of the node graph is recorded, a
model of the force fitted, compared and reported, and the tests that hold packages, containers and documents together
pass, without an edit anywhere else.
"""

import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml
from rosbags.highlevel import AnyReader

ROOT = Path(__file__).resolve().parents[2]
PATCH = Path(__file__).parent / "third_sensor" / "force_gauge.patch"
STIFFNESS = 200.0  # N/m

MAKE_STRIP = f"""
from lce_model import default_model, save_model
save_model(default_model().add("force_gauge.py").set({{"force_gauge.stiffness": {STIFFNESS}}}), "strip.yaml")
"""


def test_the_patch_touches_six_files_at_most_and_one_is_the_driver() -> None:
    touched = re.findall(r"^\+\+\+ b/(.+)$", PATCH.read_text(encoding="utf-8"), flags=re.MULTILINE)
    assert len(touched) <= 6
    assert sum("/lce_drivers/lce_drivers/" in name for name in touched) == 1


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder with a recorded run, a fitted model, a comparison and its report, all made by the patched sources."""
    place = tmp_path_factory.mktemp("third_sensor")
    for name in ("src", "docker", "test"):
        shutil.copytree(ROOT / name, place / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "conftest.py"):
        shutil.copy(ROOT / name, place / name)
    subprocess.run(["git", "apply", str(PATCH)], cwd=place, check=True)
    packages = os.pathsep.join(str(path) for path in sorted((place / "src").iterdir()))
    environment = os.environ | {"PYTHONPATH": packages + os.pathsep + os.environ.get("PYTHONPATH", "")}

    def python(*words: str) -> None:
        done = subprocess.run(
            [sys.executable, *words], cwd=place, env=environment, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr

    lce, own = ("-m", "lce_app.cli.main"), "--effect-file=force_gauge.py"
    python("-c", MAKE_STRIP)
    python(*lce, "run", "pulse:amp=0.4,th=20,rest=20", "--fast", "--seed=1", "--model=strip.yaml", own, "--out=run")
    python(*lce, "fit", "run", "--effect=force_gauge.py", "--out=model.yaml")
    python(*lce, "compare", "run", "--model=model.yaml", own, "--json=compare.json", "--report=compare.html")
    held_together = "test/repository/test_workspace.py", "test/system/test_docker.py"
    not_built = "--deselect=test/system/test_docker.py::test_the_services_commands_record_an_experiment"
    python("-m", "pytest", "-q", "-p", "no:cacheprovider", *held_together, not_built)
    yield place
    shutil.rmtree(place)


def test_its_node_is_recorded_with_the_others(folder: Path) -> None:
    with AnyReader([folder / "run"]) as reader:
        counts = {connection.topic: connection.msgcount for connection in reader.connections}
    assert counts["/lce/force"] == counts["/lce/displacement"]
    assert counts["/lce/sim/force"] > 0


def test_its_model_is_fitted(folder: Path) -> None:
    stiffness = yaml.safe_load((folder / "model.yaml").read_text())["parameters"]["force_gauge"]["stiffness"]
    assert stiffness["value"] == pytest.approx(STIFFNESS, abs=5.0 * stiffness["standard_error"])
    assert stiffness["standard_error"] < 0.1


def test_comparison_and_report_show_it(folder: Path) -> None:
    content = json.loads((folder / "compare.json").read_text())
    (run,) = content["runs"]
    assert run["force"]["rms_n"] == pytest.approx(2e-3, rel=0.05)
    assert set(content["error_shares"]) == {"temperature", "displacement", "force"}
    assert any("force" in sentence and " mN" in sentence for sentence in content["sentences"])
    assert re.search(r"force\sF", (folder / "compare.html").read_text(encoding="utf-8"))
