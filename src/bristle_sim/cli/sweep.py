"""The option ``--sweep KEY=FROM:TO:N`` runs a scenario for several values of one or two parameters.

The quantities are shown as a table, JSON, CSV, curves or maps.
"""

from __future__ import annotations

import argparse
import dataclasses
import functools
import math
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bristle_sim.cli.options import Content, deliver
from bristle_sim.cli.output import csv_text, json_of
from bristle_sim.cli.scenario import Scenario, Values, build_parameters
from bristle_sim.comparison import Report
from bristle_sim.declared import Range
from bristle_sim.parameters import KEYS, Tool
from bristle_sim.readable import WIDTH, aligned
from bristle_sim.settings import Settings
from bristle_sim.studies.many_passes import unable
from bristle_sim.studies.scenario_sweep import (
    FIRST,
    Series,
    Swept,
    constants_in_words,
    extremes,
    sweep_in_arrays,
    sweep_in_words,
    sweep_of_runs,
)
from bristle_sim.units import likely_key

MOST_POINTS = 10**6
"""Largest number of values of a swept parameter."""

MOST_ROWS = 15
"""Largest number of points shown in a terminal; files contain all points."""


def run_sweep(
    scenario: Scenario, options: argparse.Namespace, typed: Values, targets: Mapping[str, Path]
) -> None:
    """Run a scenario for several values of one or two parameters, and show its quantities.

    The requested files are written. Standard output shows the answer and a table.

    Args:
        scenario: the scenario.
        options: the parsed options.
        typed: typed values of parameters, by key.
        targets: the files to write, by option.

    Raises:
        ValueError: for bad input, if no point has a result, or if the sweep needs packages of the
            optional dependency ``sweep`` that are not installed.
    """
    axes = {axis.label: axis for axis in (_axis(scenario, text) for text in options.sweep)}
    if len(axes) < len(options.sweep):
        raise ValueError(f"--sweep = {', '.join(options.sweep)}: must name each key once")
    if len(axes) > 2:
        raise ValueError(f"--sweep = {', '.join(options.sweep)}: must be one key or two")
    found = _swept(scenario, options, typed, axes)
    chosen = _chosen(found, options.quantity)
    answer = sweep_in_words(found, chosen)

    def plot(target: Path) -> None:
        """Draw the chosen quantities against the swept parameters."""
        from bristle_sim.render.style import save_figure
        from bristle_sim.render.sweep_figures import sweep_figure

        save_figure(sweep_figure(found, chosen), target)

    contents: dict[str, Content] = {"plot": plot}
    if options.csv is not None:
        contents["csv"] = csv_text(table_columns(found))
    if options.json is not None:
        values = scenario.values_of(typed)
        fixed = {key: value for key, value in values.items() if key not in axes}
        contents["json"] = json_of(scenario.name, answer, fixed, columns=table_columns(found))
    table = _rows(found, chosen) if len(axes) == 1 else _extremes(found, chosen)
    table += _wrapped("constant", constants_in_words(found))
    deliver(options, targets, contents, "\n".join([answer, "", *table]))


def _axis(scenario: Scenario, text: str) -> Series:
    """Return the swept parameter of a text KEY=FROM:TO:N, with N equally spaced values."""
    key, _, interval = text.partition("=")
    ends = interval.split(":")
    keys = scenario.keys()
    refused = f"--sweep = {text!r}"
    if len(ends) != 3 or not ends[2].isdecimal() or not 1 <= int(ends[2]) <= MOST_POINTS:
        raise ValueError(
            f"{refused}: must be KEY=FROM:TO:N with N from 1 to {MOST_POINTS}, such as friction=0.1:0.5:9"
        )
    if key not in keys:
        raise ValueError(
            f"{refused}: unknown key {key!r}; {likely_key(key, keys, '--list-keys shows all keys')}"
        )
    declared = keys[key]
    if not isinstance(declared, Range):
        raise ValueError(f"{refused}: must name a key that is a number, not a word")
    low, high = (float(declared.parse(end)) for end in ends[:2])
    return Series(key, declared.unit, np.linspace(low, high, int(ends[2])), is_key=True)


def _swept(
    scenario: Scenario, options: argparse.Namespace, typed: Values, axes: dict[str, Series]
) -> Swept:
    """Compute a sweep: all points at once in arrays if possible, otherwise one run for each point.

    Arrays are possible only for certain scenarios, tools and swept parameters. They are not used if
    worker processes or a folder of stored points are requested.

    Args:
        scenario: the scenario.
        options: the parsed options.
        typed: typed values of the other parameters, by key.
        axes: the swept parameters with their values.
    """
    values = scenario.values_of(typed)
    keys = KEYS.keys() - {"wire_links", "knee_angle_deg"}
    alone = options.workers is None and options.store is None
    if scenario.in_arrays and alone and axes.keys() <= keys and values.get("reference") != "yes":
        tool = build_parameters(Tool, values)
        if not unable(tool):
            return sweep_in_arrays(tool, build_parameters(Settings, values), axes)
    point = functools.partial(answer_at, scenario, typed)
    return sweep_of_runs(point, axes, workers=options.workers, store=options.store)


