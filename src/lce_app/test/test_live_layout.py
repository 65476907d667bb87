# SPDX-License-Identifier: Apache-2.0
"""Live plots as plain values: their order and size, the file that keeps them, names and units of what they show."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from lce_app.workbench.history import KEPT_S, History
from lce_app.workbench.live_layout import HEIGHTS_PX, MOST_PLOTS, MOST_SERIES, Layout, LiveView, Plot
from lce_app.workbench.live_series import Series
from lce_data.errors import LceError

POWER = Series("/lce/laser/power", "data")
AGE = Series("/diagnostics", "/lce/laser: output.age_s")


def names(layout: Layout) -> list[str]:
    return [plot.name for plot in layout.plots]


def test_plots_are_added_moved_and_removed() -> None:
    first = Layout((Plot((POWER,), key=3), Plot((AGE,), key=5)))
    more = first.with_plot((Series("/lce/imu", "orientation.x"), POWER, POWER))
    key = more.plots[-1].key
    assert key not in (3, 5) and names(more)[-1] == "imu orientation.x, laser/power"
    assert names(more.moved(key, -1)) == [names(more)[0], names(more)[2], names(more)[1]]
    assert more.moved(key, -9).plots[0].key == key and more.moved(3, 9).plots[-1].key == 3
    assert [plot.key for plot in more.placed(key, 3).plots] == [key, 3, 5]
    assert [plot.key for plot in more.placed(3, key).plots] == [5, key, 3]
    assert names(more.without(3)) == names(more)[1:]
    other = more.with_series(3, (AGE,))
    assert names(other)[0] == AGE.name and other.plots[0].key not in (3, 5, key), "it is drawn anew"
    assert more.without(99) == more.moved(99, 1) == more.placed(99, 3) == more, "a plot that another page has removed"


def test_plots_are_resized_within_limits() -> None:
    layout = Layout((Plot((POWER,), key=1),))
    assert layout.resized(1, 99).plots[0].height == HEIGHTS_PX[-1]
    assert layout.resized(1, -99).plots[0].height == HEIGHTS_PX[0]
    assert layout.widened(1).plots[0].wide and not layout.widened(1).widened(1).plots[0].wide


def test_there_are_limits() -> None:
    with pytest.raises(LceError, match="choose a topic first"):
        Layout().with_plot(())
    with pytest.raises(LceError, match=f"it shows {MOST_SERIES} at most"):
        Layout().with_plot(tuple(Series("/lce/a", str(i)) for i in range(MOST_SERIES + 1)))
    with pytest.raises(LceError, match=f"{MOST_PLOTS} plots are the most"):
        Layout((Plot((POWER,)),) * MOST_PLOTS).with_plot((POWER,))


@pytest.mark.parametrize(
    ("series", "name", "unit", "of_two"),
    [
        (POWER, "laser/power", "W", 2.0),
        (Series("/lce/displacement_stamped", "value"), "displacement_stamped", "mm", 2000.0),
        (Series("/lce/temperature", "temperature"), "temperature", "°C", 2.0),
        (Series("/lce/temperature", "variance"), "temperature variance", "1", 2.0),
        (Series("/lce/room", "temperature"), "room", "°C", 2.0),
        (AGE, "/diagnostics /lce/laser: output.age_s", "s", 2.0),
        (Series("/lce/odd", "body.temperature_k"), "odd body.temperature_k", "K", 2.0),
    ],
)
def test_names_and_units_are_those_that_are_known(series: Series, name: str, unit: str, of_two: float) -> None:
    assert (series.name, series.unit.symbol) == (name, unit)
    assert series.unit.from_si(2.0) == pytest.approx(of_two)


def test_the_layout_is_kept_and_the_conditions_without_the_notes(tmp_path: Path) -> None:
    view = LiveView(tmp_path)
    view.change(view.layout.with_plot((AGE,)).widened(0).resized(0, 1).showing(30.0))
    view.remember({"specimen": "007", "day": "2026-11-22", "notes": "*x <b>", "strip_length_m": 0.01})
    again = LiveView(tmp_path)
    assert names(again.layout) == names(view.layout) and again.layout.window_s == 30.0
    assert [(p.height, p.wide) for p in again.layout.plots] == [(p.height, p.wide) for p in view.layout.plots]
    assert again.conditions == {"specimen": "007", "strip_length_m": 0.01} and again.error == ""


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("plots: 1", "plots is 1; it must be a list"),
        ("format: lce-bench-1\nwindow_s: long\nplots: []", "window_s is 'long'; it must be a number"),
        ("\0", "not a YAML file"),
        ("format: lce-bench-1\nwindow_s: 60\nplots: [{series: [[a]]}]", "series"),
        ("format: lce-bench-1\nwindow_s: 60\nplots: []\nconditions: {a b: 1}", "'a b'"),
    ],
)
def test_a_damaged_file_is_one_line_and_costs_the_layout_only(tmp_path: Path, content: str, said: str) -> None:
    file = tmp_path / "workbench" / "bench.yaml"
    file.parent.mkdir()
    file.write_text(content)
    view = LiveView(tmp_path)
    assert said in view.error and "\n" not in view.error and view.layout == Layout()
    assert file.read_text() == content
    view.change(Layout(()))
    assert yaml.safe_load(file.read_text())["plots"] == [] and view.error == ""


def test_a_size_that_there_is_not_becomes_the_next_one(tmp_path: Path) -> None:
    file = tmp_path / "workbench" / "bench.yaml"
    file.parent.mkdir()
    file.write_text("format: lce-bench-1\nwindow_s: 1e9\nplots: [{series: [[/lce/a, data]], height: -5}, {series: []}]")
    layout = LiveView(tmp_path).layout
    assert (layout.window_s, [plot.height for plot in layout.plots]) == (300.0, [HEIGHTS_PX[0]])


def test_nothing_is_watched_while_no_page_is_open(tmp_path: Path) -> None:
    view = LiveView(tmp_path)
    assert view.watched == frozenset()
    view.viewers.add("page")
    assert view.watched == view.layout.series and POWER in view.watched


def test_a_history_gives_what_is_new_and_forgets() -> None:
    history = History()
    history.add(np.arange(3.0), np.arange(3, dtype=np.float32))
    history.add(np.empty(0), np.empty(0, np.float32))
    history.add(np.arange(3.0, 5.0), np.arange(3, 5, dtype=np.float32))
    for count, left in ((0, [0, 1, 2, 3, 4]), (2, [2, 3, 4]), (4, [4]), (5, [])):
        times, values = history.since(count)
        assert times.tolist() == values.tolist() == left
    history.add(np.array([KEPT_S + 3.5]), np.zeros(1, np.float32))
    assert history.since(0)[0].tolist() == [3.0, 4.0, KEPT_S + 3.5] and history.count == 6
