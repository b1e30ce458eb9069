"""The scripts' command line, on a scenario that costs nothing: keys, table, JSON, files, pipes and exit status."""

from __future__ import annotations

import csv
import dataclasses
import errno
import io
import json
import logging
import math
import os
import signal
import subprocess
import sys
import time
import types
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bristle_sim import __version__
from bristle_sim.cli import Scenario, build, ending, main
from bristle_sim.comparison import Quantity, Report, Unfinished
from bristle_sim.parameters.experiments import Measurement
from bristle_sim.units import choice, quantity, validate


@dataclass(frozen=True)
class Body:
    mass: float = quantity(2.0, "mass", "kg", above=0.0, at_most=1e3, source="a source", meaning="how heavy it is")
    speed: float = quantity(0.5, "speed", "m/s", at_least=-10.0, at_most=10.0, source="another source")
    drag: float | None = quantity(None, "drag", "1", at_least=0.0, at_most=1.0, source="off", needs="law = plastic")
    inner: object = None

    def __post_init__(self) -> None:
        validate(self)


@dataclass(frozen=True)
class Law:
    name: str = choice("elastic", "law", ("elastic", "plastic"), source="a source")
    unused: float = quantity(1.0, "unused", "1", at_least=0.0, at_most=1.0, source="a source")

    def __post_init__(self) -> None:
        validate(self)


def run(values: Mapping[str, Any]) -> Report:
    body = build(Body, values)
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
        extra={"rows": [{"case": "a", "ok": np.bool_(True), "reached": math.nan}], "curve": np.array([1.0, np.inf])},
        subject=body,
    )


def draw(report: Report, path: Path) -> None:
    path.write_text(f"drawn {report.subject.mass}")


SCENARIO = Scenario(
    name="fake",
    question="Is momentum mass times speed? 100% of it?",
    parts=(Body, Law),
    run=run,
    plot=draw,
    video=draw,
    without=("unused",),
)


