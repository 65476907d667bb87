# SPDX-License-Identifier: Apache-2.0
"""The page as text: what is in it, what is thinned, and that it asks for nothing."""

import base64
import json
import re
import zlib
from collections.abc import Callable
from dataclasses import replace
from html.parser import HTMLParser
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from lce_analysis.comparison.compare import compare
from lce_data.channels import DISPLACEMENT, SENSORS, TEMPERATURE, Unit
from lce_data.experiment_file import Conditions, Experiment
from lce_data.marker import Marker
from lce_data.run import Run
from lce_model import Model, default_model
from lce_report import (
    Axis,
    Bars,
    Curve,
    Details,
    Fragment,
    Grid,
    Group,
    Heat,
    Intervals,
    Lines,
    Loop,
    Samples,
    Section,
    Table,
    Trace,
    render,
)
from lce_report.figures.axes import title
from lce_report.figures.before_after import overlays
from lce_report.figures.errors import error_reductions
from lce_report.html.arrays import BUCKETS, GAP, LEVELS, Arrays, distinct, visible
from lce_report.pages.comparison import render_comparison
from lce_report.pages.diagnosis import _rest
from lce_report.tables import _few, models_tried

Floats = NDArray[np.float64]
Record = Callable[..., Run]

TIME, HEIGHT = Axis("time", "s"), Axis("d", "mm")


