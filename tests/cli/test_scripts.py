"""Every script in scenarios/, held to one contract: options, keys, table, JSON, pictures, exit status."""

from __future__ import annotations

import contextlib
import csv
import dataclasses
import functools
import importlib
import inspect
import io
import itertools
import json
import math
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from bristle_sim.cli import Scenario, main
from bristle_sim.cli.scenario import load_scenario, script_paths
from bristle_sim.declared import Choice, Range
from bristle_sim.units import conversion, shown

ROOT = Path(__file__).parents[2]
SCRIPTS = script_paths()

IMPACT = (
    "normal_compressive_impulse normal_final_impulse tangential_compressive_impulse normal_compressive_work"
    " tangential_compressive_work final_bristle_rate rebound_ratio"
)
RIGID_TOOL = "hub_speed hub_radius bristle_length bristle_mass"
BELT = "belt_stiffness belt_damping_ratio"
BAR = "bar_radius bar_horizontal bar_vertical"
RUBBING = "friction restitution_friction restitution"
LAW = "contact contact_duration tangential_compliance accuracy"
WIRE = "wire_links wire_modulus wire_damping_ratio"
PASS = f"{RIGID_TOOL} wire_diameter {BELT} {BAR} penetration"
IMPACT_FILM = "bristle_sim.render.impact_pictures.ImpactFilm"


@dataclass(frozen=True)
class Promise:
    """The duties of one script beyond those of all.

    Attributes:
        quantities, keys: at least these, reported and accepted.
        lists: further lists in the JSON, and the keys of their entries.
        quick: arguments of a short run, for scripts that take long by default.
        slow: a run takes seconds all the same; one is enough.
        strikes: an impact is asked about, which has an outcome.
        integrates: by default scipy's integrators are imported, for the independent solution or another peer.
        film: the function that films, to be given a small size.
    """

    quantities: str = ""
    keys: str = ""
    lists: dict[str, str] = field(default_factory=dict)
    quick: str = ""
    slow: bool = False
    strikes: bool = True
    integrates: bool = False
    film: str = ""


