"""Every script in scenarios/, held to one contract: options, keys, table, JSON, pictures, exit status.

What can be asked in this process is asked in it; what a person types is run as they would run it.
"""

from __future__ import annotations

import contextlib
import csv
import dataclasses
import functools
import importlib
import importlib.metadata
import importlib.util
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
from bristle_sim.comparison import Report
from bristle_sim.units import Choice, Range

ROOT = Path(__file__).parents[2]
SCRIPTS = {path.stem: path for path in sorted((ROOT / "scenarios").glob("*.py"))}

IMPACT = (
    "normal_compressive_impulse",
    "normal_final_impulse",
    "tangential_compressive_impulse",
    "normal_compressive_work",
    "tangential_compressive_work",
    "final_bristle_rate",
    "rebound_ratio",
)
TOOL = ("hub_speed", "hub_radius", "bristle_length", "bristle_mass")
BELT = ("belt_stiffness", "belt_damping_ratio")
BAR = ("bar_radius", "bar_horizontal", "bar_vertical")
RUBBING = ("friction", "restitution_friction", "restitution")
LAW = ("contact", "contact_duration", "accuracy")
WIRE = ("wire_links", "wire_modulus", "wire_damping_ratio")


@dataclass(frozen=True)
class Promise:
    """What one script owes besides what all owe.

    Attributes:
        quantities, keys: at least these, reported and accepted.
        lists: further lists in the JSON, with what each of their entries has.
        quick: arguments of a short run, for scripts that take long by default.
        times: what the quantities tell is time; only the lists are the same at every run.
        strikes: an impact is asked about, which has an outcome.
        statistics: scipy's statistics are imported, and its integrators with them.
        integrates: by default the independent solution, or another peer, is requested.
        film: module and name of the function that films, to be given a small size.
    """

    quantities: tuple[str, ...] = ()
    keys: tuple[str, ...] = ()
    lists: dict[str, set[str]] = field(default_factory=dict)
    quick: tuple[str, ...] = ()
    times: bool = False
    strikes: bool = True
    integrates: bool = False
    statistics: bool = False
    film: tuple[str, str] | None = None


