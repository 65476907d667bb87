# SPDX-License-Identifier: Apache-2.0
"""Foreign tables made runs: whatever separator, decimal sign and unit, the values are those that were meant."""

from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from lce_data.channels import DISPLACEMENT, POWER, TEMPERATURE
from lce_data.errors import LceError
from lce_data.importing.headers import meaning
from lce_data.importing.layout import find_layout
from lce_data.importing.read import read_foreign
from lce_data.importing.recording import Pick, Recording
from lce_data.importing.units import SPELLINGS
from lce_data.read_runs import read_run
from lce_data.run import Run
from lce_data.units import KELVIN

Floats = NDArray[np.float64]
N = 60
TIME_S = 0.1 * np.arange(N)
POWER_W = np.where((TIME_S > 1.0) & (TIME_S < 4.0), 1.5, 0.0)
WARM_K = 295.0 + 40.0 * np.convolve(POWER_W, np.exp(-TIME_S / 1.5))[:N] / 15.0
MOVED_M = 1e-4 * (WARM_K - 295.0)

HEADERS = {
    "time": ("time_s", "Time (s)", "t [s]", "time_ms", "Time [ms]", "timestamp_us", "elapsed min", "t/s", "time in s"),
    "power": ("power_w", "power (mW)", "Laser power [W]", "P_mW", "laserPower_W", "heater_%", "P [µW]"),
    "temperature": ("temperature_c", "T [°C]", "temperature_k", "Temp degC", "T_K", "temp (F)", "Thermocouple [degC]"),
    "displacement": ("displacement_m", "displacement_mm", "d [µm]", "Position (um)", "stroke / mm", "d_cm"),
}
VALUES_SI = {"time": TIME_S, "power": POWER_W, "temperature": WARM_K, "displacement": MOVED_M}


def foreign(path: Path, columns: dict[str, Floats], separator: str = ",", decimal: str = ".", head: str = "") -> Path:
    """A table with every digit of the values."""
    rows = zip(*(values.tolist() for values in columns.values()), strict=True)
    lines = [separator.join(repr(value).replace(".", decimal) for value in row) for row in rows]
    path.write_text(
        "\n".join([*([head] if head else []), separator.join(columns), *lines]) + "\n", encoding="utf-8-sig"
    )
    return path


def imported(recording: Recording, folder: Path) -> Run:
    return read_run(recording.write(folder, {}))


def is_as_meant(run: Run) -> None:
    assert run.power is not None and run.temperature is not None and run.displacement is not None
    np.testing.assert_allclose(run.power.time_s, TIME_S, atol=1e-8)
    np.testing.assert_allclose(run.power.value, POWER_W, rtol=1e-8)
    np.testing.assert_allclose(run.temperature.value, WARM_K, atol=1e-6)
    np.testing.assert_allclose(run.displacement.value, MOVED_M, rtol=1e-8, atol=1e-15)


