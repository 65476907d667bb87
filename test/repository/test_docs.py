# SPDX-License-Identifier: Apache-2.0
"""What the documents name is there: files, commands with their options, make targets, tests."""

import argparse
import re
from pathlib import Path

import pytest

from lce_app.cli.main import COMMANDS, command_module

ROOT = Path(__file__).resolve().parents[2]
DOCUMENTS = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), *ROOT.glob("test/*.md")])
each_document = pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: str(path.relative_to(ROOT)))


def code(document: Path) -> list[str]:
    """Lines of code blocks, without comments, and code spans."""
    text = document.read_text(encoding="utf-8")
    blocks = re.findall(r"^```.*?\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    lines = [line.split(" #")[0] for block in blocks for line in block.splitlines()]
    return [*lines, *re.findall(r"`([^`\n]+)`", re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL))]


def usage(command: str) -> str:
    parser = argparse.ArgumentParser()
    command_module(command).add_arguments(parser)
    return parser.format_usage()


@each_document
def test_links_lead_to_files_of_the_repository(document: Path) -> None:
    for target in re.findall(r"\]\(([^)\s]+)\)", document.read_text(encoding="utf-8")):
        if not re.match(r"[a-z]+:", target):
            path = (document.parent / target.partition("#")[0]).resolve()
            assert path.is_relative_to(ROOT) and path.exists(), f"{document.name}: {target}"


@each_document
def test_modules_that_are_named_exist(document: Path) -> None:
    folders = [ROOT, *ROOT.glob("src/*"), *ROOT.glob("src/*/lce_*")]
    for text in code(document):
        for name in re.findall(r"(?<![\w./-])[a-z_]+/[a-z0-9_/]+\.py\b", text):
            assert any((folder / name).exists() for folder in folders), f"{document.name}: {name}"


@each_document
def test_commands_and_their_options_exist(document: Path) -> None:
    for text in code(document):
        for command, rest in re.findall(r"(?:^|\s)lce ([a-z]+)\b(.*)", text):
            assert command in COMMANDS, f"{document.name}: lce {command}"
            for option in re.findall(r"(?<!\S)--[a-z-]+", rest):
                known = option == "--help" or re.search(rf"{option}\b(?!-)", usage(command))
                assert known, f"{document.name}: lce {command} {option}"


@each_document
def test_make_targets_exist(document: Path) -> None:
    targets = re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    for text in code(document):
        for target in re.findall(r"(?:^|\s)make ([a-z]+)\b", text):
            assert target in targets, f"{document.name}: make {target}"


@each_document
def test_tests_that_are_named_exist(document: Path) -> None:
    sources = [*ROOT.glob("test/**/*.py"), *ROOT.glob("src/*/test/**/*.py")]
    known = {name for file in sources for name in re.findall(r"def (test_\w+)", file.read_text(encoding="utf-8"))}
    for text in code(document):
        for name in re.findall(r"\btest_\w+\b(?!\.)", text):
            assert name in known, f"{document.name}: {name}"


def test_every_command_is_in_the_reference() -> None:
    spans = " ".join(code(ROOT / "docs" / "reference" / "README.md"))
    assert [name for name in COMMANDS if f"lce {name}" not in spans] == []


def test_every_page_is_in_the_index_once() -> None:
    index = (ROOT / "docs" / "README.md").read_text(encoding="utf-8")
    linked = re.findall(r"\]\(([\w/-]+\.md)\)", index)
    pages = {str(page.relative_to(ROOT / "docs")) for page in DOCUMENTS if page.is_relative_to(ROOT / "docs")}
    assert sorted(linked) == sorted(name for name in pages - {"README.md"} if "decisions/0" not in name)


def test_every_decision_is_in_the_list_of_decisions() -> None:
    folder = ROOT / "docs" / "explanation" / "decisions"
    linked = re.findall(r"\]\((0[\w-]+\.md)\)", (folder / "README.md").read_text(encoding="utf-8"))
    assert linked == sorted(page.name for page in folder.glob("0*.md"))


HAND_WRITTEN = [
    page for page in DOCUMENTS if re.search(r"docs/(tutorials|how-to|reference|explanation)/[\w-]+\.md", str(page))
]


@pytest.mark.parametrize("page", HAND_WRITTEN, ids=lambda path: path.stem)
def test_a_page_begins_with_its_purpose_and_ends_with_a_next_step(page: Path) -> None:
    blocks = page.read_text(encoding="utf-8").strip().split("\n\n")
    assert blocks[0].startswith("# ") and "\n" not in blocks[0]
    assert re.match(r"[\w`\"[]", blocks[1]) and not blocks[1].startswith("```"), "no sentence under the title"
    assert re.match(r"Next: .*\]\(", blocks[-1]), "no next step"


def test_the_changelog_has_the_form_of_keep_a_changelog() -> None:
    headings = re.findall(r"^##+ .*$", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    release, kind = (
        r"## \[(Unreleased\]|\d+\.\d+\.\d+\] - \d{4}-\d\d-\d\d)",
        "### (Added|Changed|Deprecated|Removed|Fixed|Security)",
    )
    assert headings[0] == "## [Unreleased]"
    assert [heading for heading in headings if not re.fullmatch(f"{release}|{kind}", heading)] == []


def test_the_sensor_of_the_page_is_the_one_that_the_tests_add() -> None:
    page = (ROOT / "docs" / "how-to" / "add-a-sensor.md").read_text(encoding="utf-8")
    patch = (ROOT / "test" / "system" / "third_sensor" / "force_gauge.patch").read_text(encoding="utf-8")
    added = [line[1:] for line in patch.splitlines() if line.startswith("+") and not line.startswith("+++")]
    blocks = re.findall(r"^```(?:python|yaml)\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    shown = [line for block in blocks if not block.startswith("format:") for line in block.splitlines()]
    assert [line for line in shown if line not in added] == []
    assert [line for line in added if line not in shown] == []
