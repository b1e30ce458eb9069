"""The scripts' command line, on a scenario that costs nothing: keys, table, JSON, files, pipes and exit status."""

from __future__ import annotations

import contextlib
import dataclasses
import errno
import io
import json
import logging
import math
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pymunk
import pytest
import tqdm
from matplotlib.figure import Figure

from bristle_sim.cli import Scenario, command, main, output
from bristle_sim.cli.scenario import load_scenario, script_paths
from bristle_sim.comparison import Quantity, Report, Unfinished
from bristle_sim.declared import Declared
from bristle_sim.fields import choice, quantity
from bristle_sim.version import __version__, named_commit


@dataclass(frozen=True)
class Body(Declared):
    mass: float = quantity(2.0, "0 < mass <= 1e3 kg: how heavy it is [a source]")
    speed: float = quantity(0.5, "-10 <= speed <= 10 m/s [another source]")
    drag: float | None = quantity(None, "0 <= drag <= 1 [off]", needs="law = plastic")
    inner: object = None


@dataclass(frozen=True)
class Law(Declared):
    name: str = choice("law [a source]", "elastic", "plastic")
    unused: float = quantity(1.0, "0 <= unused <= 1 [a source]")


def run(body: Body, _law: Law) -> Report:
    if body.mass * abs(body.speed) > 100.0:
        raise ValueError("mass = too much:\n  must be less (in kg m/s)")
    momentum = Quantity("momentum", "N s", body.mass * body.speed, 1.0, tolerance=1e-9)
    return Report(
        "rebound",
        (momentum, Quantity("nothing", "1", math.nan, None)),
        phases=("compression slip", "restitution stick"),
        events=(("strike", 0.25), ("never", math.inf)),
        wall_s=np.float64(0.125),
        steps=np.int64(7),
        remarks=("a remark",),
        extra={
            "rows": [{"case": "a", "ok": np.bool_(True), "reached": math.nan}],
            "curve": np.array([1.0, np.inf]),
        },
        subject=body,
        answer="Momentum is mass times speed.",
    )


class Picture(Figure):
    """Writes what it shows."""

    def __init__(self, report: Report) -> None:
        super().__init__()
        self.shown = f"drawn {report.subject.mass}"

    def savefig(self, path: Path, **_: Any) -> None:  # type: ignore[override]
        path.write_text(self.shown)


class Film:
    """Writes its size and rate."""

    def __init__(self, report: Report, width: int = 640, height: int = 480) -> None:
        self.shown = f"drawn {report.subject.mass} {width}x{height}"

    def write(self, path: Path, fps: float = 30.0) -> None:
        path.write_text(f"{self.shown} {fps:g}")


QUESTION = "Is momentum mass times speed? 100% of it?"
SCENARIO = Scenario(
    name="fake", question=QUESTION, run=run, plot=Picture, film=Film, without=("unused",)
)


def doing(answer: Callable[[], Report]) -> Scenario:
    """The scenario with another run."""

    def other(_body: Body, _law: Law) -> Report:
        return answer()

    return dataclasses.replace(SCENARIO, run=other)


def refusal(
    capsys: pytest.CaptureFixture[str], *arguments: str, scenario: Scenario = SCENARIO
) -> str:
    """The one line that refuses some arguments."""
    assert main(scenario, arguments) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert err.startswith("fake.py: error: ")
    return err.removeprefix("fake.py: error: ").rstrip("\n")


def document(
    capsys: pytest.CaptureFixture[str], *arguments: str, scenario: Scenario = SCENARIO
) -> dict[str, Any]:
    main(scenario, ["--json", "-", *arguments])
    out, err = capsys.readouterr()
    assert err == ""
    found = json.loads(out, parse_constant=lambda word: pytest.fail(f"{word} in JSON"))
    assert isinstance(found, dict)
    return found