def answer_at(scenario: Scenario, typed: Values, /, **keys: float) -> Report:
    """Run a scenario at one point of a sweep, and return its report.

    The report does not list the swept parameters among its quantities.

    Args:
        scenario: the scenario.
        typed: typed values of the other parameters, by key.
        keys: values of the swept parameters.

    Raises:
        ValueError: for a refused value.
    """
    report = scenario.run(**scenario.built(scenario.values_of({**typed, **keys})))
    others = tuple(each for each in report.quantities if each.name not in keys)
    return dataclasses.replace(report, quantities=others)


def _chosen(found: Swept, requested: Sequence[str]) -> list[str]:
    """Return the names of the quantities to show: those requested, or all that vary in the sweep.

    A quantity without a value at any point is left out.
    """
    known = {name: each for name, each in found.quantities.items() if each.finite.size}
    for name in requested if known else ():
        if name not in found.quantities:
            raise ValueError(f"--quantity = {name!r}: {likely_key(name, found.quantities)}")
    changing = [name for name in (*FIRST, *known) if name in known and known[name].changes]
    return [name for name in requested or dict.fromkeys(changing) if name in known]


def table_columns(found: Swept) -> dict[str, list[Any]]:
    """Return the columns of a sweep's table, by name and unit, with one entry for each point.

    The columns are the swept parameters, the quantities, the outcome, and the reason of a failure.
    """
    grids = np.meshgrid(*(axis.values for axis in found.axes.values()), indexing="ij")
    places = dict(zip(found.axes, grids, strict=True))
    columns = {
        name if each.unit == "1" else f"{name} ({each.unit})": places.get(name, each.values)
        for name, each in (found.axes | found.quantities).items()
    }
    if found.outcome is not None:
        columns["outcome"] = found.outcome
    columns["failure"] = found.failure
    return {name: values.ravel().tolist() for name, values in columns.items()}


def _rows(found: Swept, chosen: Sequence[str]) -> list[str]:
    """Return the lines of a table of quantities for the values of one parameter.

    The table shows at most MOST_ROWS of the points.
    """
    (axis,) = found.axes.values()
    size = axis.values.size
    rows = np.linspace(0, size - 1, min(size, MOST_ROWS)).round().astype(int)
    columns = [_column(axis, rows)]
    if found.outcome is not None:
        columns.append(["", "", "outcome", *found.outcome[rows].tolist()])
    left_out = []
    for name in chosen:
        column = _column(found.quantities[name], rows)
        if sum(max(map(len, each)) + 2 for each in (*columns, column)) <= WIDTH + 2:
            columns.append(column)
        else:
            left_out.append(name)
    lines = aligned([row for row in zip(*columns, strict=True) if any(row)], ())
    return lines + _wrapped("further quantities, by --quantity or --csv", left_out)


HEAD = 16  # least width, in letters, of each of the three lines of a column's heading


def _column(series: Series, rows: Any) -> list[str]:
    """Return a column of the table as texts.

    Three lines of heading, with a readable unit, precede the values. ``rows`` are indices of the
    values.
    """
    size = series.display[1]
    words = series.heading
    width = max(HEAD, len(words) // 3 + 4)
    head = textwrap.wrap(words, width, break_long_words=False)[:3]
    values = series.values[rows] / size + 0.0
    cells = (f"{value:.5g}" if math.isfinite(value) else "-" for value in values)
    return [*[""] * (3 - len(head)), *head, *cells]


def _wrapped(title: str, parts: Sequence[str]) -> list[str]:
    """Return a title and a list of words as lines of limited width, below an empty line.

    Without words, the result is empty.
    """
    words = f"{title}: {', '.join(parts)}"
    return ["", *textwrap.wrap(words, WIDTH, subsequent_indent="  ")] if parts else []


def _extremes(found: Swept, chosen: Sequence[str]) -> list[str]:
    """Return the lines of a table of the lowest and highest value of each quantity, with their places."""
    axes = [*found.axes.values()]
    shown = [found.quantities[name] for name in chosen]
    rows = [[each.label, *extremes(each, axes)] for each in shown]
    return aligned([["quantity", "lowest", "highest"], *rows], range(3)) if rows else []
