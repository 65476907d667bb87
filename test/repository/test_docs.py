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


def test_every_command_is_in_the_readme() -> None:
    spans = " ".join(code(ROOT / "README.md"))
    assert [name for name in COMMANDS if f"lce {name}" not in spans] == []