PROMISES = {
    "cue_and_impact": Promise(
        (
            "release_time",
            "release_retraction_deg",
            "largest_retraction_deg",
            "contact_time",
            "lag_deg_at_contact",
            "relative_speed_at_contact",
            "tip_speed_at_contact",
            *IMPACT,
        ),
        (*TOOL, "wire_diameter", *BELT, *BAR, "bar_friction", "bar_restitution", "penetration", *RUBBING, *LAW),
        film=("bristle_sim.render.tool_films", "pass_film"),
    ),
    "cue_timing": Promise(
        (
            "cue_time",
            "cue_hub_turn_deg",
            "highest_relative_speed",
            "bar_direction_deg",
            "bar_horizontal",
            "bar_vertical",
        ),
        (*TOOL, *BELT, "bar_radius", "wire_diameter", "penetration", "retraction_deg", "accuracy"),
        strikes=False,
        integrates=True,
    ),
    "oblique_impact": Promise(
        IMPACT,
        (*TOOL, "speed_ratio", "impact_angle_deg", *RUBBING, *LAW),
        film=("bristle_sim.render.impact_film", "ImpactFilm"),
    ),
    "single_pendulum": Promise(
        ("rebound_ratio", "normal_compressive_impulse", "normal_final_impulse"),
        ("rod_mass", "rod_length", "impact_angle_deg", "rate", *RUBBING, *LAW),
        film=("bristle_sim.render.impact_film", "ImpactFilm"),
    ),
    "double_pendulum": Promise(
        ("final_rate_1", "final_rate_2", "normal_compressive_impulse", "normal_final_impulse", "kinetic_energy_ratio"),
        ("rod_mass", "mass_ratio", "rod_length", "angle_1_deg", "angle_2_deg", "rate_1", "rate_2", *RUBBING, *LAW),
        film=("bristle_sim.render.impact_film", "ImpactFilm"),
    ),
    "bent_bristles": Promise(
        keys=(*TOOL, *BELT, *BAR, "penetration", "knee_position", "knee_angle_deg", *WIRE, *RUBBING, *LAW),
        strikes=False,
    ),
    "force_history": Promise(
        ("peak_force", "compression_time", "compressive_impulse"),
        (*TOOL, "impact_angle_deg", *RUBBING, "force_csv", "time_column", "force_column", "force_per_volt"),
    ),
    "inertia_driven": Promise(
        (
            "largest_retraction_deg",
            "time_to_radial",
            "relative_speed_at_radial",
            "tip_speed_at_radial",
            "hub_speed_for_equal_tip_speed",
        ),
        (*TOOL, *BELT, *BAR, "penetration", "reference"),
        integrates=True,
        strikes=False,
        film=("bristle_sim.render.tool_films", "inertia_film"),
    ),
    "flexible_wire": Promise(
        (
            "first_bending_frequency",
            "second_bending_frequency",
            "normal_final_impulse",
            "peak_force",
            "time_in_touch",
            "impulse_ratio_to_rigid",
        ),
        (
            *(*TOOL, *BELT, "wire_diameter", "speed_ratio", "impact_angle_deg", *RUBBING, "contact_duration"),
            *(*WIRE, "accuracy", "reference"),
        ),
        quick=("--set", "wire_links=2"),
        integrates=True,
        film=("bristle_sim.render.wire_film", "WireFilm"),
    ),
    "crater_depth": Promise(
        ("merchant_crater_depth", "merchant_crater_depth_limit", "energy_crater_depth"),
        ("shear_yield_stress", "plies", "friction", "impact_angle_deg"),
    ),
    "measured_impacts": Promise(
        (
            *("restitution_error", "spin_error", "rebound_angle_error_deg"),
            *("rigid_restitution_error", "rigid_spin_error", "rigid_rebound_angle_error_deg"),
        ),
        ("tangential_compliance", "data"),
        strikes=False,
    ),
    "accuracy_cost": Promise(
        keys=("effort", "peers"),
        lists={"curves": {"case", "method", "setting", "error", "cpu_s", "steps"}},
        quick=("--set", "effort=quick", "--set", "peers=none"),
        times=True,
        strikes=False,
        integrates=True,
    ),
    "hard_cases": Promise(
        keys=("theme", "effort"),
        lists={"rows": {"case", "promise", "reached", "ok"}},
        quick=("--set", "theme=long_run", "--set", "effort=quick"),
        strikes=False,
    ),
    "dissertation_figures": Promise(keys=("only",), quick=("--only", "2.24"), strikes=False),
    "dissertation_audit": Promise(
        lists={"rows": {"where", "printed", "computed", "status", "why"}}, strikes=False, integrates=True
    ),
    "cue_map": Promise(
        (
            "bar_direction_for_radial_strike_deg",
            "bar_horizontal",
            "bar_vertical",
            "relative_speed_at_contact",
            "bar_direction_for_highest_tip_speed_deg",
        ),
        (*TOOL, "wire_diameter", *BELT, *BAR, "penetration", "accuracy", "map_points"),
        lists={"moves": {"key", "value", "bar_direction_for_radial_strike_deg", "relative_speed_at_contact"}},
        quick=("--set", "map_points=3", "--set", "reference=no", "--set", "accuracy=1e-2"),
        strikes=False,
    ),
    "neighbours": Promise(
        (
            "least_pitch_to_strike_deg",
            "least_pitch_whole_pass_deg",
            "wire_contacts",
            "relative_speed_at_contact",
            "lag_deg_at_contact",
            "normal_final_impulse",
        ),
        (*TOOL, "wire_diameter", *BELT, *BAR, "penetration", *RUBBING, "accuracy", "bristles", "pitch_deg"),
        quick=("--set", "search=no", "--set", "accuracy=1e-2"),
        film=("bristle_sim.render.tool_films", "row_film"),
    ),
    "whole_tool": Promise(
        (
            "impact_rate",
            "mean_normal_force",
            "mean_tangential_force",
            "mean_torque",
            "drive_power",
            "force_envelope_low",
            "force_envelope_high",
        ),
        (
            *(*TOOL, "wire_diameter", *BELT, *BAR, "penetration", *RUBBING, "accuracy"),
            *("bristles", "load_cell_bandwidth"),
        ),
        strikes=False,
    ),
    "tolerances": Promise(
        keys=(
            *TOOL,
            *BELT,
            *BAR,
            "penetration",
            *RUBBING,
            "samples",
            *(f"spread_{key}" for key in TOOL + BELT + BAR),
        ),
        lists={"rows": {"output", "mean", "std", "low", "high", "indices"}},
        quick=("--set", "samples=2", "--set", "accuracy=1e-2"),
        statistics=True,
        strikes=False,
    ),
}

