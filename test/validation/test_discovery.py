# SPDX-License-Identifier: Apache-2.0
"""What the judge of the discovery counts as right (`make discovery` runs it)."""

from typing import Any

from discovery import cases, marks
from discovery_answers import ANSWERS, DISTURBANCES, SIGNATURES
from discovery_report import report
from effects import STRENGTH

FOUND: dict[str, Any] = {
    "verdict": "found",
    "signatures": [{"name": "follows", "sensor": "temperature", "value": 1.0}],
    "closures": [{"place": "light", "covariate": "dose", "set": [["light", "dose"], ["heat", "temperature"]]}],
    "formulas": [{"closure": 0, "form": "linear", "set": ["linear", "power"]}],
}


def test_every_hidden_effect_has_an_answer() -> None:
    assert set(STRENGTH) == {*ANSWERS, *DISTURBANCES, "sticking_guide"}
    assert set(SIGNATURES) <= set(STRENGTH)


def test_an_answer_is_right_if_a_set_holds_it() -> None:
    right = {"place": True, "covariate": True, "formula": True, "wrong": False}
    assert marks(("radiation",), FOUND) == right
    assert marks(("latent_heat",), FOUND) == right
    assert marks(("clamp_conduction",), FOUND) == {**right, "covariate": False, "formula": False}
    assert not marks(("camera_lag",), FOUND)["place"]


def test_a_function_is_no_disturbance_and_a_foreign_signature_is_wrong() -> None:
    assert marks(("draught",), FOUND) == {"disturbance": False, "named": False, "wrong": False}
    period = {
        **FOUND,
        "verdict": "disturbance",
        "signatures": [{"name": "period", "sensor": "temperature", "value": 11}],
    }
    assert marks(("draught",), period) == {"disturbance": True, "named": True, "wrong": False}
    assert marks((), period) == {"wrong": True}


def test_the_cases_hide_everything_and_twenty_hide_nothing() -> None:
    chosen = cases(3, ("equilibrium", "relays"), "full")
    assert sum(not case.hidden for case in chosen) == 20
    assert {name for case in chosen for name in case.hidden} == {*ANSWERS, *DISTURBANCES}
    assert len({case.name for case in chosen}) == len(chosen)


def test_the_report_counts_failures_and_shows_the_bars() -> None:
    nothing = {
        "case": "equilibrium/nothing/clear/0", "family": "equilibrium", "hidden": [], "visible": 0.0,
        "verdict": "nothing", "closures": [], "formulas": [], "walks": [], "signatures": [], "wrong": False,
        "before": {"temperature": 1.0}, "after": {"temperature": 1.0}, "seconds": 3.0,
    }  # fmt: skip
    failed = {"case": "relays/creep/clear/0", "family": "relays", "hidden": ["creep"], "failed": "ValueError: no"}
    text = report([nothing, failed], "abc", "--seeds 1")
    assert "| discovery on nothing | \u2264 5% | 0 of 1 | 0% |" in text
    assert "| place in the set | \u2265 85% | **0 of 1** | **0%** |" in text
    assert "| relays/creep/clear/0 | | failed | ValueError: no |" in text
