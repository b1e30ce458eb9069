"""The bench: what its server answers equals what the library simulates, and its page shows it."""

from __future__ import annotations

import base64
import http.client
import json
import os
import re
import socket
import subprocess
import sys
import threading
import time
import urllib.parse
import urllib.request
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import bristle_sim as bs
from bristle_sim.cli import command
from bristle_sim.cli.explore import bench
from bristle_sim.cli.explore import worker as worker_module
from bristle_sim.cli.explore.entry import explore
from bristle_sim.cli.explore.server import Server, meant_for
from bristle_sim.cli.explore.worker import Worker, Workers
from bristle_sim.cli.scenario import main_scenario


@pytest.fixture(autouse=True)
def patience(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a busy machine take its time."""
    monkeypatch.setattr(worker_module, "TIME_LIMIT", 600.0)


class Client:
    """A browser without a page: sends requests to the server and keeps no state."""

    def __init__(self, port: int) -> None:
        self.port = port

    def get(self, path: str, *, query_string: Any = None, headers: Any = None) -> Any:
        """Return an answer with its status code, headers and content."""
        asked = path.replace(" ", "%20") + (
            f"?{urllib.parse.urlencode(query_string)}" if query_string else ""
        )
        connection = http.client.HTTPConnection("127.0.0.1", self.port)
        connection.request("GET", asked, headers=headers or {})
        answer = connection.getresponse()
        data = answer.read()
        connection.close()
        text = data.decode("utf-8", "replace")
        is_json = answer.headers["Content-Type"].startswith("application/json")
        return SimpleNamespace(
            status_code=answer.status,
            headers=answer.headers,
            data=data,
            text=text,
            json=json.loads(text) if is_json else None,
        )


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    server = Server({"friction": "0.4"})
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield Client(server.server_port)
    server.shutdown()
    thread.join()


def test_a_run_is_the_simulated_one(client: Any) -> None:
    """On top of the tool that the page began with; its numbers are rounded to picometres and attoseconds."""
    found = client.get("/run?hub_speed=280").json
    run = bs.simulate(bs.Tool(hub=bs.Hub(speed=280.0), workpart=bs.Workpart(friction=0.4)))
    motion = {name: np.array(found["motion"][name]) for name in ("time", "retraction", "velocity")}
    smooth = np.unique(motion["time"], return_counts=True)[1] == 1  # two nodes are a jump
    single = np.isin(motion["time"], np.unique(motion["time"])[smooth])
    at_nodes = run.at(1e-3 * motion["time"][single])
    for shown, values in (
        (motion["retraction"][:, 0], np.degrees(at_nodes.retraction)),
        (motion["retraction"][:, 1], -1e-3 * np.degrees(at_nodes.relative_rate)),
        (np.hypot(*motion["velocity"][:, -2:].T), at_nodes.tip_speed),
    ):
        np.testing.assert_allclose(shown[single], values, rtol=6e-6, atol=1e-6)
    assert [name for _, name in found["marks"] if name == "strike"] == ["strike"]
    assert found["changed"] == [["hub_speed", "2500 rpm", "2673.8 rpm"]]
    assert found["command"].endswith("cue_and_impact --set friction=0.4 --set hub_speed=280")
    assert found["answer"].startswith("The bristle strikes at ")


def test_the_page_of_a_run_stays_small(client: Any) -> None:
    """Contacts of 0.4 ns at 10 MN take no more than the digits that the page shows."""
    answer = client.get("/run?contact=compliant")
    motion = answer.json["motion"]
    assert motion["drawn"].startswith(f"{len(set(motion['time']))} instants drawn")
    assert len(motion["time"]) < 3000
    assert len(answer.data) < 2e6


@pytest.mark.parametrize(
    ("query", "words"),
    [
        ("friction=abc", "friction = 'abc': must be"),
        ("frictoin=1", "unknown key 'frictoin'"),
        ("bar_radius=1", "bar_radius"),
    ],
)
def test_bad_input_is_one_line(client: Any, query: str, words: str) -> None:
    found = client.get(f"/run?{query}").json
    assert words in found["error"]
    assert "\n" not in found["error"]
    assert client.get(f"/download/json?{query}").status_code == 400


def test_the_button_makes_the_strike_radial(client: Any) -> None:
    found = client.get("/radial").json["assignments"]
    assert all(text.endswith(" mm") for text in found.values())  # as the fields show them
    tool = bs.Tool(workpart=bs.Workpart(friction=0.4)).replace(**found)
    run = bs.simulate(tool, stop_after="strike")
    # The place is given to nine digits, and the lag changes by some two degrees for one of the bar's direction.
    assert run.at(run.contacts[-1].time, side="before").retraction == pytest.approx(0.0, abs=1e-6)


@pytest.mark.nightly
def test_a_downloaded_tool_is_the_one_that_was_run(client: Any, tmp_path: Path) -> None:
    path = tmp_path / "tool.toml"
    path.write_bytes(client.get("/download/toml?bristle_length=28 mm").data)
    assert bs.read_tool(path) == bs.Tool(
        bristle=bs.Bristle(length=0.028), workpart=bs.Workpart(friction=0.4)
    )
    assert client.get("/download/csv").text.startswith("time (s),")
    assert client.get("/download/json").json["answer"]
    page = client.get("/download/html").text
    assert "<h1>From bar to rebound" in page
    assert page.count("<svg") == 1  # the figure that --report has
    assert client.get("/download/svg").text.startswith("<?xml")
    assert client.get("/download/png").data.startswith(b"\x89PNG")
    assert client.get("/download/exe").status_code == 404
    assert "must" in client.get("/radial?bar_radius=0.05").json["error"]


def unpacked(found: dict[str, Any], name: str) -> np.ndarray:
    shape = (found["size"], found["size"])
    return np.frombuffer(base64.b64decode(found[name]), dtype=np.uint8).reshape(shape)


def test_a_map_has_the_passes_of_its_points(client: Any) -> None:
    """Every point is computed; a shade is the value rounded to the scale."""
    on = {
        "x": ["hub_speed", "2000 rpm", "3000 rpm"],
        "y": ["bar_horizontal", "54 mm", "47 mm"],
        "of": "tip_speed_at_contact",
    }
    query = {"on": json.dumps(on), "fine": "1", "friction": "0.35"}
    found = client.get("/map", query_string=query).json
    x = np.linspace(2000.0, 3000.0, 201) * np.pi / 30.0
    y = np.linspace(0.054, 0.047, 201)[:, np.newaxis]
    rows = [3, 40, 77, 120, 150]
    many = bs.ensemble(friction=0.35, accuracy=1e-6, hub_speed=x, bar_horizontal=y[rows])
    low, high = (float(found[each].split()[0]) for each in ("low", "high"))
    shades = unpacked(found, "shades")[rows].astype(float)
    shown = low + (high - low) * shades / 254.0
    inside = (shades > 0) & (shades < 254)
    # The ends of the scale are given to three digits, and a shade is rounded to a half.
    off = np.abs(shown - many.tip_speed_at_contact)[inside]
    assert inside.mean() > 0.9
    assert off.max() < 0.5 * (high - low) / 254.0 + 5e-3 * high
    words = np.array(found["names"])[unpacked(found, "outcomes")[rows]]
    assert (words == many.outcome).all()
    coarse = client.get("/map", query_string=query | {"fine": "0"}).json
    # The ends of the two scales are percentiles of different points, and differ by some shades.
    apart = unpacked(found, "shades")[::5, ::5].astype(int) - unpacked(coarse, "shades")
    assert np.median(np.abs(apart)) <= 3


def test_both_axes_of_a_map_may_show_one_parameter(client: Any) -> None:
    side = ["friction", "0.1", "0.5"]
    on = json.dumps({"x": side, "y": side, "of": "normal_final_impulse"})
    found = client.get("/map", query_string={"on": on, "fine": "0"}).json
    shades = unpacked(found, "shades")
    assert (shades == shades[:, :1]).all()
    assert np.unique(shades).size > 10


def test_a_map_of_the_outcome_names_those_that_occur(client: Any) -> None:
    """The outcome is the same everywhere; where no pass can be computed, the line says why."""
    on = {"x": ["hub_speed", "2490 rpm", "2500 rpm"], "y": ["friction", "0.3", "0.31"]}
    query = {"on": json.dumps(on | {"of": "outcome"}), "fine": "1"}
    found = client.get("/map", query_string=query).json
    assert found["note"] == "outcome: 40401 points"
    assert {found["names"][each] for each in found["present"]} == {"reverses its slip"}
    refused = client.get("/map", query_string=query | {"wire_links": "2"}).json
    assert "wire_links" in refused["error"]


def test_limits_and_a_design_over_the_keys_of_the_map(client: Any) -> None:
    on = {"x": ["friction", "0.1", "0.6"], "y": ["hub_speed", "2000 rpm", "3000 rpm"]}
    found = client.get("/limits", query_string={"on": json.dumps(on)}).json
    (change,) = bs.limits(friction=(0.1, 0.6))
    assert f"at {change.at:.4f}"[:8] in found["answer"]
    assert "sticks and rebounds" in found["answer"]
    on["x"] = ["bar_horizontal", "54 mm", "47 mm"]
    on["want"] = {"tip_speed_at_contact": "36 m/s", "lag_deg_at_contact": "0 deg"}
    found = client.get("/design", query_string={"on": json.dumps(on)}).json
    run = client.get("/run", query_string=found["assignments"]).json
    assert "its tip at 36 m/s" in run["answer"]
    assert ", radial, " in run["answer"]


def test_the_surface_of_the_present_tool_is_drawn(client: Any) -> None:
    found = client.get("/surface?hub_speed=280").json
    assert base64.b64decode(found["picture"]).startswith(b"\x89PNG")
    assert "must strike the workpart" in client.get("/surface?penetration=-1 mm").json["error"]


@pytest.mark.parametrize("name", bench.PRESETS)
def test_the_tools_of_the_list_strike(client: Any, name: str) -> None:
    """Their names state length and speed; all but the dissertation's strike radially, with bars to a hundredth of a millimetre."""
    defaults = {each["key"]: each["preset"] for each in bench.knobs(main_scenario(), {})}
    keys = dict(urllib.parse.parse_qsl(bench.PRESETS[name]))
    length, speed = re.findall(r"(\d+) (?:mm|rpm)", name)
    assert keys.get("bristle_length", defaults["bristle_length"]) == f"{length} mm"
    assert float(keys.get("hub_speed", "2500 rpm").split()[0]) == float(speed)
    run = client.get("/run", query_string=keys).json
    lag = run["simulated"][[row[0] for row in run["table"]].index("lag at the strike") - 1]
    assert abs(lag) < (3.0 if not keys else 0.1)


SLOW = {"wire_links": "16", "accuracy": "1e-10"}
"""Values of a run that takes longer than these tests wait for it."""


def running(workers: Workers) -> Worker:
    """Wait for the run of the page."""
    while "page" not in workers._running:
        time.sleep(0.01)
    return workers._running["page"]


def test_a_newer_run_of_the_page_stops_the_older_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(worker_module, "GRACE", 600.0)
    workers = Workers()
    with ThreadPoolExecutor(1) as pool:
        older = pool.submit(workers.answer, "page", "run", SLOW, {})
        ended = running(workers)
        assert workers.answer("page", "run", {"accuracy": "1e-3"}, {})["answer"].startswith(
            "The bristle strikes at "
        )
        assert older.result() == {"error": "stopped by a newer run"}
    assert ended.rest()  # a stopped run costs no process
    assert all(each.rest() for each in workers._idle)


def test_a_run_that_takes_too_long_or_dies_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    workers = Workers()
    with ThreadPoolExecutor(1) as pool:
        lost = pool.submit(workers.answer, "page", "run", SLOW, {})
        running(workers)._process.kill()
        assert "the process that computed this ended with status" in lost.result()["error"]
    monkeypatch.setattr(worker_module, "TIME_LIMIT", 0.2)
    assert workers.answer("", "run", SLOW, {})["error"].startswith("not done in 0.2 s; ")
    monkeypatch.setattr(workers, "_free", threading.BoundedSemaphore(1))
    with workers._free:
        assert "the server is busy" in workers.answer("", "run", {}, {})["error"]


def test_a_worker_has_one_thread_of_linear_algebra() -> None:
    """Threads that wait for each other took 70 of the 100 ms of a run."""
    worker = Worker()  # which ends its process when it is collected
    environment = Path(f"/proc/{worker._process.pid}/environ")
    if not environment.exists():
        pytest.skip("needs /proc")
    while not (given := environment.read_bytes()):  # until the process has begun
        time.sleep(0.01)
    assert b"OPENBLAS_NUM_THREADS=" in given


def test_a_worker_ends_with_its_server() -> None:
    """In the middle of a run too: the server is killed, which leaves it no time to end anything."""
    program = (
        "from bristle_sim.cli.explore.worker import Worker\nworker = Worker()\nprint(worker._process.pid, flush=True)\n"
        f"worker.begin('run', [{SLOW}, {{}}])\nworker.answer()"
    )
    with subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, text=True
    ) as server_:
        assert server_.stdout is not None
        pid = int(server_.stdout.readline())
        server_.kill()
    while is_alive(pid):
        time.sleep(0.01)


