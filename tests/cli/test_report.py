"""The report page: what it says, that it needs nothing else, and how a browser shows and prints it.

The browser is Debian's or any other Chromium, driven by playwright; without either, its tests are skipped.
"""

from __future__ import annotations

import re
from html import unescape
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bristle_sim import Bristle, Contact, Settings, Tool, Trajectory, Workpart, simulate
from bristle_sim.cli import command
from bristle_sim.comparison import Quantity, Report
from bristle_sim.declared import Choice, Range
from bristle_sim.render.motion_data import motion_data
from bristle_sim.render.report import verdict, write_report

STATED: dict[str, Any] = {"name": "s", "question": "?", "command": "run", "keys": {}, "values": {}}


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
        if tag not in ("meta", "link", "input", "img", "br", "wbr"):
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        assert tag
        self.attributes += attrs

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_the_page_says_question_result_parameters_and_command_and_refers_to_nothing_else(
    page: Path,
):
    text = page.read_text(encoding="utf-8")
    elements = Elements()
    assert "<h1>From bar to rebound: does the cued tool do what the formulas say?</h1>" in text
    assert (
        text[text.index("</h1>") + 5 :]
        .lstrip()
        .startswith('<p class="answer">The bristle strikes at')
    )
    assert "<td>retraction at release</td>" in text
    assert re.search(
        r'class="changed"><td>friction</td><td>0.3</td>.*?set for this run', text, re.DOTALL
    )
    assert "Zhang 2020, eq. 2.2: root circle" in text
    assert "bristle-sim cue_and_impact --set friction=0.3 --report &#39;" in text
    assert re.search(r"bristle_sim [\d.]+(, commit [\w-]+)?, Python 3", text)
    assert text.count('<svg role="img" aria-label=') == 1
    elements.feed(text)
    assert elements.open == []
    referring = [
        value for name, value in elements.attributes if name in ("src", "href", "xlink:href")
    ]
    assert referring
    assert all(value is not None and value.startswith(("data:", "#")) for value in referring)
    named = [value for name, value in elements.attributes if name == "id"]
    assert len(named) == len(set(named))


def test_the_verdict_counts_what_agrees_and_names_what_does_not():
    rows = (
        Quantity("a_b", "1", 1.0, 1.0, tolerance=1e-3),
        Quantity("c_d", "1", 2.0, 1.0, tolerance=0.1),
    )
    assert verdict(Report(None, rows)) == "Within their tolerance: 1 of 2 comparisons; not: c d."
    assert verdict(Report(None, rows[:1])) == "Within their tolerance: 1 of 1 comparisons."


@pytest.mark.parametrize(
    ("film", "element"),
    [("f.mp4", '<video controls src="data:video/mp4;base64,'), ("f.gif", 'src="data:image/gif;')],
)
def test_a_page_shows_every_picture_of_a_folder_and_a_film(film: str, element: str, tmp_path: Path):
    def plot(_: Report, folder: Path) -> None:
        for name in ("figure_2.png", "figure_1.png"):
            (folder / name).write_bytes(name.encode())

    (tmp_path / film).write_bytes(b"film")
    declared = (
        Range("a_key", "m", 0.0, 1.0, optional=True),
        Choice("w", options=("a", "b"), default="b"),
    )
    stated = {
        **STATED,
        "question": "<b>?",
        "keys": {each.key: each for each in declared},
        "values": {"a_key": None, "w": "a"},
    }
    options: dict[str, Any] = {"plot": plot, "plot_is_folder": True, "video": tmp_path / film}
    write_report(tmp_path / "p.html", Report(None, ()), **options, **stated)
    text = (tmp_path / "p.html").read_text(encoding="utf-8")
    assert element in text
    assert text.index('alt="figure 1"') < text.index('alt="figure 2"')
    assert "<h1>&lt;b&gt;?</h1>" in text
    assert "<td>a_<wbr>key</td><td>none</td>" in text
    assert "<canvas" not in text


def test_a_figure_that_cannot_be_drawn_spoils_no_page(tmp_path: Path):
    def plot(*_: object) -> None:
        raise ValueError("maps need the extra sweep")

    write_report(tmp_path / "page.html", Report(None, ()), plot=plot, **STATED)
    assert "no figure: maps need the extra sweep" in (tmp_path / "page.html").read_text(
        encoding="utf-8"
    )


