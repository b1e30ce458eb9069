"""``--sweep KEY=FROM:TO:N``: a scenario's quantities over one or two keys, as table, JSON, CSV,
lines or maps.
"""

from __future__ import annotations

import argparse
import dataclasses
import functools
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bristle_sim.cli.output import csv_text, json_of, print_error, print_line, write_text
from bristle_sim.cli.scenario import Scenario
from bristle_sim.comparison import WIDTH, Report, Table, readable_unit
from bristle_sim.units import Range, likely_key

if TYPE_CHECKING:
    import xarray as xr

MOST_POINTS = 10**6
"""Largest number of values of a key."""

MOST_ROWS = 60
"""Largest number of points shown in a terminal; files contain all points."""


def run_sweep(scenario: Scenario, options: argparse.Namespace, targets: Mapping[str, Path]) -> None:
    """Sweep the keys, write the requested files, and print the table.

    Raises:
        ValueError: for bad input, if no point has a result, or without the extra ``sweep``.
    """
    try:
        from bristle_sim.studies.sweep import sweep_scenario
    except ImportError as error:
        raise ValueError(
            f"--sweep needs the extra sweep: pip install bristle-sim[sweep] ({error})"
        ) from error
    keys = scenario.keys()
    axes = dict(_axis(scenario, text) for text in options.sweep)
    if len(axes) < len(options.sweep):
        raise ValueError(f"--sweep = {', '.join(options.sweep)}: must name each key once")
    point = functools.partial(answer_at, scenario, tuple(options.set))
    units = {key: keys[key][0].unit for key in axes}
    found = sweep_scenario(point, axes, units=units, workers=options.workers, store=options.store)
    columns = table_columns(found)
    answer = _summary(found, axes)
    fixed = {
        key: value for key, value in scenario.values_of(options.set).items() if key not in axes
    }
    json_text = json_of(scenario.name, answer, fixed, columns=columns)
    texts = {"csv": csv_text(columns).removesuffix("\n"), "json": json_text}
    for name, target in targets.items():
        if name == "plot":
            from bristle_sim.render.style import save_figure
            from bristle_sim.render.sweep_figures import sweep_figure

            save_figure(sweep_figure(found, list(axes)), target)
        else:
            write_text(target, texts[name])
        print_error(f"--{name}: wrote {target}")
    shown = next((texts[name] for name in texts if getattr(options, name) == "-"), None)
    print_line(shown or "\n\n".join([answer, *map(str, _tables(found, list(axes)))]))


def answer_at(scenario: Scenario, assignments: Sequence[str], /, **keys: float) -> Report:
    """Return the report of a scenario at given values of its keys, which are no quantities then.

    Raises:
        ValueError: for a refused value.
    """
    report = scenario.answer(scenario.values_of(assignments, keys))
    others = tuple(each for each in report.quantities if each.name not in keys)
    return dataclasses.replace(report, quantities=others)


def _axis(scenario: Scenario, text: str) -> tuple[str, list[float]]:
    """Return a key and the values that KEY=FROM:TO:N names, in equal steps from end to end."""
    import numpy as np

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
    declared = keys[key][0]
    if not isinstance(declared, Range):
        raise ValueError(f"{refused}: must name a key that is a number, not a word")
    low, high = (float(declared.parse(end)) for end in ends[:2])
    return key, np.linspace(low, high, int(ends[2])).tolist()


def table_columns(found: xr.Dataset) -> dict[str, list[Any]]:
    """Return keys, quantities and reasons by name and unit, with one entry for each point."""
    import xarray as xr

    names = [
        *map(str, found.dims),
        *(str(name) for name in found.data_vars if name != "failure"),
        "failure",
    ]
    full = dict(zip(names, xr.broadcast(*(found[name] for name in names)), strict=True))
    units = {name: found[name].attrs.get("units", "") for name in names}
    return {
        f"{name} ({units[name]})"
        if units[name] not in ("", "1")
        else name: each.values.ravel().tolist()
        for name, each in full.items()
    }


def _summary(found: xr.Dataset, axes: dict[str, list[float]]) -> str:
    """Return the number of points, and the reasons of points without results."""
    import numpy as np

    reasons, numbers = np.unique(found["failure"].values, return_counts=True)
    over = " and ".join(f"{len(values)} values of {key}" for key, values in axes.items())
    pairs = zip(reasons.tolist(), numbers.tolist(), strict=True)
    why = "; ".join(
        f"{number} lack results: {reason.rstrip('.')}" for reason, number in pairs if reason
    )
    return f"{over}: {found['failure'].size} points" + (
        f", {why}." if why else ", all with results."
    )


def _tables(found: xr.Dataset, axes: list[str]) -> list[Table]:
    """Return the quantities over the keys in tables that fit the width; none for more than
    MOST_ROWS points.
    """
    if found["failure"].size > MOST_ROWS:
        return []
    columns = list[tuple[str, ...]]()
    quantities = [str(name) for name in found.data_vars if name != "failure"]
    for name, values in zip((*axes, *quantities), table_columns(found).values(), strict=False):
        unit, size = readable_unit(str(found[name].attrs.get("units", "1")), values)
        head = str(found[name].attrs.get("long_name", name)) + (
            f" ({unit})" if unit not in ("", "1") else ""
        )
        columns.append(
            (head, *(f"{value / size:.5g}" if math.isfinite(value) else "-" for value in values))
        )
    keys = columns[: len(axes)]
    rest = columns[len(axes) :]
    tables = []
    while rest:
        taken = [*keys, rest.pop(0)]
        while rest and sum(max(map(len, each)) + 2 for each in (*taken, rest[0])) <= WIDTH:
            taken.append(rest.pop(0))
        rows = list(zip(*taken, strict=True))
        tables.append(Table(f"over {' and '.join(axes)}", rows[0], tuple(rows[1:])))
    return tables