PROMISES = {
    "cue_and_impact": Promise(
        "release_time release_retraction_deg largest_retraction_deg contact_time lag_deg_at_contact"
        f" relative_speed_at_contact tip_speed_at_contact {IMPACT}",
        f"{PASS} bar_friction bar_restitution {RUBBING} {LAW} {WIRE} gravity tangential_compliance",
        film="bristle_sim.render.tool_films.pass_film",
    ),
    "cue_timing": Promise(
        "cue_time cue_hub_turn_deg highest_relative_speed bar_direction_deg bar_horizontal bar_vertical",
        f"{RIGID_TOOL} {BELT} bar_radius wire_diameter penetration retraction_deg accuracy",
        strikes=False,
        integrates=True,
    ),
    "oblique_impact": Promise(
        IMPACT,
        f"{RIGID_TOOL} speed_ratio impact_angle_deg {RUBBING} {LAW} tangential_compliance",
        film=IMPACT_FILM,
    ),
    "single_pendulum": Promise(
        "rebound_ratio normal_compressive_impulse normal_final_impulse",
        f"rod_mass rod_length impact_angle_deg rate {RUBBING} {LAW}",
        film=IMPACT_FILM,
    ),
    "double_pendulum": Promise(
        "final_rate_1 final_rate_2 normal_compressive_impulse normal_final_impulse kinetic_energy_ratio",
        f"rod_mass mass_ratio rod_length angle_1_deg angle_2_deg rate_1 rate_2 {RUBBING} {LAW}",
        film=IMPACT_FILM,
    ),
    "bent_bristles": Promise(
        " ".join(
            f"{shape}_{name}"
            for shape in ("reverse", "straight", "forward")
            for name in (
                *("forward_slide", "slide_in_touch", "time_in_touch"),
                *("tip_speed_along_before", "tip_speed_along_after", "tip_speed_away_after"),
            )
        ),
        f"{RIGID_TOOL} {BELT} {BAR} penetration knee_position knee_angle_deg {WIRE} {RUBBING} {LAW}",
        strikes=False,
    ),
    "force_history": Promise(
        "peak_force compression_time compressive_impulse",
        f"{RIGID_TOOL} impact_angle_deg {RUBBING} force_csv time_column force_column force_per_volt",
    ),
    "inertia_driven": Promise(
        "largest_retraction_deg time_to_radial relative_speed_at_radial tip_speed_at_radial"
        " hub_speed_for_equal_tip_speed",
        f"{RIGID_TOOL} {BELT} {BAR} penetration reference",
        integrates=True,
        strikes=False,
        film="bristle_sim.render.tool_films.pass_film",
    ),
    "flexible_wire": Promise(
        "first_bending_frequency second_bending_frequency normal_final_impulse peak_force time_in_touch"
        " impulse_ratio_to_rigid",
        f"{RIGID_TOOL} {BELT} wire_diameter speed_ratio impact_angle_deg {RUBBING} contact_duration {WIRE} accuracy"
        " reference",
        quick="wire_links=2",
        integrates=True,
        film="bristle_sim.render.wire_pictures.WireFilm",
    ),
    "crater_depth": Promise(
        "merchant_crater_depth merchant_crater_depth_limit energy_crater_depth",
        "shear_yield_stress plies cutting_friction impact_angle_deg wire_diameter",
    ),
    "surface": Promise(
        "rz rz_across ra rq rsm sa sdr coverage mean_depth removed_volume removal_rate area_rate strike_rate"
        " crater_depth crater_length crater_width",
        "crater_rule crater_depth crater_length crater_width places areal_ratio coverage cutoff_wavelength ground_length"
        " ground_width cell planes bristles feed_speed track_width passes seed wire_diameter hub_speed",
        quick="ground_length=2mm ground_width=1mm cutoff_wavelength=0.4mm cell=20um places=random",
        strikes=False,
        film="bristle_sim.render.surface_pictures.SurfaceFilm",
    ),
    "measured_impacts": Promise(
        "restitution_error spin_error rebound_angle_error_deg rigid_restitution_error rigid_spin_error"
        " rigid_rebound_angle_error_deg",
        "tangential_compliance data",
        strikes=False,
    ),
    "film": Promise(
        "nearest_contact_duration nearest_wire_damping_ratio touches compression_time crater_depth",
        f"{PASS} {RUBBING} accuracy wire_links wire_modulus frame_rate exposure store",
        lists={
            "frames": "time tip_height",
            "variants": "variant touches compression_time crater_depth",
        },
        quick="wire_links=1 map_durations=2 map_dampings=2 workers=1 accuracy=1e-2",
        slow=True,
        strikes=False,
    ),
    "accuracy_cost": Promise(
        keys="effort peers",
        lists={"curves": "case method setting error cpu_s steps"},
        quick="effort=quick peers=none",
        slow=True,
        strikes=False,
    ),
    "hard_cases": Promise(
        keys="theme",
        lists={"rows": "case promise reached ok"},
        quick="theme=chatter",
        strikes=False,
    ),
    "dissertation_figures": Promise(keys="only", quick="only=2.24", strikes=False),
    "dissertation_audit": Promise(
        lists={"rows": "where printed computed status why"}, slow=True, strikes=False
    ),
    "cue_map": Promise(
        "bar_direction_for_radial_strike_deg bar_horizontal bar_vertical relative_speed_at_contact"
        " bar_direction_for_highest_tip_speed_deg",
        f"{PASS} accuracy map_points",
        quick="map_points=3 reference=no accuracy=1e-2",
        slow=True,
        strikes=False,
    ),
    "neighbours": Promise(
        "least_pitch_to_strike_deg least_pitch_whole_pass_deg wire_contacts relative_speed_at_contact"
        " lag_deg_at_contact normal_final_impulse",
        f"{PASS} {RUBBING} accuracy bristles pitch_deg",
        quick="search=no accuracy=1e-2",
        slow=True,
        film="bristle_sim.render.tool_films.row_film",
    ),
    "whole_tool": Promise(
        "impact_rate mean_normal_force mean_tangential_force mean_torque drive_power force_envelope_low"
        " force_envelope_high",
        f"{PASS} {RUBBING} accuracy bristles load_cell_bandwidth",
        slow=True,
        strikes=False,
    ),
    "tolerances": Promise(
        keys=f"{PASS} {RUBBING} samples "
        + " ".join(f"spread_{key}" for key in f"{RIGID_TOOL} {BELT} {BAR}".split()),
        lists={"rows": "output mean std low high indices"},
        quick="samples=32 accuracy=1e-2",
        slow=True,
        strikes=False,
    ),
}
OUTCOMES = {"rebound", "no rebound", "stiction", "no contact"}
SIDES = ("simulated", "theory", "reference", "printed")
SIGNATURES = {".png": b"\x89PNG", ".gif": b"GIF89a"}

