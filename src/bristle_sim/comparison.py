"""Comparison of simulated numbers with theory, reference and print: one row a quantity, one rule of agreement."""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import zip_longest
from types import MappingProxyType
from typing import Any

Values = Mapping[str, float | None]
"""Numbers by the names of their quantities; None where a number is not known."""

SIDES = ("simulated", "theory", "reference", "printed")


@dataclass(frozen=True, slots=True)
class Quantity:
    """One number by simulation, theory, reference and print; None where one of them does not know it.

    The unit of a pure number is "1". Simulated values are from the pymunk scene, theory from a closed form, reference from
    the independent solution, printed from the dissertation. ``tolerance`` is the largest relative difference that agrees
    (absolute where the other side is 0), or None where a difference is a finding rather than an error. ``label`` is the
    table's name of it, with its symbol; by default the name in words.
    """

    name: str
    unit: str
    simulated: float | None
    theory: float | None = None
    reference: float | None = None
    printed: float | None = None
    tolerance: float | None = None
    label: str = ""

    def __post_init__(self) -> None:
        if not self.label:
            object.__setattr__(self, "label", self.name.removesuffix("_deg").replace("_", " "))

    @property
    def judge_name(self) -> str | None:
        """What the simulated value is compared with: ``reference`` if there is one, else ``theory``, else ``print``."""
        sides = {"reference": self.reference, "theory": self.theory, "print": self.printed}
        return next((name for name, value in sides.items() if value is not None), None)

    @property
    def judge(self) -> float | None:
        """The value that the simulated one is compared with."""
        return next((each for each in (self.reference, self.theory, self.printed) if each is not None), None)

    @property
    def relative_difference(self) -> float | None:
        """(simulated - judge) / |judge|; None where it has no meaning."""
        return (self.simulated - self.judge) / abs(self.judge) if self.simulated is not None and self.judge else None

    @property
    def ok(self) -> bool | None:
        """Whether the difference is within the tolerance, which NaN never is; None without a tolerance or another value."""
        if self.tolerance is None or self.judge is None:
            return None
        difference = self.relative_difference if self.judge else self.simulated
        return difference is not None and bool(abs(difference) <= self.tolerance)

    def as_dict(self) -> dict[str, Any]:
        """The row as plain values, finite or None."""
        numbers = {name: finite(getattr(self, name)) for name in (*SIDES, "relative_difference", "tolerance")}
        return {"name": self.name, "label": self.label, "unit": self.unit, **numbers, "ok": self.ok}


def rows(
    units: Mapping[str, str | tuple[str, str]],
    simulated: Values,
    theory: Values = MappingProxyType({}),
    reference: Values = MappingProxyType({}),
    printed: Values = MappingProxyType({}),
    tolerance: float | Callable[[str], float | None] | None = None,
) -> tuple[Quantity, ...]:
    """Return a quantity for each name that has a unit, or a label and a unit, from the values of each side by name."""
    within = tolerance if callable(tolerance) else lambda _: tolerance
    sides = dict(zip(SIDES, (simulated, theory, reference, printed), strict=True))
    found = []
    for name, declared in units.items():
        label, unit = ("", declared) if isinstance(declared, str) else declared
        values = {side: given.get(name) for side, given in sides.items()}
        found.append(Quantity(name, unit, tolerance=within(name), label=label, **values))
    return tuple(found)


@dataclass(frozen=True, slots=True)
class Table:
    """A table of text cells with a title and a head."""

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def __str__(self) -> str:
        """Return the title and the aligned table for a terminal; columns but the first stand at the right."""
        lines = [self.head, *self.rows]
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        aligned = [side_by_side([[cell] for cell in line], widths, range(1, len(line)))[0] for line in lines]
        return "\n".join([f"{self.title}:", *aligned])


@dataclass(frozen=True, slots=True)
class Report:
    """The results of a scenario.

    Attributes:
        outcome: ``rebound``, ``no rebound``, ``stiction`` or ``no contact``; None where the question is not about an impact.
        phases: of the impact, in order.
        events: (name, time in s), in order.
        remarks: sentences a reader of the table should know.
        tables: further tables, beside that of the quantities.
        extra: parts of the JSON that no other scenario has.
        subject: the objects that pictures are drawn from.
        answer: the scenario's question answered in one sentence, in a person's units; empty where work was interrupted.
    """

    outcome: str | None
    quantities: tuple[Quantity, ...]
    phases: tuple[str, ...] = ()
    events: tuple[tuple[str, float], ...] = ()
    wall_s: float = 0.0
    steps: int = 0
    remarks: tuple[str, ...] = ()
    tables: tuple[Table, ...] = ()
    extra: dict[str, Any] = field(default_factory=dict)
    subject: Any = None
    answer: str = ""

    def __post_init__(self) -> None:
        """Leave rows that agree unjudged where there is no contact: values that nothing has changed confirm nothing."""
        if self.outcome == "no contact":
            unjudged = tuple(replace(each, tolerance=None) if each.ok else each for each in self.quantities)
            object.__setattr__(self, "quantities", unjudged)


