# SPDX-License-Identifier: Apache-2.0
"""Tables as loggers, spreadsheets and programs write them."""

from pathlib import Path

import numpy as np
import pytest

from lce_data.errors import LceError
from lce_data.importing.read import read_foreign
from lce_data.importing.recording import Pick, Recording

N = 40
TIME_S = 0.5 * np.arange(N)
POWER_W = np.where(TIME_S < 10.0, 1.0, 0.0)
WARM_C = 22.0 + 20.0 * np.where(TIME_S < 10.0, 1.0 - np.exp(-TIME_S / 4.0), np.exp(-(TIME_S - 10.0) / 4.0))


def understood(path: Path, head: str, form: str, *picks: str) -> Recording:
    """A table of rows (t, p, k) written by a format string."""
    rows = [form.format(t=t, p=p, k=k, i=i) for i, (t, p, k) in enumerate(zip(TIME_S, POWER_W, WARM_C, strict=True))]
    path.write_text("\n".join([head, *rows] if head else rows) + "\n", encoding="utf-8")
    return read_foreign(path, [Pick.parse(text) for text in picks])


def said(recording: Recording) -> dict[str, tuple[str, str]]:
    """By quantity: the column, and the unit with a question mark behind a guess."""
    return {row[1].rstrip("?"): (row[0], row[2]) for row in recording.rows}


@pytest.mark.parametrize(
    ("head", "form"),
    [
        ("% time_s power_w temperature_c", "{t} {p} {k}"),  # MATLAB
        ("# time_s,power_w,temperature_c", "{t},{p},{k}"),  # NumPy
        ('"","time_s","power_w","temperature_c"', '"{i}",{t},{p},{k}'),  # R, with the names of its rows
        ('"time_s","power_w","temperature_c"', '"{i}",{t},{p},{k}'),  # R, with nothing above the names of its rows
        ("time_s;power_w;temperature_c", "{t};{p};{k};"),  # a separator at the end of each row
        ("time_s,power_w,temperature_c,,", "{t},{p},{k},,"),  # a spreadsheet
        ("# a: b\ntime_s power_w temperature_c", "{t} {p} {k}"),
        ("Rig 3\nRun\t7\n\ntime_s\tpower_w\ttemperature_c", "{t}\t{p}\t{k}"),  # LabVIEW
    ],
)
def test_the_columns_are_found(head: str, form: str, tmp_path: Path) -> None:
    recording = understood(tmp_path / "x.txt", head, form)
    assert recording.guesses == ()
    run = recording.run
    assert run.power is not None and run.temperature is not None
    np.testing.assert_allclose(run.power.time_s, TIME_S)
    np.testing.assert_allclose(run.power.value, POWER_W)
    np.testing.assert_allclose(run.temperature.value, WARM_C + 273.15)


def test_a_date_beside_a_time_of_day_that_passes_midnight(tmp_path: Path) -> None:
    seconds = 86_390.0 + TIME_S
    rows = [
        f"01.02.2026;{int(s // 3600) % 24:02d}:{int(s // 60) % 60:02d}:{s % 60:04.1f};{p};{k}"
        for s, p, k in zip(seconds, POWER_W, WARM_C, strict=True)
    ]
    (tmp_path / "y.csv").write_text("\n".join(["Datum;Uhrzeit;Leistung W;Temperatur °C", *rows]), encoding="utf-8")
    recording = read_foreign(tmp_path / "y.csv")
    assert said(recording)["time"] == ("Uhrzeit", "s") and recording.guesses == ()
    np.testing.assert_allclose(recording.signals[0].time_s, TIME_S)


def test_an_incubator_with_stamps_in_nanoseconds_and_several_sensors(tmp_path: Path) -> None:
    head = "time,time_t1,t1,t2,t3,average_temperature,heater_on,fan_on"
    form = "{i}000000000,{i},{k},{k},21.5,{k},{p},True"
    rows = [
        form.format(i=1_606_000_000 + i, k=k, p=p > 0) for i, (k, p) in enumerate(zip(WARM_C, POWER_W, strict=True))
    ]
    (tmp_path / "x.csv").write_text("\n".join([head, *rows]), encoding="utf-8")
    recording = read_foreign(tmp_path / "x.csv", [Pick.parse("ambient=t3:degC")])
    assert said(recording) == {
        "time": ("time", "ns?"),
        "power": ("heater_on", "W?"),
        "temperature": ("average_temperature", "°C?"),
        "ambient": ("t3", "°C"),
    }
    np.testing.assert_allclose(recording.signals[0].time_s, np.arange(N), atol=1e-6)


def test_a_wire_under_stress(tmp_path: Path) -> None:
    recording = understood(
        tmp_path / "x.csv", "Time [s],Current,Temp [K],Strain (%),Stress [MPa]", "{t},{p},{k},-2.5,150"
    )
    assert said(recording) == {
        "time": ("Time [s]", "s"),
        "temperature": ("Temp [K]", "K"),
        "displacement": ("Strain (%)", "%"),
        "load": ("Stress [MPa]", "MPa"),
    }
    assert recording.remarks == (
        "Strain (%): 1 % counts as 1 mm: the strain of 100 mm",
        "Stress [MPa]: 1 MPa counts as 1 N: the force on a cross-section of 1 mm²",
    )
    assert [s.value_si[0] for s in recording.signals[-2:]] == pytest.approx([-0.0025, 150.0])


def test_a_time_without_a_unit_is_in_ms_if_the_response_would_take_hours(tmp_path: Path) -> None:
    recording = understood(tmp_path / "x.csv", "Time,power_w,temperature_c", "{t}e3,{p},{k}")
    assert said(recording)["time"] == ("Time", "ms?")
    recording = understood(tmp_path / "x.csv", "Time,power_w,temperature_c", "{t},{p},{k}")
    assert said(recording)["time"] == ("Time", "s?")


def test_a_spreadsheet_is_no_text(tmp_path: Path) -> None:
    (tmp_path / "x.xlsx").write_bytes(b"PK\x03\x04\x14\x00\x06\x00\x08\x00\x00\x00")
    with pytest.raises(LceError, match=r"x\.xlsx: not a text table; a spreadsheet has to be saved as CSV"):
        read_foreign(tmp_path / "x.xlsx")
