"""The report page: what it says, that it needs nothing else, and how a browser shows it.

The browser is Debian's or any other Chromium, driven by playwright; without either, its tests are skipped.
"""

from __future__ import annotations

import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bristle_sim.cli import command
from bristle_sim.comparison import Quantity, Report
from bristle_sim.parameters import Tool, Workpart
from bristle_sim.render.report import answer, motion_data, write_report
from bristle_sim.scene.tool import simulate
from bristle_sim.units import Choice, Range


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The whole pass with a friction of its own."""
    path = tmp_path_factory.mktemp("report") / "pass & more.html"
    assert command.main(["cue_and_impact", "--set", "friction=0.3", "--report", str(path)]) == 0
    return path


class Elements(HTMLParser):
    """Tags that are open, and every attribute seen."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.attributes: list[tuple[str, str | None]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.attributes += attrs
        if tag not in ("meta", "link", "input", "img", "br"):
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        assert tag
        self.attributes += attrs

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_the_page_is_well_formed_and_refers_to_nothing_else(page: Path):
    elements = Elements()
    elements.feed(page.read_text(encoding="utf-8"))
    assert elements.open == []
    referring = [value for name, value in elements.attributes if name in ("src", "href", "xlink:href")]
    assert referring
    assert all(value is not None and value.startswith(("data:", "#")) for value in referring)


def test_the_page_says_question_answer_result_parameters_and_command(page: Path):
    text = page.read_text(encoding="utf-8")
    assert "<h1>From bar to rebound: does the cued tool do what the formulas say?</h1>" in text
    assert "The bristle strikes at 4.53 ms, 2.74° short of radial" in text
    assert "<td>retraction at release</td>" in text
    assert re.search(r'class="changed"><td>friction</td><td>0.3</td>.*?set for this run', text, re.DOTALL)
    assert "Zhang 2020, eq. 2.2: root circle" in text
    assert "bristle-sim cue_and_impact --set friction=0.3 --report &#39;" in text
    assert re.search(r"bristle_sim [\d.]+, Python 3", text)
    assert text.count("<svg") == 1


def test_the_answer_counts_what_agrees_and_names_what_does_not():
    rows = (Quantity("a", "1", 1.0, 1.0, tolerance=1e-3), Quantity("b", "1", 2.0, 1.0, tolerance=0.1))
    finding = Quantity("c", "1", 1.1, 1.0)
    assert answer(Report(None, rows)) == "1 of 2 comparisons exceed their tolerance: b."
    assert answer(Report("no rebound", (*rows[:1], finding))) == (
        "Outcome: no rebound. All 1 comparisons that have a tolerance are within it. Of the findings, c differs most: +10 %"
        " from theory."
    )
    assert answer(Report(None, ())) == "See the table."


def test_a_page_shows_every_picture_of_a_folder_and_a_film(tmp_path: Path):
    def plot(_: Report, folder: Path) -> None:
        for name in ("figure_2.png", "figure_1.png"):
            (folder / name).write_bytes(name.encode())

    for name, element in (
        ("film.mp4", '<video controls src="data:video/mp4;base64,'),
        ("film.gif", 'src="data:image/gif;'),
    ):
        film = tmp_path / name
        film.write_bytes(b"film")
        options: dict[str, Any] = {"name": "s", "question": "<b>?", "command": "run 'a b'", "plot": plot}
        declared = (Range("k", "m", 0.0, 1.0, True, "source", True), Choice("w", ("a",), "source"))
        parameters = [(declared[0], None, None), (declared[1], "a", "b")]
        write_report(
            tmp_path / "page.html", Report(None, ()), parameters=parameters, plot_is_folder=True, video=film, **options
        )
        text = (tmp_path / "page.html").read_text(encoding="utf-8")
        assert element in text
        assert text.index('alt="figure 1"') < text.index('alt="figure 2"')
        assert "<h1>&lt;b&gt;?</h1>" in text
        assert "<td>k</td><td>none</td>" in text
        assert "<canvas" not in text