@pytest.mark.parametrize("seed", range(30))
def test_a_table_comes_back_whatever_its_spelling(seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(seed)
    separator, decimal = [(",", "."), (";", ","), (";", "."), ("\t", ","), ("\t", "."), ("|", ",")][rng.integers(6)]
    columns = {}
    for quantity in rng.permutation(list(HEADERS)):
        header = str(rng.choice(HEADERS[quantity]))
        said = meaning(header)
        assert said is not None and said.quantity == quantity and said.unit is not None, header
        columns[header] = said.unit.from_si(VALUES_SI[quantity])
    recording = read_foreign(foreign(tmp_path / "day 1.csv", columns, separator, decimal))
    assert recording.guesses == ()
    run = imported(recording, tmp_path / "runs")
    is_as_meant(run)
    assert run.name == "day 1" and run.experiment.other["imported"]["file"] == "day 1.csv"


@pytest.mark.parametrize("seed", range(12))
def test_columns_picked_by_hand_need_no_headers(seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(seed)
    order = rng.permutation(list(VALUES_SI))
    columns, picks = {}, []
    for i, quantity in enumerate(order):
        si = {"time": "s", "power": "W", "temperature": "K", "displacement": "m"}[quantity]
        unit, spellings = list(SPELLINGS[si].items())[rng.integers(len(SPELLINGS[si]))]
        sign = "-" if quantity == "displacement" and seed % 2 else ""
        columns[f"ch{i}"] = (-1.0 if sign else 1.0) * unit.from_si(VALUES_SI[quantity])
        source = f"ch{i}" if seed % 3 else str(i + 1)
        picks.append(Pick.parse(f"{quantity}={source}:{sign}{rng.choice(spellings)}"))
    recording = read_foreign(foreign(tmp_path / "x.csv", columns), picks)
    assert recording.guesses == ()
    is_as_meant(imported(recording, tmp_path / "runs"))


def test_units_are_guessed_from_the_values_and_marked(tmp_path: Path) -> None:
    stamps = 1.7e18 + 1e9 * TIME_S
    columns = {"time": stamps, "T1": WARM_K, "Q1": POWER_W / 0.015, "x": 1e3 * MOVED_M, "T2": WARM_K}
    recording = read_foreign(foreign(tmp_path / "x.csv", columns))
    assert {s.quantity: s.unit.symbol for s in recording.signals} == {
        "time": "ns", "temperature": "K", "power": "%", "displacement": "mm",
    }  # fmt: skip
    assert {s.quantity: s.guessed for s in recording.guesses}["temperature"] == ("column", "unit")
    assert recording.left_out == ("T2 (may be the temperature as well)",)
    assert recording.remarks == ("Q1: 100 % counts as 1 W: gains are in K per full power",)
    assert ("T1", "temperature?", "K?") in [row[:3] for row in recording.rows]


def test_dates_and_switches_are_numbers(tmp_path: Path) -> None:
    start = datetime(2026, 11, 2, 23, 59, 58, tzinfo=UTC)
    stamps = [start + timedelta(seconds=float(t)) for t in TIME_S]
    forms = {"iso": lambda s: s.isoformat(), "german": lambda s: s.strftime("%d.%m.%Y %H:%M:%S.%f")}
    for name, form in forms.items():
        rows = [f"{form(s)};{p > 0};{k - KELVIN};ok" for s, p, k in zip(stamps, POWER_W, WARM_K, strict=True)]
        path = tmp_path / f"{name}.csv"
        path.write_text("\n".join(["Date;heater_on;temperature (°C);state", *rows]), encoding="cp1252")
        recording = read_foreign(path)
        assert recording.left_out == ("state",)
        run = imported(recording, tmp_path / "runs")
        assert run.power is not None
        np.testing.assert_allclose(run.power.time_s, TIME_S, atol=1e-6)
        np.testing.assert_array_equal(run.power.value, POWER_W > 0)


def test_a_preamble_a_row_of_units_and_blank_lines_are_understood(tmp_path: Path) -> None:
    rows = [f"{1e3 * t:.1f}   {p}  {k - KELVIN:.6f}" for t, p, k in zip(TIME_S, POWER_W, WARM_K, strict=True)]
    head = ["Logger 7", "# ambient_c: 21.5", "# specimen: A7", "", "time   power  temperature", "ms  W  °C"]
    (tmp_path / "x.txt").write_text("\r\r\n".join([*head, *rows, "", ""]), encoding="utf-8")
    recording = read_foreign(tmp_path / "x.txt")
    assert recording.guesses == ()
    assert [s.unit.symbol for s in recording.signals] == ["ms", "W", "°C"]
    run = imported(recording, tmp_path / "runs")
    assert run.experiment.conditions.ambient_c == 21.5 and run.experiment.conditions.specimen == "A7"


def test_a_table_without_headers_counts_its_columns(tmp_path: Path) -> None:
    rows = [f"{t},{p},{k}" for t, p, k in zip(TIME_S, POWER_W, WARM_K, strict=True)]
    (tmp_path / "x.csv").write_text("\n".join(rows), encoding="utf-8")
    assert find_layout(tmp_path / "x.csv").table.names == ("column 1", "column 2", "column 3")
    picks = [Pick.parse(text) for text in ("time=1:s", "power=2:W", "temperature=3:K")]
    assert imported(read_foreign(tmp_path / "x.csv", picks), tmp_path / "runs").temperature is not None


def test_of_rows_that_repeat_a_time_the_last_one_is_kept(tmp_path: Path) -> None:
    columns = {"time_s": np.floor(TIME_S * 2.0), "power_w": POWER_W, "temperature_k": WARM_K}
    recording = read_foreign(foreign(tmp_path / "x.csv", columns))
    assert recording.rows_changed == (
        "48 of 60 rows repeat the time of the row before; of each column, the last value at a time is kept",
    )
    assert recording.signals[0].value.tolist() == list(range(12))


def test_rows_of_one_sensor_each_at_one_time_are_put_together(tmp_path: Path) -> None:
    rows = [f"{t},{p},\n{t},,{k}" for t, p, k in zip(TIME_S.tolist(), POWER_W.tolist(), WARM_K.tolist(), strict=True)]
    (tmp_path / "x.csv").write_text("\n".join(["time_s,power_w,temperature_k", *rows]) + "\n", encoding="utf-8")
    recording = read_foreign(tmp_path / "x.csv")
    assert recording.rows_changed[0].startswith("60 of 120 rows")
    run = imported(recording, tmp_path / "runs")
    assert run.power is not None and run.temperature is not None
    np.testing.assert_allclose(run.power.value, POWER_W)
    np.testing.assert_allclose(run.temperature.value, WARM_K)


def test_separators_of_thousands_are_refused(tmp_path: Path) -> None:
    rows = [f'{t},"1,200",{k}' for t, k in zip(TIME_S.tolist(), WARM_K.tolist(), strict=True)]
    (tmp_path / "x.csv").write_text("\n".join(["time_s,power_mw,temperature_k", *rows]), encoding="utf-8")
    with pytest.raises(
        LceError, match=r"x\.csv: it holds '1,200' and '0\.0', so '1,200' may have a separator of thousands"
    ):
        read_foreign(tmp_path / "x.csv")


def test_another_sign_in_a_column_that_nobody_reads_is_no_matter(tmp_path: Path) -> None:
    rows = [
        f"{t:.1f};{p:.1f};{k:.2f};2.1".replace(".", ",", 3) for t, p, k in zip(TIME_S, POWER_W, WARM_K, strict=True)
    ]
    (tmp_path / "x.csv").write_text("\n".join(["time_s;power_w;temperature_k;firmware", *rows]), encoding="utf-8")
    assert [row[4] for row in read_foreign(tmp_path / "x.csv").rows] == ["60", "60", "60"]


def test_a_letter_of_windows_far_down_the_table(tmp_path: Path) -> None:
    rows = [f"{0.1 * i:.1f},{i % 2},{295.0 + 0.01 * i:.2f},ok" for i in range(500)]
    rows[-1] = rows[-1].replace("ok", "zu heiß")
    (tmp_path / "x.csv").write_text("\n".join(["time_s,power_w,temperature_k,note", *rows]), encoding="cp1252")
    assert [row[4] for row in read_foreign(tmp_path / "x.csv").rows] == ["500", "500", "500"]


def test_words_for_a_sample_that_is_not_there_are_empty_cells(tmp_path: Path) -> None:
    words = ["NaN", "NA", "null", "-"]
    rows = [
        f"{t},{p},{k if i % 6 else words[i % 4]}"
        for i, (t, p, k) in enumerate(zip(TIME_S, POWER_W, WARM_K, strict=True))
    ]
    (tmp_path / "x.csv").write_text("\n".join(["time_s,power_w,temperature_k", *rows]), encoding="utf-8")
    assert [row[4] for row in read_foreign(tmp_path / "x.csv").rows] == ["60", "60", "50"]


def test_what_the_user_says_no_column_holds_is_left_out(tmp_path: Path) -> None:
    columns = {"time_s": TIME_S, "power_w": POWER_W, "temperature_k": WARM_K, "position_m": MOVED_M}
    recording = read_foreign(foreign(tmp_path / "x.csv", columns), [Pick.parse("displacement=")])
    assert [s.quantity for s in recording.signals] == ["time", "power", "temperature"]


@pytest.mark.parametrize(
    ("change", "picks", "told"),
    [
        ({}, ["temperature=T9:K"], r"x\.csv: no column 'T9'; it has time_s, power_w, temperature_k"),
        ({"time_s": TIME_S[::-1]}, [], r"x\.csv, row 3: the time goes back, from 5\.9 to 5\.8.*Split it there"),
        ({"power_w": np.where(TIME_S == 2.0, np.inf, 1.0)}, [], r"x\.csv, row 22: power_w is inf"),
    ],
)
def test_what_cannot_be_understood_is_told(
    change: dict[str, Floats], picks: list[str], told: str, tmp_path: Path
) -> None:
    columns = {"time_s": TIME_S, "power_w": POWER_W, "temperature_k": WARM_K} | change
    with pytest.raises(LceError, match=told):
        read_foreign(foreign(tmp_path / "x.csv", columns), [Pick.parse(text) for text in picks])


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("warmth=T1", "expected QUANTITY=NAME"),
        ("T1", "expected QUANTITY=NAME"),
        ("temperature=T1:mm", "'mm' is not a unit that is known here; one of °C, K, °F"),
    ],
)
def test_a_pick_that_says_nothing_is_told(text: str, told: str) -> None:
    with pytest.raises(LceError, match=told):
        Pick.parse(text)


