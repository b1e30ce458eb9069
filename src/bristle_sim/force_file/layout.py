"""Find out how a text file of numbers is laid out: separator, decimal sign, columns, their headings and units.

Eight combinations of separator and decimal sign are tried on a sample of lines. The one in which most lines have numbers
in the same columns, and least besides, is the file's.
"""

from __future__ import annotations

import csv
import math
import re
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

TIME = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
FORCE = {"N": 1.0, "mN": 1e-3, "kN": 1e3, "lbf": 4.4482216152605}
VOLTAGE = {"V": 1.0, "mV": 1e-3}
"""Units in SI."""

WORDS = {
    "sec": "s", "second": "s", "sekunde": "s", "sekunden": "s", "msec": "ms", "millisecond": "ms", "usec": "us", "microsecond": "us",
    "newton": "N", "millinewton": "mN", "kilonewton": "kN", "volt": "V", "millivolt": "mV",
}  # fmt: skip
"""Spelled out, in the singular and lower case."""

BRACKETED = re.compile(r"[\[(]\s*([^\])]*?)\s*[\])]\s*$")
LAST = re.compile(r"(?:^|[\s_/,])([^\s_/,\[\]()]+)\s*$")

SAMPLED_LINES = 200  # lines at the beginning, and as many spread over the file, from which its layout is read

LAYOUTS = (("\t", "."), ("\t", ","), (";", "."), (";", ","), (",", "."), (",", ","), (None, "."), (None, ","))
"""Separators (None: blanks) and decimal signs; of two that explain a file equally well the first counts."""

UNIT_ROWS = {
    "time": re.compile(r"^(x|horizontal|time)[ _]?units?:?$", re.IGNORECASE),
    "force": re.compile(r"^(y|vertical|force)[ _]?units?:?$", re.IGNORECASE),
}
"""First cells of rows of settings that give a unit, as Tektronix and Keysight write them."""


@dataclass(frozen=True, slots=True)
class Layout:
    """How a file is written: separator, decimal sign, columns that hold numbers, and the first line that does."""

    separator: str | None
    decimal: str
    columns: tuple[int, ...]
    first: int


@dataclass(frozen=True, slots=True)
class Column:
    """A column of numbers: its place from 0, heading, heading without unit, and unit (empty where none is given)."""

    place: int
    heading: str
    name: str
    unit: str

    def __str__(self) -> str:
        return f"{self.place + 1} ({self.heading})" if self.heading else str(self.place + 1)


