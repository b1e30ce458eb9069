"""Read a measured force history from a text file as oscilloscopes and spreadsheets export it.

Such files differ in four ways: what precedes the numbers (nothing, a heading, dozens of lines of settings, or settings
beside the first rows), the separator, the decimal sign, and the units. Eight combinations of separator and decimal sign are
tried on a sample of lines; the one in which most lines have numbers in the same columns, and least besides, is the file's.
What a file leaves open is decided as its writer most likely meant it, and refused where two readings are equally likely.
"""

from __future__ import annotations

import csv
import math
import re
from collections import Counter
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bristle_sim.arrays import Array

TIME = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
FORCE = {"N": 1.0, "mN": 1e-3, "kN": 1e3, "lbf": 4.4482216152605}
VOLTAGE = {"V": 1.0, "mV": 1e-3}  # all in SI

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

FEWEST_POINTS = 4  # fewer determine no curve: even where the start is known three unknowns are left
FEWEST_TICKS = 8  # distinct times that show by which step a clock was rounded

NAMES = {
    "time": re.compile(r"^(t|time|x|x-axis|zeit)\b", re.IGNORECASE),
    "force": re.compile(r"^(f|force|kraft)\b", re.IGNORECASE),
}
"""Headings that mark a column."""

UNIT_ROWS = {
    "time": re.compile(r"^(x|horizontal|time)[ _]?units?:?$", re.IGNORECASE),
    "force": re.compile(r"^(y|vertical|force)[ _]?units?:?$", re.IGNORECASE),
}
"""First cells of rows of settings that give a unit, as Tektronix and Keysight write them."""


class Column(NamedTuple):
    """A column of numbers: its place from 0, heading, heading without unit, and unit (empty where none is given)."""

    place: int
    heading: str
    name: str
    unit: str

    def __str__(self) -> str:
        return f"{self.place + 1} ({self.heading})" if self.heading else str(self.place + 1)


class ForceRecord(NamedTuple):
    """What a file holds: times in s on its clock, increasing, forces in N, each of shape (n,); and how it was read, in words."""

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
    """Read points of a force history from columns separated by comma, semicolon, tab or blanks.

    Lines before the numbers, blank lines and those that begin with # are no points. Decimal commas are read where the
    separator is another sign. Units (s, ms, us, ns; N, mN, kN, lbf; V, mV) are taken from headings such as ``time (ms)``,
    from a row of units, or from settings such as ``Vertical Units``; without any, s and N are assumed.

    Args:
        time_column: heading, or number from 1 on; by default the one that says it is a time, else the first.
        force_column: likewise; by default the one that says it is a force, or the only other one.
        force_per_volt: sensitivity, N/V, of a force recorded as a voltage.

    Raises ValueError in one line that names the file, and the line where there is one, for anything else.
    """
    lines = _lines(path)
    separator, decimal, places = _layout(path, lines)
    rows = [_cells(line, separator) for line in lines]
    first = next(
        number
        for number, row in enumerate(rows)
        if is_data(lines[number])
        and len(row) > places[-1]
        and all(number_in(row[i], decimal) is not None for i in places)
    )
    columns = _columns(lines[:first], rows[: first + SAMPLED_LINES], separator, places)
    time = _chosen(path, "time", time_column, columns)
    force = _chosen(path, "force", force_column, [each for each in columns if each is not time])
    numbers = [number for number, line in enumerate(lines) if number >= first and is_data(line)]
    if len(numbers) < FEWEST_POINTS:
        raise ValueError(f"{path}: {len(numbers)} points; there must be at least {FEWEST_POINTS}")
    values = np.array([_values(path, number, rows[number], decimal, (time.place, force.place)) for number in numbers]).T
    if time.unit and time.unit not in TIME:
        raise ValueError(f"{path}: column {time} in {time.unit!r}: a time must be in {', '.join(TIME)}")
    if not time.unit and (np.diff(values[0]) == 1.0).all():
        raise ValueError(
            f"{path}: column {time} counts samples: there must be a column of times, or a unit in its heading"
        )
    seconds = _increasing(path, numbers, values[0] * TIME.get(time.unit, 1.0))
    assumed = "s", "N" if force_per_volt is None else "V"
    units = [each.unit or f"no unit: taken as {unit}" for each, unit in zip((time, force), assumed, strict=True)]
    reading = f"time from column {time}, {units[0]}; force from column {force}, {units[1]}"
    return ForceRecord(seconds, values[1] * _force_unit(path, force, force_per_volt), reading)


