# SPDX-License-Identifier: Apache-2.0
"""Tables of numbers in blocks: every number as it was written, and errors that name row and cell in any block."""

from pathlib import Path

import numpy as np
import pytest

from lce_data import columns
from lce_data.columns import TableFormat, read_columns
from lce_data.errors import LceError


def written(path: Path, text: str, encoding: str = "utf-8") -> Path:
    path.write_text(text, encoding=encoding)
    return path


@pytest.fixture(autouse=True)
def small_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """So that a few rows are several blocks."""
    monkeypatch.setattr(columns, "BLOCK", 64)


@pytest.mark.parametrize("seed", range(8))
def test_numbers_are_read_as_they_were_written(seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(seed)
    values = rng.standard_normal((50, 3)) * 10.0 ** rng.integers(-9, 9, (50, 3))
    values[rng.random((50, 3)) < 0.2] = np.nan
    separator, decimal = [(",", "."), (";", ","), ("\t", ","), (";", ".")][seed % 4]
    end = "\r\n" if seed % 2 else "\n"
    cells = [["" if np.isnan(v) else repr(float(v)).replace(".", decimal) for v in row] for row in values]
    text = end.join([separator.join("abc"), *(separator.join(row) for row in cells)])
    encoding = "utf-16" if seed == 5 else "utf-8-sig"
    with (tmp_path / "t.csv").open("w", newline="", encoding=encoding) as file:
        file.write(text)
    table = TableFormat(("a", "b", "c"), separator=separator, decimal=decimal, encoding=encoding)
    found = read_columns(tmp_path / "t.csv", table)
    np.testing.assert_array_equal(np.column_stack([found[name] for name in "abc"]), values)


def test_cells_may_be_padded_and_quoted_and_rows_short(tmp_path: Path) -> None:
    path = written(tmp_path / "t.csv", 'a,b,c\n 1 , 2,3\n4,"5",\n6\n\n')
    found = read_columns(path, TableFormat(("a", "b", "c")))
    np.testing.assert_array_equal(found["a"], [1.0, 4.0, 6.0])
    np.testing.assert_array_equal(found["b"], [2.0, 5.0, np.nan])


def test_blanks_between_cells_may_be_many(tmp_path: Path) -> None:
    path = written(tmp_path / "t.txt", "a b\n  1   2.5\n 10\t3 \n")
    np.testing.assert_array_equal(read_columns(path, TableFormat(("a", "b"), separator=" "))["b"], [2.5, 3.0])


def test_columns_that_are_not_wanted_may_hold_anything(tmp_path: Path) -> None:
    path = written(tmp_path / "t.csv", "a,b,c\n1,on,2\n3,off,4\n")
    found = read_columns(path, TableFormat(("a", "b", "c")), ["c", "a"])
    assert found["c"].tolist() == [2.0, 4.0] and found["a"].tolist() == [1.0, 3.0]


@pytest.mark.parametrize("row", [2, 11, 40])
@pytest.mark.parametrize(
    ("cells", "told"),
    [
        ("1,half", r"t\.csv, row {row}: b is 'half', not a number"),
        ("1,inf", r"t\.csv, row {row}: b is inf"),
        ("nan,2", r"t\.csv, row {row}: a is nan"),
        ("1,2,5", r"t\.csv, row {row}: 3 cells under a header of 2; a decimal comma\?"),
    ],
)
def test_what_is_wrong_is_named_in_whichever_block_it_stands(row: int, cells: str, told: str, tmp_path: Path) -> None:
    rows = ["a,b", *(f"{i},{i}.5" for i in range(60))]
    rows[row - 1] = cells
    with pytest.raises(LceError, match=told.format(row=row)):
        read_columns(written(tmp_path / "t.csv", "\n".join(rows)), TableFormat(("a", "b")))


def test_a_file_that_is_no_text_is_told(tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_bytes(b"a,b\n\xff\xfe1,2\n")
    with pytest.raises(LceError, match=r"t\.csv: not a CSV text file"):
        read_columns(tmp_path / "t.csv", TableFormat(("a", "b")))
