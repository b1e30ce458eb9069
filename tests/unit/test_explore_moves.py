"""The bench under many moves in a browser: no error, no picture of another tool than the knobs', whatever the order."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import bristle_sim as bs
from bristle_sim.cli.explore import worker as worker_module
from bristle_sim.cli.explore.server import Server

MOVES = """
window.until = async (held) => { while (!held()) await new Promise((done) => setTimeout(done, 2)); };
window.settled = () => until(() => document.body.dataset.state === "done");
window.outdated = () => { // a picture of another tool that is not dimmed
  const wrong = el("status").classList.contains("wrong") && el("result").classList.contains("outdated");
  return wrong || shown.query === String(assigned()) ? [] : [`${shown.query} is shown for ${assigned()}`];
};
window.moved = async (count, seed) => {
  const random = () => { seed = (seed + 0x6D2B79F5) | 0; let t = Math.imul(seed ^ seed >>> 15, 1 | seed); t = t + Math.imul(t ^ t >>> 7, 61 | t) ^ t; return ((t ^ t >>> 14) >>> 0) / 2 ** 32; };
  const one = (list) => list[Math.floor(random() * list.length)], fire = (node, kind) => node.dispatchEvent(new Event(kind));
  const quick = [...knobs.values()].filter(({ key }) => key.mapped && key.range);
  const stepped = async (id) => { if (!el(id).disabled) { const over = new Promise((done) => addEventListener("popstate", done, { once: true })); el(id).click(); await over; } };
  const found = { faults: [], times: [], sent: [] };
  for (let k = 0; k < count; k++) {
    const kind = random(), { key, text } = one(quick), began = performance.now();
    if (kind < 0.65) {
      key.range.value = Number(key.range.min) + random() * (key.range.max - key.range.min); fire(key.range, "input"); await settled(); found.times.push(performance.now() - began); fire(key.range, "change");
    } else if (kind < 0.75) { text.value = one(["30", "abc", "0.4", "-1", "1e9", "12 mm", "2500 rpm", ""]); fire(text, "change"); await settled(); found.faults.push(...outdated()); text.value = key.text; fire(text, "change"); }
    else if (kind < 0.8) await stepped("undo");
    else if (kind < 0.85) await stepped("redo");
    else if (kind < 0.9) one([el("pin"), el("reset")]).click();
    else if (kind < 0.93) { el("preset").value = one([...el("preset").options]).value; fire(el("preset"), "change"); }
    else if (kind < 0.96) { const list = one([el("map-of"), el("map-x"), el("map-y")]); list.value = one([...list.options]).value; fire(list, "change"); }
    else { el("instant").value = 8000 * random(); fire(el("instant"), "input"); }
    await settled();
    found.faults.push(...outdated());
    if (el("status").classList.contains("wrong") && random() < 0.5) { el("reset").click(); await settled(); }
  }
  await until(() => !map.busy);
  return found;
}
"""


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    serving = Server()
    thread = threading.Thread(target=serving.serve_forever)
    thread.start()
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(worker_module, "TIME_LIMIT", 600.0)
        yield f"http://127.0.0.1:{serving.server_port}/"
    serving.shutdown()
    thread.join()


@pytest.fixture
def errors() -> list[str]:
    return []


def tab(browser: Any, address: str, errors: list[str], **view: Any) -> Any:
    """Open the bench in a page that notes the errors of its console."""
    page = browser.new_page(**view)
    page.set_default_timeout(600_000)
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("console", lambda said: errors.append(said.text) if said.type == "error" else None)
    page.goto(address)
    settle(page)
    page.evaluate(MOVES)
    return page


def settle(page: Any) -> None:
    page.wait_for_selector("body[data-state=done]")


def part_in_picture(page: Any, part: str) -> list[float]:
    """Return a point of the page at which a part can be taken."""
    page.evaluate("window.scrollTo(0, 0)")
    found: list[float] = page.evaluate(
        """(part) => { const { left, top, width, height } = el("tool").getBoundingClientRect(), found = [];
          for (let x = left + 2; x < left + width; x += 3) for (let y = top + 2; y < top + height; y += 3)
            if (viewer.place({ clientX: x, clientY: y }).part === part) found.push([x, y]);
          return found[Math.floor(found.length / 2)]; }""",
        part,
    )
    return found


def drag(page: Any, part: str, right: float, down: float, steps: int) -> None:
    """Drag a part of the picture by some pixels."""
    x, y = part_in_picture(page, part)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + right, y + down, steps=steps)
    page.mouse.up()
    settle(page)


@pytest.mark.nightly
def test_moves_in_any_order_show_the_present_tool(
    browser: Any, address: str, errors: list[str]
) -> None:
    page = tab(browser, address, errors, viewport={"width": 1400, "height": 900})
    assert page.evaluate("moved(8, 1)")["faults"] == []
    assert errors == []


def test_parts_are_dragged_and_the_state_is_kept(
    browser: Any, address: str, errors: list[str]
) -> None:
    """The bar follows the pointer, and the workpart too; the address, Back and the arrow keys step through the tools."""
    page = tab(browser, address, errors, viewport={"width": 1400, "height": 900})
    start = page.evaluate("shown.values")
    drag(page, "bar", 12.0, -9.0, 6)
    bar = page.evaluate("shown.values")
    nearer, higher = (start[key] - bar[key] for key in ("bar_horizontal", "bar_vertical"))
    # As far as the pointer, to the five digits of the fields.
    assert nearer / higher == pytest.approx(12.0 / 9.0, abs=2e-3 / higher)
    page.evaluate("history.back()")
    page.wait_for_selector("#undo[disabled]")
    settle(page)
    assert page.evaluate("shown.values") == start
    drag(page, "workpart", 0.0, -6.0, 3)
    assert page.evaluate("shown.values")["penetration"] > start["penetration"]
    page.focus("#knob-hub_speed")
    page.keyboard.press("Shift+Tab")  # to its slider
    page.keyboard.press("ArrowRight")
    settle(page)
    kept = page.evaluate("shown.values")
    assert kept["hub_speed"] > start["hub_speed"]
    page.reload()
    settle(page)
    assert page.evaluate("shown.values") == pytest.approx(kept)
    assert errors == []


def type_in(page: Any, key: str, text: str) -> None:
    page.fill(f"#knob-{key}", text)
    page.press(f"#knob-{key}", "Tab")


def test_a_page_without_a_run_yet_takes_no_moves(
    browser: Any, address: str, errors: list[str]
) -> None:
    """A link with a refused value has no picture to be moved in; the first run opens the page."""
    page = tab(browser, address + "?friction=oops", errors)
    for part in ("tool", "panel-rate", "map"):
        x, y = page.evaluate(
            "(id) => { const { x, y } = el(id).getBoundingClientRect(); return [x + 50, y + 50]; }",
            part,
        )
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + 5.0, y + 5.0)
        page.mouse.up()
    assert errors == []
    type_in(page, "friction", "0.4")
    page.wait_for_selector("body[data-shown='friction=0.4']")
    page.click("#play")
    assert errors == []


@pytest.mark.nightly
def test_a_search_neither_stops_the_run_nor_outlives_its_tool(
    browser: Any, address: str, errors: list[str]
) -> None:
    page = tab(browser, address, errors, viewport={"width": 1400, "height": 900})
    page.select_option("#map-x", "friction")
    page.select_option("#map-y", "hub_speed")
    page.evaluate("turn({ hub_speed: 2800 }); el('limits').click()")
    page.wait_for_selector("#found:not(:empty)")
    settle(page)
    assert page.evaluate("outdated()") == []
    # The second key of the map has its present value.
    (change,) = bs.limits(bs.Tool(hub=bs.Hub(speed=2800.0 * np.pi / 30.0)), friction=(0.0, 1.0))
    assert f"changes at {change.at:.4f}"[:-1] in page.inner_text("#found")
    page.evaluate("turn({ friction: 0.4 })")
    settle(page)
    assert page.inner_text("#found")  # the first key of the map may move
    page.evaluate("turn({ hub_speed: 2600 })")
    settle(page)
    assert not page.inner_text("#found")
    page.evaluate("window.searching = search('design?' + mapQuery(), ''); turn({ penetration: 3 })")
    page.evaluate("searching")
    settle(page)
    assert page.evaluate("String(assigned())") == "hub_speed=2600+rpm&friction=0.4&penetration=3+mm"
    assert not page.inner_text("#status")
    assert errors == []


def test_a_refused_tool_leaves_no_map_of_another(
    browser: Any, address: str, errors: list[str]
) -> None:
    page = tab(browser, address, errors, viewport={"width": 1400, "height": 900})
    page.wait_for_selector("#map-note:not(:empty)")
    type_in(page, "wire_diameter", "-1 mm")
    page.wait_for_selector("#map.outdated")
    page.evaluate("dispatchEvent(new Event('resize'))")  # draws it again, while it is computed
    assert page.evaluate("el('map').classList.contains('outdated')")
    page.evaluate("until(() => !map.busy)")
    assert "wire_diameter" in page.inner_text("#map-note")
    page.evaluate("el('reset').click()")
    page.wait_for_selector("#map:not(.outdated)")
    assert errors == []


@pytest.mark.nightly
def test_a_thousand_moves_in_four_tabs(browser: Any, address: str, errors: list[str]) -> None:
    """Forty drags of a hundred steps follow in one of them."""
    views = [
        {"viewport": {"width": width, "height": 900}, "color_scheme": scheme}
        for width, scheme in ((400, "dark"), (800, "light"), (1100, "dark"), (1400, "light"))
    ]
    pages = [tab(browser, address, errors, **view) for view in views]
    for seed, page in enumerate(pages):
        page.evaluate("(seed) => { window.result = moved(250, seed); }", seed)
    for page in pages:
        assert page.evaluate("result")["faults"] == []
        assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
    page = pages[-1]
    for number in range(40):
        if number % 10 == 0:
            page.evaluate("el('reset').click()")
            settle(page)
        part = ("bar", "workpart")[number % 2]
        drag(page, part, (-1) ** (number // 2) * 9.0, (-1) ** (number // 4) * 6.0, 100)
        assert page.evaluate("outdated()") == []
    assert errors == []