def refusal(capsys: pytest.CaptureFixture[str], *arguments: str, scenario: Scenario = SCENARIO) -> str:
    """The one line that refuses some arguments."""
    assert main(scenario, arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert err.startswith("fake.py: error: ")
    return err.removeprefix("fake.py: error: ").rstrip("\n")


def document(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict[str, Any]:
    main(SCENARIO, ["--json", "-", *arguments])
    out, err = capsys.readouterr()
    assert err == ""
    found = json.loads(out, parse_constant=lambda word: pytest.fail(f"{word} in JSON"))
    assert isinstance(found, dict)
    return found


def test_keys_come_from_the_declarations():
    keys = dataclasses.replace(SCENARIO, defaults={"speed": (4.0, "chosen")}).keys()
    assert {key: default for key, (_, default) in keys.items()} == {
        "mass": 2.0,
        "speed": 4.0,
        "drag": None,
        "law": "elastic",
    }


def test_a_default_of_the_script_has_its_own_source(capsys: pytest.CaptureFixture[str]):
    faster = dataclasses.replace(SCENARIO, defaults={"speed": (4.0, "chosen")})
    assert faster.keys()["speed"][0].source == "chosen"
    assert main(faster, ["--list-keys"]) == 0
    out = capsys.readouterr().out
    assert "(default: chosen)" in out
    assert "another source" not in out


def test_build_takes_what_the_values_name():
    assert build(Body, {"mass": 3.0, "law": "plastic"}) == Body(mass=3.0)
    with pytest.raises(ValueError, match="mass"):
        build(Body, {"mass": 0.0})


def test_the_table_is_printed(capsys: pytest.CaptureFixture[str]):
    assert main(SCENARIO, []) == 0
    out, err = capsys.readouterr()
    assert err == ""
    lines = out.splitlines()
    assert lines[0].split()[:4] == ["quantity", "unit", "simulated", "theory"]
    assert lines[2].split()[:5] == ["momentum", "N", "s", "1", "1"]
    assert lines[-3:] == ["", "outcome: rebound (compression slip, restitution stick)", "a remark"]
    assert main(dataclasses.replace(SCENARIO, run=lambda _: Report("no contact", ())), []) == 0
    assert capsys.readouterr().out.splitlines()[-2:] == ["", "outcome: no contact"]


def test_no_outcome_is_printed_where_no_impact_is_asked_about(capsys: pytest.CaptureFixture[str]):
    silent = dataclasses.replace(SCENARIO, run=lambda _: Report(None, (), remarks=("a remark",)))
    assert main(silent, []) == 0
    out = capsys.readouterr().out
    assert "outcome" not in out
    assert out.splitlines()[-2:] == ["", "a remark"]
    assert main(silent, ["--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["outcome"] is None


def test_long_remarks_are_wrapped_and_columns_are_not(capsys: pytest.CaptureFixture[str]):
    prose, columns = "word " * 40, "a  b  " * 40
    assert main(dataclasses.replace(SCENARIO, run=lambda _: Report(None, (), remarks=(prose, columns))), []) == 0
    lines = capsys.readouterr().out.splitlines()
    assert columns in lines
    assert max(len(line) for line in lines if line != columns) <= 100
    assert sum(line.count("word") for line in lines) == 40


def test_the_exit_status_tells_whether_all_agrees(capsys: pytest.CaptureFixture[str]):
    assert main(SCENARIO, ["--set", "speed=0.5"]) == 0
    assert main(SCENARIO, ["--set", "speed=0.6"]) == 1
    assert "NO" in capsys.readouterr().out


def test_settings_are_read_and_the_last_one_counts(capsys: pytest.CaptureFixture[str]):
    found = document(capsys, "--set", "mass=4", "--set=speed=-1e1", "--set", "law=plastic", "--set", "mass= 5")
    assert found["parameters"] == {"mass": 5.0, "speed": -10.0, "drag": None, "law": "plastic"}
    assert found["quantities"][0]["simulated"] == -50.0


def test_json_is_plain_finite_and_complete(capsys: pytest.CaptureFixture[str]):
    nothing = dict.fromkeys(("simulated", "theory", "reference", "printed", "relative_difference", "tolerance", "ok"))
    assert document(capsys) == {
        "scenario": "fake",
        "version": __version__,
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
                "relative_difference": 0.0,
            }
            | {"tolerance": 1e-9, "ok": True},
            nothing | {"name": "nothing", "label": "nothing", "unit": "1"},
        ],
        "phases": ["compression slip", "restitution stick"],
        "events": [{"name": "strike", "time": 0.25}],
        "cost": {"wall_s": 0.125, "steps": 7},
        "rows": [{"case": "a", "ok": True, "reached": None}],
        "curve": [1.0, None],
    }


def test_json_can_go_to_a_file_beside_the_table(capsys: pytest.CaptureFixture[str], tmp_path: Path):
    target = tmp_path / "out.json"
    target.write_text("old")
    assert main(SCENARIO, ["--json", str(target), "--set", "speed=0.6"]) == 1
    assert "quantity" in capsys.readouterr().out
    assert json.loads(target.read_text())["quantities"][0]["simulated"] == 1.2
    assert list(tmp_path.iterdir()) == [target]


def test_keys_are_listed_with_unit_default_range_and_source(capsys: pytest.CaptureFixture[str]):
    assert main(SCENARIO, ["--list-keys", "--set", "nonsense"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    head, below, rule, *lines = out.splitlines()
    assert head.split() == ["key", "default", "unit", "range"]
    assert below.strip() == "meaning (source of the default)"
    assert set(rule) == {"-"}
    assert [line.split()[0] for line in lines if not line.startswith(" ")] == ["mass", "speed", "drag", "law"]
    assert lines[0].split() == ["mass", "2", "kg", "0", "<", "mass", "<=", "1000"]
    assert lines[1].strip() == "how heavy it is (default: a source)"
    assert lines[4].split()[:3] == ["drag", "none", "1"]
    assert "only with law = plastic" in lines[5]
    assert lines[6].split() == ["law", "elastic", "word", "elastic", "|", "plastic"]
    assert max(map(len, out.splitlines())) <= 100


def help_text(scenario: Scenario, capsys: pytest.CaptureFixture[str]) -> str:
    with pytest.raises(SystemExit) as stop:
        main(scenario, ["--help"])
    assert stop.value.code == 0
    return capsys.readouterr().out


def test_help_shows_the_question_and_every_option(capsys: pytest.CaptureFixture[str]):
    out = help_text(SCENARIO, capsys)
    for expected in ("100% of it?", "--set KEY=VALUE", "--json FILE", "--plot FILE", "--video FILE", "--list-keys"):
        assert expected in out


@pytest.mark.parametrize(
    "text", ["abc", "", "nan", "inf", "-inf", "0", "-1", "1000.1", "1e999", "1_0", "0x1", "1,5", "1\n2"]
)
def test_bad_values_are_refused(text: str, capsys: pytest.CaptureFixture[str]):
    line = refusal(capsys, "--set", "speed=1", "--set", f"mass={text}")
    assert line == f"mass = {text!r}: must be a finite number with 0 < mass <= 1000 (in kg)"


@pytest.mark.parametrize("text", ["", "Elastic", "rubber", "elastic plastic", "law=elastic", "1"])
def test_bad_words_are_refused(text: str, capsys: pytest.CaptureFixture[str]):
    assert refusal(capsys, "--set", f"law={text}") == f"law = {text!r}: must be one of elastic | plastic"


@pytest.mark.parametrize("setting", ["", "mass", "mass 3", "mass:3"])
def test_malformed_settings_are_refused(setting: str, capsys: pytest.CaptureFixture[str]):
    assert refusal(capsys, "--set", setting) == f"--set {setting!r}: must be KEY=VALUE"


@pytest.mark.parametrize("key", ["", "unused", "inner", "__class__", "\udcff", "a\nb"])
def test_unknown_keys_are_refused(key: str, capsys: pytest.CaptureFixture[str]):
    line = refusal(capsys, "--set", f"{key}=1")
    assert line == f"--set {key + '=1'!r}: unknown key {key!r}; --list-keys shows all keys"


@pytest.mark.parametrize(
    ("key", "likely"), [("Mass", "mass"), (" mass", "mass"), ("mas", "mass"), ("sped", "speed"), ("LAW", "law")]
)
def test_a_misspelt_key_names_the_likely_one(key: str, likely: str, capsys: pytest.CaptureFixture[str]):
    line = refusal(capsys, "--set", f"{key}=1")
    assert line == f"--set {key + '=1'!r}: unknown key {key!r}; did you mean {likely}?"


def test_a_value_may_carry_a_unit(capsys: pytest.CaptureFixture[str]):
    found = document(
        capsys, "--set", "mass=2500 g", "--set", "speed=-3.6km/h", "--set", "law=plastic", "--set", "drag=20%"
    )
    # km/h through pint's own factors: roundings.
    assert found["parameters"] == {"mass": 2.5, "speed": pytest.approx(-1.0, rel=1e-15), "drag": 0.2, "law": "plastic"}


@pytest.mark.parametrize(("text", "unit"), [("2m", "m"), ("2 kg/s", "kg/s"), ("2xyz", "xyz"), ("2 deg", "deg")])
def test_a_unit_of_another_dimension_is_refused(text: str, unit: str, capsys: pytest.CaptureFixture[str]):
    line = refusal(capsys, "--set", f"mass={text}")
    assert line.startswith(f"mass = {text!r}: must be ")
    assert line.endswith(f"(in kg, to which {unit} cannot be converted)")


def test_a_key_without_effect_is_refused(capsys: pytest.CaptureFixture[str]):
    line = refusal(capsys, "--set", "drag=0.5")
    assert line == "drag = 0.5: must be left out unless law = plastic, or it has no effect"
    assert document(capsys, "--set", "drag=0.5", "--set", "law=plastic")["parameters"]["drag"] == 0.5


def test_a_default_without_effect_is_left_out(capsys: pytest.CaptureFixture[str]):
    """The script's default for one law does not stand in the way of another."""
    plastic = dataclasses.replace(SCENARIO, defaults={"law": ("plastic", "x"), "drag": (0.5, "x")})
    assert main(plastic, ["--json", "-", "--set", "law=elastic"]) == 0
    assert json.loads(capsys.readouterr().out)["parameters"]["drag"] is None


@pytest.mark.parametrize(
    ("setting", "warning"),
    [
        ("mass=2000 g", ""),
        ("mass=0.021", ""),
        ("mass=0.02", "mass = 0.02 kg is 0.01 times the default, 2 kg"),
        ("mass=200", "mass = 200 kg is 100 times the default, 2 kg; if it was meant in g: mass='200 g'"),
        ("mass=200000g", "mass = 200 kg is 100 times the default, 2 kg"),
        ("speed=0", ""),
        ("speed=-0.004", "speed = -0.004 m/s is -0.008 times the default, 0.5 m/s"),
    ],
)
def test_a_value_far_from_the_default_is_run_with_a_warning(
    setting: str, warning: str, capsys: pytest.CaptureFixture[str]
):
    """By a factor of 100 or more; zero is nothing's mistaken unit."""
    assert main(SCENARIO, ["--set", setting, "--json", "-"]) == (setting != "mass=2000 g")
    out, err = capsys.readouterr()
    assert json.loads(out)["scenario"] == "fake"
    assert err == (f"fake.py: warning: {warning}\n" if warning else "")


def test_a_refused_value_is_still_one_line(capsys: pytest.CaptureFixture[str]):
    """Values that do not fit together, one of them far off: the line that refuses them says so too."""
    line = refusal(capsys, "--set", "mass=500", "--set", "speed=5")
    assert line == (
        "mass = too much: must be less (in kg m/s);"
        " mass = 500 kg is 250 times the default, 2 kg; if it was meant in g: mass='500 g'"
    )


def test_values_that_do_not_fit_together_are_refused_in_one_line(capsys: pytest.CaptureFixture[str]):
    line = refusal(capsys, "--set", "mass=100", "--set", "speed=10")
    assert line == "mass = too much: must be less (in kg m/s)"


@pytest.mark.parametrize("error", [OverflowError, ZeroDivisionError, FloatingPointError])
def test_values_too_extreme_for_arithmetic_are_refused(
    error: type[ArithmeticError], capsys: pytest.CaptureFixture[str]
):
    def fail(_: Mapping[str, Any]) -> Report:
        raise error("out of range")

    extreme = dataclasses.replace(SCENARIO, run=fail)
    line = refusal(capsys, "--set", "mass=1e-300", "--set", "speed=3", scenario=extreme)
    assert line == (
        "mass=1e-300, speed=3: must be less extreme (out of range); mass = 1e-300 kg is 5e-301 times the default, 2 kg"
    )
    with pytest.raises(error):  # with no value typed it is nobody's input that is wrong
        main(extreme, [])


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["--unknown"], "--unknown"),
        (["--jso", "-"], "--jso"),
        (["mass=3"], "mass=3"),
        (["--set"], "--set"),
        (["--set", "--json"], "--set"),
        (["--json"], "--json"),
        (["--plot"], "--plot"),
        (["--list-keys=yes"], "--list-keys"),
    ],
)
def test_bad_options_are_refused_in_one_line_too(arguments: list[str], named: str, capsys: pytest.CaptureFixture[str]):
    assert named in refusal(capsys, *arguments)


def test_options_that_a_scenario_does_not_offer_are_refused(capsys: pytest.CaptureFixture[str]):
    plain = dataclasses.replace(SCENARIO, plot=None, video=None)
    for option in ("--plot", "--video"):
        assert option in refusal(capsys, option, "a.png", scenario=plain)
    assert main(plain, []) == 0


@pytest.mark.parametrize(("option", "suffixes"), [("--plot", ".png, .svg, .pdf"), ("--video", ".mp4, .gif")])
def test_bad_targets_are_refused_before_anything_runs(
    option: str, suffixes: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
):
    idle = dataclasses.replace(SCENARIO, run=lambda _: pytest.fail("ran"))
    suffix = suffixes.split(", ", maxsplit=1)[0]
    (tmp_path / "file").write_text("a file")
    (tmp_path / f"folder{suffix}").mkdir()
    for name in ("", "out", "out.txt", f"out{suffix}.bak", suffix):
        line = refusal(capsys, option, str(tmp_path / name) if name else "", scenario=idle)
        assert line.startswith(f"{option} = ")
        assert line.endswith(f": must be a file name that ends in {suffixes}")
    folder = refusal(capsys, option, str(tmp_path / f"folder{suffix}"), scenario=idle)
    assert folder == f"{option} = {str(tmp_path / f'folder{suffix}')!r}: must be a file, not a folder"
    for parent in ("nowhere", "file"):
        target = tmp_path / parent / f"out{suffix}"
        line = refusal(capsys, option, str(target), scenario=idle)
        assert line == f"{option} = {str(target)!r}: must be in an existing, writable folder"
    assert "File name too long" in refusal(capsys, option, str(tmp_path / ("x" * 5000 + suffix)), scenario=idle)
    assert sorted(each.name for each in tmp_path.iterdir()) == ["file", f"folder{suffix}"]


def test_a_folder_that_cannot_be_written_is_refused(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch):
    monkeypatch.setattr(os, "access", lambda *_: False)
    assert "writable" in refusal(capsys, "--json", str(tmp_path / "out.json"))


def test_pictures_and_videos_are_drawn_when_asked_for(capsys: pytest.CaptureFixture[str], tmp_path: Path):
    plot, video = tmp_path / "plot.SVG", tmp_path / "film.gif"
    assert main(SCENARIO, ["--plot", str(plot), "--video", str(video), "--json", "-", "--set", "mass=2"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["scenario"] == "fake"
    assert err == f"--plot: wrote {plot}\n--video: wrote {video}\n"
    assert plot.read_text() == video.read_text() == "drawn 2.0"


def test_a_plot_folder(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch):
    def draw_all(report: Report, folder: Path) -> None:
        folder.mkdir(exist_ok=True)
        draw(report, folder / "one.png")

    many = dataclasses.replace(SCENARIO, plot=draw_all, plot_is_folder=True)
    for _ in range(2):
        assert main(many, ["--plot", str(tmp_path / "figures")]) == 0
        assert (tmp_path / "figures" / "one.png").read_text() == "drawn 2.0"
    capsys.readouterr()
    (tmp_path / "file").write_text("a file")
    assert refusal(capsys, "--plot", str(tmp_path / "file"), scenario=many).endswith("must be a folder")
    assert "existing" in refusal(capsys, "--plot", str(tmp_path / "no" / "figures"), scenario=many)
    monkeypatch.setattr(os, "access", lambda folder, _: Path(folder) != tmp_path / "figures")
    assert "writable" in refusal(capsys, "--plot", str(tmp_path / "figures"), scenario=many)
    assert "--plot FOLDER" in help_text(many, capsys)


@pytest.mark.parametrize("error", [ValueError("nothing\nto draw"), OSError(errno.ENOSPC, "No space left")])
def test_a_failed_drawing_leaves_no_output_at_all(error: Exception, capsys: pytest.CaptureFixture[str], tmp_path: Path):
    def fail(_report: Report, _path: Path) -> None:
        raise error

    broken = dataclasses.replace(SCENARIO, plot=fail)
    for arguments in ([], ["--json", "-"], ["--json", str(tmp_path / "out.json")]):
        refusal(capsys, "--plot", str(tmp_path / "plot.png"), *arguments, scenario=broken)
    assert not list(tmp_path.iterdir())


def test_a_failed_write_leaves_the_old_file(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch):
    target = tmp_path / "out.json"
    target.write_text("old")

    def half(path: Path, text: str, **_: Any) -> None:
        with path.open("w") as stream:
            stream.write(text[:10])
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_text", half)
    assert "No space left" in refusal(capsys, "--json", str(target))
    assert target.read_text() == "old"
    assert list(tmp_path.iterdir()) == [target]


def test_a_time_series_is_written_one_row_a_sample(capsys: pytest.CaptureFixture[str], tmp_path: Path):
    """At full precision: a third and the smallest number above one survive."""
    columns = {"shape": ["a", "b"], "time (s)": np.array([1.0 / 3.0, 0.5]), "n": [math.nextafter(1.0, 2.0), math.nan]}
    moving, target = dataclasses.replace(SCENARIO, series=lambda _: columns), tmp_path / "run.csv"
    assert main(moving, ["--csv", str(target)]) == 0
    assert capsys.readouterr().err == f"--csv: wrote {target}\n"
    with target.open(newline="") as stream:
        assert list(csv.reader(stream)) == [
            ["shape", "time (s)", "n"],
            ["a", "0.3333333333333333", "1.0000000000000002"],
            ["b", "0.5", ""],
        ]
    assert "--csv" in refusal(capsys, "--csv", str(target))  # of a scenario without a motion


def test_a_series_that_is_refused_leaves_no_output(capsys: pytest.CaptureFixture[str], tmp_path: Path):
    def refuse(_: Report) -> dict[str, Any]:
        raise ValueError("law = elastic: must be plastic")

    instant = dataclasses.replace(SCENARIO, series=refuse)
    arguments = [
        "--csv",
        str(tmp_path / "a.csv"),
        "--plot",
        str(tmp_path / "a.png"),
        "--json",
        str(tmp_path / "a.json"),
    ]
    assert refusal(capsys, *arguments, scenario=instant) == "law = elastic: must be plastic"
    assert not list(tmp_path.iterdir())


def test_two_options_cannot_name_one_file(capsys: pytest.CaptureFixture[str], tmp_path: Path):
    target, link = tmp_path / "out.png", tmp_path / "link.json"
    link.symlink_to(target)
    for name in (target, link, tmp_path / ".." / tmp_path.name / "out.png"):
        line = refusal(capsys, "--plot", str(target), "--json", str(name))
        assert line == f"--json = {str(name)!r}: must be another file than that of --plot"
    assert list(tmp_path.iterdir()) == [link]


def test_an_input_file_is_not_overwritten(capsys: pytest.CaptureFixture[str], tmp_path: Path):
    points = tmp_path / "points.csv"
    points.write_text("0,0")
    measured = dataclasses.replace(SCENARIO, parts=(*SCENARIO.parts, Measurement))
    line = refusal(capsys, "--set", f"force_csv={points}", "--json", str(points), scenario=measured)
    assert line == f"--json = {str(points)!r}: must be another file than that of force_csv"
    assert points.read_text() == "0,0"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs named pipes")
def test_json_goes_through_a_named_pipe_and_into_devices(capsys: pytest.CaptureFixture[str], tmp_path: Path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    assert main(SCENARIO, ["--json", str(pipe)]) == 0
    assert json.loads(os.read(reader, 100_000))["scenario"] == "fake"
    os.close(reader)
    assert list(tmp_path.iterdir()) == [pipe]
    assert main(SCENARIO, ["--json", os.devnull]) == 0
    assert not Path(os.devnull).is_file()
    assert capsys.readouterr().err == ""


def test_ctrl_c_ends_with_one_line(capsys: pytest.CaptureFixture[str], tmp_path: Path):
    def interrupt(_: Mapping[str, Any]) -> Report:
        raise KeyboardInterrupt

    assert main(dataclasses.replace(SCENARIO, run=interrupt), ["--json", str(tmp_path / "a.json")]) == 130
    assert capsys.readouterr() == ("", "fake.py: interrupted\n")
    assert not list(tmp_path.iterdir())


def test_what_was_finished_before_ctrl_c_is_kept(capsys: pytest.CaptureFixture[str], tmp_path: Path):
    def interrupt(_: Mapping[str, Any]) -> Report:
        raise Unfinished(Report(None, (Quantity("first", "1", 1.0),), extra={"rows": [1]}))

    target, picture = tmp_path / "a.json", tmp_path / "a.png"
    long = dataclasses.replace(SCENARIO, run=interrupt)
    assert main(long, ["--json", str(target), "--plot", str(picture)]) == 130
    out, err = capsys.readouterr()
    assert "first" in out
    assert err == "fake.py: interrupted\n"
    found = json.loads(target.read_text())
    assert (found["rows"], found["finished"]) == ([1], False)
    assert list(tmp_path.iterdir()) == [target]
    assert "finished" not in document(capsys)


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize("terminal", [True, False])
def test_progress_is_shown_on_a_terminal_alone(terminal: bool, monkeypatch):
    def work(values: Mapping[str, Any]) -> Report:
        logging.getLogger("bristle_sim.studies.work").info("part 1 of 2")
        return run(values)

    monkeypatch.setattr(sys, "stderr", Terminal() if terminal else io.StringIO())
    assert main(dataclasses.replace(SCENARIO, run=work), []) == 0
    shown = sys.stderr.getvalue()
    assert ("fake.py: part 1 of 2" in shown) is terminal
    assert shown.endswith("\r\x1b[K") is terminal  # the line is cleared at the end
    assert not logging.getLogger("bristle_sim").handlers


FAKE = f"""
import importlib.util, sys
from bristle_sim.cli import main
spec = importlib.util.spec_from_file_location("fake", {__file__!r})
fake = importlib.util.module_from_spec(spec)
sys.modules["fake"] = fake
spec.loader.exec_module(fake)
sys.exit(main(fake.SCENARIO, sys.argv[1:]))
"""


SLOW = f"""
import dataclasses, importlib.util, sys, time, signal
from pathlib import Path
from bristle_sim.files import complete_or_absent
from bristle_sim.cli import main
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job ignores it
spec = importlib.util.spec_from_file_location("fake", {__file__!r})
fake = importlib.util.module_from_spec(spec)
sys.modules["fake"] = fake
spec.loader.exec_module(fake)

def draw(report, path):
    with complete_or_absent(path) as partial:
        partial.write_text("half")
        print("begun", flush=True)
        time.sleep(60)

sys.exit(main(dataclasses.replace(fake.SCENARIO, plot=draw), sys.argv[1:]))
"""


@pytest.mark.skipif(os.name == "nt", reason="signals of another kind")
@pytest.mark.parametrize(
    ("number", "status", "told"), [("SIGINT", 130, "fake.py: interrupted\n"), ("SIGTERM", 143, "")]
)
def test_a_signal_leaves_no_partial_file(number: str, status: int, told: str, tmp_path: Path):
    target = tmp_path / "a.png"
    command = [sys.executable, "-c", SLOW, "--plot", str(target)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "begun\n"
    assert len(list(tmp_path.iterdir())) == 1
    process.send_signal(getattr(signal, number))
    out, err = process.communicate(timeout=60)
    assert (process.returncode, out, err) == (status, "", told)
    assert not list(tmp_path.iterdir())


IN_CALLBACK = f"""
import dataclasses, importlib.util, os, signal, sys
import pymunk
from bristle_sim.cli import main
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job ignores it
spec = importlib.util.spec_from_file_location("fake", {__file__!r})
fake = importlib.util.module_from_spec(spec)
sys.modules["fake"] = fake
spec.loader.exec_module(fake)

def run(values):
    space, body = pymunk.Space(), pymunk.Body(1.0, 1.0)
    space.add(body)
    body.velocity_func = lambda *_: os.kill(os.getpid(), signal.SIGINT)
    space.step(0.1)
    body.velocity_func = pymunk.Body.update_velocity
    while True:
        space.step(0.1)

class Lost:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGINT)

def lose(values):
    Lost()
    while True:
        pass

sys.exit(main(dataclasses.replace(fake.SCENARIO, run=globals()[sys.argv[1]]), []))
"""


@pytest.fixture
def usual_handlers() -> Iterator[None]:
    """What a terminal's Python has, whatever the tests are run by."""
    usual = {signal.SIGINT: signal.default_int_handler, signal.SIGTERM: signal.SIG_DFL}
    before = {number: signal.signal(number, handler) for number, handler in usual.items()}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.usefixtures("usual_handlers")
@pytest.mark.parametrize(("number", "ended"), [(signal.SIGINT, KeyboardInterrupt), (signal.SIGTERM, SystemExit)])
def test_a_signal_ends_the_work_by_an_exception(number: signal.Signals, ended: type[BaseException]):
    with pytest.raises(ended), ending.ending_in_order():
        signal.raise_signal(number)
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL


@pytest.mark.usefixtures("usual_handlers")
def test_handlers_of_others_and_other_threads_are_left_alone():
    def inside() -> object:
        with ending.ending_in_order():
            return signal.getsignal(signal.SIGTERM)

    with ThreadPoolExecutor(1) as pool:
        assert pool.submit(inside).result() is signal.SIG_DFL
    signal.signal(signal.SIGINT, mine := lambda *_: None)
    signal.signal(signal.SIGTERM, mine)
    hook = sys.unraisablehook
    with ending.ending_in_order():
        assert signal.getsignal(signal.SIGINT) is signal.getsignal(signal.SIGTERM) is mine
        assert sys.unraisablehook is hook


@pytest.mark.usefixtures("usual_handlers")
def test_an_end_that_was_lost_comes_again_and_other_losses_are_told(monkeypatch: pytest.MonkeyPatch):
    told: list[object] = []
    monkeypatch.setattr(sys, "__unraisablehook__", told.append)
    lost = types.SimpleNamespace(exc_type=ValueError)

    def losing() -> None:
        sys.unraisablehook(lost)
        sys.unraisablehook(types.SimpleNamespace(exc_type=SystemExit))
        for _ in range(1000):  # a signal that a thread raises comes between two calls
            time.sleep(0.01)

    with pytest.raises(SystemExit), ending.ending_in_order():
        losing()
    assert told == [lost]


def test_ctrl_c_inside_the_hook_of_lost_exceptions_is_tried_again(monkeypatch: pytest.MonkeyPatch):
    """On a busy machine the repeated signal may come before the hook has ended, which would lose it once more."""
    tried = []

    def again(number: int) -> None:
        tried.append(number)
        if len(tried) == 1:
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(ending, "_try_again", again)
    monkeypatch.setattr(sys, "unraisablehook", sys.__unraisablehook__)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with ending.ending_in_order():
            sys.unraisablehook(types.SimpleNamespace(exc_type=KeyboardInterrupt))
    except KeyboardInterrupt:
        pytest.fail("the hook ends by an exception, which the interpreter forgets")
    finally:
        signal.signal(signal.SIGINT, before)
    assert tried == [signal.SIGINT, signal.SIGINT]


@pytest.mark.skipif(os.name == "nt", reason="signals of another kind")
@pytest.mark.parametrize("where", ["run", "lose"])
def test_ctrl_c_inside_a_callback_is_not_lost(where: str):
    """In a callback of the engine or a destructor an exception is printed and ignored; the work would go on."""
    command = [sys.executable, "-c", IN_CALLBACK, where]
    found = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    assert (found.returncode, found.stdout, found.stderr) == (130, "", "fake.py: interrupted\n")


@pytest.mark.skipif(os.name == "nt", reason="needs a POSIX shell")
def test_a_closed_standard_output_is_an_error(tmp_path: Path):
    target = tmp_path / "a.json"
    command = ["/bin/sh", "-c", 'exec "$0" "$@" >&-', sys.executable, "-c", FAKE, "--json", str(target)]
    found = subprocess.run(command, stderr=subprocess.PIPE, text=True, check=False)
    assert (found.returncode, found.stderr) == (2, "fake.py: error: standard output: must be open\n")
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(os.name == "nt", reason="needs a POSIX shell")
def test_messages_do_not_get_into_the_results(tmp_path: Path):
    """With standard error closed, print() to it would write to standard output."""
    command = ["/bin/sh", "-c", 'exec "$0" "$@" 2>&-', sys.executable, "-c", FAKE, "--json", "-"]
    found = subprocess.run([*command, "--plot", str(tmp_path / "a.png")], stdout=subprocess.PIPE, check=False)
    assert found.returncode == 0
    assert json.loads(found.stdout)["scenario"] == "fake"


def as_process(*arguments: str, **options: Any) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", FAKE, *arguments], stderr=subprocess.PIPE, text=True, stdin=subprocess.DEVNULL, **options
    )


@pytest.fixture
def pipe_without_reader() -> Iterator[int]:
    read, write = os.pipe()
    os.close(read)
    yield write
    os.close(write)


def test_a_reader_that_leaves_early_is_no_error(pipe_without_reader: int):
    """As of ``scenario.py | head -1``: no complaint at exit either."""
    process = as_process(stdout=pipe_without_reader)
    _, err = process.communicate(timeout=60)
    assert (err, process.returncode) == ("", 0)


@pytest.mark.parametrize("arguments", [[], ["--json", "-"], ["--list-keys"]])
def test_no_output_minds_a_reader_that_leaves(arguments: list[str], pipe_without_reader: int, capsys, monkeypatch):
    with os.fdopen(pipe_without_reader, "w", closefd=False) as out:
        monkeypatch.setattr(sys, "stdout", out)
        assert main(SCENARIO, arguments) == 0
        out.flush()  # what Python does at exit
    assert capsys.readouterr().err == ""


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_a_full_disk_is_an_error_in_one_line(capsys: pytest.CaptureFixture[str], monkeypatch):
    with Path("/dev/full").open("w") as out:
        monkeypatch.setattr(sys, "stdout", out)
        assert main(SCENARIO, []) == 2
        out.flush()
    assert capsys.readouterr().err == f"fake.py: error: standard output: {os.strerror(errno.ENOSPC)}\n"


def test_arguments_come_from_the_command_line_by_default(capsys: pytest.CaptureFixture[str], monkeypatch):
    monkeypatch.setattr(sys, "argv", ["fake.py", "--set", "mass=x"])
    assert main(SCENARIO) == 2
    assert "mass = 'x'" in capsys.readouterr().err