@pytest.mark.parametrize("from_file", [True, False])
def test_a_program_of_any_form_may_start_a_worker(tmp_path: Path, from_file: bool) -> None:
    """Without a guard, and without a file; the worker does not run it again."""
    program = (
        "from bristle_sim.cli.explore.worker import Worker\n"
        "print('once')\nworker = Worker()\nworker.begin('run', ({}, {}))\nprint(worker.answer()['answer'])"
    )
    file = tmp_path / "program.py"
    file.write_text(program)
    done = subprocess.run(
        [sys.executable, str(file) if from_file else "-"],
        input="" if from_file else program,
        capture_output=True,
        text=True,
        check=True,
    )
    assert re.match(r"once\nThe bristle strikes at ", done.stdout)
    assert not done.stderr


def is_alive(pid: int) -> bool:
    """Whether a process runs; one whose status nobody has asked for does not."""
    try:
        os.kill(pid, 0)
        status = Path(f"/proc/{pid}/stat")
        return not status.exists() or status.read_text().split()[2] != "Z"
    except (ProcessLookupError, FileNotFoundError):
        return False


@pytest.mark.parametrize(
    ("name", "status"),
    [
        ("localhost:{port}", 200),
        ("127.0.0.1:{port}", 200),
        ("[::1]:{port}", 200),
        ("elsewhere.example:{port}", 421),
        ("127.0.0.1:81", 421),
        ("127.0.0.1", 421),
        ("", 421),
    ],
)
def test_only_requests_to_this_machine_are_answered(client: Any, name: str, status: int) -> None:
    answer = client.get("/", headers={"Host": name.format(port=client.port)})
    assert answer.status_code == status
    assert answer.headers["X-Content-Type-Options"] == "nosniff"
    assert "default-src 'none'; script-src 'sha256-" in answer.headers["Content-Security-Policy"]