@pytest.mark.parametrize("most", [100_000, 4_000])
def test_the_nodes_give_the_motion_to_the_errors_stated(most: int, monkeypatch: pytest.MonkeyPatch):
    """At 2000 instants, against the run's own interpolation; a page with fewer numbers states larger errors."""
    monkeypatch.setattr("bristle_sim.render.motion_data.MOST_NUMBERS", most)
    run = simulate(
        Tool(contact=Contact("compliant", 1e-4), bristle=Bristle(links=2)),
        Settings(accuracy=1e-4),
        stop_after="strike",
    )
    data = motion_data(run, run.tool)
    drawn, millimetres = re.fullmatch(
        r"(\d+) instants .* to (\S+) mm, \S+° and \S+ m/s", data["drawn"]
    ).groups()
    time, line, velocity = (np.array(data[name]) for name in ("time", "line", "velocity"))
    assert int(drawn) <= time.size <= most / line.shape[1]
    instants = np.random.default_rng(1).uniform(time[0], time[-1], 2000)
    node = np.searchsorted(time, instants, side="right") - 1
    length = (time[node + 1] - time[node])[:, np.newaxis]
    s = (instants - time[node])[:, np.newaxis] / length
    p = line[node]
    q = line[node + 1]
    v = velocity[node]
    w = velocity[node + 1]
    place = q + (1 - s) ** 2 * (1 + 2 * s) * (p - q) + s * (1 - s) * length * ((1 - s) * v - s * w)
    error = np.abs(place - 1e3 * run.at(1e-3 * instants).centre_line.reshape(2000, -1)).max()
    # A cubic's error in the middle of an interval is (0.5 * 0.5 / 0.4 / 0.6)^2 = 1.085 times that where it is tried.
    assert error <= 1.1 * float(millimetres)


def test_the_motion_leaves_out_what_the_tool_has_not():
    tool = Tool(bar=None, workpart=None)
    data = motion_data(
        simulate(tool, start_relative_angle=-0.5, stop_after="highest relative speed"), tool
    )
    assert (data["bar"], data["surface"], data["contacts"]) == (None, None, [])


def opened(
    browser: Any, page: Path, width: int = 1200, scheme: str = "light"
) -> tuple[Any, list[str]]:
    """A tab that shows the page, and all that it says to the console or requests from elsewhere."""
    tab = browser.new_page(viewport={"width": width, "height": 800}, color_scheme=scheme)
    said = []
    tab.on("console", lambda message: said.append(message.text))
    tab.on("pageerror", lambda error: said.append(str(error)))
    tab.on(
        "request",
        lambda request: said.append(request.url) if request.url != page.as_uri() else None,
    )
    tab.goto(page.as_uri())
    return tab, said


@pytest.mark.parametrize(
    ("width", "scheme"),
    [(1280, "light"), pytest.param(800, "light", marks=pytest.mark.nightly), (390, "dark")],
)
def test_a_browser_shows_it_at_any_width_and_prints_it_on_white(
    browser: Any, page: Path, width: int, scheme: str
):
    tab, said = opened(browser, page, width, scheme)
    ground = "getComputedStyle(document.body).backgroundColor"
    assert tab.evaluate("document.documentElement.scrollWidth") <= width
    assert tab.evaluate(ground) == (
        "rgb(255, 255, 255)" if scheme == "light" else "rgb(21, 23, 26)"
    )
    if width >= 800:  # no table is cut
        uncut = "[...document.querySelectorAll('.wide')].every((each) => each.scrollWidth <= each.clientWidth)"
        assert tab.evaluate(uncut)
    tab.emulate_media(media="print")
    assert tab.evaluate(ground) == "rgb(255, 255, 255)"
    assert not tab.locator("button:visible, input:visible").count()
    assert tab.locator("canvas:visible").count() == 1
    assert said == []


def test_no_printed_page_ends_with_a_heading_or_cuts_the_table_of_results(
    browser: Any, page: Path, tmp_path: Path
):
    pymupdf = pytest.importorskip("pymupdf")
    tab, *_ = opened(browser, page)
    tab.pdf(path=tmp_path / "page.pdf", format="A4")
    headings = tab.locator("h2").all_inner_texts()
    results = [row.split("\t")[0] for row in tab.locator(".numbers tbody tr").all_inner_texts()]
    pages = [sheet.get_text().strip() for sheet in pymupdf.open(tmp_path / "page.pdf")]
    assert len(pages) > 3
    for sheet in pages:
        assert sheet.splitlines()[-1] not in headings
    assert [sum(name in sheet for name in results) for sheet in pages if results[0] in sheet] == [
        len(results)
    ]


TOOLS = {
    "rigid": Tool(),
    "contact in time": Tool(contact=Contact("compliant", 1e-4)),
    "short contact": Tool(contact=Contact("compliant", 2e-6)),
    "bent wire of links": Tool(
        bristle=Bristle(knee_angle_deg=30.0, links=2), contact=Contact("compliant", 1e-4)
    ),
    "no strike": Tool(workpart=Workpart(penetration=-0.01)),
}


