"""The table of command lines that are refused: exit status 2, one line with what it must be, and no file left behind."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

import pytest

from bristle_sim.cli import Scenario, command

MASS = "must be a finite number with 1e-30 <= rod_mass <= 1e+06 (in kg"
SWEPT = "cue_and_impact --sweep friction=0:1:3"

REFUSED = [
    ("cue_and_imapct", "unknown scenario 'cue_and_imapct'; did you mean cue_and_impact?"),
    ("zzz", "bristle-sim alone lists"),
    ("--set rate=1", "--set: must come after the name of a scenario"),
    *((f"single_pendulum --set rod_mass={text}", f"rod_mass = '{text}': {MASS})") for text in ("abc", "", "nan", "0")),
    (r"single_pendulum --set 'rod_mass=1\n2'".replace(r"\n", "\n"), rf"rod_mass = '1\n2': {MASS})"),
    ("single_pendulum --set rod_mass=2m", f"rod_mass = '2m': {MASS}, to which m cannot be converted)"),
    ("single_pendulum --set contact=Engine", "contact = 'Engine': must be one of energetic | compliant | engine"),
    ("single_pendulum --set contact_duration=1e-4", "contact_duration = 0.0001: must be left out unless contact = compliant"),
    *((f"single_pendulum --set '{text}'", f"--set {text!r}: must be KEY=VALUE") for text in ("", "rate", "rate:3")),
    ("single_pendulum --set =1", "--set '=1': unknown key ''; --list-keys shows all keys"),
    ("single_pendulum --set hub_radius=1", "--set 'hub_radius=1': unknown key 'hub_radius'; --list-keys shows all keys"),
    *((f"single_pendulum --set {key}=1", f"unknown key '{key}'; did you mean rate?") for key in ("rat", "Rate")),
    ("single_pendulum rate=1", "unrecognized arguments: rate=1; did you mean --set rate=1?"),
    ("single_pendulum --unknown", "--unknown; bristle-sim single_pendulum --help lists the options"),
    ("single_pendulum --jso -", "--jso"),
    ("single_pendulum --set", "--set"),
    ("single_pendulum --list-keys=yes", "--list-keys"),
    ("tolerances --csv a.csv", "--csv a.csv"),  # of a scenario without a motion
    ("single_pendulum --write-tool tool.toml", "--write-tool"),  # of a scenario without a tool
    ("cue_and_impact --video a.gif --size big", "--size = 'big': must be WIDTHxHEIGHT, such as 1280x720 (in px)"),
    ("cue_and_impact --video a.gif --size 0x0", "--size = '0x0': must be 64 to 8192 wide and 48 to 8192 high (in px)"),
    ("cue_and_impact --video a.gif --fps 0", "--fps = '0': must be a finite number with 0 < fps <= 1e+06 (in 1/s)"),
    (f"cue_and_impact --json {'a' * 300}", "must be a file name of at most 255 bytes"),
    ("cue_and_impact --size 640x480", "--size: must be given with --video"),
    ("cue_and_impact --plot a.bmp", "--plot = 'a.bmp': must be a file name that ends in .png, .svg, .pdf"),
    ("cue_and_impact --video a", "--video = 'a': must be a file name that ends in .mp4, .gif"),
    ("cue_and_impact --report a.pdf", "--report = 'a.pdf': must be a file name that ends in .html"),
    ("cue_and_impact --csv a.xlsx", "--csv = 'a.xlsx': must be a file name that ends in .csv"),
    ("cue_and_impact --csv - --json -", "--csv = '-': must be a file where --json is on standard output"),
    ("cue_and_impact --json no/a.json", "--json = 'no/a.json': must be in an existing, writable folder"),
    ("cue_and_impact --json .", "--json = '.': must be a file, not a folder"),
    ("cue_and_impact --plot a.png --json a.png", "--plot = 'a.png': must differ from the file of --json"),
    ("cue_and_impact --plot a.png --json link", "--plot = 'a.png': must differ from the file of --json"),
    ("force_history --set force_csv=points.csv --json points.csv", "must differ from the file of force_csv"),
    ("force_history --set force_csv=none.csv", "force_csv = 'none.csv': must be a readable file"),
    ("cue_timing --parameters none.toml", "--parameters = 'none.toml': must be a readable file (No such file"),
    ("cue_timing --parameters .", "--parameters = '.': must be a readable file (Is a directory)"),
    ("dissertation_audit --parameters none.toml", "--parameters"),
    ("cue_and_impact --parameters sped.toml", "sped.toml: unknown key 'hub_sped'; did you mean hub_speed?"),
    ("cue_and_impact --parameters bar.toml", "bar.toml: bar = false: must be present for cue_and_impact"),
    ("cue_and_impact --parameters slow.toml", "slow.toml: hub_speed = -1.0: must be"),
    *((f"dissertation_figures --only '{number}' --plot new", "2.24") for number in ("2.25", "", "4.18")),
    ("dissertation_figures --only 4.6 --plot f.png", "--plot = 'f.png': must be a folder, or a file name that ends in .pdf"),
    ("compare a.toml", "the following arguments are required: B.toml"),
    ("limits", "the following arguments are required: KEY=FROM:TO"),
    ("limits friction=0:1 a=1:2", "unrecognized arguments: a=1:2"),
    ("limits friction=1", "friction = '1': must be the two ends of a range, FROM:TO, such as 0.1:0.6"),
    ("limits wire_links=1:4", "wire_links: must be a key of real numbers, such as friction"),
    ("limits accuracy=1e-9:1e-3", "unknown key 'accuracy'; must be one of bar_friction, "),
    ("limits tool=1:2", "unknown key 'tool'; "),
    ("design --want tip_speed_at_contact=36 --max tip_speed_at_contact=30 --vary hub_speed=200:300",
     "tip_speed_at_contact = 36: must be at most its upper limit, 30"),
    ("design --want tip_speed_at_contact=30 --vary hub_speed=1000rpm", "hub_speed = '1000rpm': must be the two ends of a range"),
    ("crater_depth --set plies=2.5", "plies = '2.5': must be a whole number"),
    *((f"cue_and_impact --sweep {axis}", "must be KEY=FROM:TO:N with N from 1") for axis in ("friction=1", "friction=0:1:0")),
    ("cue_and_impact --sweep frition=0:1:3", "did you mean friction"),
    ("cue_and_impact --sweep contact=1:2:3", "must name a key that is a number, not a word"),
    ("cue_and_impact --sweep friction=0:-1:3", "friction = '-1': must be"),
    (f"{SWEPT} --sweep friction=0:1:2", "must name each key once"),
    (f"{SWEPT} --sweep restitution=0:1:3 --sweep hub_speed=1:2:2", "must be one key or two"),
    (f"{SWEPT} --video a.mp4", "--video: must be left out with --sweep"),
    *((f"{SWEPT} --workers {text}", f"--workers = '{text}': must be a whole number from 1 to 1024, or -1 for one") for text in ("0", "-2", "two")),
    ("cue_and_impact --csv a.csv --interval -1us", "--interval = '-1us': must be a finite number with 0 < interval <= 1 (in s)"),
    ("cue_and_impact --workers 2", "must be given with --sweep"),
    ("film --workers 0", "workers = '0': must be"),
    ("explore none.toml", "none.toml"),
    ("explore --port 99999", "--port = '99999': must be a whole number from 0 to 65535"),
    ("compare tool.toml none.toml", "none.toml"),
]  # fmt: skip

REFUSED_BY_THE_RUN = [
    (
        f"{SWEPT} --store /proc/nope",
        "--store = '/proc/nope': must be a folder that can be read and written (No such file or directory)",
    ),
    ("force_history --set force_csv=points.csv", "force_csv = points.csv: "),
    (
        "force_history --set force_csv=tool.toml",
        "force_csv = tool.toml: must have columns of time and force",
    ),
    ("measured_impacts --set data=points.csv", "data = points.csv: must"),
    ("measured_impacts --set data=none.mat", "data = 'none.mat': must be a readable file"),
    (
        "single_pendulum --set contact=compliant --set restitution=5e-4",
        "restitution = 0.0005: must be 0, or at least",
    ),
    ("oblique_impact --csv a.csv", "contact = energetic: must be compliant"),
    (
        "crater_depth --set hub_radius=4e-5 --plot a.png",
        "compression_time = 5e-05: must be shorter",
    ),
    (
        "cue_and_impact --set wire_links=2 --set wire_damping_ratio=1000",
        "wire_damping_ratio = 1000: must be below 136, or a run over this hub_turn takes more than 500000 steps",
    ),
    (
        "oblique_impact --set speed_ratio=5e-324",
        "rate before the impact = 1.29e-321: must be 0 or at least 1e-300",
    ),
    (
        "cue_and_impact --sweep penetration=0.03:0.04:2 --plot a.png",
        "--plot: must have results to draw",
    ),
]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    files = {"sped": "hub_sped = 3", "bar": "bar = false", "slow": "hub_speed = -1", "tool": ""}
    for name, text in files.items():
        (tmp_path / f"{name}.toml").write_text(text)
    (tmp_path / "points.csv").write_text("0,0")
    (tmp_path / "link").symlink_to(tmp_path / "a.png")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(("line", "words"), REFUSED + REFUSED_BY_THE_RUN)
def test_a_line_is_refused_in_one_line(
    line: str, words: str, folder: Path, capsys, monkeypatch: pytest.MonkeyPatch
):
    """Before anything is computed, if the line alone says that it is wrong."""
    if (line, words) in REFUSED:
        monkeypatch.setattr(Scenario, "built", lambda *_: pytest.fail("ran"))
    before = {path: path.is_symlink() or path.read_text() for path in folder.iterdir()}
    assert command.main(shlex.split(line)) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert err.startswith("bristle-sim")
    assert "error: " in err
    assert words in err
    assert {path: path.is_symlink() or path.read_text() for path in folder.iterdir()} == before


def test_an_unusual_value_of_a_command_is_one_line(capsys) -> None:
    assert command.main(["limits", "friction=0.3:0.31", "--set", "belt_stiffness=10"]) == 0
    err = capsys.readouterr().err
    assert err.startswith(
        "bristle-sim limits: warning: belt_stiffness = 10 N m/rad is 426 times the"
    )
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("line", "module", "words"),
    [
        (f"{SWEPT} --workers 2", "studies.sweep", "extra sweep: pip install bristle-sim[sweep]"),
    ],
)
def test_a_missing_extra_is_named(
    line: str, module: str, words: str, monkeypatch: pytest.MonkeyPatch, capsys
):
    monkeypatch.setitem(sys.modules, f"bristle_sim.{module}", None)
    assert command.main(shlex.split(line)) == 2
    assert words in capsys.readouterr().err
