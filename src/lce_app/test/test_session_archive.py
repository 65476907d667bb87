# SPDX-License-Identifier: Apache-2.0
"""A session of the workbench as one file, opened elsewhere."""

import os
from pathlib import Path
from zipfile import ZipFile

import pytest

from lce_app.workbench import archive
from lce_app.workbench.session import Session, load
from lce_data.errors import LceError
from lce_model import default_model, save_model


@pytest.fixture
def session(tmp_path: Path) -> Session:
    """A CSV with what stands beside it, a bag folder, a run that is left aside, a model, an effect, an upload."""
    folder = tmp_path / "here"
    (folder / "bag").mkdir(parents=True)
    for name in ("a.csv", "a.yaml", "aside.csv", "bag/bag_0.mcap", "bag/metadata.yaml", "bag.experiment.yaml"):
        (folder / name).write_text(name)
    os.utime(folder / "a.csv", (0.0, 0.0))  # a computer whose clock was never set
    session = Session(folder, {"a.csv": "train", "bag": "test", "aside.csv": "off"}).with_model("fitted", None)
    session.save()
    save_model(default_model(), session.model_file(1))
    session.own_effects.mkdir()
    (session.own_effects / "mine.py").write_text("raise SystemExit")
    session.uploads.mkdir()
    (session.uploads / "raw.txt").write_text("raw")
    return session


def written(session: Session, tmp_path: Path) -> Path:
    file = tmp_path / "elsewhere" / "taken.zip"
    file.parent.mkdir()
    archive.write(session, [session.folder / "a.csv", session.folder / "bag"], file)
    return file


def test_another_machine_opens_what_was_exported(session: Session, tmp_path: Path) -> None:
    folder = archive.unpack(written(session, tmp_path))
    assert folder == tmp_path / "elsewhere" / "taken"
    opened = load(folder)
    assert (opened.roles, opened.models, opened.current) == (session.roles, session.models, 1)
    assert opened.model_file(1).read_bytes() == session.model_file(1).read_bytes()
    files = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    assert files == {
        "a.csv", "a.yaml", "bag/bag_0.mcap", "bag/metadata.yaml", "bag.experiment.yaml", "workbench/session.yaml",
        "workbench/model-1.yaml",
        "workbench/effects/mine.py", "workbench/versions.txt",
    }  # fmt: skip


def test_what_cannot_be_opened_is_told(session: Session, tmp_path: Path) -> None:
    file = written(session, tmp_path)
    archive.unpack(file)
    with pytest.raises(LceError, match=r"taken: exists already; open it \(lce workbench "):
        archive.unpack(file)
    (tmp_path / "text.zip").write_text("no archive")
    with pytest.raises(LceError, match=r"text\.zip: cannot be unpacked"):
        archive.unpack(tmp_path / "text.zip")
    damaged = bytearray(file.read_bytes())
    damaged[len(damaged) // 4 : len(damaged) // 2] = bytes(len(damaged) // 2 - len(damaged) // 4)
    (tmp_path / "damaged.zip").write_bytes(damaged)
    with pytest.raises(LceError, match=r"damaged\.zip: cannot be unpacked"):
        archive.unpack(tmp_path / "damaged.zip")
    assert not (tmp_path / "damaged").exists()
    with ZipFile(tmp_path / "other.zip", "w") as other:
        other.writestr("a.csv", "time_s")
    with pytest.raises(LceError, match=r"other\.zip: no session of the workbench is in it"):
        archive.unpack(tmp_path / "other.zip")


def test_what_a_link_leads_to_outside_of_the_folder_is_not_taken_along(session: Session, tmp_path: Path) -> None:
    (tmp_path / "secret").write_text("mine")
    (session.folder / "bag" / "link.txt").symlink_to(tmp_path / "secret")
    with ZipFile(written(session, tmp_path)) as taken:
        assert "bag/bag_0.mcap" in taken.namelist() and "bag/link.txt" not in taken.namelist()


def test_an_archive_writes_nothing_outside_of_its_folder(tmp_path: Path) -> None:
    file = tmp_path / "evil.zip"
    with ZipFile(file, "w") as evil:
        evil.writestr("workbench/versions.txt", "")
        evil.writestr("../../escaped.txt", "out")
    folder = archive.unpack(file)
    assert (folder / "escaped.txt").read_text() == "out"
    assert {path.name for path in tmp_path.iterdir()} == {"evil.zip", "evil"}
