"""The command ``bristle-sim``: it lists the scenarios, and runs one as its script does; ``--parameters`` reads a tool."""

from __future__ import annotations

import json
import os
import runpy
import subprocess
import sys
import zipfile
from functools import partial
from pathlib import Path
from typing import Any

import pytest

import bristle_sim
from bristle_sim.cli import command
from bristle_sim.parameters import Bar, Hub, Tool
from bristle_sim.tool_file import write_tool

ROOT = Path(__file__).parents[2]
NAMES = sorted(path.stem for path in (ROOT / "scenarios").glob("*.py"))


def test_alone_it_lists_every_scenario_with_its_question(capsys: pytest.CaptureFixture[str]):
    assert command.main([]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("usage: bristle-sim SCENARIO")
    listed = lines[2 : lines.index("", 2)]
    assert [line.split()[0] for line in listed] == NAMES
    assert all(line.endswith("?") for line in listed)


@pytest.mark.parametrize("name", NAMES)
def test_every_scenario_is_found_and_keeps_its_name(name: str, capsys: pytest.CaptureFixture[str]):
    assert command.main([name, "--list-keys"]) == 0
    assert command.load(command.scripts()[name]).name == name
    assert capsys.readouterr().out


def test_help_and_messages_name_the_command(capsys: pytest.CaptureFixture[str]):
    assert command.main(["--version"]) == 0
    assert capsys.readouterr().out == f"bristle-sim {bristle_sim.__version__}\n"
    assert command.main(["--help"]) == 0
    told = capsys.readouterr().out
    assert told.startswith(command.overview())
    assert "--list-keys" in told
    assert command.main(["single_pendulum", "--set", "rat=1"]) == 2
    assert capsys.readouterr().err == (
        "bristle-sim single_pendulum: error: --set 'rat=1': unknown key 'rat'; did you mean rate?\n"
    )


@pytest.mark.parametrize(
    ("name", "advice"), [("cue_and_imapct", "did you mean cue_and_impact?"), ("zzz", "bristle-sim alone lists")]
)
def test_an_unknown_scenario_is_refused_in_one_line(name: str, advice: str, capsys: pytest.CaptureFixture[str]):
    assert command.main([name]) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert advice in err


def test_misplaced_settings_are_told_where_they_belong(capsys: pytest.CaptureFixture[str]):
    assert command.main(["--set", "rate=1"]) == 2
    assert "--set: must come after the name of a scenario" in capsys.readouterr().err
    assert command.main(["single_pendulum", "rate=1"]) == 2
    assert capsys.readouterr().err.endswith("unrecognized arguments: rate=1; did you mean --set rate=1?\n")
    assert command.main(["tolerances", "--csv", "a.csv"]) == 2
    assert capsys.readouterr().err.endswith("--csv a.csv; bristle-sim tolerances --help lists the options\n")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_a_full_disk_is_an_error_in_one_line(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch):
    with Path("/dev/full").open("w") as out:
        monkeypatch.setattr(sys, "stdout", out)
        assert command.main([]) == 2
        out.flush()
    assert capsys.readouterr().err.startswith("bristle-sim: error: standard output: ")


def quantities(*words: str, **options: Any) -> Any:
    found = subprocess.run(
        [sys.executable, *words, "--json", "-"], capture_output=True, text=True, check=True, **options
    )
    document = json.loads(found.stdout)
    return document["parameters"], document["quantities"]


def test_the_module_does_what_the_script_does(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    script = partial(runpy.run_path, str(ROOT / "scenarios" / "oblique_impact.py"))
    module = partial(runpy.run_module, "bristle_sim")
    found = []
    for started, words in ((script, []), (module, ["oblique_impact"])):
        monkeypatch.setattr(sys, "argv", ["started", *words, "--set", "friction=0.2", "--json", "-"])
        with pytest.raises(SystemExit) as ended:
            started(run_name="__main__")
        assert ended.value.code == 0
        document = json.loads(capsys.readouterr().out)
        found.append((document["parameters"], document["quantities"]))
    assert found[0] == found[1]


def test_an_installed_package_runs_in_an_empty_folder(tmp_path: Path):
    """A wheel unpacked: the package with the scripts in it, and no work tree beside."""
    site, empty = tmp_path / "site", tmp_path / "empty"
    empty.mkdir()
    with zipfile.ZipFile(tmp_path / "package.zip", "w") as archive:
        package = Path(bristle_sim.__file__).parent
        for folder, place in ((package, "bristle_sim"), (ROOT / "scenarios", "bristle_sim/scenarios")):
            for path in (
                each
                for each in folder.rglob("*")
                if each.suffix in (".py", ".jinja", ".mplstyle", ".html", ".js", ".css")
            ):
                archive.write(path, f"{place}/{path.relative_to(folder).as_posix()}")
        archive.extractall(site)
    environment = {**os.environ, "PYTHONPATH": str(site)}
    arguments = ("-m", "bristle_sim", "single_pendulum", "--report", "page.html")
    parameters, _ = quantities(*arguments, cwd=empty, env=environment)
    assert parameters["friction"] > 0.0
    assert [path.name for path in empty.iterdir()] == ["page.html"]
    assert "bristle-sim single_pendulum --report page.html" in (empty / "page.html").read_text(encoding="utf-8")


def run(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[Any, str]:
    assert command.main([*arguments, "--json", "-"]) == 0
    out, err = capsys.readouterr()
    return json.loads(out)["parameters"], err


def test_a_tool_file_that_cannot_be_read_is_named_with_its_option(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    for path, reason in ((tmp_path / "none.toml", "No such file or directory"), (tmp_path, "Is a directory")):
        assert command.main(["cue_timing", "--parameters", str(path)]) == 2
        line = capsys.readouterr().err.strip()
        assert line.endswith(f"error: --parameters = '{path}': must be a readable file ({reason})")


def test_a_tool_file_gives_parameters_and_set_overrides_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    path = tmp_path / "tool.toml"
    write_tool(Tool(hub=Hub(speed=300.0), bar=None), path)
    arguments = ["oblique_impact", "--parameters", str(path)]
    parameters, err = run(arguments, capsys)
    assert (parameters["hub_speed"], err) == (300.0, "")
    assert run([*arguments, "--set", "hub_speed=280"], capsys)[0]["hub_speed"] == 280.0


def test_a_value_without_effect_on_the_scenario_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    path = tmp_path / "tool.toml"
    write_tool(Tool(bar=Bar(friction=0.1)), path)
    _, err = run(["oblique_impact", "--parameters", str(path)], capsys)
    assert err == (f"bristle-sim oblique_impact: warning: {path}: bar_friction = 0.1 has no effect on oblique_impact\n")


@pytest.mark.parametrize(
    ("text", "advice"),
    [
        ("hub_sped = 3", "unknown key 'hub_sped'; did you mean hub_speed?"),
        ("bar = false", "bar = false: must be present for cue_and_impact"),
        ("hub_speed = -1", "hub_speed = '-1': must be"),
    ],
)
def test_a_faulty_tool_file_is_refused_in_one_line(
    text: str, advice: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    (tmp_path / "tool.toml").write_text(text)
    assert command.main(["cue_and_impact", "--parameters", str(tmp_path / "tool.toml")]) == 2
    err = capsys.readouterr().err
    assert f"{tmp_path / 'tool.toml'}: {advice}" in err
    assert err.count("\n") == 1


def test_a_missing_tool_file_and_a_scenario_without_a_tool_are_refused(capsys: pytest.CaptureFixture[str]):
    assert command.main(["cue_and_impact", "--parameters", "nowhere.toml"]) == 2
    assert "nowhere.toml" in capsys.readouterr().err
    assert command.main(["dissertation_audit", "--parameters", "nowhere.toml"]) == 2
    assert "--parameters" in capsys.readouterr().err
