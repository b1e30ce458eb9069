"""``bristle-sim design``: the tool in given ranges whose pass has wanted quantities, and the
sensitivity to its keys.
"""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Sequence
from typing import Any

from bristle_sim.cli.main import MISSED
from bristle_sim.cli.output import json_of, print_error, print_line, write_text
from bristle_sim.cli.scenario import Scenario, Values, build_parameters
from bristle_sim.files import checked_target
from bristle_sim.parameters import Tool, tool_keys
from bristle_sim.readable import aligned, readable_unit
from bristle_sim.studies.design import Design, design
from bristle_sim.tool_file import write_tool

OPTIONS = {
    "want": ("QUANTITY=VALUE", "a quantity of cue_and_impact that the pass must have"),
    "vary": ("KEY=FROM:TO", "a key of the tool and the range of its values"),
    "max": ("KEY=VALUE", "upper limit of a quantity, or of a key that is varied"),
    "set": ("KEY=VALUE", "another key of the tool"),
}
"""Metavariable and help of options that may be repeated."""

FILES = {"json": (), "plot": (".png", ".svg", ".pdf"), "write_tool": (".toml",)}


def main(pass_of: Scenario, parser: argparse.ArgumentParser, arguments: Sequence[str]) -> int:
    """Print the answer and write the requested files; return the exit status, 1 if the wants
    conflict.

    Raises:
        ValueError: for bad input.
        OSError: if a file cannot be written; the message names it.
    """
    for name, (metavar, words) in OPTIONS.items():
        parser.add_argument(f"--{name}", metavar=metavar, action="append", default=[], help=words)
    parser.add_argument("--minimize", metavar="QUANTITY", default="")
    parser.add_argument("--maximize", metavar="QUANTITY", default="")
    parser.add_argument("--parameters", metavar="FILE.toml", help="read the tool from a file")
    parser.add_argument("--write-tool", metavar="FILE.toml", help="write the tool that was found")
    parser.add_argument("--json", metavar="FILE|-", help="write the answer as JSON")
    parser.add_argument("--plot", metavar="FILE", help="draw the trade-off of conflicting wants")
    options = parser.parse_args(arguments)
    targets = {
        name: checked_target(path, kinds, option=f"--{name.replace('_', '-')}")
        for name, kinds in FILES.items()
        if (path := getattr(options, name)) not in (None, "-")
    }
    given = [] if options.parameters is None else pass_of.assignments_from(options.parameters)[0]
    values = pass_of.values_of([*given, *options.set])
    found = design(
        build_parameters(Tool, values),
        want=_pairs("--want", options.want),
        vary={key: text.split(":") for key, text in _pairs("--vary", options.vary).items()},
        at_most=_pairs("--max", options.max),
        minimize=options.minimize,
        maximize=options.maximize,
    )
    text = json_of("design", found.answer, values, **_fields(found, values))
    if "write_tool" in targets:
        write_tool(found.tool, targets["write_tool"])
    if "json" in targets:
        write_text(targets["json"], text)
    if "plot" in targets and not found.trade_off:
        print_error("--plot: left out, as no two wants conflict")
        del targets["plot"]
    if "plot" in targets:
        from bristle_sim.render.style import save_figure

        save_figure(found.plot(), targets["plot"])
    print_line(
        text
        if options.json == "-"
        else "\n".join([found.answer, *found.remarks, "", *_tables(found)])
    )
    for name, target in targets.items():
        print_error(f"--{name.replace('_', '-')}: wrote {target}")
    return MISSED if found.conflict else 0


def _pairs(option: str, assignments: Sequence[str]) -> dict[str, str]:
    """Return the texts of assignments by name."""
    found = {}
    for assignment in assignments:
        name, equals, text = assignment.partition("=")
        if not equals or name in found:
            raise ValueError(f"{option} {assignment!r}: must be NAME=VALUE, each name once")
        found[name] = text
    return found


def _fields(found: Design, values: Values) -> dict[str, Any]:
    """Return the results for the JSON; ``values`` are those of the given tool's keys."""
    keys = {key for part in tool_keys().values() for key in part}
    return {
        "outcome": found.report.outcome,
        "tool": {key: value for key, value in values.items() if key in keys} | found.varied,
        "quantities": [each.as_dict() for each in found.report.quantities],
        "wants": [dataclasses.asdict(each) for each in found.wants],
        "sensitivity": found.sensitivity,
        "kept": found.kept,
        "remarks": found.remarks,
        "conflict": found.conflict,
        "trade_off": found.trade_off,
        "check": dataclasses.asdict(found.check),
    }


def _tables(found: Design) -> list[str]:
    """Return the quantities of both tools, and their changes by 1 % of each key, in aligned lines."""
    head = [
        "quantity",
        "unit",
        "given tool",
        "found tool",
        *(f"+1 % {key}" for key in found.varied),
    ]
    rows = [head]
    for each in found.report.quantities:
        changes = [
            0.01 * value * found.sensitivity[key][each.name] for key, value in found.varied.items()
        ]
        values = [found.before.get(each.name), each.simulated]
        unit, size = readable_unit(each.unit, values)
        shown = ["-" if value is None else f"{round(value / size, 6):.6g}" for value in values]
        slopes = [f"{change / size:+.3g}" for change in changes]
        rows.append([each.label, "" if unit == "1" else unit, *shown, *slopes])
    return aligned(rows, 2)