def _values(path: str | Path, number: int, row: list[str], decimal: str, places: tuple[int, int]) -> list[float]:
    """Return the numbers in the given places of a row."""
    found = []
    for i in places:
        cell = row[i] if i < len(row) else ""
        value = number_in(cell, decimal)
        if value is None or not math.isfinite(value):
            raise ValueError(f"{path}, line {number + 1}: {cell!r} in column {i + 1}: must be a finite number")
        found.append(value)
    return found


def _layout(path: str | Path, lines: list[str]) -> tuple[str | None, str, tuple[int, ...]]:
    """Return separator, decimal sign and the columns in which most lines have numbers, and the fewest words beside them."""
    data = [line for line in lines if is_data(line)]
    sample = data[:SAMPLED_LINES] + data[SAMPLED_LINES :: max(1, len(data) // SAMPLED_LINES)]
    scored = []
    for separator, decimal in LAYOUTS:
        rows = [_cells(line, separator) for line in sample]
        places = [tuple(i for i, cell in enumerate(row) if number_in(cell, decimal) is not None) for row in rows]
        counted = Counter(each for each in places if len(each) >= 2)
        count, _, columns = max(((count, -len(each), each) for each, count in counted.items()), default=(0, 0, ()))
        filled = sum(len([*filter(None, row)]) for row, each in zip(rows, places, strict=True) if each == columns)
        scored.append((count, count * len(columns) - filled, (separator, decimal, columns)))
    lines_of_numbers, _, found = max(scored, key=lambda each: each[:2])
    if not lines_of_numbers:
        raise ValueError(f"{path}: no line with two numbers; there must be columns of time and force")
    return found


def _columns(above: list[str], rows: list[list[str]], separator: str | None, places: tuple[int, ...]) -> list[Column]:
    """Return the columns of numbers with headings and units: those of the heading, a row of units, or settings."""
    names, units = _headings([*filter(str.strip, (line.lstrip(" \t#") for line in above))], separator, places)
    settings: dict[str, str] = {}  # units from rows of settings, above the numbers or beside them
    for row in rows:
        for kind, pattern in UNIT_ROWS.items():
            if len(row) > 1 and pattern.match(row[0]):
                unit = next(filter(None, row[1:]), "")
                settings.setdefault(kind, split_unit(unit)[1] or unit)
    found = []
    for i in places:
        heading, kind = names.get(i, ""), "time" if i == places[0] else "force"
        name, unit = split_unit(heading)
        found.append(Column(i, heading, name, units.get(i, "") or unit or settings.get(kind, "")))
    return found


def _headings(
    above: list[str], separator: str | None, places: tuple[int, ...]
) -> tuple[dict[int, str], dict[int, str]]:
    """Return names and units from the line above the numbers, or the two above if the lower one holds units alone."""
    rows = []
    for line in reversed(above[-2:]):
        row = _cells(re.sub(r"\s+(?=[\[(])", "", line) if separator is None else line, separator)
        if len(row) <= places[-1] or not all(row[i] for i in places):
            break
        if any(pattern.match(row[0]) for pattern in UNIT_ROWS.values()):
            break
        rows.append({i: row[i] for i in places})
    if not rows:
        return {}, {}
    split = {i: split_unit(cell) for i, cell in rows[0].items()}
    if all(unit and not name for name, unit in split.values()):
        return (rows[1] if len(rows) > 1 else {}), {i: unit for i, (_, unit) in split.items()}
    return rows[0], {}


def is_data(line: str) -> bool:
    """Tell whether a line is neither blank nor a remark."""
    return bool(line.strip()) and not line.lstrip().startswith("#")


def _cells(line: str, separator: str | None) -> list[str]:
    """Return a line's cells, without blanks and quotes around them."""
    if separator is None:
        return line.split()
    row = next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])
    return [cell.strip() for cell in row]


