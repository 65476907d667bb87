# SPDX-License-Identifier: Apache-2.0
"""What is wrong with a file is one line that names the file, the key and the value."""

import os
from pathlib import Path
from typing import Annotated, Any, Literal

import pytest
from msgspec import Meta, Struct

from lce_data.errors import LceError
from lce_data.read_runs import read_run
from lce_data.schema import checked, read_yaml


class Spring(Struct, frozen=True, forbid_unknown_fields=True):
    length_m: Annotated[float, Meta(gt=0)]
    turns: int | None = None
    name: str | int = ""


class Box(Struct, frozen=True):
    springs: list[Spring] = []
    use: dict[str, Literal["new", "old"]] = {}
    counts: dict[str, dict[str, int]] = {}
    closed: bool = False


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ([1], "box.yaml: the content is a list; it must be keys with values"),
        (None, "box.yaml: the content is empty; it must be keys with values"),
        ({"closed": "yes"}, "box.yaml: closed is 'yes'; it must be true or false"),
        ({"springs": "two"}, "box.yaml: springs is 'two'; it must be a list"),
        ({"springs": [{}]}, "box.yaml: springs[0].length_m is missing"),
        (
            {"springs": [{"length_m": 1}, {"length_m": "x" * 70}]},
            f"box.yaml: springs[1].length_m is '{56 * 'x'}...; it must be a number",
        ),
        ({"springs": [{"length_m": -1}]}, "box.yaml: springs[0].length_m is -1; it must be a number > 0.0"),
        ({"springs": [{"length_m": True}]}, "box.yaml: springs[0].length_m is True; it must be a number"),
        ({"springs": [{"length_m": 1, "turns": 1.5}]}, "box.yaml: springs[0].turns is 1.5; it must be a whole number"),
        ({"springs": [{"length_m": 1, "name": []}]}, "springs[0].name is a list; it must be a whole number or text"),
        ({"springs": [{"length_m": 1, "size": 2}]}, "springs[0].size is not a key that is known here"),
        (
            {"use": {"a b": "new", "c.d": "lost"}},
            "box.yaml: use.c.d is 'lost', which is not a value that is known here",
        ),
        ({"use": {3: "new"}}, "a key is not text"),
        (
            {"counts": {"one": {"x": 1}, "two": {"x": 1, "y": {}}}},
            "counts.two.y is keys with values; it must be a whole",
        ),
    ],
)
def test_a_wrong_value_is_named_by_file_key_and_value(content: Any, told: str) -> None:
    with pytest.raises(LceError) as caught:
        checked("box.yaml", content, Box)
    assert told in str(caught.value) and "\n" not in str(caught.value)


def test_what_fits_becomes_the_type() -> None:
    assert checked("box.yaml", {"springs": [{"length_m": 2, "turns": None}]}, Box) == Box(springs=[Spring(2.0)])


def test_yaml_keeps_dates_as_text_and_reads_short_exponents(tmp_path: Path) -> None:
    file = tmp_path / "a.yaml"
    file.write_text("day: 2026-11-22\nsize: 1e-3\ncount: 3\nratio: -2.5E2\nname: e3\n", encoding="utf-8")
    assert read_yaml(file) == {"day": "2026-11-22", "size": 0.001, "count": 3, "ratio": -250.0, "name": "e3"}


def test_what_is_no_yaml_is_named(tmp_path: Path) -> None:
    broken, binary = tmp_path / "broken.yaml", tmp_path / "binary.yaml"
    broken.write_text("a: 1\nb: [\n", encoding="utf-8")
    binary.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(LceError, match=r"broken\.yaml: not a YAML file \(line 3: did not find"):
        read_yaml(broken)
    with pytest.raises(LceError, match=r"binary\.yaml: not a YAML file \(not a text\)"):
        read_yaml(binary)
    with pytest.raises(LceError, match=r"none\.yaml: No such file or directory$"):
        read_yaml(tmp_path / "none.yaml")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("a: &a [1, 1]\nb: *a\n", "line 2: an alias"),
        ("\n".join(["x0: &x0 [9]", *(f"x{i}: &x{i} [{f'*x{i - 1},' * 9}]" for i in range(1, 30))]), "line 2: an alias"),
        ("[" * 60 + "]" * 60, "nested deeper than 50"),
        ("[" * 500_000, "nested deeper than 50"),
        ("when: !!timestamp nonsense", "a tag"),
        ("data: !!binary '=='", "a tag"),
        ("run: !!python/object/apply:os.system [ls]", "a tag"),
        (f"seed: {'9' * 5000}", "too many digits"),
        (f"seed: {2**64}", "too many digits"),
        ("- a: [" * 2, "not a YAML file"),
        ("'" + "x" * 2_100_000 + "'", "longer than 2 MB"),
    ],
)
def test_what_an_attack_needs_is_not_read(tmp_path: Path, text: str, told: str) -> None:
    (tmp_path / "run.yaml").write_text(text)
    with pytest.raises(LceError, match=told):
        read_yaml(tmp_path / "run.yaml")


@pytest.mark.parametrize("name", ["run.csv", "run.yaml", "run.mcap", "bag/bag.mcap", "bag/metadata.yaml"])
def test_a_pipe_is_not_waited_for(tmp_path: Path, name: str) -> None:
    file = tmp_path / name
    file.parent.mkdir(exist_ok=True)
    os.mkfifo(file)
    if name == "run.yaml":
        (tmp_path / "run.csv").write_text("time_s,power_w\n")
    recording = {"run.yaml": tmp_path / "run.csv", "bag": file.parent}.get(name.partition("/")[0], file)
    with pytest.raises(LceError, match="a pipe, a socket or a device, not a file"):
        read_run(recording)
