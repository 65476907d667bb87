# SPDX-License-Identifier: Apache-2.0
"""docs/tutorials/own-effect.md, run as it stands; and one line says what is wrong with an effect file."""

import re
import shlex
from pathlib import Path

import pytest
import yaml
from run_command import lce

from lce_analysis.diagnosis.ranking import reason
from lce_app.cli import main as cli
from lce_data.errors import LceError
from lce_model import default_model, load_model, save_model, trust
from lce_model.effects import find

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "tutorials" / "own-effect.md").read_text(encoding="utf-8")


def blocks(kind: str) -> list[str]:
    """The code blocks of one kind, in their order."""
    found = re.findall(r"^```(.*?)\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
    return [text for name, text in found if name == kind]


EFFECT, WITH_TIME = blocks("python")
(STRIP,) = blocks("yaml")
TRY_OUT, TRUST, RUN, USE = blocks("")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with the two files of the page."""
    (tmp_path / "glare.py").write_text(EFFECT, encoding="utf-8")
    (tmp_path / "strip.yaml").write_text(STRIP, encoding="utf-8")
    return tmp_path


def shell(block: str, folder: Path) -> list[str]:
    """What the commands of a block print, each run to its good end in the folder."""
    printed = []
    for line in block.splitlines():
        program, *words = shlex.split(line, comments=True)
        assert program == "lce"
        found = [sorted(map(str, folder.glob(w))) if "*" in w else [w] for w in words]
        done = lce(*(word for part in found for word in part), cwd=folder, timeout_s=100.0)
        assert done.returncode == 0, done.stderr
        printed.append(done.stdout)
    return printed


def test_an_effect_takes_fewer_than_25_lines() -> None:
    assert len(EFFECT.splitlines()) < 25


@pytest.mark.timeout(300)  # eight commands, each a process
def test_the_page_from_the_strip_that_has_the_effect_to_the_model_that_knows_it(folder: Path) -> None:
    (said,) = shell(TRY_OUT, folder)
    refused = lce("simulate", "--model", "strip.yaml", "--input", "pulse", "--out", "run.csv", cwd=folder)
    assert refused.returncode == 1 and "glare.py is a program that was not run" in refused.stderr
    assert "T_meas = T + b P" in said and "Tried out" in said
    shell(TRUST, folder)
    shell(RUN, folder)
    diagnosed, added, fitted = shell(USE, folder)
    assert diagnosed.startswith("glare is missing")
    assert re.search(r"^With glare [\d.]+% of the squared error above the noise goes", added)
    assert "glare.b" in fitted
    for name in ("m2.yaml", "m3.yaml"):
        assert yaml.safe_load((folder / name).read_text())["effects"] == ["glare.py"]
        trust.trust(folder / "glare.py")
        assert load_model(folder / name)["glare.b"] == pytest.approx(0.4, abs=0.02)


def test_the_page_shows_a_step_that_reads_the_time(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    function = EFFECT[EFFECT.index("def step") : EFFECT.index("\n\n\nEFFECT")]
    (folder / "glare.py").write_text(EFFECT.replace(function, WITH_TIME), encoding="utf-8")
    assert cli.main(["effects", str(folder / "glare.py")]) == 0
    assert "(up to 0.45 K of temperature)" in capsys.readouterr().out


def test_a_model_file_finds_its_effect_wherever_it_is_read_from(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir("/")
    trust.trust(folder / "glare.py")
    model = load_model(folder / "strip.yaml")
    (folder / "elsewhere").mkdir()
    save_model(model, folder / "elsewhere" / "copy.yaml")
    assert yaml.safe_load((folder / "elsewhere" / "copy.yaml").read_text())["effects"] == [str(folder / "glare.py")]
    assert load_model(folder / "elsewhere" / "copy.yaml") == model
    assert model.without(str(folder / "glare.py")).values == default_model().values


def test_the_first_line_of_the_docstring_is_the_meaning_unless_the_file_gives_one(folder: Path) -> None:
    file = folder / "glare.py"
    glare = find(str(file))
    assert glare.title == "glare"
    assert glare.meaning == "Laser light that the strip reflects into the camera: T_meas = T + b P"
    named = EFFECT.replace(
        'name="glare",', 'name="glare", title="glare of the laser", meaning="the camera sees the laser",'
    )
    (folder / "named.py").write_text(named, encoding="utf-8")
    assert find(str(folder / "named.py")).title == "glare of the laser"
    assert find(str(folder / "named.py")).meaning == "the camera sees the laser"


def test_a_file_of_version_0_1_may_call_its_step_sizes_nudges(folder: Path) -> None:
    (folder / "old.py").write_text(
        EFFECT.replace("typical=0.3,", "typical=0.3,\n    nudges=(0.1, 0.5),"), encoding="utf-8"
    )
    assert find(str(folder / "old.py")).step_sizes == (0.1, 0.5)
    assert find(str(folder / "glare.py")).step_sizes == (pytest.approx(5e-4),)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("EFFECT =", "EFECT =", "defines no EFFECT = Effect(...)"),
        ('    strength="b",\n', "", "missing 1 required keyword-only argument: 'strength'"),
        ('strength="b"', 'strength="c"', "effect glare: no parameter 'c'; it has b"),
        ('"K/W", 0.0,', '"K/W", 1.0,', "effect glare: b is 1 by default, not at its null 0"),
        ("typical=0.3", "typical=30.0", "parameter b: 30 K/W is outside [-5, 5] K/W"),
        ("power, b)", "powr, b)", "term glare: argument 'powr' of step is no signal, parameter or state"),
        ('"measured_temperature",)', '"reading",)', "term glare: unknown output 'reading'"),
        ('"sensor"', '"camera"', "term glare: unknown stage 'camera'"),
        ('name="glare"', 'name="gl are"', "'gl are' is no name"),
        ("+ b * power", "+ b *", "SyntaxError: invalid syntax (glare.py, line 8)"),
        ("import Parameter", "import Parametre", "ImportError: cannot import name 'Parametre'"),
        ("+ b * power", "+ b * light_of_day", "step cannot be compiled: NameError: name 'light_of_day' is not defined"),
        ("+ b * power", ", b * power", "step returns UniTuple(float64 x 2), but has to return a number each for"),
        ("+ b * power", "+ b * power + 1.0", "at b = 0 it changes measured_temperature"),
        ("step=step", "step=lambda power, b: b * powr", "step cannot be compiled: NameError: name 'powr'"),
        ("step=step", "step=lambda powr, b: b * powr", "argument 'powr' of step is no signal, parameter or state"),
        (
            "+ b * power",
            "+ 0.0 * b",
            "it changes nothing from 301 to 453 K (28 to 180 °C), 0 to 2 W, within 600 s: does it act beyond?",
        ),
        (
            "power, b):\n    return measured_temperature + b",
            "power):\n    return measured_temperature + 0",
            "not read b",
        ),
        ("+ b * power", "+ b * power / (b - 0.3)", "at b = 0.3 it gives what is not a number"),
        ('name="glare"', 'name="lumped"', "the model has a term lumped already"),
    ],
)
def test_what_is_wrong_with_a_file_is_told_in_one_line(
    folder: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, told: str
) -> None:
    file = folder / "glare.py"
    assert old in EFFECT
    file.write_text(EFFECT.replace(old, new), encoding="utf-8")
    assert cli.main(["effects", str(file)]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"lce: {file}: ")
    assert told in line


THRESHOLD = EFFECT.replace("power, b)", "power, temperature, b, limit)").replace(
    "b * power", "(b if temperature > limit else 0.0)"
)
LIMIT = '"a look into the beam"), Parameter("limit", "K", {:g}, 250.0, 600.0, "threshold", "a test")'


def with_threshold(folder: Path, limit_k: float) -> Path:
    """The effect with a threshold of the temperature, in a file."""
    file = folder / f"above_{limit_k:g}.py"
    file.write_text(THRESHOLD.replace('"a look into the beam")', LIMIT.format(limit_k)), encoding="utf-8")
    return file


def test_an_effect_beyond_a_threshold_is_tried_out_as_far_as_the_bench_can_go(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["effects", str(with_threshold(folder, 320.0))]) == 0
    said = capsys.readouterr().out
    assert "Tried out from 301 to 335 K (28 to 62 °C), 0 to 1.5 W, within 60 s: it compiles" in said
    assert "at its typical one (up to 0.3 K of temperature)." in said
    assert "changes nothing from" not in said

    assert cli.main(["effects", str(with_threshold(folder, 340.0))]) == 0
    said = capsys.readouterr().out
    assert "Tried out from 301 to 453 K (28 to 180 °C), 0 to 2 W, within 600 s: it compiles" in said
    assert "It changes nothing from 301 to 335 K (28 to 62 °C), 0 to 1.5 W, within 60 s." in said

    assert cli.main(["effects", str(with_threshold(folder, 480.0))]) == 1
    assert "0 to 2 W, within 600 s, with limit = 480 K: does it act beyond?" in capsys.readouterr().err


def test_a_parameter_without_a_grid_is_named_where_the_strength_stays_at_zero(folder: Path) -> None:
    effect = find(str(with_threshold(folder, 340.0)))
    assert effect.at_default_only == ("limit",)
    told = reason(effect, "null")
    assert told.startswith("refitted, its strength stays within 0.1 % of its range of its null value, or the error")
    assert told.endswith("it was looked for at limit = 340 only, give `grid` in above_340.py values to try")
    assert "grid" not in reason(effect, "chance")
    assert "grid" not in reason(find(str(folder / "glare.py")), "null")
    assert "grid" not in reason(find("camera_lag"), "null")


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(LceError, match=r"none\.py: no such effect file"):
        default_model().add(str(tmp_path / "none.py"))


def test_an_effect_of_the_library_cannot_be_had_twice_under_one_name(folder: Path) -> None:
    (folder / "glare.py").write_text(EFFECT.replace('name="glare"', 'name="creep"'), encoding="utf-8")
    with pytest.raises(LceError, match=r"glare\.py: the model has a term creep already"):
        default_model().add("creep").add(str(folder / "glare.py"))
