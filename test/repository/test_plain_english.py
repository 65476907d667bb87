# SPDX-License-Identifier: Apache-2.0
"""The check of `make lint` finds what has to be read twice, and leaves plain sentences alone."""

import importlib.util
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SPEC = importlib.util.spec_from_file_location("plain_english", ROOT / "tools" / "plain_english.py")
assert SPEC is not None and SPEC.loader is not None
plain_english = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(plain_english)


@pytest.mark.parametrize(
    "riddle",
    [
        "A reading from the future by more than pause_after_s is none.",
        "age of a displacement that is none",
        "Raises LceError where there is none of that number.",
        "effects of the heat balance have no say",
        "The log tells which node failed.",
        "a value at its bound is told",
        "Where much is left, it is said.",
        "the likeness of two effects",
    ],
)
def test_a_riddle_is_found(riddle: str) -> None:
    assert list(plain_english.findings(riddle))


@pytest.mark.parametrize(
    "plain",
    [
        "Readings stamped more than pause_after_s ahead are ignored.",
        "Maximum age before a displacement is ignored.",
        "Returns None if there is none.",
        "fit : the value is None before the first fit",
        "These data cannot tell which of the two it is.",
        "Two effects that cannot be told apart.",
        "'volts' is none of them.",
        "The experiment that tells two effects apart.",
    ],
)
def test_a_plain_sentence_is_left_alone(plain: str) -> None:
    assert list(plain_english.findings(plain)) == []


def test_strings_of_sources_and_text_of_documents_are_read_but_not_their_code(tmp_path: Path) -> None:
    source = tmp_path / "node.py"
    source.write_text('"""A node."""\nis_none = None\ndescription = "age of a reading that is none"\n')
    page = tmp_path / "page.md"
    page.write_text("`x is none` is code.\n\nThe log tells why.\n")
    assert [line.partition(": ")[0] for line in plain_english.complaints([source, page])] == [
        f"{source}:3",
        f"{page}:3",
    ]


def test_the_documents_and_the_packages_are_read() -> None:
    files = {str(file.relative_to(ROOT)) for file in plain_english.checked_files(ROOT)}
    assert {"README.md", "docs/explanation/safety.md", "src/lce_drivers/lce_drivers/laser/laser_node.py"} <= files
