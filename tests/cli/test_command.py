"""The command ``bristle-sim``: it lists the scenarios, and runs one as its script does; ``--parameters`` reads a tool."""

from __future__ import annotations

import json
import math
import os
import runpy
import subprocess
import sys
import zipfile
from functools import partial
from pathlib import Path

import pytest

import bristle_sim
from bristle_sim import version as versions
from bristle_sim.cli import command
from bristle_sim.cli.scenario import script_paths
from bristle_sim.parameters import Bar, Hub, Tool
from bristle_sim.tool_file import read_tool, write_tool
from bristle_sim.version import commit

ROOT = Path(__file__).parents[2]


def test_alone_it_lists_every_scenario_with_its_question(capsys: pytest.CaptureFixture[str]):
    assert command.main([]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("usage: bristle-sim SCENARIO")
    listed = lines[2 : lines.index("", 2)]
    assert [line.split()[0] for line in listed] == sorted(
        path.stem for path in (ROOT / "scenarios").glob("*.py")
    )
    assert all(line.endswith("?") for line in listed)


def test_help_and_version(capsys: pytest.CaptureFixture[str]):
    known = f" (commit {commit()})" if commit() else ""  # an unpacked archive knows none
    assert command.main(["--version"]) == 0
    assert capsys.readouterr().out == f"bristle-sim {bristle_sim.__version__}{known}\n"
    assert command.main(["--help"]) == 0
    out = capsys.readouterr().out
    assert out.startswith(command.overview())
    assert "--list-keys" in out


# argcomplete leaves its stream to the garbage collector.
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize(
    ("line", "completed"),
    [
        ("bristle-sim cue_t", ["cue_timing"]),
        ("bristle-sim exp", ["explore"]),
        ("bristle-sim cue_and_impact --set hub_r", ["hub_radius="]),
        ("bristle-sim cue_and_impact --set contact=e", ["energetic", "engine"]),
        ("bristle-sim cue_and_impact --sweep frict", ["friction="]),
        ("bristle-sim single_pendulum --list", ["--list-keys"]),
    ],
)
def test_a_shell_completes_scenarios_options_and_keys(
    line: str, completed: list[str], tmp_path: Path, monkeypatch
):
    """As the shell asks: the line in the environment, the answer in the file that the environment names."""
    pytest.importorskip("argcomplete")
    asked = {"_ARGCOMPLETE": "1", "COMP_LINE": line, "COMP_POINT": str(len(line)), "COMP_TYPE": "9"}
    asked |= {
        f"_ARGCOMPLETE_{name}": value
        for name, value in {"IFS": "\n", "COMP_WORDBREAKS": " =:"}.items()
    }
    asked["_ARGCOMPLETE_STDOUT_FILENAME"] = str(tmp_path / "answer")
    for name, value in asked.items():
        monkeypatch.setenv(name, value)
    monkeypatch.delattr(os, "fdopen")  # by which it would take the tests' ninth file
    with pytest.raises(SystemExit):
        command.main([])
    assert [each.rstrip() for each in (tmp_path / "answer").read_text().split("\n")] == completed


def test_a_distribution_carries_its_commit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Built from a checkout it has a file; without file and checkout nothing is known."""
    package = tmp_path / "lib" / "site-packages" / "bristle_sim"
    package.mkdir(parents=True)
    monkeypatch.setattr(versions, "__file__", str(package / "version.py"))
    assert versions.commit.__wrapped__() == ""
    (package / "commit.txt").write_text("0123456789ab\n")
    assert versions.commit.__wrapped__() == "0123456789ab"


def test_the_module_does_what_the_script_does(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    script = partial(runpy.run_path, str(ROOT / "scenarios" / "oblique_impact.py"))
    module = partial(runpy.run_module, "bristle_sim")
    found = []
    for started, words in ((script, []), (module, ["oblique_impact"])):
        monkeypatch.setattr(
            sys, "argv", ["started", *words, "--set", "friction=0.2", "--json", "-"]
        )
        with pytest.raises(SystemExit) as ended:
            started(run_name="__main__")
        assert ended.value.code == 0
        document = json.loads(capsys.readouterr().out)
        found.append((document["parameters"], document["quantities"]))
    assert found[0] == found[1]


def test_an_installed_package_runs_in_an_empty_folder(tmp_path: Path):
    """A wheel unpacked: the package with the scripts in it, and no work tree beside."""
    site = tmp_path / "site"
    empty = tmp_path / "empty"
    empty.mkdir()
    with zipfile.ZipFile(tmp_path / "package.zip", "w") as archive:
        package = Path(bristle_sim.__file__).parent
        scripts = next(
            iter(script_paths().values())
        ).parent  # in the package already, if this is installed
        for folder, place in {package: "bristle_sim", scripts: "bristle_sim/scenarios"}.items():
            for path in folder.rglob("*"):
                if (folder == scripts or scripts not in path.parents) and path.suffix in (
                    ".py",
                    ".jinja",
                    ".mplstyle",
                    ".html",
                    ".js",
                    ".css",
                    ".toml",
                ):
                    archive.write(path, f"{place}/{path.relative_to(folder).as_posix()}")
        archive.extractall(site)
    arguments = [
        sys.executable,
        "-m",
        "bristle_sim",
        "single_pendulum",
        "--report",
        "page.html",
        "--json",
        "-",
    ]
    environment = {**os.environ, "PYTHONPATH": str(site)}
    found = subprocess.run(
        arguments, capture_output=True, text=True, check=True, cwd=empty, env=environment
    )
    assert json.loads(found.stdout)["parameters"]["friction"] > 0.0
    assert [path.name for path in empty.iterdir()] == ["page.html"]
    page = (empty / "page.html").read_text(encoding="utf-8")
    assert "bristle-sim single_pendulum --report page.html" in page


def test_a_tool_file_gives_parameters_and_set_overrides_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    """A value that has no effect on the scenario is named."""
    path = tmp_path / "tool.toml"
    warning = "bar_friction = 0.1 has no effect on oblique_impact\n"
    for bar, more, speed in (
        (None, [], 300.0),
        (None, ["--set", "hub_speed=280"], 280.0),
        (Bar(friction=0.1), [], 300.0),
    ):
        write_tool(Tool(hub=Hub(speed=300.0), bar=bar), path)
        assert (
            command.main(["oblique_impact", "--parameters", str(path), *more, "--json", "-"]) == 0
        )
        out, err = capsys.readouterr()
        assert json.loads(out)["parameters"]["hub_speed"] == speed
        assert err == (f"bristle-sim oblique_impact: warning: {path}: {warning}" if bar else "")


@pytest.mark.parametrize(
    ("line", "bar"),
    [
        ("cue_and_impact --set hub_speed=280", Bar().centre),
        # By two independent computations the bar's place for a radial strike, to 5 um.
        ("cue_map --set reference=no --set map_points=3", (-0.05120, -0.02054)),
    ],
)
def test_the_tool_that_was_run_or_found_is_written(
    line: str, bar: tuple[float, float], tmp_path: Path
):
    path = tmp_path / "tool.toml"
    assert command.main([*line.split(), "--write-tool", str(path)]) == 0
    found = read_tool(path)
    assert found.bar is not None
    assert found.bar.centre == pytest.approx(bar, abs=5e-6)
    assert found.hub.speed == (280.0 if "280" in line else Hub().speed)


def test_limits_are_printed_and_written(capsys: pytest.CaptureFixture[str]):
    """A tip on a rod sticks from mu = tan phi on; the angle of the wire at the strike is that of the scene, to a microradian."""
    strike = bristle_sim.simulate(Tool(), stop_after="strike").first_contact("workpart")
    assert strike is not None
    expected = abs(math.tan(strike.angles[0]))
    assert command.main(["limits", "friction=0.1:0.6", "--json", "-"]) == 0
    (change,) = json.loads(capsys.readouterr().out)["changes"]
    assert change["at"] == pytest.approx(expected, abs=1e-5)
    assert command.main(["limits", "hub_speed=250:255", "--set", "friction=0.2"]) == 0
    assert "does not change" in capsys.readouterr().out
    for wrong in ("friction", "friction=0.1", "frict=0:1", "contact=a:b", "friction=0.1:0.1"):
        assert command.main(["limits", wrong]) == 2
        assert capsys.readouterr().err.count("\n") == 1