class Unfinished(KeyboardInterrupt):
    """The user's interruption of long work, with a report of the finished part."""

    def __init__(self, report: Report) -> None:
        super().__init__("interrupted")
        self.report = report


def finite(value: float | None) -> float | None:
    """Return the number, or None if it is absent or not finite."""
    return float(value) if value is not None and math.isfinite(value) else None


WIDTH = 100  # columns that a table fits in
WIDEST = ("reference", "within")  # columns that are left out, in this order, where a table would be too wide with them

PREFIXES = {"G": 1e9, "M": 1e6, "k": 1e3, "": 1.0, "m": 1e-3, "u": 1e-6, "n": 1e-9}

LARGEST_PREFIX = {"s": "", "m": "", "N s": "", "g": "k", "N": "k", "N m": "k", "J": "k", "W": "k", "Pa": "G", "Hz": "k"}
"""Units that are shown with a prefix, and the largest one that is customary."""

SMALLEST_PREFIX = {"N s": "m", "N": "m"}
"""The smallest customary prefix of units that do without smaller ones."""


def table(quantities: Sequence[Quantity], width: int = WIDTH) -> str:
    """Return an aligned table for a terminal of so many columns, in units with prefixes, without empty columns.

    The relative difference names the side that it is from. Where the table would be too wide, the reference's own
    column is left out first, then the tolerance.
    """
    for digits, left_out in ((6, ()), (5, ()), (6, WIDEST[:1]), (5, WIDEST[:1]), (4, WIDEST[:1]), (4, WIDEST)):
        found = cells(quantities, digits, left_out)
        widths = [max(map(len, column)) for column in zip(*found, strict=True)]
        lines = [side_by_side([[cell] for cell in row], widths, range(2, len(row)))[0] for row in found]
        if (needed := max(map(len, lines))) <= width:
            break
    return "\n".join([lines[0], "-" * needed, *lines[1:]])


def cells(quantities: Sequence[Quantity], digits: int = 6, left_out: Sequence[str] = ()) -> list[list[str]]:
    """Return the table's cells, its head first, without columns that would be empty and those that are left out."""
    head = ["quantity", "unit", *SIDES, "difference from", "within", "ok"]
    lines = [head]
    for each in quantities:
        values = [getattr(each, side) for side in SIDES]
        unit, factor = readable_unit(each.unit, values)
        numbers = ["-" if finite(value) is None else f"{value / factor:.{digits}g}" for value in values]
        difference = _relative(each.relative_difference, "+")
        difference += "" if difference == "-" else f" {each.judge_name}"
        tail = (difference, _relative(each.tolerance), {True: "yes", False: "NO", None: "-"}[each.ok])
        lines.append([each.label, "-" if unit == "1" else unit, *numbers, *tail])
    kept = [i for i, title in enumerate(head) if title in head[:3] or any(line[i] != "-" for line in lines[1:])]
    return [[line[i] for i in kept if head[i] not in left_out] for line in lines]


def side_by_side(columns: Sequence[Sequence[str]], widths: Sequence[int], right: Container[int] = ()) -> list[str]:
    """Join cells of several lines each into the lines of a row; those whose number is in ``right`` stand at the right."""
    lines = []
    for parts in zip_longest(*columns, fillvalue=""):
        padded = zip(parts, widths, strict=True)
        aligned = [f"{part:>{width}}" if i in right else f"{part:<{width}}" for i, (part, width) in enumerate(padded)]
        lines.append("  ".join(aligned).rstrip())
    return lines


def readable_unit(unit: str, values: Sequence[float | None]) -> tuple[str, float]:
    """Return the unit with the prefix that leaves one to three digits before the point of the largest value, and its size."""
    base, own = ("g", 1e-3) if unit == "kg" else (unit, 1.0)
    largest = max((abs(value) for value in values if value is not None and math.isfinite(value)), default=0.0)
    if base not in LARGEST_PREFIX or largest == 0.0:
        return unit, 1.0
    most, least = PREFIXES[LARGEST_PREFIX[base]], PREFIXES[SMALLEST_PREFIX.get(base, "n")]
    customary = [(prefix, size) for prefix, size in PREFIXES.items() if least <= size <= most]
    fitting = (each for each in customary if largest >= each[1] * own * (1.0 - 1e-9))
    prefix, size = next(fitting, customary[-1])
    return prefix + base, size * own


def _relative(value: float | None, sign: str = "") -> str:
    """Return a relative number in per cent, or as a power of ten where it is small and as a multiple where it is large."""
    if not value or not math.isfinite(value):
        return "0" if value == 0.0 else "-"
    if 1e-4 <= abs(value) < 10.0:
        return f"{100.0 * value:{sign}.3g} %"
    return f"{value:{sign}.0e}" if abs(value) < 1.0 else f"{value:{sign}.2g} times"
