"""Reading of a measured force history from a text file with columns.

A line of headings may come first. Lines that begin with # and blank lines are ignored. Columns are
separated by tab, semicolon, comma or blanks. A comma may be the decimal sign if it does not
separate columns. A heading may include a unit, as in ``time (ms)``; otherwise s and N are assumed.
"""

import csv
import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bristle_sim.arrays import Array

TIME = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
FORCE = {"N": 1.0, "mN": 1e-3, "kN": 1e3, "lbf": 4.4482216152605}
VOLTAGE = {"V": 1.0, "mV": 1e-3}  # conversion factors of units to SI, as in TIME and FORCE

UNIT = re.compile(r"^(.*?)\s*[\[(/]\s*([^\])/]*?)\s*[\])]?$")
"""Pattern of a heading with a unit: ``time (ms)``, ``force [kN]``, ``t / us``."""

MOST = 1e100  # largest magnitude of a number in a file, so that squares and products stay finite

# Least number of points in a file. The curve fitted to the points has three unknowns even if the
# instant at which it starts is given.
FEWEST_POINTS = 4


class Column(NamedTuple):
    """A column of a file.

    Attributes:
        number: number of the column, counted from 1.
        name: heading without the unit.
        unit: unit in the heading; empty if there is none.
    """

    number: int
    name: str
    unit: str

    def __str__(self) -> str:
        return f"{self.number} ({self.name})" if self.name else str(self.number)


class Chosen(NamedTuple):
    """The column that holds the times or the forces.

    Attributes:
        column: the column.
        factor: factor that converts its numbers to SI units.
        reading: words that name the column and its unit.
    """

    column: Column
    factor: float
    reading: str


class ForceRecord(NamedTuple):
    """A force history read from a file.

    Attributes:
        time: increasing times (s) as in the file, shape (n,).
        force: forces (N), shape (n,).
        reading: sentence that names the columns and units that were read.
    """

    time: Array
    force: Array
    reading: str


def read_force_csv(
    path: str | Path,
    *,
    time_column: str | None = None,
    force_column: str | None = None,
    force_per_volt: float | None = None,
) -> ForceRecord:
    """Read a force history from a text file whose columns are separated by comma, semicolon, tab or
    blanks.

    Args:
        path: name of the file.
        time_column: heading or number of the column of times; by default the only column with a
            unit of time, or else the first column.
        force_column: heading or number of the column of forces; by default the only column with a
            unit of force, or else the only other column.
        force_per_volt: calibration of a force that was recorded as a voltage, N/V.

    Raises:
        ValueError: if the file is not of this kind; the message is one line that names the file
            and, where possible, the number of the faulty line.
    """
    lines = [
        (number, line)
        for number, line in enumerate(_lines(path), 1)
        if line.strip() and line.lstrip()[0] != "#"
    ]
    if not lines:
        raise ValueError(f"{path}: must have columns of time and force")
    sample = lines[len(lines) // 2][1].strip()
    by_blanks = (
        "\t" not in sample and ";" not in sample and re.search(r"[^,]\s", sample) is not None
    )
    separator = None if by_blanks else next((sign for sign in "\t;," if sign in sample), None)
    decimal = "." if separator == "," else ","
    rows = [(number, _cells(path, number, line, separator)) for number, line in lines]
    headed = any(_number(cell, decimal) is None for cell in rows[0][1])
    headings = rows.pop(0)[1] if headed else [""] * len(rows[0][1])
    columns = [_column(*each) for each in enumerate(headings, 1)]
    volts = " or V, mV; of a voltage force_per_volt must be given (in N/V)"
    forces = FORCE
    if force_per_volt is not None:
        forces = {unit: factor * force_per_volt for unit, factor in VOLTAGE.items()}
        volts = ", or force_per_volt must not be given"
    time = _chosen(path, "time", time_column, columns, TIME)
    columns.remove(time.column)
    force = _chosen(path, "force", force_column, columns, forces, volts)
    if len(rows) < FEWEST_POINTS:
        raise ValueError(f"{path}: must have at least {FEWEST_POINTS} points, not {len(rows)}")
    chosen = (time.column, force.column)
    values = np.array([[_value(path, *row, decimal, each) for each in chosen] for row in rows]).T
    for i in np.flatnonzero(np.diff(values[0]) <= 0.0)[:1] + 1:
        must = f"must be more than the time before, {values[0][i - 1]:g}"
        raise ValueError(f"{path}, line {rows[i][0]}: time = {values[0][i]:g}: {must}")
    reading = f"time from {time.reading}; force from {force.reading}"
    return ForceRecord(values[0] * time.factor, values[1] * force.factor, reading)


def _lines(path: str | Path) -> list[str]:
    try:
        return Path(path).read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError:
        raise ValueError(f"{path}: must be a text file (UTF-8)") from None
    except (OSError, TypeError, ValueError) as error:
        why = getattr(error, "strerror", None) or "no name of a file"
        raise ValueError(
            f"{' '.join(str(path).split())[-100:]}: must be a readable file ({why})"
        ) from None


def _cells(path: str | Path, number: int, line: str, separator: str | None) -> list[str]:
    """Return the texts between a line's separators, without surrounding blanks and quotes."""
    try:
        row = (
            next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])
            if separator
            else line.split()
        )
    except csv.Error as error:
        raise ValueError(f"{path}, line {number}: must be columns of numbers ({error})") from None
    return [cell.strip() for cell in row]


