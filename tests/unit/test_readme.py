"""What README shows must run, and what it says comes out must come out."""

from __future__ import annotations

import contextlib
import itertools
import json
import re
import runpy
import shlex
import sys
from pathlib import Path
from typing import Any

import pytest

from bristle_sim.cli import command
from bristle_sim.dissertation import figures

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
PYTHON = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
SHELL = [
    line.split("#")[0].strip()
    for block in re.findall(r"```sh\n(.*?)```", README, re.DOTALL)
    for line in block.splitlines()
]
COMMANDS = [line for line in SHELL if line.startswith("bristle-sim")]

SLOW = ("accuracy_cost", "hard_cases")
"""Scenarios that take minutes; their own tests run them."""


def test_the_python_example_runs(capsys: pytest.CaptureFixture[str]) -> None:
    names: dict[str, Any] = {}
    for block in PYTHON:
        exec(compile(block, "README.md", "exec"), names)
    outcome, rate = capsys.readouterr().out.splitlines()
    assert outcome.startswith("rebound at ")
    assert float(rate.split()[-2]) == pytest.approx(names["strike"].rates_before[0], abs=0.05)


def test_a_front_page_has_two_pages() -> None:
    assert len(README.split()) <= 1000
    assert len((ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").split()) <= 900


@pytest.mark.parametrize("line", COMMANDS)
def test_the_commands_run(
    line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The films of small scenes are filmed elsewhere; slow scenarios only read their keys here."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "media").mkdir()
    _, *arguments = shlex.split(line)
    if "--video" in arguments:
        at = arguments.index("--video")
        del arguments[at : at + 2]
    if arguments and arguments[0] in SLOW:
        arguments.append("--list-keys")
    assert command.main(arguments) == 0
    assert capsys.readouterr().out
    files = [
        value
        for option, value in itertools.pairwise(arguments)
        if option in ("--csv", "--json", "--plot")
    ]
    assert all(
        (tmp_path / name).stat().st_size > 0 for name in files if "--list-keys" not in arguments
    )


def test_what_draws_the_other_media_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With one figure on the sheet instead of all."""
    (line,) = re.findall(r"^python media/make.py .*$", README, re.MULTILINE)
    _, script, *files = shlex.split(line)
    (tmp_path / "media").mkdir()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [script, *files])
    monkeypatch.setattr(figures, "NUMBERS", figures.NUMBERS[:1])
    with contextlib.suppress(SystemExit):
        runpy.run_path(str(ROOT / script), run_name="__main__")
    assert all(Path(name).stat().st_size > 1000 for name in files)


ROWS = {
    "retraction at the last touch of the bar": ("release_retraction_deg", 1.0),
    "largest retraction before the strike": ("largest_retraction_deg", 1.0),
    "time of the strike": ("contact_time", 1e3),
    "lag behind the radial direction at the strike": ("lag_deg_at_contact", 1.0),
    "bristle's speed relative to the hub at the strike": ("relative_speed_at_contact", 1.0),
    "tip speed at the strike": ("tip_speed_at_contact", 1.0),
    "final normal impulse": ("normal_final_impulse", 1e3),
    "bristle's rate after the strike, over before": ("rebound_ratio", 1.0),
}
"""Rows of README's table: the quantity's name in the JSON, and what converts it to the unit shown."""


def test_the_results_are_those_that_come_out(capsys: pytest.CaptureFixture[str]) -> None:
    """To half a unit of the last digit shown."""
    assert command.main(["cue_and_impact", "--json", "-"]) == 0
    found = {row["name"]: row for row in json.loads(capsys.readouterr().out)["quantities"]}
    table = README[README.index("| quantity | simulated") :].split("\n\n")[0].splitlines()[2:]
    rows = {cells[1].strip(): cells[2:5] for cells in (line.split("|") for line in table)}
    assert rows.keys() == ROWS.keys()
    for label, cells in rows.items():
        name, factor = ROWS[label]
        for side, cell in zip(("simulated", "theory", "printed"), cells, strict=True):
            shown = re.match(r"-?[\d.]+", cell.strip().replace("\N{MINUS SIGN}", "-"))
            value = found[name][side]
            if shown is None:
                assert side == "printed"
                continue
            decimals = len(shown[0].partition(".")[2])
            assert f"{factor * value:.{decimals}f}" == shown[0], (label, side)


def test_the_costs_are_those_of_the_kept_results() -> None:
    assert runpy.run_path(str(ROOT / "docs" / "keep.py"))["costs"]() in README


def test_every_scenario_is_in_the_table() -> None:
    table = README[README.index("| scenario | question") :].split("\n\n")[0]
    assert set(re.findall(r"`(\w+)`", table)) == {
        path.stem for path in (ROOT / "scenarios").glob("*.py")
    }


def test_named_files_and_headings_exist() -> None:
    """A picture is named in the commands that make it."""
    links = set(re.findall(r"\]\(([^)]+)\)", README))
    headings = {
        re.sub(r"[^\w -]", "", each.lower()).replace(" ", "-")
        for each in re.findall(r"^#+ (.*)", README, re.M)
    }
    for link in links:
        assert link[1:] in headings if link.startswith("#") else (ROOT / link).exists(), link
    pages = "".join(page.read_text(encoding="utf-8") for page in (ROOT / "docs").rglob("*.md"))
    pictures = {link for link in links if link.startswith("media/")} | set(
        re.findall(r"media/[\w.]+", pages)
    )
    assert pictures == {
        word for line in SHELL for word in line.split() if re.match(r"media/.*(?<!\.py)$", word)
    }


def test_files_of_the_package_that_pages_name_exist() -> None:
    known = {path.relative_to(ROOT).as_posix() for path in (ROOT / "src").rglob("*")}
    for page in (*(ROOT / "docs").rglob("*.md"), ROOT / "CONTRIBUTING.md"):
        for named in re.findall(r"`((?:\w+/)*\w+\.py)`", page.read_text(encoding="utf-8")):
            assert (
                any(f"/{path}".endswith(f"/{named}") for path in known) or (ROOT / named).exists()
            ), (page, named)
