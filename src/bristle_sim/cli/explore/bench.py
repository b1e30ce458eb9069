"""Simulations for the bench, the interactive page of a tool. They turn typed values into displayed
results.
"""

from __future__ import annotations

import shlex
from contextlib import chdir, redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from bristle_sim.cli.command import BAD_INPUT, run_scenario
from bristle_sim.cli.scenario import Scenario, Values
from bristle_sim.comparison import cells
from bristle_sim.declared import Choice, Declaration, Range
from bristle_sim.parameters import FIELDS, Tool
from bristle_sim.readable import plain_number
from bristle_sim.render.motion_data import motion_data
from bristle_sim.render.story import key_events, story_end
from bristle_sim.studies.whole_pass import QUANTITIES
from bristle_sim.tool_file import write_tool
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
"""Ranges of sliders, in SI units or deg, by parameter.

Other sliders run from a third of the parameter's first value to three times this value."""

UNMAPPED = ("knee_angle_deg", "contact_duration")
"""Parameters of a tool over which no map is drawn.

Nor is a map drawn over settings, over whole numbers, or over parameters that have an effect only
together with a certain value of another parameter."""

PROGRAM = "bristle-sim cue_and_impact"
"""Command that simulates a pass on the command line."""


def knobs(pass_of: Scenario, start: Values) -> list[dict[str, Any]]:
    """Return the description of every parameter's control on the page, one dictionary each.

    ``pass_of`` is the scenario that simulates a pass. ``start`` holds the values of the tool that
    is shown first, by key.
    """
    values = pass_of.values_of(start)
    groups = {each.key: part for part, fields in FIELDS.items() if part for each in fields.values()}
    return [
        _knob(declared, values[key], groups.get(key, "settings"))
        for key, declared in pass_of.keys().items()
    ]


def _knob(declared: Any, value: Any, group: str) -> dict[str, Any]:
    """Return the description of one parameter's control on the page.

    The description holds texts and, for a number, unit and range. ``value`` is the parameter's
    first value, in SI units or deg. ``group`` names the control's group.
    """
    text = "" if value is None else declared.displayed(value)
    preset = "" if declared.default is None else _typed(declared, declared.default)
    words = {
        "key": declared.key,
        "label": declared.key.removesuffix("_deg").replace("_", " "),
        "group": "Contact law" if group == "contact" else group.capitalize(),
        "open": group in OFTEN,
        "meaning": declared.meaning,
        "source": declared.source,
        "needs": declared.needs,
        "optional": declared.optional,
        "text": text,
        "preset": text if value == declared.default else preset,
    }
    if isinstance(declared, Choice):
        choices = [*declared.options]
        return words | {"unit": "", "between": declared.allowed, "start": value, "choices": choices}
    unit, size = declared.display
    limits = [float(f"{limit / size:.6g}") for limit in (declared.lowest, declared.highest)]
    between = " to ".join(plain_number(limit, 6) for limit in limits)
    single = group == "settings" or declared.whole or declared.needs or declared.key in UNMAPPED
    return words | {
        "unit": unit,
        "size": size,
        "between": f"from {between} {unit}".rstrip(),
        "start": None if value is None else value / size,
        "limits": limits,
        "slider": [each / size for each in SLIDERS.get(declared.key, ())],
        "whole": declared.whole,
        "mapped": value is not None and not single,
    }


def run_of(pass_of: Scenario, typed: Values, start: Values) -> dict[str, Any]:
    """Simulate the pass of a tool, and return the results for the page.

    Args:
        pass_of: the scenario that simulates a pass.
        typed: values of the tool, as texts or numbers by key.
        start: values of the tool that the page shows first, by key.
    """
    values = pass_of.values_of(typed)
    before = pass_of.values_of(start)
    report = pass_of.run(**pass_of.built(values))
    run = report.subject.trajectory
    keys = pass_of.keys()
    return {
        "answer": report.answer,
        "warnings": pass_of.warnings_of(typed, values),
        "table": cells(report.quantities),
        "simulated": [each.simulated for each in report.quantities],
        "remarks": [each for each in report.remarks if each],
        "motion": motion_data(run, report.subject.tool),
        "marks": [[1e3 * each.time, each.name] for each in key_events(run, story_end(run))],
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
        "command": shlex.join([*PROGRAM.split(), *_options(typed)]),
    }