def number_in(cell: str, decimal: str) -> float | None:
    """Return the number that a cell is meant as, infinite or not; None if it is none."""
    if cell.lstrip("+-") == "∞":
        return math.inf
    if "_" in cell or (decimal == "," and "." in cell):
        return None
    try:
        return float(cell.replace(decimal, "."))
    except ValueError:
        return None


def split_unit(heading: str) -> tuple[str, str]:
    """Return a heading without its unit, and the unit: one of the tables above, or as written in brackets; empty if none."""
    if (bracketed := BRACKETED.search(heading)) is not None:
        return heading[: bracketed.start()].strip(), _known(bracketed[1]) or bracketed[1]
    last = LAST.search(heading)
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


def _lines(path: str | Path) -> list[str]:
    try:
        content = Path(path).read_bytes()
    except (OSError, TypeError, ValueError) as error:
        told = getattr(error, "strerror", None) or "no name of a file"
        name = " ".join(str(path).split())[-100:]
        raise ValueError(f"{name}: must be a readable file ({told})") from None
    try:
        # A byte order mark tells UTF-16; instruments that know no UTF-8 write the micro sign in the Windows code page.
        wide = content[:2] in (b"\xff\xfe", b"\xfe\xff")
        text = content.decode("utf-16" if wide else "utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("cp1252", errors="replace")
    if "\0" in text:
        raise ValueError(f"{path}: must be a text file")
    return text.splitlines()


def _chosen(path: str | Path, kind: str, key: str | None, columns: list[Column]) -> Column:
    """Return the column that the key names, or the one that the file itself marks as time or force."""
    listed = ", ".join(str(each) for each in columns)
    if key is not None:
        numbered = [each for each in columns if key.strip() == str(each.place + 1)]
        named = numbered or [each for each in columns if key.strip() in (each.heading, each.name)]
        if len(named) != 1:
            raise ValueError(f"{path}: {kind}_column = {key!r}: must be the heading or number of one of {listed}")
        return named[0]
    if kind == "force" and len(columns) == 1:
        return columns[0]
    for marked in (
        [each for each in columns if NAMES[kind].match(each.name)],
        [each for each in columns if each.unit in (TIME if kind == "time" else FORCE)],
        columns[:1] if kind == "time" else [],
    ):
        if len(marked) == 1:
            return marked[0]
    raise ValueError(f"{path}: columns {listed}: {kind}_column must say which of them is the {kind}")


def _increasing(path: str | Path, numbers: list[int], time: Array) -> Array:
    """Return the times; equal steps where a rounded clock shows several samples at one time."""
    steps = np.diff(time)
    if (steps > 0.0).all():
        return time
    tick = float(steps.max())
    even = np.linspace(time[0], time[-1], time.size)
    rounded = (steps >= 0.0).all() and (np.abs(time - even) <= tick).all()
    if rounded and int((steps > 0.0).sum()) >= FEWEST_TICKS:
        return even
    wrong = int(np.flatnonzero(steps <= 0.0)[0]) + 1
    rule = f"must be more than the time before, {time[wrong - 1]:g} (in s)"
    raise ValueError(f"{path}, line {numbers[wrong] + 1}: time = {time[wrong]:g}: {rule}")


def _force_unit(path: str | Path, column: Column, force_per_volt: float | None) -> float:
    if column.unit in VOLTAGE or (not column.unit and force_per_volt is not None):
        if force_per_volt is None:
            raise ValueError(f"{path}: column {column} in {column.unit}: force_per_volt must be given (in N/V)")
        return VOLTAGE.get(column.unit, 1.0) * force_per_volt
    if column.unit and column.unit not in FORCE:
        raise ValueError(f"{path}: column {column} in {column.unit!r}: a force must be in {', '.join(FORCE)} or V, mV")
    if force_per_volt is not None:
        raise ValueError(f"{path}: column {column}: force_per_volt must not be given with a force in {column.unit}")
    return FORCE.get(column.unit, 1.0)
