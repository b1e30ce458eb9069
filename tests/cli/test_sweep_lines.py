"""``--sweep`` on a scenario: table, files, reasons, and bad input in one line."""

from __future__ import annotations

import csv
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from bristle_sim.cli import command
from bristle_sim.studies.strike_point import strike_of_keys


def called(*words: str) -> int:
    return command.main(["cue_and_impact", *words])


@pytest.mark.parametrize("by_scene", [False, True])
def test_a_sweep_over_one_key_is_the_single_passes(
    by_scene: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    """The bar at 60 mm is not touched: the point says why it has no release. A store is the scene's, whose passes are single."""
    files = [f"--{kind}={tmp_path / f'sweep.{kind}'}" for kind in ("csv", "json")]
    store = [f"--store={tmp_path / 'store'}"] if by_scene else []
    swept = ("--sweep", "bar_horizontal=50mm:60mm:3", "--set", "accuracy=1e-5", *store)
    assert called(*swept, *files, f"--plot={tmp_path / 'lines.svg'}") == 0
    shown = capsys.readouterr().out.splitlines()
    assert "no results at 2 of 3 points" in shown[0]
    assert ("the time-domain simulation agrees" in shown[0]) is not by_scene
    assert "the tip reverses its slip" in shown[0]
    assert all(len(line) <= 100 for line in shown[1:])
    rows = list(csv.DictReader((tmp_path / "sweep.csv").read_text(encoding="utf-8").splitlines()))
    assert [float(row["bar_horizontal (m)"]) for row in rows] == pytest.approx(
        [0.05, 0.055, 0.06], rel=1e-15
    )
    alone = strike_of_keys(bar_horizontal=0.05)
    # Two passes at 1e-5 and 1e-6.
    assert float(rows[0]["tip_speed_at_contact (m/s)"]) == pytest.approx(
        alone["tip_speed_at_contact"], rel=1e-4
    )
    assert {row["outcome"] for row in rows} == {"reverses its slip"}
    assert [bool(row["failure"]) for row in rows] == [False, True, True]
    assert [row["release_time (s)"] for row in rows][1:] == ["", ""]
    found = json.loads((tmp_path / "sweep.json").read_text(encoding="utf-8"))
    assert found["columns"]["release_time (s)"][1:] == [None, None]
    assert "bar_horizontal" not in found["parameters"]
    assert (tmp_path / "lines.svg").read_text(encoding="utf-8").count('id="axes_') >= 7
    assert called(*swept, "--json", "-") == 0
    assert json.loads(capsys.readouterr().out)["columns"] == found["columns"]


def test_the_answer_says_how_the_quantity_runs_and_where_the_outcome_changes(
    capsys: pytest.CaptureFixture[str],
):
    """The tip sticks from tan phi = 0.4619 on, which two values of friction enclose."""
    keys = ("--sweep", "friction=0.4:0.5:21", "--quantity", "normal_compressive_impulse")
    assert called(*keys) == 0
    answer, *lines = capsys.readouterr().out.splitlines()
    assert "normal impulse of compression p_cy falls from" in answer
    assert "the tip reverses its slip, then sticks and rebounds from 0.465" in answer
    assert any(line.startswith("constant: time of release") for line in lines)
    assert len([line for line in lines if "reverses" in line or "sticks" in line]) == 15
    assert called(*keys[:2], "--quantity", "tip_speed_at_contct") == 2
    assert "did you mean tip_speed_at_contact?" in capsys.readouterr().err


def test_a_sweep_over_two_keys_is_a_map_with_the_extremes_of_each_quantity(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    keys = ("--sweep", "friction=0.1:0.3:5", "--sweep", "hub_speed=2400rpm:2600rpm:3")
    assert called(*keys, "--plot", str(tmp_path / "map.png")) == 0
    answer, _, *lines = capsys.readouterr().out.splitlines()
    assert "(5 x 3 points)" in answer
    assert "the tip reverses its slip in 100 % of them" in answer
    (speed,) = [line for line in lines if line.startswith("tip speed")]
    # The slower hub gives the slower tip.
    assert re.match(r"tip speed v_C +[\d.]+ m/s at 0\.1, 2400 rpm ", speed)
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


def test_without_any_result_the_reason_is_the_answer(capsys: pytest.CaptureFixture[str]):
    """A quantity that is requested has no name to be checked against then."""
    swept = ("--sweep", "penetration=30mm:40mm:2", "--set", "reference=yes")
    assert called(*swept, "--quantity", "tip_speed_at_contact") == 0
    assert (
        "no results at 1 of 2 points: penetration = 0.03: must be less" in capsys.readouterr().out
    )


def test_a_refused_point_and_a_change_below_the_printed_digits_have_their_words(
    capsys: pytest.CaptureFixture[str],
):
    """A wire of one and a half links is refused; the accuracy changes the lag by less than is printed."""
    assert called("--sweep", "wire_links=1:2:3", "--set", "accuracy=1e-3") == 0
    answer = capsys.readouterr().out.splitlines()[0]
    assert (
        "the tip reverses its slip, then is refused from 1.5, then reverses its slip from 2"
        in answer
    )
    assert called("--sweep", "accuracy=1e-9:1e-5:3") == 0
    assert "the lag at the strike stays 2.743°; the tip" in capsys.readouterr().out


BLOCKED = "import sys; sys.modules.update(dict.fromkeys('joblib xarray zarr tqdm cloudpickle distributed'.split()));"


def test_without_the_extra_a_sweep_is_computed_all_the_same():
    """In a process of its own that can import none of the extra's packages: in arrays, or one run after the other."""
    code = f"{BLOCKED} from bristle_sim.cli.command import main; sys.exit(main(sys.argv[1:]))"
    start = [sys.executable, "-c", code]
    swept = ["cue_and_impact", "--sweep", "friction=0.1:0.5:3", "--csv", "-"]
    run = subprocess.run([*start, *swept], capture_output=True, text=True, check=True)
    assert run.stdout.count("reverses its slip") == 2
    plies = ["crater_depth", "--sweep", "plies=100:300:2", "--csv", "-"]
    alone = subprocess.run([*start, *plies], capture_output=True, text=True, check=True)
    assert command.main(plies) == 0
    stored = subprocess.run(
        [*start, *swept, "--workers=2"], capture_output=True, text=True, check=False
    )
    assert (stored.returncode, stored.stdout, stored.stderr.count("\n")) == (2, "", 1)
    assert "need the extra sweep: pip install bristle-sim[sweep] (" in stored.stderr
    assert len(alone.stdout.splitlines()) == 3


def test_workers_that_are_lost_are_one_line(monkeypatch: pytest.MonkeyPatch, capsys):
    def lost(*_: object, **__: object) -> None:
        raise RuntimeError("workers: lost at the point {}, and none answers any more")

    monkeypatch.setattr("bristle_sim.studies.sweep.sweep", lost)
    assert called("--sweep", "friction=0.1:0.3:2", "--workers", "2") == 2
    line = "bristle-sim cue_and_impact: error: --workers: lost at the point"
    assert capsys.readouterr().err.startswith(line)