def _options(typed: Values) -> list[str]:
    return [part for key, value in typed.items() for part in ("--set", f"{key}={value}")]


def _change(declared: Declaration, before: Any, after: Any) -> list[str]:
    """Return the texts of a parameter's values before and after a change.

    The texts have five digits, or full precision if they would be equal with five digits.
    """
    found = [declared.displayed(each) for each in (before, after)]
    return found if found[0] != found[1] else [_typed(declared, each) for each in (before, after)]


def _typed(declared: Declaration, value: Any) -> str:
    """Return the shortest text that states a parameter's value exactly, for example ``27 mm``."""
    if value is None or not isinstance(declared, Range):
        return declared.displayed(value)
    return exact_text(value, declared.key, declared.unit)


COLOURS = {"outcome": "outcome"} | {name: label for name, (label, _) in QUANTITIES.items()}
"""Quantities that a map can show, by name, with their labels."""

DOWNLOADS = {
    "toml": ("write-tool", "tool (TOML)"),
    "json": ("json", "JSON"),
    "csv": ("csv", "CSV"),
    "html": ("report", "page"),
    "png": ("plot", "picture (PNG)"),
    "svg": ("plot", "picture (SVG)"),
}
"""Files that the page offers for download: option of the command line, and label, by suffix."""

PRESETS = {
    "27 mm wire, 2500 rpm (Zhang 2020)": "",
    "27 mm wire, 3500 rpm": "hub_speed=3500 rpm&bar_horizontal=54.12 mm&bar_vertical=10.69 mm",
    "20 mm wire, 4000 rpm": "hub_speed=4000 rpm&hub_radius=20 mm&bristle_length=20 mm&wire_diameter=0.5 mm"
    "&belt_stiffness=0.005 N m/rad&bar_radius=4 mm&bar_horizontal=40.04 mm&bar_vertical=4.69 mm&penetration=3 mm",
    "35 mm wire, 1800 rpm": "hub_speed=1800 rpm&hub_radius=40 mm&bristle_length=35 mm&wire_diameter=0.9 mm"
    "&belt_stiffness=0.05 N m/rad&bar_radius=6 mm&bar_horizontal=66.59 mm&bar_vertical=33.02 mm",
}
"""Example tools by label.

The parameters that differ from those of the default tool are written KEY=VALUE, joined by &. The
wire is radial when it strikes, except in the tool of Zhang (2020)."""


def download(pass_of: Scenario, typed: Values, suffix: str) -> dict[str, bytes]:
    """Simulate a pass and return its results as the bytes of a file.

    The file is the one that the command line writes. ``suffix`` is one of :data:`DOWNLOADS`; the
    other arguments are those of :func:`run_of`.

    Raises:
        ValueError: for bad input.
    """
    name = f"tool.{suffix}"
    line = [*_options(typed), f"--{DOWNLOADS[suffix][0]}", name]
    said = StringIO()
    with (
        TemporaryDirectory() as folder,
        chdir(folder),
        redirect_stdout(StringIO()),
        redirect_stderr(said),
    ):
        if run_scenario(pass_of, line, program=PROGRAM) == BAD_INPUT:
            raise ValueError(said.getvalue().partition("error: ")[2])
        return {"content": Path(name).read_bytes()}


def typed_of(tool: Tool, pass_of: Scenario) -> dict[str, Any]:
    """Return the parameters in which a tool differs from the default tool, by key.

    The values are texts or numbers. ``pass_of`` is the scenario that simulates a pass.
    """
    with TemporaryDirectory() as folder:
        path = Path(folder) / "tool.toml"
        write_tool(tool, path)
        return pass_of.typed_in(str(path))[0]