LONG_WITH_EACH_KEY = {"bent_bristles", "whole_tool"}
"""Scripts whose run for each of their keys takes some ten seconds in all."""

each_script = pytest.mark.parametrize("name", SCRIPTS)


@functools.cache
def scenario(name: str) -> Scenario:
    """The scenario that a script declares, without running it."""
    return load_scenario(SCRIPTS[name])


def settings(assignments: str) -> list[str]:
    return [f"--set={each}" for each in assignments.split()]


def parsed(text: str) -> dict[str, Any]:
    """One JSON object and nothing else, without NaN and infinities."""
    found = json.loads(text, parse_constant=lambda word: pytest.fail(f"{word} in the JSON"))
    assert isinstance(found, dict)
    return found


def asked(name: str, *arguments: str) -> tuple[int, str, dict[str, Any]]:
    """Exit status, standard output and JSON of a script asked in this process."""
    with contextlib.redirect_stdout(io.StringIO()) as out:
        status = main(scenario(name), ["--json", "-", *arguments])
    return status, out.getvalue(), parsed(out.getvalue())


def untimed(value: Any) -> Any:
    """The same without the clock's readings."""
    if isinstance(value, dict):
        return {
            key: untimed(each)
            for key, each in value.items()
            if not key.startswith(("wall_s", "cpu_s"))
        }
    return [untimed(each) for each in value] if isinstance(value, list) else value


