# SPDX-License-Identifier: Apache-2.0
"""Parameters that differ from run to run: the model of one run, and the model file."""

from pathlib import Path

import pytest

from lce_data.errors import LceError
from lce_model import RunValue, Variation, default_model, load_model, save_model

MODEL = default_model("lumped", "none").varying(
    {"ambient.t_env": Variation(1.5, {"monday": RunValue(295.0, 0.1), "tuesday": RunValue(298.0)})}
)


def test_a_run_has_its_own_value_and_another_run_that_of_the_model() -> None:
    assert MODEL.of_run("monday")["ambient.t_env"] == 295.0
    assert MODEL.of_run("friday")["ambient.t_env"] == MODEL["ambient.t_env"]
    assert MODEL.of_run("monday")["lumped.tau"] == MODEL["lumped.tau"]


def test_a_run_of_the_same_name_and_other_content_is_another_run() -> None:
    fitted = MODEL.with_values(MODEL.values, {"runs": [{"name": "monday", "sha256": "a"}]})
    assert fitted.of_run("monday", "a")["ambient.t_env"] == 295.0
    assert fitted.of_run("monday", "b")["ambient.t_env"] == MODEL["ambient.t_env"]


def test_what_varies_stays_when_an_effect_comes_and_goes_with_the_term_that_has_it() -> None:
    assert MODEL.add("radiation").without("radiation").varies == MODEL.varies
    drifting = MODEL.add("ambient_drift").varying({"ambient_drift.rate": Variation()})
    assert not drifting.without("ambient_drift").varies


def test_the_file_reads_back_as_it_was_written(tmp_path: Path) -> None:
    save_model(MODEL, tmp_path / "m.yaml")
    assert load_model(tmp_path / "m.yaml") == MODEL


@pytest.mark.parametrize(
    ("written", "instead", "message"),
    [
        ("value: 295.0", "value: 900.0", r"ambient\.t_env: 900 K is outside"),
        ("unit: K\n    spread", "unit: s\n    spread", r"varies\.ambient\.t_env\.unit: 's' does not fit"),
        ("varies:\n  ambient.t_env", "varies:\n  ambient.tenv", "unknown parameter 'ambient.tenv'"),
        ("spread: 1.5", "spread: -1.5", "spread"),
    ],
)
def test_a_mistake_in_the_file_is_named(tmp_path: Path, written: str, instead: str, message: str) -> None:
    path = tmp_path / "m.yaml"
    save_model(MODEL, path)
    text = path.read_text()
    assert written in text
    path.write_text(text.replace(written, instead))
    with pytest.raises(LceError, match=message):
        load_model(path)


def test_a_run_whose_name_looks_like_a_number_comes_back(tmp_path: Path) -> None:
    model = default_model().varying({"ambient.t_env": Variation(1.5, {"12e3": RunValue(295.0, 0.1)})})
    save_model(model, tmp_path / "m.yaml")
    assert load_model(tmp_path / "m.yaml").varies == model.varies