def test_answer_table_and_exit_status(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    assert main(SCENARIO, []) == 0
    out, err = capsys.readouterr()
    assert err == ""
    lines = out.splitlines()
    assert lines[:2] == ["Momentum is mass times speed.", ""]
    assert lines[2].split()[:4] == ["quantity", "unit", "simulated", "theory"]
    assert lines[4].split()[:5] == ["momentum", "N", "s", "1", "1"]
    assert lines[-3:] == ["", "outcome: rebound (compression slip, restitution stick)", "a remark"]
    assert main(SCENARIO, ["--set", "speed=0.6"]) == 1
    assert "NO" in capsys.readouterr().out
    monkeypatch.setattr(sys, "stderr", None)
    assert main(SCENARIO, []) == 0
    monkeypatch.setattr(sys, "stdout", None)
    assert main(SCENARIO, []) == 2


def test_remarks_alone(capsys: pytest.CaptureFixture[str]):
    """No outcome where no impact is asked about; prose is wrapped, and columns are not."""
    prose = "word " * 40
    columns = "a  b  " * 40
    silent = doing(lambda: Report(None, (), remarks=(prose, columns)))
    assert main(silent, []) == 0
    lines = capsys.readouterr().out.splitlines()
    assert columns in lines
    assert max(len(line) for line in lines if line != columns) <= 100
    assert sum(line.count("word") for line in lines) == 40
    assert not [line for line in lines if "outcome" in line]
    assert document(capsys, scenario=silent)["outcome"] is None


def test_settings_are_read_and_the_last_one_counts(capsys: pytest.CaptureFixture[str], monkeypatch):
    found = document(
        capsys,
        "--set",
        "mass=4",
        "--set=speed=-1e1",
        "--set",
        "law=plastic",
        "--set",
        "mass=5000 g",
    )
    assert found["parameters"] == {"mass": 5.0, "speed": -10.0, "drag": None, "law": "plastic"}
    assert found["quantities"][0]["simulated"] == -50.0
    monkeypatch.setattr(sys, "argv", ["fake.py", "--set", "mass=x"])
    assert main(SCENARIO) == 2
    assert "mass = 'x'" in capsys.readouterr().err


def test_the_value_none_that_a_list_of_keys_shows_can_be_typed():
    """A parameter that may be absent is left out by it, also where the scenario has a default or another key is missing."""
    for name in ("cue_and_impact", "bent_bristles", "force_history", "surface"):
        scenario = load_scenario(script_paths()[name])
        for key, declared in scenario.keys().items():
            if declared.optional:
                values = scenario.values_of({key: "none"})
                assert values[key] is None
                assert declared.default is None or key in scenario.defaults
    with pytest.raises(ValueError, match="wire_diameter = 'none': must be a finite number"):
        load_scenario(script_paths()["cue_and_impact"]).values_of({"wire_diameter": "none"})


def test_json_is_plain_finite_and_complete(capsys: pytest.CaptureFixture[str], tmp_path: Path):
    nothing = dict.fromkeys(
        ("simulated", "theory", "reference", "printed", "relative_difference", "tolerance", "ok")
    )
    assert document(capsys) == {
        "scenario": "fake",
        "answer": "Momentum is mass times speed.",
        "version": __version__,
        **named_commit(),
        "parameters": {"mass": 2.0, "speed": 0.5, "drag": None, "law": "elastic"},
        "outcome": "rebound",
        "quantities": [
            nothing
            | {
                "name": "momentum",
                "label": "momentum",
                "unit": "N s",
                "simulated": 1.0,
                "theory": 1.0,
            }
            | {"relative_difference": 0.0, "tolerance": 1e-9, "ok": True},
            nothing | {"name": "nothing", "label": "nothing", "unit": "1"},
        ],
        "phases": ["compression slip", "restitution stick"],
        "events": [{"name": "strike", "time": 0.25}],
        "cost": {"wall_s": 0.125, "steps": 7},
        "rows": [{"case": "a", "ok": True, "reached": None}],
        "curve": [1.0, None],
    }
    target = tmp_path / "out.json"
    target.write_text("old")
    assert main(SCENARIO, ["--json", str(target), "--set", "speed=0.6"]) == 1
    assert "quantity" in capsys.readouterr().out
    assert json.loads(target.read_text())["quantities"][0]["simulated"] == 1.2
    assert list(tmp_path.iterdir()) == [target]


def test_a_value_far_from_the_default_is_run_with_a_warning(capsys: pytest.CaptureFixture[str]):
    """The line that refuses values that do not fit together says so too."""
    assert main(SCENARIO, ["--set", "mass=200", "--json", "-"]) == 1
    out, err = capsys.readouterr()
    assert json.loads(out)["scenario"] == "fake"
    warning = "mass = 200 kg is 100 times the default, 2 kg; if it was meant in g: mass='200 g'"
    assert err == f"fake.py: warning: {warning}\n"
    line = refusal(capsys, "--set", "mass=200", "--set", "speed=5")
    assert line == f"mass = too much: must be less (in kg m/s); {warning}"


@pytest.mark.parametrize("error", [OverflowError, ZeroDivisionError, FloatingPointError])
def test_values_too_extreme_for_arithmetic_are_refused(
    error: type[ArithmeticError], capsys: pytest.CaptureFixture[str]
):
    def fail() -> Report:
        raise error("out of range")

    line = refusal(capsys, "--set", "mass=1e-300", "--set", "speed=3", scenario=doing(fail))
    assert line.startswith(
        "mass=1e-300, speed=3: must be less extreme (out of range); mass = 1e-300 kg is 5e-301 times"
    )
    with pytest.raises(error):  # with no value typed it is nobody's input that is wrong
        main(doing(fail), [])


def test_pictures_and_videos_are_drawn_when_asked_for(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
):
    plot = tmp_path / "plot.SVG"
    video = tmp_path / "film.gif"
    arguments = [
        "--plot",
        str(plot),
        "--video",
        str(video),
        "--size",
        "64x48",
        "--fps",
        "12",
        "--json",
        "-",
    ]
    assert main(SCENARIO, arguments) == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["scenario"] == "fake"
    assert err == f"--plot: wrote {plot}\n--video: wrote {video}\n"
    assert (plot.read_text(), video.read_text()) == ("drawn 2.0", "drawn 2.0 64x48 12")


@pytest.mark.parametrize(
    "error", [ValueError("too long"), OSError(errno.ENOSPC, "No space left on device")]
)
@pytest.mark.parametrize("part", ["plot", "series"])
def test_a_file_that_fails_is_named_and_leaves_no_output(
    part: str, error: Exception, capsys: pytest.CaptureFixture[str], tmp_path: Path
):
    def fail(_report: Report) -> Any:
        raise error

    moving = dataclasses.replace(SCENARIO, series=lambda _: {"n": [1]})
    scenario = dataclasses.replace(moving, **{part: fail})
    targets = {
        option: str(tmp_path / f"a.{kind}")
        for option, kind in (("csv", "csv"), ("plot", "png"), ("json", "json"))
    }
    line = refusal(
        capsys,
        *(word for option, path in targets.items() for word in (f"--{option}", path)),
        scenario=scenario,
    )
    assert line.endswith("too long" if isinstance(error, ValueError) else "No space left on device")
    assert (
        part != "plot"
        or isinstance(error, ValueError)
        or line.startswith(f"--plot = {targets['plot']!r}: ")
    )
    assert not list(tmp_path.iterdir())


COLUMNS = {
    "shape": ["a", "b"],
    "time (s)": np.array([1.0 / 3.0, 0.5]),
    "n": [math.nextafter(1.0, 2.0), math.nan],
}
MOVING = dataclasses.replace(SCENARIO, series=lambda _: COLUMNS)


def test_a_time_series_is_written_one_row_a_sample(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
):
    """At full precision: a third and the smallest number above one survive."""
    target = tmp_path / "run.csv"
    text = "shape,time (s),n\na,0.3333333333333333,1.0000000000000002\nb,0.5,\n"
    assert main(MOVING, ["--csv", str(target)]) == 0
    assert capsys.readouterr().err == f"--csv: wrote {target}\n"
    assert target.read_text() == text
    assert main(MOVING, ["--csv", "-"]) == 0
    assert capsys.readouterr() == (text, "")


def test_a_device_may_serve_several_options():
    assert main(MOVING, ["--json", os.devnull, "--csv", os.devnull]) == 0
    assert not Path(os.devnull).is_file()


@pytest.mark.parametrize("kept", [False, True])
def test_ctrl_c_ends_with_one_line_and_keeps_what_is_finished(
    kept: bool, capsys: pytest.CaptureFixture[str], tmp_path: Path
):
    def interrupt() -> Report:
        if kept:
            raise Unfinished(Report(None, (Quantity("first", "1", 1.0),), extra={"rows": [1]}))
        raise KeyboardInterrupt

    target = tmp_path / "a.json"
    picture = tmp_path / "a.png"
    assert main(doing(interrupt), ["--json", str(target), "--plot", str(picture)]) == 130
    out, err = capsys.readouterr()
    assert err == "fake.py: interrupted\n"
    assert ("first" in out) is bool(out) is kept
    assert list(tmp_path.iterdir()) == ([target] if kept else [])
    if kept:
        found = json.loads(target.read_text())
        assert (found["rows"], found["finished"]) == ([1], False)
        moving = dataclasses.replace(doing(interrupt), series=lambda _: COLUMNS)
        assert main(moving, ["--csv", "-"]) == 130
        assert "first" in capsys.readouterr().out  # the table, since the series is not complete


@pytest.mark.parametrize(("terminal", "bar"), [(True, False), (False, False), (False, True)])
def test_progress_is_shown_in_one_line_on_a_terminal_and_now_and_then_elsewhere(
    terminal: bool, bar: bool, monkeypatch
):
    """Where a bar counts, nothing else does."""

    def work() -> Report:
        log = logging.getLogger("bristle_sim.studies.work")
        log.warning("take care")
        log.info("part 1 of 2")
        deadline = time.monotonic() + (0.8 if bar else 60.0)
        while "s: part" not in stderr.getvalue() and time.monotonic() < deadline:
            time.sleep(0.01)
        return Report(None, ())

    stderr = io.StringIO()
    monkeypatch.setattr(stderr, "isatty", lambda: terminal)
    monkeypatch.setattr(output, "SILENCE", 60.0 if terminal else 0.3)
    monkeypatch.setattr(sys, "stderr", stderr)
    with tqdm.tqdm(file=io.StringIO()) if bar else contextlib.nullcontext():
        assert main(doing(work), []) == 0
    shown = stderr.getvalue().removeprefix("fake.py: warning: take care\n")
    words = r"fake\.py: \d+ s: part 1 of 2"
    expected = r"\r\x1b\[K" + words if terminal else "$" if bar else words + r"\n"
    assert re.match(expected, shown)
    assert shown.endswith("\r\x1b[K") is terminal  # the line is cleared at the end
    assert not logging.getLogger("bristle_sim").handlers


posix = pytest.mark.skipif(os.name == "nt", reason="signals and shells of another kind")
SCRIPT = """
import runpy, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job ignores it
if hasattr(signal, "SIGHUP"):
    signal.signal(signal.SIGHUP, signal.SIG_DFL)  # nohup ignores it
sys.argv = sys.argv[1:]
runpy.run_path(sys.argv[0], run_name="__main__")
"""
"""Runs a script as a shell in a terminal does."""


def started(name: str, *arguments: str) -> list[str]:
    return [sys.executable, "-c", SCRIPT, str(script_paths()[name]), *arguments]


@posix
@pytest.mark.parametrize(
    ("number", "status", "line"),
    [
        ("SIGINT", 130, "interrupted\n"),
        pytest.param("SIGTERM", 143, "", marks=pytest.mark.nightly),
        pytest.param("SIGHUP", 129, "", marks=pytest.mark.nightly),
    ],
)
def test_a_signal_leaves_no_partial_file(number: str, status: int, line: str, tmp_path: Path):
    """It is sent as soon as a film of some seconds has its partial file."""
    film = started("cue_and_impact", "--video", str(tmp_path / "a.gif"))
    process = subprocess.Popen(film, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    while not list(tmp_path.iterdir()):
        assert process.poll() is None
        time.sleep(0.01)
    process.send_signal(getattr(signal, number))
    out, err = process.communicate(timeout=60)
    assert (process.returncode, out) == (status, "")
    assert err.endswith(line)
    assert "Traceback" not in err
    assert not list(tmp_path.iterdir())


@pytest.fixture
def usual_handlers() -> Iterator[None]:
    """The handlers of Python in a terminal, whatever runs the tests."""
    before = {number: signal.signal(number, handler) for number, handler in output.USUAL.items()}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.usefixtures("usual_handlers")
def test_handlers_of_others_and_other_threads_are_left_alone():
    def inside() -> object:
        with output.ending_in_order():
            return signal.getsignal(signal.SIGTERM)

    with ThreadPoolExecutor(1) as pool:
        assert pool.submit(inside).result() is signal.SIG_DFL
    mine = lambda *_: None  # noqa: E731
    for number in output.USUAL:
        signal.signal(number, mine)
    hook = sys.unraisablehook
    with output.ending_in_order():
        assert all(signal.getsignal(number) is mine for number in output.USUAL)
        assert sys.unraisablehook is hook


def in_destructor(action: Callable[[], object]) -> None:
    class Freed:
        def __del__(self) -> None:
            action()

    Freed()


def in_callback(action: Callable[[], object]) -> None:
    space = pymunk.Space()
    body = pymunk.Body(1.0, 1.0)
    space.add(body)
    body.velocity_func = lambda *_: action()
    space.step(0.1)


@posix
@pytest.mark.usefixtures("usual_handlers")
@pytest.mark.parametrize(
    ("number", "ended"), [(signal.SIGINT, KeyboardInterrupt), (signal.SIGTERM, SystemExit)]
)
@pytest.mark.parametrize("where", [in_destructor, in_callback])
def test_an_end_is_not_lost_where_an_exception_is_printed_and_ignored(
    where, number: int, ended: type, monkeypatch
):
    """In a destructor or a callback of the engine; another exception is printed there as ever."""
    reported: list[type] = []
    monkeypatch.setattr(sys, "__unraisablehook__", lambda lost: reported.append(lost.exc_type))

    def losing() -> None:
        in_destructor(lambda: 1 / 0)
        where(lambda: signal.raise_signal(number))
        for _ in range(1000):  # a signal that a thread raises comes between two calls
            time.sleep(0.01)

    with pytest.raises(ended), output.ending_in_order():
        losing()
    assert reported == [ZeroDivisionError]
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL


@posix
@pytest.mark.parametrize(("closed", "status"), [(">&-", 2), ("2>&-", 0)])
def test_a_closed_stream(closed: str, status: int, tmp_path: Path):
    """Without standard output nothing runs. Without standard error, messages do not get into the results."""
    shell = ["/bin/sh", "-c", f'exec "$0" "$@" {closed}']
    line = [*shell, *started("single_pendulum", "--json", "-", "--plot", str(tmp_path / "a.png"))]
    found = subprocess.run(line, capture_output=True, stdin=subprocess.DEVNULL, check=False)
    assert found.returncode == status
    if status == 0:
        assert json.loads(found.stdout)["scenario"] == "single_pendulum"
    else:
        assert found.stderr == b"single_pendulum.py: error: standard output: must be open\n"
        assert not list(tmp_path.iterdir())


def test_letters_that_the_output_lacks_do_not_end_a_run(monkeypatch: pytest.MonkeyPatch):
    """The answer of a pass has degrees, which ASCII lacks."""
    out = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    monkeypatch.setattr(sys, "stdout", out)
    output.print_line("2.74\N{DEGREE SIGN} short of radial")
    assert out.buffer.getvalue() == b"2.74? short of radial\n"


def test_a_reader_that_leaves_early_is_no_error(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    """As of ``scenario.py | head -1``: no complaint when the stream is closed either."""
    read, write = os.pipe()
    os.close(read)
    with os.fdopen(write, "w") as out:
        monkeypatch.setattr(sys, "stdout", out)
        assert main(SCENARIO, []) == 0
    assert capsys.readouterr().err == ""


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_a_full_disk_is_an_error_in_one_line(capsys: pytest.CaptureFixture[str], monkeypatch):
    with Path("/dev/full").open("w") as out:
        monkeypatch.setattr(sys, "stdout", out)
        assert main(SCENARIO, []) == 2
        out.flush()
    assert (
        capsys.readouterr().err == f"fake.py: error: standard output: {os.strerror(errno.ENOSPC)}\n"
    )


def test_rows_of_a_csv_at_equal_intervals(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    """18 ms of a pass in steps of 50 us: 360 rows, the last one before the end, the peak not cut."""
    file = tmp_path / "pass.csv"
    given = ["cue_and_impact", "--csv", str(file)]
    assert command.main([*given, "--interval", "50us"]) == 0
    head, *rows = file.read_text(encoding="utf-8").splitlines()
    times = [float(row.split(",")[0]) for row in rows]
    assert head.startswith("time (s),hub_angle (rad),angle_1 (rad)")
    assert len(rows) == 360
    assert times == pytest.approx([5e-5 * row for row in range(360)], abs=1e-15)
    capsys.readouterr()
    for options, words in (
        (["--interval", "0"], "interval = '0': must be a finite number with 0 < interval"),
        (["--interval", "1ns"], "--interval = 1e-09 s: must give at most 1000000 rows"),
    ):
        assert command.main([*given, *options]) == 2
        assert words in capsys.readouterr().err
    assert command.main(["cue_and_impact", "--interval", "50us"]) == 2
    assert "must be given with --csv" in capsys.readouterr().err