def shown(tab: Any, times: list[float]) -> list[tuple[list[float], str]]:
    """Retraction, tip, speed and force that the page shows at instants, and its phase."""
    read = "time => { viewer.showAt(time); return [...document.querySelectorAll('.readings dd')].map((each) => each.innerText); }"
    found = []
    for _, phase, retraction, tip, speed, force in tab.evaluate(
        f"times => times.map({read})", [1e3 * time for time in times]
    ):
        newtons = force.split(" N ")[0] if " N by" in force else "0"
        numbers = (
            retraction.rstrip("°"),
            *tip.removesuffix(" mm").split(","),
            speed.split()[0],
            newtons,
        )
        found.append(([*map(float, numbers)], phase))
    return found


def view(run: Trajectory, folder: Path) -> Path:
    """The page that a notebook shows of a run."""
    page = folder / "page.html"
    page.write_text(unescape(run.show().text.split('srcdoc="')[1].split('"')[0]), encoding="utf-8")
    return page


@pytest.mark.parametrize("name", TOOLS)
def test_the_numbers_under_the_slider_are_those_of_the_run(browser: Any, tmp_path: Path, name: str):
    """At ten instants, and ten in each contact that lasts: half of the last digit shown, and a tenth for interpolation."""
    run = simulate(TOOLS[name], stop_after="strike" if name == "bent wire of links" else None)
    tab, said = opened(browser, view(run, tmp_path))
    data = motion_data(run, run.tool)
    fractions = (np.arange(10) + 0.5) / 10.0
    end = 1e-3 * data["time"][-1]
    contacts = data["contacts"]
    lasting = [each for each in run.contacts if each.duration and each.time + each.duration < end]
    times = [
        *(end * fractions),
        *(time for each in lasting for time in each.time + each.duration * fractions),
    ]
    motion = run.at(times)
    values = [
        np.degrees(motion.retraction),
        *(1e3 * motion.tip.T),
        motion.tip_speed,
        motion.normal_force,
    ]
    found = np.array([numbers for numbers, _ in shown(tab, [float(time) for time in times])])
    digits = [
        max([0.01, *(each[-1] for each in contacts if each[1] <= 1e3 * time <= each[1] + each[2])])
        for time in times
    ]
    for number, value, digit in zip(
        found.T, values, (0.01, 0.01, 0.01, 0.1, np.array(digits)), strict=True
    ):
        assert (np.abs(number - value) <= 0.6001 * digit).all()
    assert said == []
    if (
        name == "contact in time"
    ):  # a quarter of it is more than half the peak, before the tip turns
        strike = run.first_contact("workpart")
        instants = [strike.time + part * strike.duration for part in (0.25, 0.9)]
        (pressed, early), (_, late) = shown(tab, instants)
        assert pressed[-1] > 0.5 * strike.history.normal_force.max()
        assert (early, late) == ("strike: compression", "strike: restitution")


def test_the_view_says_phase_and_force_and_plays(browser: Any, page: Path):
    tab, said = opened(browser, page)
    assert tab.locator("#now-phase").inner_text() == "turns with the hub"
    before = tab.locator("#tool").evaluate("canvas => canvas.toDataURL()")
    tab.get_by_role("button", name="strike").click()
    # 2.746 mN s normal at a friction of 0.3, whose net tangential impulse is small after the reversal of slip
    assert re.fullmatch(
        r"impulse 2\.7\d\d mN s by the workpart", tab.locator("#now-force").inner_text()
    )
    assert tab.locator("#tool").evaluate("canvas => canvas.toDataURL()") != before
    assert "strike" in tab.locator("#tool").get_attribute("aria-label")
    assert shown(tab, [2e-3])[0][1] == "held back by the bar"
    tab.locator("#play").click()
    tab.get_by_role("button", name="pause").wait_for()
    assert said == []


def test_a_filter_shows_the_rows_of_one_status(browser: Any, tmp_path: Path):
    rows = [
        {
            "where": str(number),
            "status": "differs" if number % 3 else "reproduced",
            "value": number,
            "ok": True,
        }
        for number in range(9)
    ]
    write_report(tmp_path / "a.html", Report(None, (), extra={"rows": rows}), **STATED)
    tab, _ = opened(browser, tmp_path / "a.html")
    for name, count in (("reproduced 3", 3), ("all 9", 9)):
        tab.get_by_role("button", name=name).click()
        assert tab.locator("tr[data-status]:visible").count() == count
