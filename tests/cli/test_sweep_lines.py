"""``--sweep`` on a scenario: table, files, reasons, and bad input in one line."""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("zarr", reason="needs the extra sweep")

from bristle_sim.cli import command, sweep
from bristle_sim.studies.strike_point import strike_of_keys


def called(*words: str) -> int:
    return command.main(["cue_and_impact", *words])


def test_a_sweep_over_one_key_is_the_single_passes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    """The bar at 60 mm is not touched: the point says why it has no release."""
    files = [f"--{kind}={tmp_path / f'sweep.{kind}'}" for kind in ("csv", "json")]
    store = f"--store={tmp_path / 'store'}"
    swept = ("--sweep", "bar_horizontal=50mm:60mm:3", "--set", "accuracy=1e-5", store)
    assert called(*swept, *files, f"--plot={tmp_path / 'lines.svg'}") == 0
    shown = capsys.readouterr()
    assert "3 values of bar_horizontal: 3 points, 2 lack results" in shown.out
    assert all(len(line) <= 100 for line in shown.out.splitlines()[1:])
    rows = list(csv.DictReader((tmp_path / "sweep.csv").read_text(encoding="utf-8").splitlines()))
    assert [float(row["bar_horizontal (m)"]) for row in rows] == pytest.approx(
        [0.05, 0.055, 0.06], rel=1e-15
    )
    alone = strike_of_keys(bar_horizontal=0.05)
    # Two passes at 1e-5 and 1e-6.
    assert float(rows[0]["tip_speed_at_contact (m/s)"]) == pytest.approx(
        alone["tip_speed_at_contact"], rel=1e-4
    )
    assert [bool(row["failure"]) for row in rows] == [False, True, True]
    assert [row["release_time (s)"] for row in rows][1:] == ["", ""]
    found = json.loads((tmp_path / "sweep.json").read_text(encoding="utf-8"))
    assert found["columns"]["release_time (s)"][1:] == [None, None]
    assert "bar_horizontal" not in found["parameters"]
    assert (tmp_path / "lines.svg").read_text(encoding="utf-8").count('id="axes_') >= 7
    assert called(*swept, "--json", "-") == 0
    assert json.loads(capsys.readouterr().out)["columns"] == found["columns"]


def test_a_sweep_over_two_keys_is_a_map_and_more_rows_than_a_terminal_shows_are_in_files(
    tmp_path: Path, capsys, monkeypatch
):
    monkeypatch.setattr(sweep, "MOST_ROWS", 3)
    keys = (
        "--sweep",
        "friction=0.1:0.3:2",
        "--sweep",
        "hub_speed=2400rpm:2600rpm:2",
        "--set",
        "accuracy=1e-3",
    )
    assert called(*keys, "--plot", str(tmp_path / "map.png")) == 0
    (line,) = capsys.readouterr().out.splitlines()
    assert line == "2 values of friction and 2 values of hub_speed: 4 points, all with results."
    assert (tmp_path / "map.png").stat().st_size > 0


def test_a_quantity_that_is_nowhere_simulated_is_that_of_its_formula(
    capsys: pytest.CaptureFixture[str],
):
    """The depth of endless plies does not depend on their number, and no point lacks a result."""
    assert command.main(["crater_depth", "--sweep", "plies=100:300:2", "--csv", "-"]) == 0
    rows = list(csv.DictReader(capsys.readouterr().out.splitlines()))
    assert [row["failure"] for row in rows] == ["", ""]
    assert len({row["merchant_crater_depth_limit (m)"] for row in rows}) == 1
    few, many = (float(row["merchant_crater_depth (m)"]) for row in rows)
    assert few < many < float(rows[0]["merchant_crater_depth_limit (m)"])


BLOCKED = "import sys; sys.modules.update(dict.fromkeys('joblib xarray zarr tqdm cloudpickle distributed'.split()));"


def test_without_the_extra_a_sweep_ends_in_one_line():
    """In a process of its own that can import none of the extra's packages."""
    code = f"{BLOCKED} from bristle_sim.cli.command import main; sys.exit(main(sys.argv[1:]))"
    line = [sys.executable, "-c", code, "cue_and_impact", "--sweep", "friction=0.1:0.5:3"]
    run = subprocess.run(line, capture_output=True, text=True, check=False)
    assert (run.returncode, run.stdout, run.stderr.count("\n")) == (2, "", 1)
    assert "--sweep needs the extra sweep: pip install bristle-sim[sweep] (" in run.stderr