OUTCOMES = {"rebound", "no rebound", "stiction", "no contact"}
SIDES = ("simulated", "theory", "reference", "printed")
TIMINGS = ("wall_s", "cpu_s")
SIGNATURES = {".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF", ".gif": b"GIF89a"}


def promise(name: str) -> Promise:
    return PROMISES.get(name, Promise())


each_script = pytest.mark.parametrize("name", SCRIPTS)


@functools.cache
def scenario(name: str) -> Scenario:
    """The scenario that a script declares, without running it."""
    spec = importlib.util.spec_from_file_location(f"scenario_{name}", SCRIPTS[name])
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    found = module.SCENARIO
    assert isinstance(found, Scenario)
    return found


def process(command: list[str], folder: Path, **variables: str) -> subprocess.CompletedProcess[str]:
    environment = {key: value for key, value in os.environ.items() if key not in ("DISPLAY", "MPLBACKEND")} | variables
    return subprocess.run(
        command, cwd=folder, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False
    )


def parsed(text: str) -> dict[str, Any]:
    """One JSON object and nothing else, without NaN and infinities."""

    def refuse(word: str) -> None:
        pytest.fail(f"{word} in the JSON")

    found = json.loads(text, parse_constant=refuse)
    assert isinstance(found, dict)
    return found


def asked(name: str, *arguments: str) -> tuple[int, dict[str, Any]]:
    """Exit status and JSON of a script asked in this process."""
    with contextlib.redirect_stdout(io.StringIO()) as out:
        status = main(scenario(name), ["--json", "-", *arguments])
    return status, parsed(out.getvalue())


def numbers(name: str, found: dict[str, Any]) -> Any:
    """What must not differ between two runs of a script."""
    return untimed([found[key] for key in promise(name).lists] if promise(name).times else found)


def untimed(value: Any) -> Any:
    """The same without what the clock measured."""
    if isinstance(value, dict):
        return {key: untimed(each) for key, each in value.items() if not key.startswith(TIMINGS)}
    return [untimed(each) for each in value] if isinstance(value, list) else value


LATE = set(SCRIPTS) - {
    "accuracy_cost",
    "cue_map",
    "tolerances",
    "dissertation_audit",
    "dissertation_figures",
    "whole_tool",
}
"""Scripts whose parameters come without an engine; those of the others belong to a study."""


