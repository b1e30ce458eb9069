"""Runs for the bench: from the values of its knobs to the numbers and words on its page."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.cli.output import csv_text, document, format_value
from bristle_sim.cli.scenario import Scenario, build_parameters
from bristle_sim.comparison import cells
from bristle_sim.parameters import PARTS, Tool, tool_keys
from bristle_sim.render.motion_data import motion_data
from bristle_sim.render.report import write_report
from bristle_sim.settings import Settings
from bristle_sim.tool_file import write_tool
from bristle_sim.trajectory import Trajectory
from bristle_sim.units import Choice, Computed, Range, declarations

OFTEN = ("hub", "bristle", "workpart")
"""Parts whose knobs are open when the page is loaded."""

SHOWN_IN = {"m": ("mm", 1e-3), "kg": ("mg", 1e-6), "s": ("ms", 1e-3), "Pa": ("GPa", 1e9)}
"""Units that an engineer types, and their size in SI."""

WHOLE = 1500
PANEL_COLUMNS = 300
"""Most samples of a run that a panel shows whole, and the intervals of time, each a pixel or two wide, of which it shows the first,
last, least and largest values of a longer run."""


def knobs(pass_of: Scenario, start: Sequence[str] = ()) -> list[dict[str, Any]]:
    """Return every key as a dictionary for the page; ``start`` are the assignments that the page begins with."""
    values = pass_of.values_of(start)
    groups = {
        each.key: name for name, kinds in PARTS.items() for each in declarations(kinds[0]).values()
    }
    return [
        _knob(declared, values[key], groups.get(key, "settings"))
        for key, (declared, _) in pass_of.keys().items()
    ]


def _knob(declared: Range | Choice, value: Any, group: str) -> dict[str, Any]:
    """Return one key: its words, and for a number the unit that is shown, its start and its range in that unit."""
    unit = "" if declared.unit in ("1", "word") else declared.unit
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
            "range": declared.allowed,
            "start": value,
            "choices": list(declared.options),
        }
    unit, size = SHOWN_IN.get(unit, (unit, 1.0))
    start = None if value is None else float(f"{value / size:.10g}")
    limits = [float(f"{limit / size:.6g}") for limit in (declared.lowest, declared.highest)]
    between = f"from {limits[0]:g} to {limits[1]:g}{' ' if unit else ''}{unit}"
    return words | {
        "unit": unit,
        "range": between,
        "start": start,
        "limits": limits,
        "whole": declared.whole,
    }


def run_of(pass_of: Scenario, start: Sequence[str], typed: Sequence[str]) -> dict[str, Any]:
    """Return the run for typed values on top of those that the page began with; ``error`` is the one line of a refusal."""
    try:
        values = pass_of.values_of([*start, *typed])
        report = pass_of.answer(values)
    except (ValueError, ArithmeticError) as error:
        return {"error": " ".join(str(error).split())}
    run = report.subject.trajectory
    tool = report.subject.tool
    before = pass_of.values_of(start)
    return {
        "answer": report.answer,
        "warnings": pass_of.warnings_of(typed, values),
        "table": cells(report.quantities),
        "remarks": [each for each in report.remarks if each],
        "motion": motion_data(run, tool),
        "series": series(run),
        "changed": [
            [key, format_value(before[key]), format_value(value)]
            for key, value in values.items()
            if value != before[key]
        ],
        "values": {each["key"]: each["start"] for each in knobs(pass_of, [*start, *typed])},
        "command": command([*start, *typed]),
    }


def series(run: Trajectory) -> dict[str, Any]:
    """Return the panels' curves: time in ms, retraction in degrees, rate relative to the hub, tip speed and normal force.

    ``drawn`` states the number of samples in them; others would not change a panel by a pixel.
    """
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
    return {**columns, "drawn": f"{len(chosen)} of {run.time.size} samples drawn"}


def _visible_samples(time: Array, curves: Sequence[Array]) -> list[int]:
    """Return the samples that a panel can show: in each of its columns the first, the last and every curve's extremes."""
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
    """Return the command line that repeats the run."""
    return shlex.join(
        [
            "bristle-sim",
            "cue_and_impact",
            *(part for each in assignments for part in ("--set", each)),
        ]
    )


def radial_bar(pass_of: Scenario, assignments: Sequence[str]) -> dict[str, Any]:
    """Return the assignments that place the bar, at its distance from the hub's centre, for a radial strike."""
    from bristle_sim.studies.bar_search import placed, radial_place, simulation

    try:
        values = pass_of.values_of(assignments)
        tool = build_parameters(Tool, values)
        found = placed(
            tool, radial_place(tool, simulation(Settings(accuracy=values["accuracy"]))).direction
        ).bar
    except (ValueError, ArithmeticError) as error:
        return {"error": " ".join(str(error).split())}
    assert found is not None
    return {
        "assignments": {
            "bar_horizontal": f"{found.horizontal:.9g}",
            "bar_vertical": f"{found.vertical:.9g}",
        }
    }


def download(pass_of: Scenario, kind: str, assignments: Sequence[str]) -> dict[str, Any]:
    """Return the ``text`` of a file of the run, and its ``media`` type, or its ``error``; ``kind`` is toml, json, csv or html."""
    try:
        text, media = _file(pass_of, kind, assignments)
    except (ValueError, ArithmeticError) as error:
        return {"error": " ".join(str(error).split())}
    return {"text": text, "media": media}


def _file(pass_of: Scenario, kind: str, assignments: Sequence[str]) -> tuple[str, str]:
    """Return text and media type of a file of the run."""
    values = pass_of.values_of(assignments)
    if kind == "json":
        return document(pass_of.name, values, pass_of.answer(values)) + "\n", "application/json"
    if kind == "csv" and pass_of.series is not None:
        return csv_text(pass_of.series(pass_of.answer(values))), "text/csv"
    with TemporaryDirectory() as folder:
        path = Path(folder) / f"tool.{kind}"
        if kind == "toml":
            write_tool(build_parameters(Tool, values), path)
        else:
            write_report(
                path,
                pass_of.answer(values),
                name=pass_of.name,
                question=pass_of.question,
                command=command(assignments),
                parameters=pass_of.parameter_rows(values),
            )
        return path.read_text(
            encoding="utf-8"
        ), "application/toml" if kind == "toml" else "text/html"


def assignments_of(tool: Tool | None, pass_of: Scenario) -> list[str]:
    """Return the assignments that make a tool from the defaults."""
    assignments = list[str]()
    known = pass_of.keys()
    for part, keys in tool_keys().items() if tool is not None else ():
        owner = getattr(tool, part) if part else tool
        for key, (field, _) in keys.items() if owner is not None else ():
            value = getattr(owner, field)
            if key in known and not isinstance(value, Computed | None) and value != known[key][1]:
                assignments.append(f"{key}={value}")
    return assignments
