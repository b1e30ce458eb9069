"""Simulations for the bench, the interactive page of a tool: from typed values to displayed
results.
"""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from functools import partial
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.cli.command import draw
from bristle_sim.cli.output import csv_text, document, write_text
from bristle_sim.cli.scenario import Scenario, Values, build_parameters
from bristle_sim.comparison import cells
from bristle_sim.declared import Choice, Declaration, Range
from bristle_sim.parameters import FIELDS, Tool
from bristle_sim.readable import plain_number
from bristle_sim.render.motion_data import motion_data
from bristle_sim.render.report import write_report
from bristle_sim.render.story import key_events
from bristle_sim.studies.whole_pass import QUANTITIES
from bristle_sim.tool_file import write_tool
from bristle_sim.trajectory import Trajectory
from bristle_sim.units import exact_text

OFTEN = ("hub", "bristle", "bar", "workpart")
"""Parts of the tool whose controls are visible when the page is loaded."""

SLIDERS = {
    "accuracy": (1e-10, 1e-2),
    "bar_friction": (0.0, 1.0),
    "bar_horizontal": (0.0, 0.08),
    "bar_vertical": (-0.08, 0.08),
    "belt_damping_ratio": (0.0, 2.0),
    "friction": (0.0, 1.0),
    "gravity": (0.0, 10.0),
    "knee_angle_deg": (-60.0, 60.0),
    "restitution": (0.0, 1.0),
    "tangential_compliance": (0.0, 1.5),
    "wire_links": (1.0, 12.0),
}
"""Ranges of sliders, in SI units. Other sliders run from a third to three times the first value."""

WHOLE = 1500
PANEL_COLUMNS = 300
"""Largest number of samples of a run that is drawn whole, and number of columns of a longer run.

A column of a panel is one or two pixels wide. It shows the first, last, smallest and largest value
in its time interval."""


def knobs(pass_of: Scenario, start: Sequence[str] = ()) -> list[dict[str, Any]]:
    """Return the description of every parameter's control on the page, one dictionary each.

    ``start`` holds the assignments ``KEY=VALUE`` of the tool that is shown first.
    """
    values = pass_of.values_of(start)
    groups = {each.key: part for part, fields in FIELDS.items() if part for each in fields.values()}
    found = []
    for key, declared in pass_of.keys().items():
        knob = _knob(declared, values[key], groups.get(key, "settings"))
        preset = knob["text"]
        if values[key] != declared.default:
            preset = "" if declared.default is None else _typed(declared, declared.default)
        found.append(knob | {"preset": preset})
    return found


def _knob(declared: Any, value: Any, group: str) -> dict[str, Any]:
    """Return the description of one parameter's control on the page.

    It holds texts and, for a number, unit and range. ``value`` is the first value, in SI units.
    ``group`` is the name of the group of controls.
    """
    words = {
        "key": declared.key,
        "label": declared.key.removesuffix("_deg").replace("_", " "),
        "group": "Contact law" if group == "contact" else group.capitalize(),
        "open": group in OFTEN,
        "meaning": declared.meaning,
        "source": declared.source,
        "needs": declared.needs,
        "optional": declared.optional,
    }
    if isinstance(declared, Choice):
        return words | {
            "unit": "",
            "between": declared.allowed,
            "start": value,
            "text": value,
            "choices": list(declared.options),
        }
    unit, size = declared.display
    ends = [each / size for each in SLIDERS.get(declared.key, ())]
    limits = [float(f"{limit / size:.6g}") for limit in (declared.lowest, declared.highest)]
    between = " to ".join(plain_number(limit, 6) for limit in limits)
    return words | {
        "unit": unit,
        "size": size,
        "between": f"from {between} {unit}".rstrip(),
        "start": None if value is None else value / size,
        "text": "" if value is None else declared.displayed(value),
        "limits": limits,
        "slider": ends,
        "whole": declared.whole,
        "mapped": not (group == "settings" or declared.whole or declared.needs or value is None)
        and declared.key not in ("knee_angle_deg", "contact_duration"),
    }


def run_of(pass_of: Scenario, start: Sequence[str], typed: Sequence[str]) -> dict[str, Any]:
    """Simulate the pass of a tool with changed parameters, and return the results for the page.

    Args:
        pass_of: the scenario that simulates a pass.
        start: assignments ``KEY=VALUE`` of the tool that the page shows first.
        typed: assignments that the user has typed; they override ``start``.
    """
    values = pass_of.values_of([*start, *typed])
    report = pass_of.run(**pass_of.built(values))
    run = report.subject.trajectory
    tool = report.subject.tool
    before = pass_of.values_of(start)
    keys = pass_of.keys()
    return {
        "answer": report.answer,
        "warnings": pass_of.warnings_of(typed, values),
        "table": cells(report.quantities),
        "simulated": [each.simulated for each in report.quantities],
        "remarks": [each for each in report.remarks if each],
        "motion": motion_data(run, tool),
        "series": series(run),
        "changed": [
            [key, *_change(keys[key], before[key], value)]
            for key, value in values.items()
            if value != before[key]
        ],
        "values": {
            key: values[key] / declared.display[1]
            for key, declared in keys.items()
            if isinstance(declared, Range) and values[key] is not None
        },
        "command": command([*start, *typed]),
    }


def _change(declared: Declaration, before: Any, after: Any) -> list[str]:
    """Return the texts of a parameter's values before and after a change.

    The texts have five digits, or full precision if they would be equal with five digits.
    """
    found = [declared.displayed(each) for each in (before, after)]
    return found if found[0] != found[1] else [_typed(declared, each) for each in (before, after)]


