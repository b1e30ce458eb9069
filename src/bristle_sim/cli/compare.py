"""``bristle-sim compare A.toml B.toml``: the differences of two tools, their answers and their
passes.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from bristle_sim.cli.output import format_value, print_line
from bristle_sim.cli.scenario import Scenario
from bristle_sim.comparison import Quantity, aligned, readable_unit
from bristle_sim.files import checked_target


def main(pass_of: Scenario, parser: argparse.ArgumentParser, arguments: Sequence[str]) -> int:
    """Print the comparison, write its page if one is requested, and return the exit status.

    Raises:
        ValueError: for bad input.
        OSError: if the page cannot be written; the message names the file.
    """
    parser.add_argument("first", metavar="A.toml", help="a tool")
    parser.add_argument("second", metavar="B.toml", help="another tool")
    parser.add_argument(
        "--report", metavar="FILE.html", help="write a page with the numbers and the pictures"
    )
    options = parser.parse_args(arguments)
    target = (
        None
        if options.report is None
        else checked_target(options.report, (".html",), option="--report")
    )
    names = (Path(options.first).stem, Path(options.second).stem)
    one, two = (
        pass_of.values_of(pass_of.assignments_from(path)[0])
        for path in (options.first, options.second)
    )
    reports = [pass_of.answer(one), pass_of.answer(two)]
    changed = [
        [key, format_value(one[key]), format_value(two[key])] for key in one if one[key] != two[key]
    ]
    others = {each.name: each for each in reports[1].quantities}
    shown = [
        each for each in reports[0].quantities if each.tolerance is None and each.name in others
    ]
    rows = [_row(each, others[each.name]) for each in shown]
    answers = [f"{name}: {report.answer}" for name, report in zip(names, reports, strict=True)]
    keys = aligned([["key (SI)", *names], *(changed or [["no key differs", "", ""]])], 1)
    quantities = aligned([["quantity", "unit", *names, "difference"], *rows], 2)
    print_line("\n".join([*answers, "", *keys, "", *quantities]))
    if target is not None:
        from bristle_sim.render.report import write_comparison

        write_comparison(target, names, reports, changed, rows)
        print_line(f"--report: wrote {target}")
    return 0


def _row(first: Quantity, second: Quantity) -> list[str]:
    """Return label, unit, both values and their relative difference."""
    a, b = first.simulated, second.simulated
    unit, size = readable_unit(first.unit, [a, b])
    shown = ["none" if each is None else f"{each / size:.6g}" for each in (a, b)]
    difference = "" if a is None or b is None or not a else f"{100.0 * (b - a) / abs(a):+.3g} %"
    return [first.label, "" if unit == "1" else unit, *shown, difference]
