"""The scripts of chapters 3 and 4, the audit and the redrawn figures, as a person runs them.

What every script owes is in test_scripts.py; here is what these four owe besides.
"""

from __future__ import annotations

import contextlib
import functools
import importlib.util
import io
import json
import runpy
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bristle_sim.cli import Scenario, main
from bristle_sim.dissertation.audit import audit_rows
from bristle_sim.dissertation.figures import NUMBERS
from bristle_sim.theory.force_history import BALL

ROOT = Path(__file__).parents[2]
PNG = b"\x89PNG"


@functools.cache
def scenario(name: str) -> Scenario:
    spec = importlib.util.spec_from_file_location(f"scenario_{name}", ROOT / "scenarios" / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    found = module.SCENARIO
    assert isinstance(found, Scenario)
    return found


@dataclass(frozen=True)
class Ended:
    """How a script ended and what it said."""

    returncode: int
    stdout: str
    stderr: str


def ended(call: Callable[[], int]) -> Ended:
    with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.redirect_stderr(io.StringIO()) as err:
        status = call()
    return Ended(status, out.getvalue(), err.getvalue())


def run(name: str, *arguments: str) -> Ended:
    """In this process; test_scripts.py shows that it makes no difference."""
    return ended(lambda: main(scenario(name), arguments))


def document(name: str, *arguments: str) -> dict[str, Any]:
    found = run(name, "--json", "-", *arguments)
    assert found.stderr == ""
    parsed = json.loads(found.stdout)
    assert isinstance(parsed, dict)
    return parsed


def quantity(found: dict[str, Any], name: str) -> dict[str, Any]:
    row = next(row for row in found["quantities"] if row["name"] == name)
    assert isinstance(row, dict)
    return row


def refused(found: Ended, *words: str) -> None:
    assert (found.returncode, found.stdout) == (2, "")
    assert found.stderr.count("\n") == 1
    for word in words:
        assert word in found.stderr


def test_force_history_beside_print():
    found = document("force_history")
    peak = quantity(found, "peak_force")
    # Printed to the newton.
    assert peak["theory"] == pytest.approx(peak["printed"], abs=0.5)
    assert quantity(found, "compression_time")["ok"] is True
    assert quantity(found, "compressive_impulse")["ok"] is True


def test_force_history_of_measured_points(tmp_path: Path):
    """A ball's impact, sampled exactly: a bristle on a turning hub has no such contact, so that there is nothing to compare."""
    time = np.linspace(0.0, 5e-3, 51)
    lines = [f"{t:.9g};{f:.9g}" for t, f in zip(time, BALL(time), strict=True)]
    path = tmp_path / "ball.csv"
    path.write_text("\n".join(["time (s);force (N)", *lines]))
    found = document("force_history", "--set", f"force_csv={path}")
    picture = tmp_path / "picture.png"
    assert run("force_history", "--set", f"force_csv={path}", "--plot", str(picture)).returncode == 0
    assert picture.read_bytes().startswith(PNG)
    assert all(row["simulated"] is None and row["ok"] is None for row in found["quantities"][:3])
    # (3.5) peaks at 340.75 N and 2.329 ms and carries 0.46288 N s; its offset is rounded by 0.02 %.
    assert quantity(found, "peak_force")["theory"] == pytest.approx(340.75, rel=1e-3)
    assert quantity(found, "compression_time")["theory"] == pytest.approx(2.329e-3, rel=1e-3)
    assert quantity(found, "compressive_impulse")["theory"] == pytest.approx(0.46288, rel=1e-3)
    assert found["parameters"]["force_csv"] == str(path)
    assert found["outcome"] is None


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (None, ("force_csv", "must be a readable file")),
        ("0,0\n1,nan\n2,1\n3,0\n", ("force_csv", "line 2", "nan", "must be a finite number")),
        ("0,0\n1,1\n0.5,2\n1,1\n", ("line 3", "more than the time before")),
        ("a,b,c\n0,1,2\n1,2,3\n", ("columns 2 (b), 3 (c)", "force_column")),
        ("", ("force_csv", "must have columns of time and force")),
    ],
)
def test_force_files_that_are_none(tmp_path: Path, text: str | None, words: tuple[str, ...]):
    path = tmp_path / "points.csv"
    if text is not None:
        path.write_text(text)
    picture = tmp_path / "picture.png"
    refused(run("force_history", "--plot", str(picture), "--set", f"force_csv={path}"), *words)
    assert not picture.exists()


def test_crater_depth_beside_print():
    found = document("crater_depth")
    depth = quantity(found, "merchant_crater_depth")
    # 139.40 um with 300 plies, 142.09 in the limit.
    assert depth["theory"] == pytest.approx(1.3940e-4, abs=5e-9)
    assert quantity(found, "merchant_crater_depth_limit")["theory"] == pytest.approx(1.4209e-4, abs=5e-9)
    for name in ("merchant_crater_depth", "merchant_crater_depth_limit", "energy_crater_depth"):
        assert quantity(found, name)["simulated"] is None, "nothing of it is simulated"
    assert quantity(found, "contact_work")["ok"] is True
    assert found["measured_crater_depth"] == 1.3e-4