def _typed(declared: Declaration, value: Any) -> str:
    """Return a parameter's value as the shortest text that reads back exactly, for example ``27
    mm``.
    """
    if value is None or not isinstance(declared, Range):
        return declared.displayed(value)
    return exact_text(value, declared.key, declared.unit)


def series(run: Trajectory) -> dict[str, Any]:
    """Return the curves of a pass for the page, with the events that are marked in them.

    The curves are ``time`` (ms), ``retraction`` (degrees), ``rate``, the angular velocity relative
    to the hub (rad/s), ``speed`` of the tip (m/s) and normal ``force`` (N). A long run is drawn
    with only the samples that change a displayed curve; ``drawn`` is a text with their number.
    ``marks`` are times (ms) and names of events.
    """
    marks = [[1e3 * each.time, each.name] for each in key_events(run)]
    curves = {
        "time": 1e3 * run.time,
        "retraction": np.degrees(run.retraction),
        "rate": run.relative_rate,
        "speed": run.tip_speed,
        "force": run.normal_force,
    }
    chosen = (
        list(range(run.time.size))
        if run.time.size <= WHOLE
        else _visible_samples(run.time, list(curves.values()))
    )
    columns = {
        name: [float(f"{value:.6g}") for value in values[chosen]] for name, values in curves.items()
    }
    return {**columns, "marks": marks, "drawn": f"{len(chosen)} of {run.time.size} samples drawn"}


def _visible_samples(time: Array, curves: Sequence[Array]) -> list[int]:
    """Return the indices of the samples that change a displayed curve.

    The time is divided into equal intervals, one for each column of the panel. In each interval,
    the first sample, the last sample, and the extremes of every curve are selected.
    """
    edges = np.searchsorted(time, np.linspace(time[0], time[-1], PANEL_COLUMNS + 1)[:-1])
    kept = set[int]()
    for first, end in pairwise([*edges.tolist(), time.size]):
        if end > first:
            own = [values[first:end] for values in curves]
            kept |= {
                first + int(place) for each in own for place in (each.argmin(), each.argmax())
            } | {first, end - 1}
    return sorted(kept)


def command(assignments: Sequence[str]) -> str:
    """Return the command line that repeats the simulation with the given assignments ``KEY=VALUE``."""
    return shlex.join(
        [
            "bristle-sim",
            "cue_and_impact",
            *(part for each in assignments for part in ("--set", each)),
        ]
    )


COLOURS = {"outcome": "outcome"} | {name: label for name, (label, _) in QUANTITIES.items()}
"""Quantities that a map can show, by name, with their labels."""

DOWNLOADS = {
    "toml": "tool (TOML)",
    "json": "JSON",
    "csv": "CSV",
    "html": "page",
    "png": "picture (PNG)",
    "svg": "picture (SVG)",
}
"""Files that the page offers for download, by suffix, with their labels."""

PRESETS = {
    "27 mm wire, 2500 rpm (Zhang 2020)": "",
    "27 mm wire, 3500 rpm": "hub_speed=3500 rpm&bar_horizontal=54.12 mm&bar_vertical=10.69 mm",
    "20 mm wire, 4000 rpm": "hub_speed=4000 rpm&hub_radius=20 mm&bristle_length=20 mm&wire_diameter=0.5 mm"
    "&belt_stiffness=0.005 N m/rad&bar_radius=4 mm&bar_horizontal=40.04 mm&bar_vertical=4.69 mm&penetration=3 mm",
    "35 mm wire, 1800 rpm": "hub_speed=1800 rpm&hub_radius=40 mm&bristle_length=35 mm&wire_diameter=0.9 mm"
    "&belt_stiffness=0.05 N m/rad&bar_radius=6 mm&bar_horizontal=66.59 mm&bar_vertical=33.02 mm",
}
"""Example tools by label. The parameters that differ from the default tool are written KEY=VALUE,
joined by &. All tools except Zhang's strike radially."""


def download(pass_of: Scenario, kind: str, assignments: Sequence[str]) -> dict[str, bytes]:
    """Simulate a pass and return its results as the bytes of a file.

    ``kind`` is the suffix of the file, one of :data:`DOWNLOADS`.
    """
    values = pass_of.values_of(assignments)
    with TemporaryDirectory() as folder:
        path = Path(folder) / f"tool.{kind}"
        if kind == "toml":
            write_tool(build_parameters(Tool, values), path)
        else:
            _write(pass_of, path, values, assignments)
        return {"content": path.read_bytes()}


def _write(pass_of: Scenario, path: Path, values: Values, assignments: Sequence[str]) -> None:
    """Simulate a pass and write its results to a file of the kind that its suffix names."""
    report = pass_of.run(**pass_of.built(values))
    if path.suffix == ".json":
        write_text(path, document(pass_of.name, values, report))
    elif path.suffix == ".csv":
        assert pass_of.series is not None
        write_text(path, csv_text(pass_of.series(report)).removesuffix("\n"))
    elif path.suffix == ".html":
        write_report(
            path,
            report,
            name=pass_of.name,
            question=pass_of.question,
            command=command(assignments),
            keys=pass_of.keys(),
            values=values,
            plot=partial(draw, pass_of),
        )
    else:
        draw(pass_of, report, path)


def assignments_of(tool: Tool, pass_of: Scenario) -> list[str]:
    """Return the assignments ``KEY=VALUE`` that change the default tool into the given tool."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "tool.toml"
        write_tool(tool, path)
        return pass_of.assignments_from(str(path))[0]