class _Page(HTMLParser):
    """Text by element, and everything that an element would fetch."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.fetched: list[str] = []
        self.text: dict[str, str] = {}
        self._open: list[str] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = dict(attrs)
        self._open.append(values.get("id") or tag)
        for name in ("src", "href", "action", "poster", "srcset"):
            if value := values.get(name):
                self.fetched.append(value)

    def handle_endtag(self, tag: str) -> None:
        if self._open:
            self._open.pop()

    def handle_data(self, data: str) -> None:
        name = self._open[-1] if self._open else ""
        self.text[name] = self.text.get(name, "") + data


def _numbers(page: _Page, spec: list[Any]) -> Floats:
    """An array of the page as its script reads it."""
    codes = np.frombuffer(zlib.decompress(base64.b64decode(page.text["numbers"])), dtype="<u2")
    begin, length, low, step = spec
    found = np.cumsum(codes[begin : begin + length], dtype=np.uint16).astype(float)
    return np.where(found == GAP, np.nan, low + step * found)


def _one(figure: Lines | Loop) -> tuple[_Page, dict[str, Any]]:
    page = _Page(render("t", ("a",), (Section("s", (figure,)),)))
    return page, json.loads(page.text["figures"])[0]


def test_numbers_arrive_to_a_65534th_of_their_range() -> None:
    x, y = np.linspace(0.0, 150.0, 5000), np.random.default_rng(0).standard_normal(5000)
    y[[0, 17, 4999]] = np.nan
    page, figure = _one(Lines("f", TIME, HEIGHT, x, (Curve("c", y, "model"),)))
    assert _numbers(page, figure["x"]) == pytest.approx(x, abs=150.0 / LEVELS)
    seen = _numbers(page, figure["curves"][0]["y"])
    assert seen == pytest.approx(y, abs=float(np.nanmax(y) - np.nanmin(y)) / LEVELS, nan_ok=True)


@pytest.mark.parametrize("values", [np.zeros(9), np.full(9, np.nan), np.full(9, 1e-300), np.array([1e9])])
def test_arrays_without_a_range_arrive_too(values: Floats) -> None:
    page, figure = _one(Loop("f", TIME, HEIGHT, (Trace("t", np.arange(values.size) * 1.0, values, "model"),)))
    assert _numbers(page, figure["traces"][0]["y"]) == pytest.approx(values, nan_ok=True)


def test_the_same_array_is_stored_once() -> None:
    arrays = Arrays()
    x = np.random.default_rng(0).standard_normal(10_000)
    assert arrays.add(x) == arrays.add(x.copy())
    assert len(base64.b64decode(arrays.packed())) < 2.1 * x.size


def test_thinning_keeps_every_extreme_that_a_screen_could_show() -> None:
    n = 60_000
    y = np.sin(np.arange(n) / 3000.0)
    y[31_234], y[31_250] = 9.0, -9.0  # a spike of one sample each way
    keep = visible([y])
    assert keep.size <= 2 * BUCKETS + 2 and {0, n - 1, 31_234, 31_250} <= set(keep.tolist())
    edges = np.linspace(0, n, 1921).astype(int)  # the columns of a screen
    for begin, end in pairwise(edges.tolist()):
        here = y[keep[(keep >= begin) & (keep < end)]]
        assert here.max() - y[begin:end].max() == pytest.approx(0.0, abs=1e-2)
        assert here.min() - y[begin:end].min() == pytest.approx(0.0, abs=1e-2)


def test_a_run_of_150_s_at_100_hz_is_not_thinned() -> None:
    assert visible([np.zeros(15_000), np.ones(15_000)]).size == 15_000


def test_a_cloud_keeps_one_point_of_each_cell_and_a_line_its_way() -> None:
    rng = np.random.default_rng(0)
    x, y = rng.integers(0, 20, 50_000) * 1.0, rng.integers(0, 20, 50_000) * 1.0
    cloud = distinct(x, y, joined=False)
    assert cloud.size == 400 and np.all(np.diff(cloud) > 0)
    there_and_back = np.concatenate([np.linspace(0, 1, 50_000), np.linspace(1, 0, 50_000)])
    line = distinct(there_and_back, there_and_back, joined=True)
    assert line.size < 6000
    assert np.max(np.abs(np.diff(there_and_back[line]))) < 2e-3


def test_every_kind_of_block_is_on_the_page() -> None:
    x = np.arange(5.0)
    blocks = (
        "A paragraph.",
        Table("table", ("name", "value"), (("first", "1.5 K"), ("second", "–"))),
        Heat("heat", "°C", ("40", "50"), ("up", "down"), np.array([[0.25, np.nan], [-0.5, 0.0]]), diverging=True),
        Bars("bars", "χ²", ("creep", "drift"), (Group("g", "model", np.array([3.0, np.nan])),), mark=2.0),
        Intervals("dots", "s", ("a", "b"), np.array([1.0, np.nan]), np.array([0.2, np.nan]), ("1.0 ± 0.2", "–"), 0.0),
        Details("More", ("Behind a click.", Table("", ("p",), (("0.3",),)))),
        Grid(
            (
                Lines("l", TIME, HEIGHT, x, (Curve("c", x, "before", low=x - 1, high=x + 1),)),
                (Loop("a", TIME, HEIGHT, (Trace("t", x, x, "after", at=x),)), Loop("b", TIME, HEIGHT, ())),
            )
        ),
    )
    text = render("Title", ("The answer.", "More."), (Section("One", blocks), Section("Two", ())), ("at the foot",))
    page = _Page(text)
    figures = json.loads(page.text["figures"])
    assert [f["title"] for f in figures] == ["l", "a", "b"]
    assert set(figures[0]["curves"][0]) == {"label", "role", "form", "y", "low", "high"}
    assert text.count("data-figure=") == 3
    assert "−50%" in text and "25%" in text and "<td></td>" in text  # an empty cell is empty, not nan
    assert "nan" not in re.sub(r"<script.*?</script>", "", text, flags=re.DOTALL)
    assert 'class="n minus" style="--tint:50%"' in text
    assert 'style="left:66.67%"' in text  # the mark at 2 of 3
    assert text.count('<s style="left:') == 1 and "1.0 ± 0.2" in text  # a dot for what there is
    assert re.search("<details><summary>More</summary><p>Behind a click.</p>", text)
    for word in ("A paragraph.", "The answer.", "at the foot", "χ²", ">One<", ">Two<"):
        assert word in text


def test_a_whole_bar_may_stand_for_more_than_the_largest_value() -> None:
    group = Group("g", "model", np.array([0.25, 2.0]))
    text = render("t", (), (Section("s", (Bars("b", "1", ("quarter", "more"), (group,), ".0%", full=1.0),)),))
    assert re.findall(r"width:([\d.]+)%", text.partition("<main>")[2]) == ["25.00", "100.00"]


def test_an_interval_is_drawn_where_its_value_and_its_error_are() -> None:
    found = Intervals("i", "1", ("a", "b"), np.array([1.0, 2.0]), np.array([0.5, np.inf]), ("", ""), 0.0, common=1.0)
    text = render("t", (), (Section("s", (found,)),))
    whole = 2.0 * 1.12  # from 0 to 2, and a margin at either end
    places = [f"{100.0 * (x + 0.12) / whole:.2f}%" for x in (0.0, 1.0, 1.0, 2.0)]
    seen = re.findall(r'<(?:i class="null"|i class="mark"|s) style="left:([\d.]+%)"', text)
    assert seen == [places[0], places[1], places[2], places[0], places[1], places[3]]
    assert re.findall(r'<u style="left:([\d.]+)%;width:([\d.]+)%"', text) == [
        (f"{100.0 * 0.62 / whole:.2f}", f"{100.0 / whole:.2f}"),
        ("0.00", "100.00"),
    ]


def test_hostile_names_stay_text() -> None:
    evil = '</script><script>alert("&1")</script>'
    x = np.arange(3.0)
    figures = (Lines(evil, Axis(evil, evil), HEIGHT, x, (Curve(evil, x, "model"),), linked=evil),)
    blocks = (
        evil,
        Table(evil, (evil,), ((evil,),)),
        Heat(evil, evil, (evil,), (evil,), np.ones((1, 1)), notes=((evil,),)),
    )
    text = render(evil, (evil,), (Section(evil, (*blocks, *figures)),), (evil,))
    assert "<script>alert" not in text
    assert json.loads(_Page(text).text["figures"])[0]["title"] == evil


def test_the_page_asks_for_nothing(strip: Model, recorded: Record) -> None:
    text = render_comparison(compare(strip, [recorded(duration_s=30.0)]))
    assert all(place.startswith(("#", "data:")) for place in _Page(text).fetched)
    assert not re.search(r"@import|url\(", text)
    assert "default-src 'none'" in text


def test_the_page_of_a_comparison(strip: Model, recorded: Record) -> None:
    runs = [recorded(extra=lambda t, k, d: 50e-6 * (t > 40.0)), recorded("stairs", seed=2, temperature=False)]
    comparison = compare(strip, runs)
    text = render_comparison(comparison)
    assert text == render_comparison(comparison)  # the same data, the same file
    assert (
        text.index(comparison.sentences[0]) < text.index("Misfit") < text.index("Run pulse") < text.index("Run stairs")
    )
    for wanted in ("NRMSE", "SMAPE", "RMS error", "as printed", "Data (SHA-256)", "Written by lce", "heating, hold"):
        assert wanted in text
    figures = json.loads(_Page(text).text["figures"])
    assert all(f["xAxis"]["unit"] and f["yAxis"]["unit"] for f in figures)
    linked = {f["linked"] for f in figures}
    assert linked == {"pulse", "stairs", ""}
    titles = [f["title"] for f in figures if f["linked"] == "pulse"]
    assert {"residual d over T", "residual d over dT/dt", "residual d over P", "hysteresis loop: d over T"} <= set(
        titles
    )
    assert sum(f["title"].startswith("autocorrelation") for f in figures) == 3


def test_a_run_of_150_s_takes_less_than_half_a_megabyte(strip: Model, recorded: Record) -> None:
    power: Callable[[Floats], Floats] = lambda t: np.where(t % 30.0 < 12.0, 1.3, 0.0)  # noqa: E731
    text = render_comparison(
        compare(strip, [recorded(duration_s=150.0, power=power, extra=lambda t, k, d: 1e-4 * np.sin(t))])
    )
    assert len(text.encode()) < 0.5e6 + 0.15e6  # ten of them and the script: below 5 MB


def test_error_reductions_by_channel_condition_and_run(strip: Model, recorded: Record) -> None:
    runs = [recorded("one"), recorded("two", seed=1, extra=lambda t, k, d: 40e-6 * (np.gradient(k) < 0.0))]
    slow = strip.set({"lumped.tau": 1.1 * strip["lumped.tau"]})
    before, after = compare(slow, runs), compare(strip, runs)
    grids = error_reductions({"as given": before, "refitted": after}, held_out=("two",))
    assert len(grids) == len(SENSORS)
    of = dict(zip(before.shares, (grid.figures for grid in grids), strict=True))
    for channel, noise in ((TEMPERATURE, 0.06), (DISPLACEMENT, 4.0)):
        by_condition, by_run = of[channel]
        assert isinstance(by_condition, Bars) and isinstance(by_run, Bars)
        assert by_condition.title == f"rms residual of {title(channel)} by operating condition"
        assert by_run.mark == pytest.approx(noise, rel=0.1)
        assert list(by_run.labels) == ["one", "two (held out)"]
        was, now = by_run.groups
        assert np.all(now.values < was.values)
        assert now.values[0] == pytest.approx(noise, rel=0.1)
    of_displacement = of[DISPLACEMENT][0]
    assert isinstance(of_displacement, Bars)
    cooling = list(of_displacement.labels).index("cooling")
    assert of_displacement.groups[1].values[cooling] == pytest.approx(28.0, rel=0.1)  # 40 µm in one run of two


def test_a_third_sensor_gets_its_rows_and_figures(strip: Model, recorded: Record) -> None:
    newton = Unit("N")
    force = replace(DISPLACEMENT, name="force", symbol="F", unit="N", recorded=newton, display=newton,
                    difference=Unit("mN", 1e3))  # fmt: skip
    found = compare(strip, [recorded(duration_s=30.0)])
    (run,) = found.runs
    like = replace(run.channels[DISPLACEMENT], channel=force)
    run = replace(run, channels={**run.channels, force: like})
    found = replace(found, runs=(run,), shares={**found.shares, force: found.shares[DISPLACEMENT]})
    text = render_comparison(found)
    titles = [figure["title"] for figure in json.loads(_Page(text).text["figures"])]
    assert {"force\u00a0F", "hysteresis loop: F over T", "residual F over dT/dt"} <= set(titles)
    assert "Squared error of F by run and cycle" in text and "mean residual F [mN]" in text
    assert len(error_reductions({"as given": found})) == len(overlays({"as given": found})[0].blocks) // 2 == 3


def test_the_models_tried_have_a_column_for_each_side_and_sensor(strip: Model) -> None:
    errors = {"temperature_nrmse": 0.0123, "displacement_nrmse": None}
    entry = {"thermal": "lumped", "deformation": "equilibrium", "effects": ["creep"], "verdict": "confirmed"}
    table = models_tried(strip.with_values(strip.values, {"history": [{**entry, "train": errors, "test": {}}]}))
    assert table.head == ("model", "train T", "train d", "test T", "test d", "verdict")
    assert table.rows == [("lumped + equilibrium + creep", "1.23%", "", "", "", "confirmed")]


def test_a_page_that_answers_has_every_sample_and_cells_to_pick() -> None:
    heat = Heat("shares", "", ["cold", "hot"], ["ramp"], np.array([[0.25, np.nan]]), pick="displacement condition")
    x = np.linspace(0.0, 1.0, 6 * BUCKETS)
    numbers = Samples()
    page = Fragment(numbers)
    assert 'data-pick="displacement condition" data-row="0" data-column="0"' in page.block(heat)
    page.block(Lines("", TIME, HEIGHT, x, [Curve("d", np.where(x > 0.5, np.nan, x), "model")]))
    begin, length = page.figures[0]["curves"][0]["y"]
    sent = np.frombuffer(numbers.packed(), "<f4")[begin : begin + length]
    assert np.array_equal(np.isnan(sent), x > 0.5) and sent[100] == np.float32(x[100])
    assert "data-pick" not in Fragment(Arrays()).block(heat)


def test_a_report_tells_specimen_notes_and_markers_as_text(recorded: Record) -> None:
    stated = Conditions(specimen="A7 <b>", day="2026-11-22", other={"notes": "a & b"})
    run = replace(
        recorded("marked"), experiment=Experiment(conditions=stated), markers=(Marker(3.0, "</script><i>lamp"),)
    )
    page = render_comparison(compare(default_model("lumped", "equilibrium"), [run]))
    for words in ("Specimen: A7 &lt;b&gt;", "Day: 2026-11-22", "Notes: a &amp; b"):
        assert words in page
    assert "Marked: &lt;/script&gt;&lt;i&gt;lamp at 3.0 s" in page and "</script><i>" not in page


def test_the_name_of_one_run_stands_for_itself_however_long() -> None:
    assert _few(["a-run-with-quite-a-long-name"]) == "a-run-with-quite-a-long-name"
    assert _few(["a-run-with-quite-a-long-name", "b"]) == "2 runs"


def test_one_run_cannot_show_what_repeats_itself() -> None:
    assert "Only one run was given" in str(_rest((), 1, 0.15)[0])
    assert "Nothing that repeats itself" in str(_rest((), 2, 0.15)[0])