def test_a_table_without_a_time_or_without_numbers_is_refused(tmp_path: Path) -> None:
    path = foreign(tmp_path / "x.csv", {"power_w": POWER_W, "temperature_k": WARM_K})
    with pytest.raises(LceError, match=r"no column looks like a time; --column time=NAME:UNIT names it: power_w, temp"):
        read_foreign(path)
    path.write_text("nothing\nhere\n", encoding="utf-8")
    with pytest.raises(LceError, match="no table of numbers"):
        read_foreign(path)


def test_a_recording_is_not_written_over_itself_or_another(tmp_path: Path) -> None:
    columns = {"time_s": TIME_S, "power_w": POWER_W, "temperature_k": WARM_K}
    recording = read_foreign(foreign(tmp_path / "x.csv", columns))
    with pytest.raises(LceError, match="is the file that is read"):
        recording.write(tmp_path, {}, overwrite=True)
    recording.write(tmp_path / "runs", {"load_n": 0.2})
    with pytest.raises(LceError, match="exists already; --force overwrites it"):
        recording.write(tmp_path / "runs", {})
    assert read_run(tmp_path / "runs" / "x.csv").experiment.conditions.load_n == 0.2
    models = tmp_path / "models"
    models.mkdir()
    (models / "x.yaml").write_text("a model", encoding="utf-8")
    with pytest.raises(LceError, match=r"x\.yaml: exists already; --force overwrites it"):
        recording.write(models, {})
    with pytest.raises(LceError, match=r"x\.csv: cannot be made"):
        recording.write(tmp_path / "x.csv", {})