def test_a_figure_that_cannot_be_drawn_spoils_no_page(tmp_path: Path):
    def plot(*_: object) -> None:
        raise ValueError("maps need the extra sweep")

    told: dict[str, Any] = {"name": "s", "question": "?", "command": "run", "parameters": []}
    write_report(tmp_path / "page.html", Report(None, ()), plot=plot, **told)
    assert "no figure: maps need the extra sweep" in (tmp_path / "page.html").read_text(encoding="utf-8")


def test_the_motion_leaves_out_what_the_tool_has_not():
    tool = Tool(bar=None, workpart=None)
    data = motion_data(simulate(tool, start_relative_angle=-0.5, stop_after="highest relative speed"), tool)
    assert (data["bar"], data["surface"], data["contacts"]) == (None, None, [])
    tool = Tool(workpart=Workpart(penetration=-0.5))
    assert motion_data(simulate(tool), tool)["contacts"][0][0] == "bar"


def opened(browser: Any, page: Path, width: int = 1200, scheme: str = "light") -> tuple[Any, list[str], list[str]]:
    """A tab that shows the page, and what it says to the console and requests from anywhere."""
    tab, said, requested = browser.new_page(viewport={"width": width, "height": 800}, color_scheme=scheme), [], []
    tab.on("console", lambda message: said.append(message.text))
    tab.on("pageerror", lambda error: said.append(str(error)))
    tab.on("request", lambda request: requested.append(request.url))
    tab.goto(page.as_uri())
    return tab, said, requested


def move_to(tab: Any, microseconds: float) -> None:
    tab.locator("#instant").evaluate(
        "(slider, value) => { slider.value = value; slider.dispatchEvent(new Event('input')); }", microseconds
    )


def picture(tab: Any) -> str:
    return str(tab.locator("#tool").evaluate("canvas => canvas.toDataURL()"))


@pytest.mark.parametrize(("width", "scheme"), [(1200, "light"), (390, "dark")])
def test_a_browser_shows_it_at_desk_and_phone_width(browser: Any, page: Path, width: int, scheme: str):
    tab, said, requested = opened(browser, page, width, scheme)
    assert said == []
    assert requested == [page.as_uri()]
    assert tab.evaluate("document.documentElement.scrollWidth") <= width
    assert tab.evaluate("getComputedStyle(document.body).backgroundColor") == (
        "rgb(255, 255, 255)" if scheme == "light" else "rgb(21, 23, 26)"
    )
    assert tab.locator("canvas").bounding_box()["width"] > 0.8 * min(width, 992)


def test_the_slider_moves_the_wire(browser: Any, page: Path):
    """Where the page says the tip is, it is by an interpolation that knows nothing of the page, to its two decimals.

    Far from events both cubics have the same ends; beside one the page keeps the side of the instant it shows.
    """
    tab, said, _ = opened(browser, page)
    run = simulate(Tool(workpart=Workpart(friction=0.3)))
    seen = set()
    for microseconds in (0, 1000, 2500, 4000, 4529, 4540, 6000, 8000):
        move_to(tab, microseconds)
        seen.add(picture(tab))
        shown = [float(each) for each in tab.locator("#tip").inner_text().removesuffix(" mm").split(",")]
        np.testing.assert_allclose(shown, 1e3 * run.at(1e-6 * microseconds).tip, rtol=0.0, atol=0.00501)
    assert len(seen) == 8
    assert said == []


def test_the_view_says_phase_and_force_and_plays(browser: Any, page: Path):
    tab, said, _ = opened(browser, page)
    assert tab.locator("#phase").inner_text() == "turns with the hub"
    tab.get_by_role("button", name="strike").click()
    # 2.746 mN s normal at a friction of 0.3, whose net tangential impulse is small after the reversal of slip
    assert re.fullmatch(r"impulse 2\.7\d\d mN s by the workpart", tab.locator("#force").inner_text())
    move_to(tab, 2000)
    assert tab.locator("#phase").inner_text() == "held back by the bar"
    assert tab.locator("#force").inner_text().endswith(" N by the bar")
    tab.get_by_role("button", name="play").click()
    while float(tab.locator("#instant").input_value()) < 2100.0:
        tab.wait_for_timeout(20)
    tab.get_by_role("button", name="pause").click()
    assert tab.get_by_role("button", name="play").is_visible()
    assert said == []
