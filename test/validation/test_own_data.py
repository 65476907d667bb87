# SPDX-License-Identifier: Apache-2.0
"""docs/tutorials/your-own-data.md, walked on the measured heater, where its runs lie beside the repository."""

import json
from pathlib import Path

import heater
import pytest
import walk

from lce_data.read_runs import read_runs
from lce_data.suspicions import suspicions

PAGE = (heater.REPOSITORY / "docs" / "tutorials" / "your-own-data.md").read_text(encoding="utf-8")
DATA = heater.find()

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(DATA is None, reason="no heater runs: docs/tutorials/your-own-data.md names the source"),
    pytest.mark.timeout(300),
]


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    assert DATA is not None
    folder = tmp_path_factory.mktemp("page")
    walk.as_downloaded(DATA, folder)
    return folder


@pytest.fixture(scope="module")
def said(place: Path) -> list[str]:
    """What each shell block of the page prints."""
    return walk.run(walk.blocks(PAGE, "bash"), place)


@pytest.fixture(scope="module")
def quoted() -> list[str]:
    """The outputs that the page quotes: of the first lines of a file, of an import and of a comparison."""
    return [text.strip() for text in walk.blocks(PAGE, "text")]


def test_the_files_are_those_that_the_page_shows(said: list[str], quoted: list[str]) -> None:
    assert said[0].split() == quoted[0].split()  # its lines end with CR CR LF


def test_without_a_word_by_hand_it_shows_its_guesses_and_writes_nothing(
    said: list[str], quoted: list[str], place: Path
) -> None:
    (command,) = walk.blocks(PAGE, "")
    printed = walk.run([f"{command.strip().replace('--out heater', '--out other')} </dev/null || true"], place)[0]
    assert printed.strip() == quoted[1]
    assert not (place / "other").exists()


def test_all_six_runs_are_imported_without_a_warning(said: list[str], place: Path) -> None:
    runs = read_runs(sorted((place / "heater").glob("*.csv")))
    assert sorted(run.name for run in runs) == sorted(heater.RUNS)
    assert [suspicions(run) for run in runs] == [()] * 6
    assert runs[0].experiment.other["imported"]["columns"] == ["time=Time:s", "power=Q1:%", "temperature=T1:degC"]


def test_the_comparison_is_the_quoted_one(said: list[str], quoted: list[str]) -> None:
    head, *rows = quoted[2].splitlines()
    assert head in said[3]
    for row in rows:
        name, times_noise = row.split()[0], float(row.split()[-2])
        (printed,) = [line for line in said[3].splitlines() if line.startswith(name)]
        assert float(printed.split()[-2]) == pytest.approx(times_noise, rel=0.02)


def test_the_verdict_is_told_to_people_and_to_programs(said: list[str], place: Path) -> None:
    found = json.loads((place / "d.json").read_text(encoding="utf-8"))
    assert said[5].split()[0] == found["verdict"]
    assert said[4].splitlines()[0]
    assert (place / "d.html").exists() and (place / "compare.html").exists()
