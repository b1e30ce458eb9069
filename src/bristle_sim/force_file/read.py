"""Read a measured force history from a text file as oscilloscopes and spreadsheets export it.

Such files differ in four ways: what precedes the numbers (nothing, a heading, dozens of lines of settings, or settings
beside the first rows), the separator, the decimal sign, and the units. What a file leaves open is decided as its writer
most likely meant it, and refused where two readings are equally likely. The numbers themselves are read by NumPy.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.force_file import layout as layouts
from bristle_sim.force_file.layout import FORCE, TIME, VOLTAGE, Column, Layout

FEWEST_POINTS = 4  # a file with fewer points than this determines no curve: one term has three unknowns
FEWEST_TICKS = 8  # distinct times that show by which step a clock was rounded

TIME_NAME = re.compile(r"^(t|time|x|x-axis|zeit)\b", re.IGNORECASE)
FORCE_NAME = re.compile(r"^(f|force|kraft)\b", re.IGNORECASE)


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
        path: of the file.
        time_column: heading, or number from 1 on; by default the one that says it is a time, else the first.
        force_column: likewise; by default the one that says it is a force, or the only other one.
        force_per_volt: sensitivity, N/V, of a force recorded as a voltage.

    Raises:
        ValueError: in one line that names the file, and the line where there is one, for anything else.
    """
    lines = _lines(path)
    layout = layouts.find_layout(path, lines)
    columns = layouts.columns_of(layout, lines)
    time = _chosen(path, "time", time_column, columns)
    force = _chosen(path, "force", force_column, [each for each in columns if each is not time])
    rows = [
        (number, line) for number, line in enumerate(lines[layout.first :], layout.first + 1) if layouts.is_data(line)
    ]
    if len(rows) < FEWEST_POINTS:
        raise ValueError(f"{path}: {len(rows)} points; there must be at least {FEWEST_POINTS}")
    values = _numbers(path, layout, rows, (time.place, force.place))
    if time.unit and time.unit not in TIME:
        raise ValueError(f"{path}: column {time} in {time.unit!r}: a time must be in {', '.join(TIME)}")
    if not time.unit and np.array_equal(np.diff(values[0]), np.ones(len(rows) - 1)):
        raise ValueError(
            f"{path}: column {time} counts samples: there must be a column of times, or a unit in its heading"
        )
    seconds = _increasing(path, rows, values[0] * TIME.get(time.unit, 1.0))
    assumed = "s", "N" if force_per_volt is None else "V"
    units = [each.unit or f"no unit: taken as {unit}" for each, unit in zip((time, force), assumed, strict=True)]
    reading = f"time from column {time}, {units[0]}; force from column {force}, {units[1]}"
    return ForceRecord(seconds, values[1] * _force_unit(path, force, force_per_volt), reading)


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
    pattern, units = (TIME_NAME, TIME) if kind == "time" else (FORCE_NAME, FORCE)
    for marked in (
        [each for each in columns if pattern.match(each.name)],
        [each for each in columns if each.unit in units],
        columns[:1] if kind == "time" else [],
    ):
        if len(marked) == 1:
            return marked[0]
    raise ValueError(f"{path}: columns {listed}: {kind}_column must say which of them is the {kind}")


def _numbers(path: str | Path, layout: Layout, rows: list[tuple[int, str]], places: tuple[int, int]) -> Array:
    """Return the two columns, shape (2, n)."""
    convert = None if layout.decimal == "." else (lambda cell: float(cell.replace(",", ".")))
    try:
        values = np.loadtxt(
            [line for _, line in rows],
            delimiter=layout.separator, comments=None, quotechar='"', usecols=places, converters=convert, ndmin=2, encoding=None,
        )  # fmt: skip
    except ValueError:
        values = np.full((1, 2), np.nan)
    if np.isfinite(values).all():
        return np.asarray(values.T)
    for number, line in rows:
        row = layouts.cells_of(line, layout.separator)
        for i in places:
            cell = row[i] if i < len(row) else ""
            value = layouts.number_in(cell, layout.decimal)
            if value is None or not np.isfinite(value):
                raise ValueError(f"{path}, line {number}: {cell!r} in column {i + 1}: must be a finite number")
    raise ValueError(f"{path}: must be columns of finite numbers")


def _increasing(path: str | Path, rows: list[tuple[int, str]], time: Array) -> Array:
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
    before, here = time[wrong - 1], time[wrong]
    raise ValueError(
        f"{path}, line {rows[wrong][0]}: time = {here:g}: must be more than the time before, {before:g} (in s)"
    )


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