def test_scripts_load_engine_and_solvers_only_to_run() -> None:
    """Help and bad input answer at once; the parameters of a few scripts belong to a study."""
    assert set(PROMISES) == set(SCRIPTS)
    late = set(SCRIPTS) - {"accuracy_cost", "cue_map", "tolerances", "whole_tool"}
    late -= {"dissertation_audit", "dissertation_figures"}
    code = "import runpy, sys\nfor path in sys.argv[1:]: runpy.run_path(path)\nprint(*{'pymunk', 'scipy'} & {*sys.modules})"
    paths = [str(SCRIPTS[name]) for name in sorted(late)]
    done = subprocess.run(
        [sys.executable, "-c", code, *paths], capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == []


@each_script
def test_declared_names_and_keys(name: str, capsys: pytest.CaptureFixture[str]):
    """Each key is listed with meaning, unit, default, range and the source of the default that this script uses."""
    declared = scenario(name)
    promise = PROMISES[name]
    assert declared.name == name
    assert declared.question.endswith("?")
    assert {*promise.keys.split(), *declared.defaults} <= set(declared.keys())
    assert bool(declared.film) is bool(promise.film)
    of_class = {
        found.key: (each.default, found.source)
        for part in declared.parts
        for each in dataclasses.fields(part)
        if (found := each.metadata.get("declaration")) is not None
    }
    assert main(declared, ["--list-keys"]) == 0
    out, err = capsys.readouterr()
    assert (err, out.isascii()) == ("", True)
    assert max(map(len, out.splitlines())) <= 100
    entries = re.split(r"\n(?! )", out.partition("---\n")[2].strip())
    listed = {each.split()[0]: " ".join(each.split()) for each in entries}
    assert list(listed) == list(declared.keys())
    for key, found in declared.keys().items():
        default = found.default
        assert (default is None and found.optional) or found.check(default) == default
        assert default == of_class[key][0] or found.source != of_class[key][1], key
        unit = "" if found.unit in ("1", "word") else found.unit
        if isinstance(found, Range) and not found.whole:
            row = re.match(rf"{key} (\S+) (.*?) ?(\S+) <=? {key} <= (\S+)", listed[key])
            assert row is not None
            given, unit, low, high = row.groups()
            size = conversion(unit, found.unit) if unit else 1.0
            assert size is not None
            pairs = [(low, found.lowest), (high, found.highest)]
            pairs += [] if default is None else [(given, default)]
            for text, number in pairs:
                assert float(text) * size == pytest.approx(number, rel=5.1e-5)  # five digits
        elif default is not None:
            assert listed[key].split()[1] == str(default)
        needs = f"only with {found.needs}" if found.needs else ""
        for expected in (
            unit,
            found.meaning,
            needs,
            f"(default: {found.source})",
        ):
            assert expected in listed[key]


IMPORTED = """
import runpy, sys
sys.argv = sys.argv[1:]
status = 0
try:
    runpy.run_path(sys.argv[0], run_name="__main__")
except SystemExit as ended:
    status = ended.code
print("imported", *sys.modules, file=sys.stderr)
sys.exit(status)
"""


@each_script
def test_a_run_keeps_the_contract(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    """Table, JSON, imports and picture; and the same numbers in a process of its own and here, where others ran before.

    The two differ by their hash seed; and here each parameter is set to its default, which must give the same numbers as
    none set. A slow script runs here alone. Without assertions: tests/promises/test_repeatability.py.
    """
    promise = PROMISES[name]
    target = tmp_path / "results.json"
    picture = tmp_path / "picture.png"
    quick = settings(promise.quick)
    defaults = {key: found.default for key, found in scenario(name).keys().items()}
    named = [f"--set={key}={default}" for key, default in defaults.items() if default is not None]
    plot = ["--plot", str(picture)] if scenario(name).plot is not None else []
    assert main(scenario(name), [*named, *quick, "--json", str(target), *plot]) == 0
    printed = capsys.readouterr().out
    found = parsed(target.read_text())
    if not promise.slow:
        own = [sys.executable, "-c", IMPORTED, str(SCRIPTS[name]), *quick, "--json", str(target)]
        typed = subprocess.run(
            own,
            cwd=ROOT.parent,
            env=os.environ | {"PYTHONHASHSEED": "0"},
            capture_output=True,
            text=True,
            check=False,
        )
        messages, _, imported = typed.stderr.partition("imported ")
        messages = re.sub(r".*\d+ s: .*\n", "", messages)  # progress, on a busy machine
        assert (messages, typed.returncode) == ("", 0)
        check_imports(name, set(imported.split()))
        assert untimed(parsed(target.read_text())) == untimed(found)
    check_table(name, printed, found["quantities"])
    check_json(name, found)
    assert quick or found["parameters"] == defaults
    if plot:
        assert picture.read_bytes().startswith(SIGNATURES[".png"])
        assert picture.stat().st_size > 10_000  # an empty picture of that size takes less
    assert {path.name for path in tmp_path.iterdir()} == {
        "results.json",
        *(["picture.png"] if plot else []),
    }


def check_imports(name: str, modules: set[str]) -> None:
    """A run imports nothing that it does not need."""
    assert "bristle_sim.cli" in modules
    assert not modules & {"matplotlib", "PIL", "imageio_ffmpeg", "bristle_sim.render"}
    assert (
        ("scipy.integrate" in modules)
        is ("bristle_sim.reference" in modules)
        is PROMISES[name].integrates
    )
    if name == "cue_and_impact":
        assert (
            "scipy" not in modules
        )  # a rigid bristle's pass, whose libraries would take longer than it


def check_table(name: str, printed: str, quantities: list[dict[str, Any]]) -> None:
    """The table comes after the answer, fits a terminal, names every promised quantity and has no empty column."""
    head, rule, *lines = (
        printed[printed.index("quantity  ") :].split("\n\n", maxsplit=1)[0].splitlines()
    )
    assert max(map(len, [head, rule, *lines])) <= 100
    titles = re.split(r"\s{2,}", head)
    rows = [re.split(r"\s{2,}", line) for line in lines]
    assert {len(row) for row in rows} == {len(titles)}
    promised = PROMISES[name].quantities.split()
    assert {row["label"] for row in quantities if row["name"] in promised} <= {
        row[0] for row in rows
    }
    assert {title for title, *cells in zip(titles, *rows, strict=True) if set(cells) == {"-"}} <= {
        "unit"
    }
    everything = printed.splitlines()
    assert any(line.startswith("outcome: ") for line in everything) is PROMISES[name].strikes
    if name != "accuracy_cost":  # which has a column for each decade of error
        assert max(map(len, everything)) <= 100


def check_json(name: str, found: dict[str, Any]) -> None:
    """Every list and member that the contract names is there, of its type, in order of time."""
    promise = PROMISES[name]
    assert {"scenario", "version", "parameters", "phases", *promise.lists} <= set(found)
    assert (found["scenario"], found["version"]) == (
        name,
        importlib.metadata.version("bristle-sim"),
    )
    assert found["outcome"] in OUTCOMES if promise.strikes else found["outcome"] is None
    assert all(isinstance(phase, str) for phase in found["phases"])
    assert set(found["cost"]) == {"wall_s", "steps"}
    assert found["cost"]["wall_s"] >= 0.0
    assert isinstance(found["cost"]["steps"], int)
    assert all(set(event) == {"name", "time"} for event in found["events"])
    times = [event["time"] for event in found["events"]]
    assert times == sorted(times)
    for key, columns in promise.lists.items():
        assert found[key]
        assert all(set(columns.split()) <= set(entry) for entry in found[key])
    names = [row["name"] for row in found["quantities"]]
    assert len(set(names)) == len(names)
    assert set(promise.quantities.split()) <= set(names)
    for row in found["quantities"]:
        assert set(row) == {
            "name",
            "label",
            "unit",
            *SIDES,
            "relative_difference",
            "tolerance",
            "ok",
        }
        assert row["unit"]
        assert row["label"]
        assert all(
            row[side] is None or isinstance(row[side], float) for side in (*SIDES, "tolerance")
        )


def other_values(found: Range | Choice, default: Any) -> list[str]:
    """Values that a key could be changed to: near the default, and far from it."""
    if isinstance(found, Choice):
        return list(found.options)
    if isinstance(found, Range) and found.whole and default is not None:
        return [f"{default + 1}"]
    if default is None:
        values = {
            "s": ["1e-5"],
            "1": ["0.2"],
            "column": ["1"],
            "N/V": ["2.0"],
            "kg": ["1e-4"],
            "deg": ["-95"],
        }
        return values[found.unit]
    if default == 0.0:
        return ["0.1", "30"]
    return [repr(default + 10.0 if default >= 100.0 else default * 1.1), repr(0.2 * default)]


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.nightly] if name in LONG_WITH_EACH_KEY else [])
        for name in SCRIPTS
        if not PROMISES[name].quick and not name.startswith("dissertation")
    ],
)
def test_every_key_has_an_effect_or_is_refused(name: str, capsys: pytest.CaptureFixture[str]):
    """Alone, from the defaults: a key that changes nothing misleads whoever sets it.

    The independent solution takes most of a run's time, and no key is its own but ``reference``, whose run has it.
    """
    keys = scenario(name).keys()
    shorter = (
        {"accuracy": "accuracy=1e-2", "reference": "reference=no"}
        if name != "cue_and_impact"
        else {}
    )
    if name == "bent_bristles":
        shorter["contact_duration"] = "contact_duration=5e-5"
    cheap = settings(" ".join(setting for key, setting in shorter.items() if key in keys))

    def computed(found: dict[str, Any]) -> Any:
        rows = [
            [row[side] for side in ("simulated", "theory", "reference")]
            for row in found["quantities"]
        ]
        return rows, {
            key: each
            for key, each in found.items()
            if key not in ("parameters", "quantities", "cost")
        }

    base = computed(asked(name, *cheap)[2])
    for key, found in keys.items():
        if key in ("force_csv", "data"):  # test_dissertation_scripts.py, test_measured_impacts.py
            continue
        for value in other_values(found, found.default):
            status = main(scenario(name), ["--json", "-", *cheap, "--set", f"{key}={value}"])
            out, err = capsys.readouterr()
            if f"{key} = " in err if status == 2 else computed(parsed(out)) != base:
                break
        else:
            pytest.fail(key)


