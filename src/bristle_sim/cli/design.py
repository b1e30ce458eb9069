"""``bristle-sim design`` finds a tool whose pass attains target values of quantities.

It varies parameters in given ranges, and prints the sensitivity of the quantities to these
parameters.
"""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from bristle_sim.cli.command import MISSED
from bristle_sim.cli.options import Content, add_options, deliver, targets_of
from bristle_sim.cli.output import json_of, print_error
from bristle_sim.cli.scenario import Scenario, assigned, build_parameters
from bristle_sim.parameters import KEYS, Tool
from bristle_sim.readable import aligned, readable_unit
from bristle_sim.studies.design import Design, design
from bristle_sim.tool_file import write_tool

OPTIONS = {
    "want": ("QUANTITY=VALUE", "a quantity of cue_and_impact that the pass must have"),
    "vary": ("KEY=FROM:TO", "a key of the tool and the range of its values"),
    "max": ("KEY=VALUE", "upper limit of a quantity, or of a key that is varied"),
}
"""Placeholder of the value, and help text, of each option that may be repeated."""


def main(pass_of: Scenario, parser: argparse.ArgumentParser, arguments: Sequence[str]) -> int:
    """Find a tool that attains the target values, print the answer, and write the requested files.

    Args:
        pass_of: the scenario that simulates a pass.
        parser: parser to which the options of the command are added.
        arguments: arguments of the command.

    Returns:
        The exit status: 1 if the targets and limits cannot be met together, otherwise 0.

    Raises:
        ValueError: for bad input.
        OSError: if a file cannot be written; the message names the file.
    """
    for name, (metavar, words) in OPTIONS.items():
        parser.add_argument(f"--{name}", metavar=metavar, action="append", default=[], help=words)
    parser.add_argument("--minimize", metavar="QUANTITY", default="")
    parser.add_argument("--maximize", metavar="QUANTITY", default="")
    add_options(parser, "set", "parameters", "write-tool", "json", "plot")
    options = parser.parse_args(arguments)
    given = {} if options.parameters is None else pass_of.typed_in(options.parameters)[0]
    values = pass_of.values_of(given | assigned("--set", options.set))
    targets = targets_of(options, pass_of, values)
    found = design(
        build_parameters(Tool, values),
        want=assigned("--want", options.want),
        vary=assigned("--vary", options.vary),
        at_most=assigned("--max", options.max),
        minimize=options.minimize,
        maximize=options.maximize,
    )
    if not found.trade_off and "plot" in targets:
        del targets["plot"]
        print_error("--plot: left out, as no two targets or limits conflict")

    def plot(target: Path) -> None:
        """Draw the trade-off between two conditions that conflict."""
        from bristle_sim.render.style import save_figure

        save_figure(found.plot(), target)

    made: dict[str, Content] = {
        "plot": plot,
        "write-tool": partial(write_tool, found.tool),
        "json": _json(found, values),
    }
    lines = [found.answer, *found.remarks, "", *_table(found)]
    deliver(options, targets, made, "\n".join(lines))
    return MISSED if found.conflict else 0


def _json(found: Design, values: Mapping[str, Any]) -> str:
    """Return a design as JSON text; ``values`` are the parameters of the given tool, by key."""
    return json_of(
        "design",
        found.answer,
        values,
        outcome=found.report.outcome,
        tool={key: value for key, value in values.items() if key in KEYS} | found.varied,
        quantities=[each.as_dict() for each in found.report.quantities],
        wants=[dataclasses.asdict(each) for each in found.wants],
        sensitivity=found.sensitivity,
        kept=found.kept,
        remarks=found.remarks,
        conflict=found.conflict,
        trade_off=found.trade_off,
        check=dataclasses.asdict(found.check),
    )


def _table(found: Design) -> list[str]:
    """Return the lines of a table that compares the given tool with the tool found.

    Each row is a quantity. A further column for each varied parameter holds the change of the
    quantity if this parameter grows by 1 %.
    """
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
        slopes = [f"{change / size:+.3g}".replace("+nan", "-") for change in changes]
        rows.append([each.label, "" if unit == "1" else unit, *shown, *slopes])
    return aligned(rows, (0, 1))