def test_scripts_load_engine_and_solvers_only_to_run() -> None:
    """Help and bad input answer at once, and Ctrl-C while libraries load finds ``main`` in charge, not a traceback."""
    code = "import runpy, sys\nfor path in sys.argv[1:]: runpy.run_path(path)\nprint(*{'pymunk', 'scipy'} & {*sys.modules})"
    paths = [str(SCRIPTS[name]) for name in sorted(LATE)]
    done = subprocess.run([sys.executable, "-c", code, *paths], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def test_every_script_is_promised_something():
    assert SCRIPTS
    assert set(SCRIPTS) <= set(PROMISES)


@each_script
def test_declared_names_and_keys(name: str):
    declared = scenario(name)
    assert declared.name == name
    assert declared.question.endswith("?")
    assert set(promise(name).keys) <= set(declared.keys())
    assert set(declared.defaults) <= set(declared.keys())
    assert (declared.film is None) is (promise(name).film is None)
    for found, default in declared.keys().values():
        assert (default is None and found.optional) or found.check(default) == default


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
def test_a_run_keeps_the_contract(name: str, tmp_path: Path):
    """Table, JSON, imports and picture; and the same numbers in a process of its own and here, where others ran before.

    The two differ by their hash seed; and here each parameter is set to its default, which must give the same numbers as
    none set. Without assertions: tests/promises/test_repeatability.py.
    """
    quick, target = promise(name).quick, tmp_path / "results.json"
    command = [sys.executable, "-c", IMPORTED, str(SCRIPTS[name]), *quick, "--json", str(target)]
    typed = process(command, ROOT.parent, PYTHONHASHSEED="0")
    messages, _, imported = typed.stderr.partition("imported ")
    assert (messages, typed.returncode) == ("", 0)
    found = parsed(target.read_text())
    check_table(name, typed.stdout, found["quantities"])
    check_json(name, found)
    check_quantities(name, found["quantities"])
    check_imports(name, set(imported.split()))

    draws = scenario(name).plot is not None
    defaults = {key: default for key, (_, default) in scenario(name).keys().items()}
    assert quick or found["parameters"] == defaults
    named = [f"--set={key}={default}" for key, default in defaults.items() if default is not None]
    status, here = asked(name, *named, *quick, *(["--plot", str(tmp_path / "picture.png")] if draws else []))
    assert status == 0
    assert numbers(name, here) == numbers(name, found)
    if draws:
        picture = (tmp_path / "picture.png").read_bytes()
        assert picture.startswith(SIGNATURES[".png"])
        assert len(picture) > 10_000  # an empty picture of that size takes less
    assert {path.name for path in tmp_path.iterdir()} == {"results.json", *(["picture.png"] if draws else [])}


def check_table(name: str, printed: str, quantities: list[dict[str, Any]]) -> None:
    """The table comes first, fits a terminal, names every promised quantity and has no empty column."""
    head, rule, *lines = printed[printed.index("quantity  ") :].split("\n\n", maxsplit=1)[0].splitlines()
    assert max(map(len, [head, rule, *lines])) <= 100
    titles = re.split(r"\s{2,}", head)
    assert titles[0] == "quantity"
    rows = [re.split(r"\s{2,}", line) for line in lines]
    assert {len(row) for row in rows} == {len(titles)}
    labels = {row["label"] for row in quantities if row["name"] in promise(name).quantities}
    assert labels <= {row[0] for row in rows}
    empty = [title for title, *cells in zip(titles, *rows, strict=True) if set(cells) == {"-"}]
    assert set(empty) <= {"unit"}
    everything = printed.splitlines()
    assert any(line.startswith("outcome: ") for line in everything) is promise(name).strikes
    if name != "accuracy_cost":  # which has a column for each decade of error
        assert max(map(len, everything)) <= 100


def check_json(name: str, found: dict[str, Any]) -> None:
    """Every list and member that the contract names is there, of its type, in order of time."""
    required = {"scenario", "version", "parameters", "outcome", "quantities", "phases", "events", "cost"}
    assert {*required, *promise(name).lists} <= set(found)
    assert found["scenario"] == name
    assert found["version"] == importlib.metadata.version("bristle-sim")
    assert (found["outcome"] in OUTCOMES) is promise(name).strikes
    assert (found["outcome"] is None) is not promise(name).strikes
    assert all(isinstance(phase, str) for phase in found["phases"])
    assert set(found["cost"]) == {"wall_s", "steps"}
    assert found["cost"]["wall_s"] >= 0.0
    assert isinstance(found["cost"]["steps"], int)
    for event in found["events"]:
        assert set(event) == {"name", "time"}
        assert isinstance(event["name"], str)
    times = [event["time"] for event in found["events"]]
    assert times == sorted(times)
    for key, columns in promise(name).lists.items():
        assert found[key]
        assert all(columns <= set(entry) for entry in found[key])


def check_imports(name: str, modules: set[str]) -> None:
    """What a run does not call for is not imported."""
    assert "bristle_sim.cli" in modules
    assert not modules & {"matplotlib", "PIL", "imageio_ffmpeg", "bristle_sim.render"}
    assert ("scipy.integrate" in modules) is (promise(name).integrates or promise(name).statistics)
    assert ("bristle_sim.reference" in modules) is promise(name).integrates
    if name == "cue_and_impact":
        assert "scipy" not in modules  # a rigid bristle's pass, whose libraries would take longer than it


def check_quantities(name: str, rows: list[dict[str, Any]]) -> None:
    """Every promised quantity is there once, with its sides and a verdict that follows from them."""
    names = [row["name"] for row in rows]
    assert len(set(names)) == len(names)
    assert set(promise(name).quantities) <= set(names)
    for row in rows:
        assert set(row) == {"name", "label", "unit", *SIDES, "relative_difference", "tolerance", "ok"}
        assert row["unit"]
        assert row["label"]
        for side in (*SIDES, "relative_difference", "tolerance"):
            assert row[side] is None or isinstance(row[side], float)
        check_verdict(row)


def check_verdict(row: dict[str, Any]) -> None:
    """The difference is the one between the row's own numbers, and the verdict follows from it."""
    judge = next((row[side] for side in ("reference", "theory", "printed") if row[side] is not None), None)
    difference = None
    if judge and row["simulated"] is not None:
        difference = (row["simulated"] - judge) / abs(judge)
    assert row["relative_difference"] == difference
    if row["tolerance"] is None or judge is None:
        assert row["ok"] is None
    elif row["simulated"] is None:
        assert row["ok"] is False
    else:
        assert row["ok"] is (abs(row["simulated"] if judge == 0.0 else difference) <= row["tolerance"])


@each_script
def test_keys_are_listed(name: str, capsys: pytest.CaptureFixture[str]):
    assert main(scenario(name), ["--list-keys"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert out.isascii()
    assert max(map(len, out.splitlines())) <= 100
    body = out.partition("---\n")[2]
    listed = {each.split()[0]: " ".join(each.split()) for each in re.split(r"\n(?! )", body.strip())}
    assert list(listed) == list(scenario(name).keys())
    for key, (found, default) in scenario(name).keys().items():
        assert len(found.meaning) > 10
        for expected in (
            "" if found.unit in ("1", "word") else found.unit,
            found.allowed,
            found.meaning,
            f"(default: {found.source})",
        ):
            assert expected in listed[key]
        shown = default if isinstance(default, str) else "none" if default is None else f"{default:.9g}"
        assert shown in listed[key]


def test_a_script_gives_the_source_of_its_own_default():
    """Bent bristles are damped, which "undamped as in Zhang 2020" does not explain."""
    for name in SCRIPTS:
        of_class = {
            found.key: (each.default, found.source)
            for part in scenario(name).parts
            for each in dataclasses.fields(part)
            if (found := each.metadata.get("declaration")) is not None
        }
        for key, (found, default) in scenario(name).keys().items():
            assert default == of_class[key][0] or found.source != of_class[key][1], (name, key)


def other_values(found: Range | Choice, default: Any) -> list[str]:
    """Values that a key could be changed to: near the default, and far from it."""
    if isinstance(found, Choice):
        return list(found.options)
    if isinstance(found, Range) and found.whole and default is not None:
        return [f"{default + 1}"]
    if default is None:
        return {"s": ["1e-5"], "1": ["0.2"], "column": ["1"], "N/V": ["2.0"]}[found.unit]
    if default == 0.0:
        return ["0.1", "30"]
    return [repr(default + 10.0 if default >= 100.0 else default * 1.1), repr(0.2 * default)]


def computed(found: dict[str, Any]) -> Any:
    """What a run computed: no parameters, and nothing that follows from whether they are those in print."""
    rows = [[row[side] for side in ("simulated", "theory", "reference")] for row in found["quantities"]]
    return rows, {key: each for key, each in found.items() if key not in ("parameters", "quantities", "cost")}


CHEAP = {
    "cue_timing": ("--set", "reference=no"),
    "inertia_driven": ("--set", "reference=no"),
    "bent_bristles": ("--set", "accuracy=1e-2"),
    "whole_tool": ("--set", "accuracy=1e-2"),
}
"""Settings that make a run shorter, from which a key is changed."""


@pytest.mark.parametrize(
    "name", [name for name in SCRIPTS if not promise(name).quick and not name.startswith("dissertation")]
)
def test_every_key_has_an_effect_or_is_refused(name: str, capsys: pytest.CaptureFixture[str]):
    """Alone, from the defaults: a key that changes nothing misleads whoever sets it.

    The independent solution takes most of a run's time, and no key is its own but ``reference``, whose run has it.
    """
    cheap = CHEAP.get(name, ())
    _, base = asked(name, *cheap)
    for key, (found, default) in scenario(name).keys().items():
        if key in ("force_csv", "data"):  # test_dissertation_scripts.py, test_measured_impacts.py
            continue
        seen = []
        for value in other_values(found, default):
            status = main(scenario(name), ["--json", "-", *cheap, "--set", f"{key}={value}"])
            out, err = capsys.readouterr()
            seen.append(f"{key} = " in err if status == 2 else computed(parsed(out)) != computed(base))
            if seen[-1]:
                break
        assert any(seen), key


@pytest.mark.parametrize(
    "name", [name for name in SCRIPTS if {"contact", "contact_duration"} <= set(scenario(name).keys())]
)
@pytest.mark.parametrize("law", ["energetic", "engine"])
def test_a_duration_without_a_contact_in_time_is_refused(name: str, law: str, capsys: pytest.CaptureFixture[str]):
    assert main(scenario(name), ["--set", f"contact={law}", "--set", "contact_duration=2e-5"]) == 2
    assert capsys.readouterr() == (
        "",
        f"{name}.py: error: contact_duration = 2e-05: must be left out unless contact = compliant, or it has no effect\n",
    )


@pytest.mark.parametrize(
    ("setting", "told"),
    [
        ("hub_speed=2500", "hub_speed = 2500 rad/s is 9.55 times the default, 261.8 rad/s; if it was meant in rpm"),
        ("bristle_length=27", "bristle_length = 27 m is 1e+03 times the default, 0.027 m; if it was meant in mm"),
    ],
)
def test_a_mistaken_unit_is_warned_of(setting: str, told: str, capsys: pytest.CaptureFixture[str]):
    ran = scenario("cue_and_impact").run
    quick = dataclasses.replace(scenario("cue_and_impact"), run=functools.wraps(ran)(lambda **_: Report(None, ())))
    assert main(quick, ["--set", setting]) == 0
    assert capsys.readouterr().err.startswith(f"cue_and_impact.py: warning: {told}: ")
    for suggested in ("hub_speed=2500rpm", "bristle_length=27mm"):
        assert main(quick, ["--set", suggested]) == 0
        assert capsys.readouterr().err == ""


SERIES = [name for name in SCRIPTS if scenario(name).series]


@pytest.mark.parametrize("name", SERIES)
def test_a_time_series_has_one_row_a_sample(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    target = tmp_path / "run.csv"
    law = ["--set", "contact=compliant"] if scenario(name).keys().get("contact") else []
    assert main(scenario(name), ["--csv", str(target), "--json", "-", *law, *promise(name).quick]) == 0
    assert capsys.readouterr().err == f"--csv: wrote {target}\n"
    with target.open(newline="") as stream:
        head, *rows = csv.reader(stream)
    assert all(re.fullmatch(r"\w+ \([\w/]+\)", title) for title in head if title != "shape")
    assert len(rows) > 5  # a release up to its highest speed is a quarter of a period, sampled 24 times a period
    time = head.index("time (s)")
    shapes = dict.fromkeys(row[0] for row in rows) if head[0] == "shape" else [None]
    for shape in shapes:
        own = [float(row[time]) for row in rows if shape in (None, row[0])]
        assert own == sorted(own)
    assert all(
        math.isfinite(float(cell)) for row in rows for title, cell in zip(head, row, strict=True) if "(" in title
    )


def test_an_impact_at_an_instant_has_no_time_series(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    assert main(scenario("oblique_impact"), ["--csv", str(tmp_path / "a.csv")]) == 2
    assert capsys.readouterr().err.startswith("oblique_impact.py: error: contact = energetic: must be compliant")
    assert not list(tmp_path.iterdir())


def bad_texts(found: Range | Choice) -> Iterator[str]:
    """Nothing, words, what floats know besides numbers, and the nearest numbers out of range; a heading may be any word."""
    if found.unit == "column":
        yield from ("", " ", "\t")
        return
    yield from ("", " ", "abc", "nan", "inf", "-inf", "1e999", "1_0", "0x10", "1,5", "\u22121", "1\n2")
    if isinstance(found, Range):
        yield repr(math.nextafter(found.lowest, -math.inf) if found.lowest_allowed else found.lowest)
        yield repr(math.nextafter(found.highest, math.inf))


@each_script
def test_bad_values_of_every_key_are_refused(name: str, capsys: pytest.CaptureFixture[str]):
    """In one line with key, value and what it must be, before anything is computed."""
    idle = dataclasses.replace(scenario(name), run=functools.wraps(scenario(name).run)(lambda **_: pytest.fail("ran")))
    for key, (found, _) in idle.keys().items():
        for text in bad_texts(found):
            assert main(idle, ["--json", "-", "--set", f"{key}={text}"]) == 2
            out, err = capsys.readouterr()
            assert out == ""
            assert err.count("\n") == 1
            assert err.startswith(f"{name}.py: error: {key} = {text!r}: ")
            assert "must be " in err
            assert found.allowed in err


SEARCHING = {"cue_map", "neighbours"}
"""Scripts whose independent solution searches a direction or a pitch, pass after pass."""


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.nightly] if name in SEARCHING else [])
        for name in SCRIPTS
        if scenario(name).keys().get("reference")
    ],
)
def test_the_independent_solution_agrees(name: str):
    """Every quantity that the simulation knows, the reference knows too, and they agree to the requested accuracy."""
    harder = ("--set", "pitch_deg=10") if name == "neighbours" else ()  # wires that stay in contact
    status, found = asked(name, "--set", "reference=yes", *harder)
    assert status == 0
    referred = [row for row in found["quantities"] if row["name"] in promise(name).quantities]
    for row in referred:
        assert row["reference"] is not None
        assert row["ok"] is True
    # The tolerance of a well-conditioned quantity is of the order of the accuracy, 1e-6.
    assert min(row["tolerance"] for row in referred) <= 1e-5


BAD_ARGUMENTS = {
    "not a number": ["--set", "friction=nan"],
    "unknown key": ["--set", "no_such_key=1"],
    "malformed": ["--set", "friction"],
    "unknown option": ["--no-such-option"],
    "missing argument": ["--set"],
    "picture of unknown kind": ["--plot", "picture.bmp"],
    "video of unknown kind": ["--video", "film.avi"],
    "nowhere": ["--json", "no/such/folder/results.json"],
    "do not fit together": ["--set", "penetration=0.03"],
}


@pytest.mark.parametrize("case", BAD_ARGUMENTS)
def test_bad_input_as_a_person_meets_it(case: str, tmp_path: Path):
    arguments = BAD_ARGUMENTS[case]
    run = process([sys.executable, str(SCRIPTS["cue_and_impact"]), *arguments], tmp_path)
    assert (run.stdout, run.returncode) == ("", 2)
    assert run.stderr.startswith("cue_and_impact.py: error: ")
    assert run.stderr.count("\n") == 1
    assert arguments[-1].partition("=")[0] in run.stderr
    assert not list(tmp_path.iterdir())


FIT = {
    "cue_and_impact": ["penetration=0.027", "bar_radius=0.05", "bar_vertical=0"],
    "cue_timing": ["penetration=0.027", "penetration=-0.1"],
}


@pytest.mark.parametrize(("name", "setting"), [(name, each) for name in FIT for each in FIT[name]])
def test_values_that_do_not_fit_together(name: str, setting: str, capsys: pytest.CaptureFixture[str]):
    """One line that begins with the part concerned."""
    assert main(scenario(name), ["--json", "-", "--set", setting]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert err.startswith(f"{name}.py: error: {setting.partition('_')[0].partition('=')[0]}")
    assert "must be" in err


@pytest.mark.parametrize("name", [name for name in SCRIPTS if scenario(name).plots])
def test_one_picture_of_a_folder_can_be_drawn_alone(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    folder = tmp_path / "figures"
    assert main(scenario(name), ["--only", "2.24", "--plot", str(folder), "--json", "-"]) == 0
    out, err = capsys.readouterr()
    assert parsed(out)["scenario"] == name
    assert err == f"--plot: wrote {folder}\n"
    assert [path.name for path in folder.iterdir()] == ["figure_2.24.png"]
    assert (folder / "figure_2.24.png").read_bytes().startswith(SIGNATURES[".png"])


def test_a_picture_needs_no_display(tmp_path: Path):
    target = tmp_path / "picture.svg"
    run = process([sys.executable, str(SCRIPTS["cue_and_impact"]), "--plot", str(target)], tmp_path)
    assert run.returncode == 0
    assert target.read_bytes().startswith(SIGNATURES[".svg"])
    assert list(tmp_path.iterdir()) == [target]


FILMED = [name for name in SCRIPTS if promise(name).film]


@pytest.mark.parametrize(("name", "suffix"), [*zip(FILMED, itertools.cycle((".gif", ".mp4")))])
def test_a_video_is_rendered_when_asked_for(name: str, suffix: str, tmp_path: Path, capsys, monkeypatch):
    film = promise(name).film
    assert film
    module = importlib.import_module(film[0])
    made = getattr(module, film[1])
    small = {"width": 160, "height": 120, "duration": 0.2}
    offered = {option: value for option, value in small.items() if option in inspect.signature(made).parameters}
    monkeypatch.setattr(module, film[1], functools.partial(made, **offered))
    target = tmp_path / f"film{suffix}"
    assert main(scenario(name), ["--video", str(target), "--json", "-", *promise(name).quick]) == 0
    out, err = capsys.readouterr()
    assert parsed(out)["scenario"] == name
    assert err == f"--video: wrote {target}\n"
    content = target.read_bytes()
    assert content.startswith(SIGNATURES[".gif"]) if suffix == ".gif" else content[4:8] == b"ftyp"
    assert list(tmp_path.iterdir()) == [target]