@pytest.mark.parametrize("name", [name for name in SCRIPTS if scenario(name).series])
def test_a_time_series_has_one_row_a_sample(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    target = tmp_path / "run.csv"
    quick = settings(PROMISES[name].quick)
    law = ["--set", "contact=compliant"] if scenario(name).keys().get("contact") else []
    assert main(scenario(name), ["--csv", str(target), "--json", "-", *law, *quick]) == 0
    assert capsys.readouterr().err == f"--csv: wrote {target}\n"
    with target.open(newline="") as stream:
        head, *rows = csv.reader(stream)
    assert all(re.fullmatch(r"\w+ \([\w/]+\)", title) for title in head if title != "shape")
    assert (
        len(rows) > 5
    )  # a release up to its highest speed is a quarter of a period, sampled 24 times a period
    shapes = dict.fromkeys(row[0] for row in rows) if head[0] == "shape" else [None]
    for shape in shapes if "time (s)" in head else ():  # a height map has none
        times = [float(row[head.index("time (s)")]) for row in rows if shape in (None, row[0])]
        assert times == sorted(times)
    cells = [
        float(cell) for row in rows for title, cell in zip(head, row, strict=True) if "(" in title
    ]
    assert all(map(math.isfinite, cells))


NO_NUMBERS = (
    *(
        "",
        " ",
        "abc",
        "nan",
        "inf",
        "-inf",
        "1e999",
        "1_0",
        "0x10",
        "1,5",
        "\u22121",
        "1\n2",
        "True",
        "None",
        "1j",
        "[0.5]",
    ),
    *("1" + 400 * "0", "-1" + 400 * "0", "\u0661", "no such file", "\0"),
)
"""Nothing, words, what Python's float() knows besides numbers, numbers that no float holds, other scripts' digits."""


def bad_texts(found: Range | Choice) -> Iterator[str]:
    """Texts that are no value of a key, and the nearest numbers out of range; a heading or folder is any word."""
    if found.unit in ("column", "folder"):
        yield from ("", " ", "\t")
        return
    yield from NO_NUMBERS
    if isinstance(found, Range):
        yield repr(
            math.nextafter(found.lowest, -math.inf) if found.lowest_allowed else found.lowest
        )
        yield repr(math.nextafter(found.highest, math.inf))


@functools.cache
def first_with(declaration: Range | Choice) -> str:
    """The first script that has a key of a declaration; others differ by the default at most."""
    alike = dataclasses.replace(declaration, default=None, source="")
    return next(
        name
        for name in SCRIPTS
        for each in scenario(name).keys().values()
        if dataclasses.replace(each, default=None, source="") == alike
    )


@each_script
def test_bad_values_of_every_key_are_refused(name: str, capsys: pytest.CaptureFixture[str]):
    """In one line with key, value and what it must be, before anything is computed.

    Every text is tried on a key's first script; on the others a word, and the numbers out of range, which come last.
    """
    idle = dataclasses.replace(
        scenario(name), run=functools.wraps(scenario(name).run)(lambda **_: pytest.fail("ran"))
    )
    for key, found in idle.keys().items():
        texts = list(bad_texts(found))
        for text in texts if first_with(found) == name else ["abc", *texts[-2:]]:
            assert main(idle, ["--json", "-", "--set", f"{key}={text}"]) == 2
            out, err = capsys.readouterr()
            assert (out, err.count("\n")) == ("", 1)
            assert err.startswith(f"{name}.py: error: {key} = {shown(text)}: ")
            assert "must be " in err
            assert found.allowed in err
            assert len(err) < 400


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.nightly] if name in {"cue_map", "neighbours"} else [])
        for name in SCRIPTS
        if scenario(name).keys().get("reference")
    ],
)
def test_the_independent_solution_agrees(name: str):
    """Every quantity that the simulation knows, the reference knows too, and they agree to the requested accuracy.

    Least pitches have a referee of their own: the theory, which is the motion of one bristle alone. Two scripts, whose independent
    solution takes long, are left to the night.
    """
    harder = ["--set", "pitch_deg=10"] if name == "neighbours" else []  # wires that stay in contact
    status, _, found = asked(name, "--set", "reference=yes", *harder)
    assert status == 0
    referred = [
        row
        for row in found["quantities"]
        if row["name"] in PROMISES[name].quantities.split()
        and not row["name"].startswith("least_pitch")
    ]
    assert all(row["reference"] is not None and row["ok"] is True for row in referred)
    # The tolerance of a well-conditioned quantity is of the order of the accuracy, 1e-6.
    assert min(row["tolerance"] for row in referred) <= 1e-5


FILMED = [name for name in SCRIPTS if PROMISES[name].film]


@pytest.mark.parametrize(("name", "suffix"), [*zip(FILMED, itertools.cycle((".gif", ".mp4")))])
def test_a_video_is_rendered_when_asked_for(
    name: str, suffix: str, tmp_path: Path, capsys, monkeypatch
):
    place, _, function = PROMISES[name].film.rpartition(".")
    made = getattr(importlib.import_module(place), function)
    offered = inspect.signature(made).parameters
    small = {
        option: each
        for option, each in (("width", 160), ("height", 120), ("duration", 0.2))
        if option in offered
    }
    monkeypatch.setattr(PROMISES[name].film, functools.partial(made, **small))
    target = tmp_path / f"film{suffix}"
    assert (
        main(
            scenario(name), ["--video", str(target), "--json", "-", *settings(PROMISES[name].quick)]
        )
        == 0
    )
    out, err = capsys.readouterr()
    assert parsed(out)["scenario"] == name
    assert err == f"--video: wrote {target}\n"
    content = target.read_bytes()
    assert content.startswith(SIGNATURES[".gif"]) if suffix == ".gif" else content[4:8] == b"ftyp"
    assert list(tmp_path.iterdir()) == [target]
