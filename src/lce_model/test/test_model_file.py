# SPDX-License-Identifier: Apache-2.0
"""Model files: what is written reads back, and what does not fit is named."""

from pathlib import Path

import pytest

from lce_data.errors import LceError
from lce_model import default_model, load_model, save_model


@pytest.mark.parametrize("deformation", ["none", "equilibrium", "dynamic"])
def test_a_model_reads_back_as_it_was(tmp_path: Path, deformation: str) -> None:
    model = default_model("lumped", deformation)
    save_model(model, tmp_path / "m.yaml")
    assert load_model(tmp_path / "m.yaml") == model


def test_fit_record_errors_and_flags_survive(tmp_path: Path) -> None:
    from dataclasses import replace

    model = default_model()
    first = replace(model.values[1], value=1.0 / 3.0, standard_error=2.5e-3, determined=True)
    loose = replace(model.values[2], standard_error=None, determined=False)
    model = model.with_values(
        (model.values[0], first, loose, *model.values[3:]), {"runs": [{"name": "a", "nrmse": 0.02}]}
    )
    save_model(model, tmp_path / "m.yaml")
    assert load_model(tmp_path / "m.yaml") == model


def test_a_number_as_people_write_it_is_a_number(tmp_path: Path) -> None:
    path = tmp_path / "m.yaml"
    save_model(default_model(), path)
    path.write_text(path.read_text().replace("5.58e-22", "6e-22"))
    assert load_model(path)["equilibrium.a0"] == 6e-22


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "thermal: lumped",
            "thermal: lumpy",
            r"m\.yaml: thermal: unknown model 'lumpy' \(did you mean 'lumped'\?\); one of none, lumped",
        ),
        (
            "gain:",
            "gian:",
            r"m\.yaml: parameters\.lumped: unknown key 'gian' \(did you mean 'gain'\?\); known: gain, tau",
        ),
        ("unit: K/W", "unit: K/mW", r"m\.yaml: parameters\.lumped\.gain\.unit: 'K/mW' does not fit.*'K/W'"),
        ("value: 18.0", "value: -18.0", r"m\.yaml: lumped\.tau: -18 s is outside \[0\.01, 1e\+06\] s"),
        ("value: 18.0", "value: fast", r"m\.yaml: parameters\.lumped\.tau\.value is 'fast'; it must be a number"),
        ("value: 18.0", "value: .nan", r"parameters\.lumped\.tau\.value: nan is not a finite number"),
        ("bounds: [0.01, 1000000.0]}", "bounds: [0.1]}", r"bounds: \[0\.1\] is not \[lower, upper\]"),
        ("effects: []", "effects: [creeep]", r"m\.yaml: unknown effect 'creeep'"),
        ("format: lce-model-1", "format: 7", r"m\.yaml: format is 7; it must be text"),
        ("format: lce-model-1", "format: lce-model-9", r"m\.yaml: format: 'lce-model-9' is not 'lce-model-1'"),
        ("value: 18.0", "vlaue: 18.0", r"m\.yaml: parameters\.lumped\.tau\.vlaue is not a key that is known here"),
        ("value: 18.0, ", "", r"m\.yaml: parameters\.lumped\.tau\.value is missing"),
        ("value: 18.0", "value: 18.0, colour: red", r"m\.yaml: parameters\.lumped\.tau\.colour is not a key"),
        ("value: 18.0", "value: true", r"m\.yaml: parameters\.lumped\.tau\.value is True; it must be a number"),
        ("fixed: true", "fixed: perhaps", r"m\.yaml: parameters\.\S+\.fixed is 'perhaps'; it must be true or false"),
        ("deformation: equilibrium", "colour: red", r"m\.yaml: the file: unknown key 'colour'"),
        ("parameters:", "parameters: [", r"m\.yaml: not a YAML file \(line \d+: "),
    ],
)
def test_what_does_not_fit_is_named(tmp_path: Path, old: str, new: str, message: str) -> None:
    path = tmp_path / "m.yaml"
    save_model(default_model(), path)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(LceError, match=message):
        load_model(path)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(LceError, match=r"none\.yaml: No such file"):
        load_model(tmp_path / "none.yaml")


def test_an_unwritable_place_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(LceError, match="cannot be written"):
        save_model(default_model(), tmp_path / "missing" / "m.yaml")
    assert list(tmp_path.iterdir()) == []


def test_setting_names_key_value_and_range() -> None:
    with pytest.raises(LceError, match=r"lumped\.gain: 1e\+07 K/W is outside \[0\.0001, 1e\+06\] K/W"):
        default_model().set({"lumped.gain": 1e7})
    with pytest.raises(LceError, match=r"unknown parameter 'lumped\.gin'"):
        default_model().set({"lumped.gin": 1.0})


def test_bounds_wider_than_by_default_are_kept(tmp_path: Path) -> None:
    model = default_model("lumped", "none", ("camera_lag",)).hold({"camera_lag.tau": (0.0, 60.0)})
    model = model.set({"camera_lag.tau": 43.0})
    save_model(model, tmp_path / "m.yaml")
    assert load_model(tmp_path / "m.yaml") == model


@pytest.mark.parametrize(
    ("key", "bounds", "message"),
    [
        ("lumped.tau", (5.0, 5.0), r"lumped\.tau: bounds \[5, 5\] s are not an interval"),
        ("lumped.tau", (0.0, 5.0), r"lumped\.tau: the lower bound, 0 s, must be above 0, as its scale is logarithmic"),
        ("camera_lag.tau", (-1.0, 5.0), r"camera_lag\.tau: the lower bound, -1 s, must be at least 0"),
        ("camera_lag.tau", (0.0, float("inf")), r"bounds \[0, inf\] s are not an interval"),
    ],
)
def test_bounds_that_a_parameter_cannot_have_are_refused(key: str, bounds: tuple[float, float], message: str) -> None:
    with pytest.raises(LceError, match=message):
        default_model("lumped", "none", ("camera_lag",)).hold({key: bounds})


def test_what_is_fixed_by_default_stays_fixed_where_a_file_does_not_say(tmp_path: Path) -> None:
    path = tmp_path / "m.yaml"
    save_model(default_model(), path)
    path.write_text(path.read_text(encoding="utf-8").replace(", fixed: true", ""), encoding="utf-8")
    loaded = load_model(path)
    assert loaded.values[loaded.index("strip.length")].fixed


FIXTURES = Path(__file__).parent / "models"


@pytest.mark.parametrize("name", ["strip.yaml", "fitted.yaml"])
def test_a_file_that_version_0_1_wrote_reads(name: str, tmp_path: Path) -> None:
    model = load_model(FIXTURES / name)
    save_model(model, tmp_path / name)
    assert load_model(tmp_path / name) == model
    if name == "fitted.yaml":
        assert model.values[1].standard_error is not None and model.fit["software"]
        assert (tmp_path / name).read_text(encoding="utf-8") == (FIXTURES / name).read_text(encoding="utf-8")