@pytest.mark.parametrize("header", ["T setpoint", "target_temperature", "note", "flow_l", "reference power"])
def test_what_is_no_measurement_has_no_meaning(header: str) -> None:
    assert meaning(header) is None


@pytest.mark.parametrize(
    ("header", "channel"), [("T", TEMPERATURE), ("d", DISPLACEMENT), ("Q1", POWER), ("temp", TEMPERATURE)]
)
def test_a_symbol_only_suggests_what_a_column_is(header: str, channel: object) -> None:
    said = meaning(header)
    assert said is not None and said.quantity == getattr(channel, "name", "") and said.certain == (header == "temp")


def test_a_unit_alone_suggests_what_a_column_is() -> None:
    found = {header: meaning(header) for header in ("IR camera [°C]", "lifted (µm)", "Verdi / mW", "ramp [%]", "n [V]")}
    said = {header: what and (what.quantity, what.certain) for header, what in found.items()}
    assert said == {
        "IR camera [°C]": ("temperature", False),
        "lifted (µm)": ("displacement", False),
        "Verdi / mW": ("power", False),
        "ramp [%]": None,
        "n [V]": None,
    }


def test_the_room_the_load_and_inputs_of_ones_own_are_understood(tmp_path: Path) -> None:
    columns = {
        "time_s": TIME_S, "power_w": POWER_W, "temperature_k": WARM_K, "T_room [°C]": np.full(N, 22.5),
        "load_g": np.full(N, 50.0), "fan": TIME_S,
    }  # fmt: skip
    recording = read_foreign(foreign(tmp_path / "x.csv", columns), [Pick.parse("input_fan=fan")])
    assert recording.guesses == () and recording.left_out == ()
    run = imported(recording, tmp_path / "runs")
    by_name = {channel.name: series.value for channel, series in run.series.items()}
    np.testing.assert_allclose(by_name["ambient"], 22.5 + KELVIN, atol=1e-6)
    np.testing.assert_allclose(by_name["load"], 0.4903325)
    np.testing.assert_allclose(by_name["input_fan"], TIME_S)
