"""``bristle-sim compare A.toml B.toml``: what differs in two tools, in the answer and in the numbers of their passes."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from bristle_sim.cli.output import say
from bristle_sim.cli.scenario import Scenario
from bristle_sim.comparison import Quantity, Report, readable_unit, side_by_side
from bristle_sim.files import checked_target

PROGRAM = "bristle-sim compare"


def main(pass_of: Scenario, arguments: Sequence[str]) -> int:
    """Print the comparison, write its page if one is requested, and return the exit status.

    Raises:
        ValueError: for bad input.
        OSError: naming the file, if the page cannot be written.
    """
    parser = argparse.ArgumentParser(
        prog=PROGRAM, description="Compare the passes of two tools.", allow_abbrev=False, exit_on_error=False
    )
    parser.add_argument("first", metavar="A.toml", help="a tool")
    parser.add_argument("second", metavar="B.toml", help="another tool")
    parser.add_argument("--report", metavar="FILE.html", help="write a page with the numbers and the pictures")
    options = parser.parse_args(arguments)
    target = None if options.report is None else checked_target(options.report, (".html",), option="--report")
    names = (Path(options.first).stem, Path(options.second).stem)
    values = [pass_of.values_of(pass_of.assignments_from(path)[0]) for path in (options.first, options.second)]
    reports = [pass_of.answer(each) for each in values]
    changed = [
        [key, _word(values[0][key]), _word(values[1][key])] for key in values[0] if values[0][key] != values[1][key]
    ]
    rows = numbers(reports)
    lines = [f"{name}: {report.answer}" for name, report in zip(names, reports, strict=True)]
    lines += ["", *_table([["key (SI)", *names], *(changed or [["no key differs", "", ""]])])]
    lines += ["", *_table([["quantity", "unit", *names, "difference"], *rows])]
    say("\n".join(lines))
    if target is not None:
        from bristle_sim.render.comparison_page import write_comparison

        write_comparison(target, names, reports, changed, rows)
        say(f"--report: wrote {target}")
    return 0


def numbers(reports: Sequence[Report]) -> list[list[str]]:
    """Return a row for each finding that both reports have: label, unit, both values, and their relative difference."""
    second = {each.name: each for each in reports[1].quantities}
    return [
        _row(each, second[each.name])
        for each in reports[0].quantities
        if each.name in second and each.tolerance is None
    ]


def _row(first: Quantity, second: Quantity) -> list[str]:
    a, b = first.simulated, second.simulated
    unit, size = readable_unit(first.unit, [a, b])
    shown = ["none" if each is None else f"{each / size:.6g}" for each in (a, b)]
    return [
        first.label,
        "" if unit == "1" else unit,
        *shown,
        "" if a is None or b is None or not a else f"{100.0 * (b - a) / abs(a):+.3g} %",
    ]


def _table(rows: Sequence[Sequence[str]]) -> list[str]:
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    numeric = range(len(widths) - 2 if len(widths) == 3 else 2, len(widths))
    return [line for row in rows for line in side_by_side([[cell] for cell in row], widths, numeric)]


def _word(value: Any) -> str:
    return "none" if value is None else f"{value:.6g}" if isinstance(value, float) else str(value)
