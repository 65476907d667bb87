# SPDX-License-Identifier: Apache-2.0
"""What the first tutorial quotes stands in the output of the demo, which `make pictures` writes beside it."""

import re
from pathlib import Path

TUTORIALS = Path(__file__).resolve().parents[2] / "docs" / "tutorials"
LEFT_OUT = "…"


def quoted(tutorial: str) -> list[str]:
    """The lines of its blocks of text, and of its commands that the demo runs."""
    text = [line for block in re.findall(r"```text\n(.*?)```", tutorial, re.DOTALL) for line in block.splitlines()]
    commands = [line for line in tutorial.splitlines() if line.startswith("lce ")]
    return [line for line in text if line and line != LEFT_OUT] + [f"$ {line}" for line in commands]


def test_every_line_that_the_tutorial_quotes_is_of_the_demo() -> None:
    lines = quoted((TUTORIALS / "first-hour.md").read_text(encoding="utf-8"))
    said = (TUTORIALS / "first-hour-output.txt").read_text(encoding="utf-8").splitlines()
    assert len(lines) > 40
    assert [line for line in lines if line not in said] == []