def _number(cell: str, decimal: str) -> float | None:
    """Return the number, perhaps infinite or NaN, in a cell; None if the text is no number."""
    try:
        return None if "_" in cell else float(cell.replace(decimal, "."))
    except ValueError:
        return None


def _value(path: str | Path, number: int, row: list[str], decimal: str, column: Column) -> float:
    """Return the value that a row of a file has in a column.

    ``number`` is the number of the row's line in the file, for messages. ``decimal`` is the decimal
    sign.

    Raises:
        ValueError: if the text is not a number, or the number is larger than MOST; the message
            names file, line and column.
    """
    cell = row[column.number - 1] if column.number <= len(row) else ""
    value = _number(cell, decimal)
    if value is None or not abs(value) <= MOST:
        shown = cell if len(cell) <= 40 else f"{cell[:40]}..."
        raise ValueError(
            f"{path}, line {number}: {shown!r} in column {column.number}: must be a finite number of at most {MOST:g}"
        )
    return value


def _column(number: int, heading: str) -> Column:
    """Return the description of a column, with name and unit taken from its heading.

    Either Unicode character for micro is replaced by u.
    """
    split = UNIT.match(heading)
    name, unit = split.groups() if split else (heading, "")
    return Column(number, name, unit.replace("\u00b5", "u").replace("\u03bc", "u"))


def _chosen(
    path: str | Path,
    kind: str,
    key: str | None,
    columns: list[Column],
    units: dict[str, float],
    otherwise: str = "",
) -> Chosen:
    """Return the column of the times or of the forces, with the factor that converts it to SI.

    Args:
        path: name of the file, for the message.
        kind: kind of the column, ``time`` or ``force``.
        key: heading or number of the column. If it is None, the only column with a fitting unit is
            chosen. If no or several units fit, the times are in the first column, and the forces in
            the only other column.
        columns: columns from which to choose.
        units: conversion factors of the fitting units. The first of them is assumed for a column
            without a unit.
        otherwise: advice that the message adds if the unit does not fit.

    Raises:
        ValueError: if no column or several columns fit, or the unit does not.
    """
    found = [each for each in columns if each.unit in units]
    if key is not None:
        found = [each for each in columns if key.strip() in (str(each.number), each.name)]
    elif len(found) != 1:
        found = columns if kind == "force" else columns[:1]
    if len(found) != 1:
        named = (
            f"{kind}_column = {key!r}: must be the heading or number of one of "
            if key is not None
            else "columns "
        )
        must = "" if key is not None else f": {kind}_column must say which of them is the {kind}"
        raise ValueError(f"{path}: {named}{', '.join(map(str, columns))}{must}")
    column = found[0]
    unit = column.unit or next(iter(units))
    if unit not in units:
        must = f"a {kind} must be in {', '.join(units)}{otherwise}"
        raise ValueError(f"{path}: column {column} in {unit!r}: {must}")
    reading = f"column {column}, {column.unit or f'no unit: taken as {unit}'}"
    return Chosen(column, units[unit], reading)
