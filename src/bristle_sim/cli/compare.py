"""``bristle-sim compare A.toml B.toml`` compares the passes of two tools.

A one-sentence verdict precedes a table of the parameters that differ and a table of quantities.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from bristle_sim.cli.options import Content, add_options, deliver, targets_of
from bristle_sim.cli.output import csv_text
from bristle_sim.cli.scenario import Scenario, Values
from bristle_sim.comparison import Quantity, Report
from bristle_sim.readable import aligned, amount, readable_unit, relative_text
from bristle_sim.studies.strike_measures import beside_radial

# Largest ratio of the first tool's value to that of the second at which the first counts as
# rounding error. The relative difference is then not shown.
LEAST_PART = 1e-6

VERDICT = ("normal_final_impulse", "tip_speed_at_contact")
"""The quantities that the verdict compares, besides the lag."""


def main(pass_of: Scenario, parser: argparse.ArgumentParser, arguments: Sequence[str]) -> int:
    """Print the comparison of two tools, write the requested files, and return the exit status.

    Args:
        pass_of: the scenario that simulates a pass.
        parser: parser to which the options of the command are added.
        arguments: arguments of the command.

    Raises:
        ValueError: for bad input.
        OSError: if a file cannot be written; the message names the file.
    """
    parser.add_argument("first", metavar="A.toml", help="a tool")
    parser.add_argument("second", metavar="B.toml", help="another tool")
    add_options(parser, "report", "plot", "csv")
    options = parser.parse_args(arguments)
    names = [Path(options.first).stem, Path(options.second).stem]
    tools = [
        pass_of.values_of(pass_of.typed_in(path, name)[0])
        for name, path in (("A.toml", options.first), ("B.toml", options.second))
    ]
    targets = targets_of(options, pass_of, tools[0])
    reports = [pass_of.run(**pass_of.built(values)) for values in tools]
    changed = _changes(pass_of, *tools)
    seconds = {each.name: each for each in reports[1].quantities}
    pairs = [
        (each, seconds[each.name])
        for each in reports[0].quantities
        if each.tolerance is None and each.name in seconds
    ]
    rows = [_row(*pair) for pair in pairs]
    verdict = _verdict(names, reports)

    def plot(target: Path) -> None:
        """Draw the figure of both passes."""
        from bristle_sim.render.pass_figure import pair_figure
        from bristle_sim.render.style import save_figure

        save_figure(pair_figure(names, [each.subject.trajectory for each in reports]), target)

    def page(target: Path) -> None:
        """Write the page of the comparison."""
        from bristle_sim.render.report import write_comparison

        write_comparison(target, names, reports, changed=changed, rows=rows, verdict=verdict)

    heads = ["quantity", "unit", names[0], names[1] + " (second)" * (names[0] == names[1])]
    values = [(one.name, one.unit, one.simulated, two.simulated) for one, two in pairs]
    columns = dict(zip(heads, zip(*values, strict=True), strict=True))
    keys = [["key", *names], *(changed or [["no key differs", "", ""]])]
    quantities = [["quantity", "unit", *names, "difference"], *rows]
    answers = [f"{name}: {report.answer}" for name, report in zip(names, reports, strict=True)]
    lines = [verdict, *answers, "", *aligned(keys, (0,)), "", *aligned(quantities, (0, 1))]
    contents: dict[str, Content] = {"plot": plot, "report": page, "csv": csv_text(columns)}
    deliver(options, targets, contents, "\n".join(lines))
    return 0


def _changes(pass_of: Scenario, one: Values, two: Values) -> list[list[str]]:
    """Return a table row for each key whose values differ: key, and both values in customary units."""
    return [
        [key, declared.displayed(one[key]), declared.displayed(two[key])]
        for key, declared in pass_of.keys().items()
        if one[key] != two[key]
    ]


def _verdict(names: Sequence[str], reports: Sequence[Report]) -> str:
    """Return a sentence that compares the strike of the second tool with that of the first."""
    first, second = (each.outcome_in_words for each in reports)
    if "does not strike" in (first, second):
        one, two = (each if each == "does not strike" else "strikes" for each in (first, second))
        return f"{names[0]} {one}, {names[1]} {two}."
    tables = [{each.name: each for each in report.quantities} for report in reports]
    found = []
    for name in VERDICT:
        a, b = (table[name] for table in tables)
        beside = _difference(a.simulated, b.simulated)
        found.append(
            f"{a.label} {amount(b.simulated or 0.0, b.unit)} instead of {amount(a.simulated or 0.0, a.unit)}"
            + (f" ({beside})" if beside else "")
        )
    lags = [beside_radial(table["lag_deg_at_contact"].simulated or 0.0) for table in tables]
    found.append(f"{lags[1]} instead of {lags[0]}")
    ends = (
        f"the tip of both {first}"
        if first == second
        else f"the tip {second}, that of {names[0]} {first}"
    )
    return f"{names[1]} against {names[0]}: {', '.join(found)}; {ends}."


def _difference(a: float | None, b: float | None) -> str:
    """Return the relative difference (b - a)/|a| of two values as text, in per cent or as a factor.

    The text is empty if either value is missing, or if a is so much smaller than b that a counts as
    rounding error.
    """
    if a is None or b is None or abs(a) <= LEAST_PART * abs(b):
        return ""
    return relative_text((b - a) / abs(a), "+")


def _row(first: Quantity, second: Quantity) -> list[str]:
    """Return a table row: label, unit, the values of both passes, and their relative difference."""
    a, b = first.simulated, second.simulated
    unit, size = readable_unit(first.unit, [a, b])
    shown = ["none" if each is None else f"{each / size:.6g}" for each in (a, b)]
    return [first.label, "" if unit == "1" else unit, *shown, _difference(a, b)]
