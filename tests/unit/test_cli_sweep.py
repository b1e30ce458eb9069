"""``--sweep`` on a scenario: table, files, reasons, and bad input in one line."""

from __future__ import annotations

import csv
import json
import sys
from pathlib import Path

import pytest

pytest.importorskip("zarr", reason="needs the extra sweep")

from bristle_sim.cli import command
from bristle_sim.studies.strike_point import strike_of_keys


def called(*words: str) -> int:
    return command.main(["cue_and_impact", *words])


def test_a_sweep_over_one_key_is_the_single_passes(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    """The bar at 60 mm is not touched: the point says why it has no release."""
    files = [f"--{kind}={tmp_path / f'sweep.{kind}'}" for kind in ("csv", "json")]
    store = f"--store={tmp_path / 'store'}"
    swept = ("--sweep", "bar_horizontal=50mm:60mm:3", "--set", "accuracy=1e-5", store)
    assert called(*swept, *files, f"--plot={tmp_path / 'lines.svg'}") == 0
    shown = capsys.readouterr()
    assert "3 values of bar_horizontal: 3 points, 2 lack results" in shown.out
    assert all(len(line) <= 100 for line in shown.out.splitlines()[1:])
    rows = list(csv.DictReader((tmp_path / "sweep.csv").read_text(encoding="utf-8").splitlines()))
    assert [float(row["bar_horizontal (m)"]) for row in rows] == pytest.approx([0.05, 0.055, 0.06], rel=1e-15)
    alone = strike_of_keys(bar_horizontal=0.05)
    # Two passes at 1e-5 and 1e-6.
    assert float(rows[0]["tip_speed_at_contact (m/s)"]) == pytest.approx(alone["tip_speed_at_contact"], rel=1e-4)
    assert [bool(row["failure"]) for row in rows] == [False, True, True]
    assert [row["release_time (s)"] for row in rows][1:] == ["", ""]
    found = json.loads((tmp_path / "sweep.json").read_text(encoding="utf-8"))
    assert found["columns"]["release_time (s)"][1:] == [None, None]
    assert "bar_horizontal" not in found["parameters"]
    assert (tmp_path / "lines.svg").read_text(encoding="utf-8").count('id="axes_') >= 7
    assert called(*swept, "--json", "-") == 0
    assert json.loads(capsys.readouterr().out)["columns"] == found["columns"]


def test_a_sweep_over_two_keys_is_a_map(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    keys = ("--sweep", "friction=0.1:0.3:2", "--sweep", "hub_speed=2400rpm:2600rpm:2", "--set", "accuracy=1e-3")
    assert called(*keys, "--plot", str(tmp_path / "map.png")) == 0
    assert "2 values of friction and 2 values of hub_speed: 4 points, all with results" in capsys.readouterr().out
    assert (tmp_path / "map.png").stat().st_size > 0


def test_a_quantity_that_is_nowhere_simulated_is_that_of_its_formula(capsys: pytest.CaptureFixture[str]):
    """The depth of endless plies does not depend on their number, and no point lacks a result."""
    assert command.main(["crater_depth", "--sweep", "plies=100:300:2", "--csv", "-"]) == 0
    rows = list(csv.DictReader(capsys.readouterr().out.splitlines()))
    assert [row["failure"] for row in rows] == ["", ""]
    assert len({row["merchant_crater_depth_limit (m)"] for row in rows}) == 1
    few, many = (float(row["merchant_crater_depth (m)"]) for row in rows)
    assert few < many < float(rows[0]["merchant_crater_depth_limit (m)"])


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--sweep", "friction=1"), "must be KEY=FROM:TO:N with N from 1"),
        (("--sweep", "friction=0:1:0"), "must be KEY=FROM:TO:N with N from 1"),
        (("--sweep", "frition=0:1:3"), "did you mean friction"),
        (("--sweep", "contact=1:2:3"), "must name a key that is a number, not a word"),
        (("--sweep", "friction=0:-1:3"), "friction = '-1': must be"),
        (("--sweep", "friction=0:1:3", "--sweep", "friction=0:1:2"), "must name each key once"),
        (("--sweep", "friction=0:1:3", "--video", "a.mp4"), "--video: must be left out with --sweep"),
        (("--sweep", "friction=0:1:3", "--workers", "0"), "workers = 0: must be"),
        (("--workers", "2"), "must be given with --sweep"),
        (("--sweep", "penetration=0.03:0.04:2", "--plot", "none.png"), "--plot: must have results to draw"),
        (
            tuple(f"--sweep={key}=0.1:0.2:2" for key in ("friction", "restitution", "penetration")),
            "must be one key or two",
        ),
    ],
)
def test_bad_input_is_one_line(words: tuple[str, ...], told: str, capsys: pytest.CaptureFixture[str]):
    assert called(*words) == 2
    error = capsys.readouterr().err
    assert told in error
    assert error.count("\n") == 1


def test_without_the_extra_the_command_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.setitem(sys.modules, "bristle_sim.cli.sweep", None)
    assert called("--sweep", "friction=0.1:0.2:2") == 2
    assert "--sweep needs the extra sweep: pip install bristle-sim[sweep]" in capsys.readouterr().err
