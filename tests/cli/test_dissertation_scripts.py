"""The audit and the redrawn figures, as a person runs them; every script's contract is in test_scripts.py."""

from __future__ import annotations

import functools
import json
import runpy
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bristle_sim.cli import command
from bristle_sim.dissertation.audit import audit_rows
from bristle_sim.dissertation.figures import NUMBERS
from bristle_sim.theory.force_history import BALL

MEDIA = Path(__file__).parents[2] / "media"

audited = functools.cache(audit_rows)


@pytest.fixture(autouse=True)
def one_audit(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let all tests of this file show the rows of one audit, which takes seconds."""
    monkeypatch.setattr("bristle_sim.dissertation.audit.audit_rows", audited)


def document(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict[str, Any]:
    assert command.main([*arguments, "--json", "-"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert isinstance(found, dict)
    return found


def test_every_row_of_the_audit_has_a_verdict_that_the_counts_and_the_page_in_media_repeat(capsys):
    """On the page, digits may move by rounding from machine to machine; rows and words may not."""
    found = document(capsys, "dissertation_audit")
    rows = found["rows"]
    assert len(rows) == len({row["where"] for row in rows}) >= 120
    counts = Counter(row["status"] for row in rows)
    assert set(counts) == {"reproduced", "differs", "not computable"}
    reported = {row["name"]: row["simulated"] for row in found["quantities"]}
    assert (reported["rows_reproduced"], reported["rows_that_differ"]) == (
        counts["reproduced"],
        counts["differs"],
    )
    for row in rows:
        assert isinstance(row["printed"], float | str)
        assert (row["computed"] is None) == (row["status"] == "not computable")
        assert row["why"] or row["status"] != "differs"
    made = runpy.run_path(str(MEDIA / "make.py"))["audit_page"](audited())
    kept = (MEDIA / "audit.md").read_text(encoding="utf-8")
    places = [
        [line.split(" | ")[0] for line in text.splitlines() if line.startswith("|")]
        for text in (made, kept)
    ]
    assert places[0] == places[1]
    assert len(places[0]) > 150
    assert all(line.count(" | ") in (4, 5) for line in made.splitlines() if line.startswith("|"))


@pytest.mark.parametrize("show", ["all", "differs"])
def test_the_audit_fits_a_terminal(show: str, capsys):
    assert command.main(["dissertation_audit", "--set", f"show={show}"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 100
    body = lines[next(i for i, line in enumerate(lines) if line.startswith("where")) :]
    assert any(line.endswith("reproduced") for line in body) is (show == "all")
    assert any(line.endswith("differs") for line in body)


def test_one_figure_alone(tmp_path: Path, capsys):
    """``--only`` is short for its key. A name that ends in .pdf is a file like in every script, replaced if it exists."""
    by_option = document(
        capsys, "dissertation_figures", "--only", "4.6", "--plot", str(tmp_path / "figures")
    )
    by_key = document(
        capsys, "dissertation_figures", "--set", "only=4.6", "--plot", str(tmp_path / "figures.pdf")
    )
    assert by_option["quantities"] == by_key["quantities"]
    assert (by_option["parameters"], by_option["outcome"]) == ({"only": "4.6"}, None)
    assert [path.name for path in (tmp_path / "figures").iterdir()] == ["figure_4.6.png"]
    assert (
        command.main(
            ["dissertation_figures", "--only", "4.6", "--plot", str(tmp_path / "figures.pdf")]
        )
        == 0
    )
    assert (tmp_path / "figures.pdf").read_bytes().startswith(b"%PDF")
    assert {path.name for path in tmp_path.iterdir()} == {"figures", "figures.pdf"}


@pytest.mark.nightly
def test_every_figure(tmp_path: Path, capsys):
    found = document(capsys, "dissertation_figures", "--plot", str(tmp_path))
    computed = (
        " ".join([f"2.{i}" for i in range(7, 25)]) + " 2.26 2.28 2.29 2.30 3.1 3.2 3.3 table_3.1"
    )
    assert " ".join(NUMBERS) == f"{computed} 4.2 4.3 4.6 4.13 4.14 4.15 4.16 4.17 4.19"
    names = [number if number.startswith("table") else f"figure_{number}" for number in NUMBERS]
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(
        f"{name}.png" for name in names
    )
    assert all(
        path.stat().st_size > 20_000 for path in tmp_path.iterdir()
    )  # an empty page takes less
    rows = found["quantities"]
    assert {row["name"].rpartition("_")[0] for row in rows} == {
        name for name in names if name != "table_3.1"
    }


def test_points_of_a_file_are_fitted_and_drawn(tmp_path: Path, capsys):
    """A ball's impact: a bristle on a turning hub has no such contact, so that there is nothing to compare."""
    points = tmp_path / "ball.csv"
    picture = tmp_path / "picture.png"
    time = np.linspace(0.0, 5e-3, 51)
    lines = [f"{t:.9g};{f:.9g}" for t, f in zip(time, BALL(time), strict=True)]
    points.write_text("\n".join(["time (s);force (N)", *lines]))
    found = document(
        capsys, "force_history", "--set", f"force_csv={points}", "--plot", str(picture)
    )
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert (found["parameters"]["force_csv"], found["outcome"]) == (str(points), None)
    assert all(row["simulated"] is None and row["ok"] is None for row in found["quantities"][:3])
    # (3.5) peaks at 340.75 N and 2.329 ms and carries 0.46288 N s; its offset is rounded by 0.02 %.
    fitted = {row["name"]: row["theory"] for row in found["quantities"]}
    for name, value in {
        "peak_force": 340.75,
        "compression_time": 2.329e-3,
        "compressive_impulse": 0.46288,
    }.items():
        assert fitted[name] == pytest.approx(value, rel=1e-3)