def find_layout(path: str | Path, lines: list[str]) -> Layout:
    """Return the layout in which most lines have numbers in the same columns, and the fewest words beside them.

    Raises:
        ValueError: if no line has two numbers.
    """
    data = [line for line in lines if is_data(line)]
    sample = data[:SAMPLED_LINES] + data[SAMPLED_LINES :: max(1, len(data) // SAMPLED_LINES)]
    scored = [(*_columns_of_numbers(sample, *written), *written) for written in LAYOUTS]
    lines_of_numbers, _, columns, separator, decimal = max(scored, key=lambda each: each[:2])
    if not lines_of_numbers:
        raise ValueError(f"{path}: no line with two numbers; there must be columns of time and force")
    rows = ((number, cells_of(line, separator)) for number, line in enumerate(lines) if is_data(line))
    first = next(number for number, row in rows if _holds(row, decimal, columns))
    return Layout(separator, decimal, columns, first)


def _holds(row: list[str], decimal: str, columns: tuple[int, ...]) -> bool:
    return len(row) > columns[-1] and all(number_in(row[i], decimal) is not None for i in columns)


def _columns_of_numbers(sample: list[str], separator: str | None, decimal: str) -> tuple[int, int, tuple[int, ...]]:
    """Return the number of lines with numbers in the same columns, minus that of their words, and the columns."""
    rows = [cells_of(line, separator) for line in sample]
    places = [tuple(i for i, cell in enumerate(row) if number_in(cell, decimal) is not None) for row in rows]
    counted = Counter(each for each in places if len(each) >= 2)
    count, _, columns = max(((count, -len(each), each) for each, count in counted.items()), default=(0, 0, ()))
    filled = sum(len([cell for cell in row if cell]) for row, each in zip(rows, places, strict=True) if each == columns)
    return count, count * len(columns) - filled, columns


def columns_of(layout: Layout, lines: list[str]) -> list[Column]:
    """Return the columns of numbers with headings and units: those of the heading, a row of units, or settings."""
    above = [line.lstrip(" \t#") for line in lines[: layout.first]]
    names, units = _headings(layout, [line for line in above if line.strip()])
    settings: dict[str, str] = {}  # units from rows of settings, above the numbers or beside them
    for row in (cells_of(line, layout.separator) for line in lines[: layout.first + SAMPLED_LINES]):
        for kind, pattern in UNIT_ROWS.items():
            if len(row) > 1 and pattern.match(row[0]):
                unit = next((cell for cell in row[1:] if cell), "")
                settings.setdefault(kind, split_unit(unit)[1] or unit)
    found = []
    for i in layout.columns:
        heading, kind = names.get(i, ""), "time" if i == layout.columns[0] else "force"
        name, unit = split_unit(heading)
        found.append(Column(i, heading, name, units.get(i, "") or unit or settings.get(kind, "")))
    return found


def _headings(layout: Layout, above: list[str]) -> tuple[dict[int, str], dict[int, str]]:
    """Return names and units from the line above the numbers, or the two above if the lower one holds units alone."""
    rows = []
    for line in reversed(above[-2:]):
        joined = re.sub(r"\s+(?=[\[(])", "", line) if layout.separator is None else line
        row = cells_of(joined, layout.separator)
        if len(row) <= layout.columns[-1] or not all(row[i] for i in layout.columns):
            break
        if any(pattern.match(row[0]) for pattern in UNIT_ROWS.values()):
            break
        rows.append({i: row[i] for i in layout.columns})
    if not rows:
        return {}, {}
    split = {i: split_unit(cell) for i, cell in rows[0].items()}
    if all(unit and not name for name, unit in split.values()):
        return (rows[1] if len(rows) > 1 else {}), {i: unit for i, (_, unit) in split.items()}
    return rows[0], {}


def is_data(line: str) -> bool:
    """Tell whether a line is neither blank nor a remark."""
    return bool(line.strip()) and not line.lstrip().startswith("#")


def cells_of(line: str, separator: str | None) -> list[str]:
    """Return a line's cells, without blanks and quotes around them."""
    if separator is None:
        return line.split()
    row = next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])
    return [cell.strip() for cell in row]


def number_in(cell: str, decimal: str) -> float | None:
    """Return the number that a cell is meant as, infinite or not; None if it is none."""
    if cell.lstrip("+-") == "∞":
        return math.inf
    try:
        return (
            None if "_" in cell else float(cell if decimal == "." else "x" if "." in cell else cell.replace(",", "."))
        )
    except ValueError:
        return None


def split_unit(heading: str) -> tuple[str, str]:
    """Return a heading without its unit, and the unit: one of the tables above, or as written in brackets; empty if none."""
    bracketed, last = BRACKETED.search(heading), LAST.search(heading)
    if bracketed is not None:
        return heading[: bracketed.start()].strip(), _known(bracketed[1]) or bracketed[1]
    if last is None or not _known(last[1]):
        return heading.strip(), ""
    return re.sub(r"[\s_/,]+(in)?$", "", heading[: last.start()]).strip(), _known(last[1])


def _known(word: str) -> str:
    # The micro sign and the Greek letter are two characters.
    plain = word.replace("µ", "u").replace("μ", "u")
    if plain in TIME or plain in FORCE or plain in VOLTAGE:
        return plain
    word = plain.lower()
    return WORDS.get(word) or WORDS.get(word.removesuffix("s"), "")
