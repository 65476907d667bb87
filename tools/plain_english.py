# SPDX-License-Identifier: Apache-2.0
"""Finds constructions that have to be read twice: in documents, and in docstrings and texts of the sources.

Few of them, each with its cure; more would give false alarms. `make lint` runs it.
"""

import argparse
import ast
import re
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FORBIDDEN = {
    r"(?<!there )\b(is|are) none\b(?! of)": "say what happens: 'is ignored', 'does not exist', 'counts as missing'",
    r"\bwhere there (is|are) none\b": "'if there is none'",
    r"\b(has|have|had) no say\b": "'does not count', 'is ignored'",
    r"\bof that number\b": "name the thing",
    r"(?<!cannot )(?<!can )(?<!could )\b[Tt]ells? (what|which|whether|why|how|when|where)\b": "'says' or 'shows'",
    r"\b(is|are|be|was|were) told\b(?! apart| from)": "'is reported', 'is shown'",
    r"\b(is|are) said (at once|rather|of|to be)\b|\bit is said\b": "say who says it",
    r"\b(likeness|strangers|goal node|believed strip)\b": "collinearity, outlier runs, target, estimated strip",
}
"""By the construction: what to write instead. None with a capital is Python's."""


def findings(text: str) -> Iterator[tuple[int, str, str]]:
    """The line, the words and the cure of each forbidden construction in a text."""
    for construction, cure in FORBIDDEN.items():
        for found in re.finditer(construction, text):
            yield text.count("\n", 0, found.start()) + 1, " ".join(found[0].split()), cure


def texts(file: Path) -> Iterator[tuple[int, str]]:
    """The texts of a file, with the lines on which they begin: a document whole, of a source its strings."""
    content = file.read_text(encoding="utf-8")
    if file.suffix == ".md":
        yield 1, re.sub(r"`[^`\n]*`", "``", content)
        return
    for node in ast.walk(ast.parse(content)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.lineno, node.value


def checked_files(root: Path) -> list[Path]:
    """Documents, sources of the packages, examples."""
    patterns = ("*.md", "docs/**/*.md", "test/*.md", "src/*/lce_*/**/*.py", "src/*/launch/*.py", "examples/*.py")
    return sorted(file for pattern in patterns for file in root.glob(pattern))


def complaints(files: Iterable[Path]) -> list[str]:
    """One line for each finding."""
    return [
        f"{file}:{first + line - 1}: {words!r}: {cure}"
        for file in files
        for first, text in texts(file)
        for line, words, cure in findings(text)
    ]


def main() -> int:
    """Print the findings; 1 if there are any."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="*", type=Path, help="default: documents, packages, examples")
    found = complaints(parser.parse_args().files or checked_files(ROOT))
    print(*found, sep="\n", end="\n" if found else "")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