def test_crater_depth_without_a_chip(tmp_path: Path):
    picture = tmp_path / "picture.png"
    found = run("crater_depth", "--set", "friction=0.31", "--plot", str(picture))
    assert picture.read_bytes().startswith(PNG)
    assert found.returncode == 0
    assert "friction = 0.31: must be friction >= tan(impact_angle)" in found.stdout
    numbers = document("crater_depth", "--set", "friction=0.31")
    assert quantity(numbers, "merchant_crater_depth")["theory"] is None
    assert quantity(numbers, "merchant_crater_depth")["ok"] is None


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("plies=2.5", ("plies = '2.5'", "must be a whole number")),
        ("plies=0", ("plies = '0'", "whole number from 1 to 100000")),
        ("shear_yield_stress=-1", ("shear_yield_stress = '-1'", "in Pa")),
        ("impact_angle_deg=90", ("impact_angle_deg = '90'", "in deg")),
        ("hub_radius=4e-5", ("compression_time = 5e-05: must be shorter", "in s")),
    ],
)
def test_crater_parameters_out_of_range(setting: str, words: tuple[str, ...]):
    refused(run("crater_depth", "--json", "-", "--set", setting), *words)


def test_the_audit_has_every_row():
    parsed = document("dissertation_audit")
    rows = parsed["rows"]
    assert len(rows) >= 120
    assert len({row["where"] for row in rows}) == len(rows)
    counts = Counter(row["status"] for row in rows)
    assert set(counts) == {"reproduced", "differs", "not computable"}
    reported = [quantity(parsed, name)["simulated"] for name in ("rows_reproduced", "rows_that_differ")]
    assert reported == [counts["reproduced"], counts["differs"]]
    for row in rows:
        assert isinstance(row["printed"], float | str)
        assert (row["computed"] is None) == (row["status"] == "not computable")
        assert row["why"] or row["status"] != "differs"


@pytest.mark.parametrize("show", ["all", "differs"])
def test_the_audit_fits_a_terminal(show: str):
    lines = run("dissertation_audit", "--set", f"show={show}").stdout.splitlines()
    assert max(map(len, lines)) <= 100
    body = lines[next(i for i, line in enumerate(lines) if line.startswith("where")) :]
    assert any(line.endswith("reproduced") for line in body) is (show == "all")
    assert any(line.endswith("differs") for line in body)


def test_the_audit_page_is_what_its_script_makes():
    """The page in media/ is up to date: digits may move by rounding from machine to machine, rows and words may not."""
    media = ROOT / "media"
    make = runpy.run_path(str(media / "make.py"))
    made, kept = make["audit_page"](audit_rows()), (media / "audit.md").read_text(encoding="utf-8")
    places = [[line.split(" | ")[0] for line in text.splitlines() if line.startswith("|")] for text in (made, kept)]
    assert places[0] == places[1]
    assert len(places[0]) > 150
    assert all(line.count(" | ") in (4, 5) for line in made.splitlines() if line.startswith("|"))


def test_figures_on_the_pages_of_one_pdf(tmp_path: Path):
    """A name that ends in .pdf is a file like in every script, an existing one is replaced; one page a figure."""
    target = tmp_path / "figures.pdf"
    for _ in range(2):
        found = run("dissertation_figures", "--only", "4.6", "--plot", str(target))
        assert (found.returncode, found.stderr) == (0, f"--plot: wrote {target}\n")
        assert target.read_bytes().startswith(b"%PDF")
    assert list(tmp_path.iterdir()) == [target]


@pytest.mark.parametrize("name", ["dissertation_audit", "dissertation_figures"])
def test_no_impact_is_asked_about(name: str):
    assert document(name, *(["--only=4.6"] if name == "dissertation_figures" else []))["outcome"] is None


def test_the_option_is_short_for_the_key():
    by_option, by_key = (document("dissertation_figures", *each) for each in (["--only=4.6"], ["--set", "only=4.6"]))
    assert by_option["parameters"] == {"only": "4.6"}
    assert by_option["quantities"] == by_key["quantities"]


@pytest.mark.parametrize("number", ["2.25", "", "2.7 ", "4.18"])
def test_no_such_figure(number: str, tmp_path: Path):
    folder = tmp_path / "pictures"
    refused(run("dissertation_figures", "--only", number, "--plot", str(folder)), f"only = {number!r}", "2.24")
    assert not folder.exists()


def test_every_figure(tmp_path: Path):
    found = run("dissertation_figures", "--plot", str(tmp_path), "--json", "-")
    assert found.returncode == 0
    names = [number if number.startswith("table") else f"figure_{number}" for number in NUMBERS]
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(f"{name}.png" for name in names)
    for path in tmp_path.iterdir():
        assert path.stat().st_size > 20_000  # an empty page takes less
    rows = json.loads(found.stdout)["quantities"]
    assert {row["name"].rpartition("_")[0] for row in rows} == {name for name in names if name != "table_3.1"}


def test_a_folder_that_is_none(tmp_path: Path):
    target = tmp_path / "file.png"
    target.write_text("")
    refused(run("dissertation_figures", "--only", "4.6", "--plot", str(target)), "--plot", "must be a folder")
    assert target.read_text() == ""
