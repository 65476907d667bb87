# SPDX-License-Identifier: Apache-2.0
"""A model file may come from anywhere: the effect files that it lists run only if the user trusts their content."""

import os
import py_compile
from pathlib import Path

import pytest

from lce_data.errors import LceError
from lce_model import default_model, load_model, save_model, trust
from lce_model.effects import find
from lce_model.trust import UntrustedEffect

EFFECT = '''"""An offset of the camera."""
from pathlib import Path
from lce_model.effects import Effect
from lce_model.terms import Parameter

Path({was_run!r}).touch()


def step(measured_temperature, b):
    return measured_temperature + b


EFFECT = Effect(name="offset", stage="sensor", equation="T_meas = T + b", strength="b", typical=0.3, step=step,
    parameters=(Parameter("b", "K", 0.0, -5.0, 5.0, "offset", "a test"),), outputs=("measured_temperature",))
'''


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """An effect file that leaves a trace when it is run."""
    place = tmp_path / "models" / "offset.py"
    place.parent.mkdir()
    place.write_text(EFFECT.format(was_run=str(tmp_path / "was_run")))
    return place


def listing(file: Path, name: str) -> Path:
    """A model file beside the effect that lists it by this name."""
    path = file.with_name("strip.yaml")
    path.write_text(f"format: lce-model-1\nthermal: lumped\neffects: ['{name}']\n")
    return path


def was_run(file: Path) -> bool:
    return (file.parents[1] / "was_run").exists()


@pytest.mark.parametrize("name", ["./offset.py", "offset.py", "{file}", "sub/../offset.py", "../models/offset.py"])
def test_opening_a_model_runs_no_file_that_is_not_trusted(file: Path, name: str) -> None:
    with pytest.raises(LceError, match=r"offset\.py"):
        load_model(listing(file, name.format(file=file)))
    assert not was_run(file)


def test_the_refusal_says_what_to_do(file: Path) -> None:
    told = rf"strip\.yaml: effects: {file} is a program that was not run: read it, then trust it \(lce trust {file}\)"
    with pytest.raises(UntrustedEffect, match=told):
        load_model(listing(file, "./offset.py"))


@pytest.mark.parametrize("name", ["./offset.py", "{file}"])
def test_a_trusted_file_runs_until_it_changes(file: Path, name: str) -> None:
    model = listing(file, name.format(file=file))
    digest = trust.trust(file)
    assert trust.trusted() == {digest: str(file)}
    assert load_model(model).effect_names == ("offset",)
    changed = file.with_name("changed.py")
    changed.write_text(f"{file.read_text()}\n")
    with pytest.raises(UntrustedEffect):
        load_model(listing(changed, "changed.py"))


def test_a_relative_path_does_not_leave_the_folder_even_if_the_file_is_trusted(file: Path) -> None:
    trust.trust(file)
    with pytest.raises(LceError, match=r"effects: \.\./models/offset\.py lies outside the folder of the model file"):
        load_model(listing(file, "../models/offset.py"))


def test_trust_for_one_command_reaches_the_processes_that_it_starts(file: Path) -> None:
    trust.allow(file)
    assert os.environ[trust.VARIABLE] == trust.sha256(file)
    assert load_model(listing(file, "offset.py")).effect_names == ("offset",)
    assert trust.trusted() == {}


def test_a_file_that_the_user_named_may_be_listed(file: Path) -> None:
    model = default_model().add(str(file))
    save_model(model, file.with_name("strip.yaml"))
    assert load_model(file.with_name("strip.yaml")) == model
    (file.parent / "elsewhere").mkdir()
    save_model(model, file.parent / "elsewhere" / "strip.yaml")
    assert f"- {file}\n" in (file.parent / "elsewhere" / "strip.yaml").read_text()
    assert load_model(file.parent / "elsewhere" / "strip.yaml") == model


def test_what_runs_is_the_trusted_text_and_not_a_compiled_file_beside_it(file: Path, tmp_path: Path) -> None:
    honest, when = file.read_text(), file.stat().st_mtime_ns
    file.write_text(honest.replace("was_run", "was_ill"))  # of the same length, as the check of a .pyc asks for
    os.utime(file, ns=(when, when))
    py_compile.compile(str(file), doraise=True)
    file.write_text(honest)
    os.utime(file, ns=(when, when))
    find(str(file))
    assert was_run(file) and not (tmp_path / "was_ill").exists()


@pytest.mark.parametrize("line", ["raise SystemExit(0)", "import sys; sys.exit()", "1 / 0", "(", "\0"])
def test_a_file_that_ends_the_program_is_an_error(file: Path, line: str) -> None:
    file.write_text(f"{line}\n")
    with pytest.raises(LceError, match=r"offset\.py: cannot be loaded: "):
        find(str(file))


def test_a_pipe_is_no_effect_file(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.py")
    with pytest.raises(LceError, match=r"pipe\.py: a pipe, a socket or a device, not a file"):
        find(str(tmp_path / "pipe.py"))


def test_a_list_of_trust_that_cannot_be_read_trusts_nothing(file: Path) -> None:
    trust.trust(file)
    trust.trust_file().write_text("effects: yes\n")
    with pytest.raises(LceError, match=r"trusted\.yaml"):
        load_model(listing(file, "offset.py"))
    assert not was_run(file)
