# SPDX-License-Identifier: Apache-2.0
"""Numbers that pages write out are those of the code. A number that is not here should come from a command."""

import re
from pathlib import Path
from typing import Any, Final

import pytest
import yaml

from lce_analysis.diagnosis.trials import FIRST_STEPS
from lce_analysis.options import DiagnoseOptions, DiscoverOptions
from lce_model.closures.forms import KNOTS
from lce_report.html.arrays import BUCKETS

ROOT = Path(__file__).resolve().parents[2]
WORDS: Final = ("zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")
BENCH = yaml.safe_load((ROOT / "src" / "lce_bringup" / "config" / "bench.yaml").read_text(encoding="utf-8"))
LASER = BENCH["/**/laser"]["ros__parameters"]
PLAYER = BENCH["/**/experiment_player"]["ros__parameters"]
DIAGNOSE, DISCOVER = DiagnoseOptions(), DiscoverOptions()

diagnosis, discovery = "docs/explanation/diagnosis.md", "docs/explanation/discovery.md"
safety, glance = "docs/explanation/safety.md", "docs/reference/README.md"


def ms(seconds: float) -> str:
    return f"{1000 * seconds:.0f} ms"


CLAIMS = [
    (diagnosis, f"The {WORDS[DIAGNOSE.refitted]} that promise most are refitted for {FIRST_STEPS} steps"),
    (diagnosis, f"The best {WORDS[DIAGNOSE.contenders]} are refitted to the end and judged on data left out"),
    (diagnosis, f"takes or promises {100 * DIAGNOSE.far:.0f} % of what is above the noise of a sensor"),
    (diagnosis, f"each of them for at least {100 * DIAGNOSE.far:.0f} % of what is above the noise"),
    (diagnosis, f"of its stage by more than {100 * DIAGNOSE.worse:.0f} %"),
    (diagnosis, f"mean square by {DIAGNOSE.worth_noise:g} and by {100 * DIAGNOSE.worth_share:.0f} % of what is above"),
    (diagnosis, f"more than {DIAGNOSE.explained:g} × its noise"),
    (diagnosis, f"({WORDS[DIAGNOSE.knots]} knots"),
    (diagnosis, f"more than {100 * DIAGNOSE.jumping:.0f} % of the energy of the innovations"),
    (diagnosis, f"beyond {WORDS[round(DIAGNOSE.jump_size)]} standard deviations"),
    (discovery, f"the {WORDS[DISCOVER.refitted]} strongest, their curves free"),
    (discovery, f"the best {WORDS[DISCOVER.forms]} refitted in full"),
    (discovery, f"straight lines between {WORDS[KNOTS]} knots"),
    (discovery, f"tried with {WORDS[len(DISCOVER.lags_s)]} time constants loses ln {len(DISCOVER.lags_s)}"),
    (discovery, f"ln(n/{DISCOVER.false_alarm:g})"),
    ("docs/how-to/report.md", f"by their extremes in {BUCKETS} buckets"),
    (safety, f"no command for {ms(LASER['command_timeout_s'])} (`command_timeout_s`)"),
    (safety, f"for {ms(LASER['command_fault_s'])} (`command_fault_s`)"),
    (safety, f"no temperature for {ms(LASER['temperature_pause_s'])} (`temperature_pause_s`)"),
    (safety, f"for {ms(LASER['temperature_fault_s'])} (`temperature_fault_s`)"),
    (safety, f"more than {ms(LASER['max_tick_gap_s'])} between two ticks"),
    (safety, f"`arming_patience_s` ({PLAYER['arming_patience_s'] / 60:.0f} minutes)"),
    (glance, f"the newest command is older than {ms(LASER['command_timeout_s'])}"),
    (glance, f"temperature is older than {ms(LASER['temperature_pause_s'])}"),
]
"""The page, and the words that the code's values make."""


def prose(page: str) -> str:
    return " ".join((ROOT / page).read_text(encoding="utf-8").split())


@pytest.mark.parametrize(("page", "claim"), CLAIMS)
def test_a_number_in_a_page_is_that_of_the_code(page: str, claim: str) -> None:
    assert claim in prose(page)


def test_an_effect_file_is_as_short_as_the_documents_say() -> None:
    page = (ROOT / "docs" / "tutorials" / "own-effect.md").read_text(encoding="utf-8")
    block = re.search(r"^```python\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    assert block is not None
    assert len(block[1].splitlines()) <= 25
    assert [p for p in ("docs/README.md", "docs/tutorials/own-effect.md") if "twenty lines" not in prose(p)] == []


def test_a_page_says_no_duration_that_nobody_checks() -> None:
    said: dict[str, Any] = {}
    for folder in ("tutorials", "how-to"):
        for page in (ROOT / "docs" / folder).glob("*.md"):
            text = " ".join(page.read_text(encoding="utf-8").split())
            said[page.name] = re.findall(r"\b(?:takes|in) (?:about |half )?(?:an?|\w+) (?:minutes?|hours?)\b", text)
    assert {name: found for name, found in said.items() if found} == {}