@pytest.mark.parametrize(
    ("name", "port", "meant"),
    [
        ("localhost:8000", 8000, True),
        ("127.0.0.1", 80, True),
        ("evil.example:8000", 8000, False),
        ("10.0.0.7:8000", 8000, False),
        ("127.0.0.1:port", 8000, False),
    ],
)
def test_a_request_to_another_machine_or_port_is_refused(name: str, port: int, meant: bool) -> None:
    """A browser leaves out port 80."""
    assert meant_for(name, port) is meant


def test_a_request_that_does_not_end_is_given_up(
    monkeypatch: pytest.MonkeyPatch, address: str
) -> None:
    monkeypatch.setattr("bristle_sim.cli.explore.server.Request.timeout", 0.2)
    with socket.create_connection(
        ("127.0.0.1", urllib.parse.urlparse(address).port or 0), timeout=30.0
    ) as slow:
        slow.sendall(b"GET / HTTP/1.1\r\nHost: ")
        assert slow.recv(1) == b""


def test_two_tools_are_compared(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    paths = [str(tmp_path / name) for name in ("slow.toml", "fast.toml")]
    for path, speed in zip(paths, (250.0, 270.0), strict=True):
        bs.write_tool(bs.Tool(hub=bs.Hub(speed=speed)), path)
    page = tmp_path / "page.html"
    assert command.main(["compare", *paths, "--report", str(page)]) == 0
    said = capsys.readouterr().out
    assert "hub_speed  2387.3 rpm  2578.3 rpm" in said  # 250 and 270 rad/s times 30/pi
    assert re.match(
        r"fast against slow: normal impulse p_fy \S+ mN s instead of \S+ mN s \(-", said
    )
    assert "slow: The bristle strikes at " in said
    assert page.read_text(encoding="utf-8").count("<svg") == 3  # a pass each, and both
    assert command.main(["compare", *paths]) == 0
    assert said.startswith(capsys.readouterr().out)
    table = tmp_path / "numbers.csv"
    picture = tmp_path / "pair.svg"
    assert command.main(["compare", *paths, "--csv", str(table), "--plot", str(picture)]) == 0
    assert table.read_text(encoding="utf-8").startswith(
        "quantity,unit,slow,fast\nrelease_time,s,0.00"
    )
    assert "tip speed" in picture.read_text(encoding="utf-8")
    bs.write_tool(bs.Tool(workpart=bs.Workpart(penetration=-0.002)), tmp_path / "high.toml")
    capsys.readouterr()
    assert command.main(["compare", paths[0], str(tmp_path / "high.toml")]) == 0
    assert capsys.readouterr().out.startswith("slow strikes, high does not strike.\n")
    assert command.main(["compare", paths[0], str(tmp_path / "none.toml")]) == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.fixture
def address() -> Iterator[str]:
    serving = Server()
    thread = threading.Thread(target=serving.serve_forever)
    thread.start()
    yield f"http://127.0.0.1:{serving.server_port}/"
    serving.shutdown()
    thread.join()


def test_the_page_in_a_browser(address: str, browser: Any) -> None:
    """A link shows its state, a bad value keeps the last picture, two pages show their own tools, and no console has an error."""
    errors: list[str] = []
    pages = [browser.new_page(viewport={"width": width, "height": 900}) for width in (1280, 800)]
    for page, query in zip(pages, ("?friction=0.2", "?friction=0.5"), strict=True):
        page.set_default_timeout(600_000)
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.on(
            "console",
            lambda message: errors.append(message.text) if message.type == "error" else None,
        )
        page.goto(address + query)
        page.wait_for_selector("body[data-shown]")
        assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
    assert [page.inner_text("#changed") for page in pages] == [
        "friction\t0.31 → 0.2",
        "friction\t0.31 → 0.5",
    ]
    before = pages[0].inner_text("#rows")
    pages[0].fill("#knob-friction", "oops")
    pages[0].press("#knob-friction", "Tab")
    pages[0].wait_for_selector("#status.wrong")
    assert "friction = 'oops': must be" in pages[0].inner_text("#status")
    assert pages[0].inner_text("#rows") == before
    simulated = pages[1].inner_text("#rows tr:first-child td:nth-child(3)")
    assert simulated == pages[1].evaluate("shown.table[1][2]")
    pages[1].click("#pin")
    pages[1].fill("#knob-hub_speed", "2600rpm")
    pages[1].press("#knob-hub_speed", "Tab")
    pages[1].wait_for_selector("#changed tr:has-text('hub_speed')")
    assert pages[1].inner_text("#rows tr:first-child td:nth-child(4)") == simulated  # pinned
    assert "pin=friction%3D0.5" in pages[1].url
    assert "hub_speed=2600rpm" in pages[1].url
    assert not errors


def test_a_notebook_shows_the_page() -> None:
    page = explore(bs.Tool(hub=bs.Hub(speed=280.0)))._repr_html_()
    address = re.search(r'<iframe src="(http://127[^"]*)"', page)
    assert address is not None
    with urllib.request.urlopen(f"{address[1]}run") as answer:
        assert json.load(answer)["changed"] == []  # of the tool that it began with
    assert (
        command.main(["explore", "--port", str(urllib.parse.urlparse(address[1]).port)]) == 2
    )  # it is taken


def test_the_command_serves_until_it_is_ended(monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    def interrupted() -> None:
        raise KeyboardInterrupt

    serving = SimpleNamespace(address="http://127.0.0.1:8000/", serve_forever=interrupted)
    monkeypatch.setattr("bristle_sim.cli.explore.server.Server", lambda *_, **__: serving)
    assert command.main(["explore"]) == 130
    out, err = capsys.readouterr()
    assert "http://127.0.0.1:8000/ shows the bench; Ctrl-C ends it" in out + err
    assert err.count("\n") == 1
