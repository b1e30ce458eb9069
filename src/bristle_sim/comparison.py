"""Comparison of simulated numbers with theory, reference and print: one row a quantity, one rule of agreement, and its words."""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import zip_longest
from types import MappingProxyType
from typing import Any

from bristle_sim.conversion import plain_number

Values = Mapping[str, float | None]
"""Numbers by the names of their quantities; None where a number is not known."""

UNKNOWN: Values = MappingProxyType({})

SIDES = ("simulated", "theory", "reference", "printed")


@dataclass(frozen=True, slots=True)
class Quantity:
    """One number by simulation, theory, reference and print; None for a side without a value.

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
        """The side that the simulated value is compared with: ``reference`` if there is one, else ``theory``, else ``print``."""
        if self.reference is not None:
            return "reference"
        if self.theory is not None:
            return "theory"
        return None if self.printed is None else "print"

    @property
    def judge(self) -> float | None:
        """The value of that side."""
        first = self.theory if self.reference is None else self.reference
        return self.printed if first is None else first

    @property
    def relative_difference(self) -> float | None:
        """(simulated - judge) / |judge|; None where it has no meaning."""
        judge = self.judge
        return (
            (self.simulated - judge) / abs(judge) if self.simulated is not None and judge else None
        )

    @property
    def ok(self) -> bool | None:
        """Whether the difference is within the tolerance, which NaN never is; None without a tolerance or another value."""
        if self.tolerance is None or self.judge is None:
            return None
        difference = self.relative_difference if self.judge else self.simulated
        return difference is not None and bool(abs(difference) <= self.tolerance)

    def as_dict(self) -> dict[str, Any]:
        """The row as plain values, finite or None."""
        numbers = {
            name: finite(getattr(self, name))
            for name in (*SIDES, "relative_difference", "tolerance")
        }
        return {"name": self.name, "label": self.label, "unit": self.unit, **numbers, "ok": self.ok}


def rows(
    units: Mapping[str, str | tuple[str, str]],
    simulated: Values,
    theory: Values = UNKNOWN,
    reference: Values = UNKNOWN,
    printed: Values = UNKNOWN,
    tolerance: float | Callable[[str], float | None] | None = None,
) -> tuple[Quantity, ...]:
    """Return a quantity for each name that has a unit, or a label and a unit, from the values of each side by name.

    A tolerance, which may depend on the name, applies where there is a value to compare with.
    """
    found = []
    for name, declared in units.items():
        label, unit = ("", declared) if isinstance(declared, str) else declared
        row = Quantity(
            name,
            unit,
            simulated.get(name),
            theory.get(name),
            reference.get(name),
            printed.get(name),
            None,
            label,
        )
        if row.judge is not None:
            row = replace(row, tolerance=tolerance(name) if callable(tolerance) else tolerance)
        found.append(row)
    return tuple(found)


@dataclass(frozen=True, slots=True)
class Table:
    """A table of text cells with a title and a head."""

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def __str__(self) -> str:
        """Return the title and the aligned table for a terminal; columns but the first stand at the right."""
        return "\n".join([f"{self.title}:", *aligned([self.head, *self.rows], 1)])


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
        outcome_in_words: as sentences, sweeps and pages write it (``ContactRecord.outcome_in_words``); empty with no outcome.
        not_reached: the sentence on an accuracy that a run has not reached (``Trajectory.accuracy_not_reached``). It becomes the
            last remark; where it begins with "accuracy not reached", the answer does so, too.
    """

    outcome: str | None = None
    quantities: tuple[Quantity, ...] = ()
    phases: tuple[str, ...] = ()
    events: tuple[tuple[str, float], ...] = ()
    wall_s: float = 0.0
    steps: int = 0
    remarks: tuple[str, ...] = ()
    tables: tuple[Table, ...] = ()
    extra: dict[str, Any] = field(default_factory=dict)
    subject: Any = None
    answer: str = ""
    not_reached: str = ""
    outcome_in_words: str = ""

    def __post_init__(self) -> None:
        """State an accuracy that was not reached, and leave rows that agree unjudged where there is no contact.

        Values that nothing has changed confirm nothing.
        """
        if self.not_reached:
            if self.not_reached.startswith("accuracy not reached"):
                object.__setattr__(self, "answer", f"Accuracy not reached: {self.answer}")
            object.__setattr__(self, "remarks", (*self.remarks, self.not_reached))
            object.__setattr__(self, "not_reached", "")
        if self.outcome == "no contact":
            unjudged = tuple(
                replace(each, tolerance=None) if each.ok else each for each in self.quantities
            )
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

LAYOUTS = (
    (6, ()),
    (5, ()),
    (6, ("reference",)),
    (5, ("reference",)),
    (4, ("reference",)),
    (4, ("reference", "within")),
)
"""Digits, and columns that are left out, of ever narrower tables."""

PREFIXES = {"n": 1e-9, "µ": 1e-6, "m": 1e-3, "": 1.0, "k": 1e3, "M": 1e6, "G": 1e9}

LARGEST_PREFIX = {
    "s": "",
    "m": "",
    "N s": "",
    "Pa": "G",
    **dict.fromkeys(("g", "N", "N m", "J", "W", "Hz"), "k"),
}
"""Units that are shown with a prefix, and the largest one that is customary."""

SMALLEST_PREFIX = {"N s": "m", "N": "m"}
"""The smallest customary prefix of units for which smaller ones are unusual."""


def table(quantities: Sequence[Quantity], width: int = WIDTH) -> str:
    """Return an aligned table for a terminal of that width, in units with prefixes, without empty columns.

    The relative difference names the side that it is from. Where the table would be too wide, the reference's own
    column is left out first, then the tolerance.
    """
    for layout in LAYOUTS:
        head, *lines = aligned(cells(quantities, *layout), 2)
        needed = max(map(len, [head, *lines]))
        if needed <= width:
            break
    return "\n".join([head, "-" * needed, *lines])


def cells(
    quantities: Sequence[Quantity], digits: int = 6, left_out: Sequence[str] = ()
) -> list[list[str]]:
    """Return the table's cells, its head first, without columns that would be empty and those that are left out."""
    head = ["quantity", "unit", *SIDES, "difference from", "within", "ok"]
    lines = [head]
    for each in quantities:
        values = [getattr(each, side) for side in SIDES]
        unit, factor = readable_unit(each.unit, values)
        numbers = [
            "-" if finite(value) is None else f"{value / factor:.{digits}g}" for value in values
        ]
        difference = _relative(each.relative_difference, "+")
        difference += "" if difference == "-" else f" {each.judge_name}"
        tail = (
            difference,
            _relative(each.tolerance),
            {True: "yes", False: "NO", None: "-"}[each.ok],
        )
        lines.append([each.label, "-" if unit == "1" else unit, *numbers, *tail])
    columns = list(zip(*lines, strict=True))
    kept = [
        each
        for each in columns
        if each[0] not in left_out and (each[0] in head[:3] or {*each[1:]} - {"-"})
    ]
    return list(map(list, zip(*kept, strict=True)))


def aligned(lines: Sequence[Sequence[str]], left: int) -> list[str]:
    """Return the rows of a table as text; its first columns stand at the left, the others at the right."""
    columns = list(zip(*lines, strict=True))
    return side_by_side(
        columns, [max(map(len, column)) for column in columns], range(left, len(columns))
    )


def side_by_side(
    columns: Sequence[Sequence[str]], widths: Sequence[int], right: Container[int] = ()
) -> list[str]:
    """Join cells of several lines each into the lines of a row; those whose number is in ``right`` stand at the right."""
    lines = []
    for parts in zip_longest(*columns, fillvalue=""):
        padded = zip(parts, widths, strict=True)
        shown = [
            part.rjust(width) if i in right else part.ljust(width)
            for i, (part, width) in enumerate(padded)
        ]
        lines.append("  ".join(shown).rstrip())
    return lines


def readable_unit(unit: str, values: Sequence[float | None]) -> tuple[str, float]:
    """Return the unit with the prefix that leaves one to three digits before the point of the largest value, and its size."""
    base, own = ("g", 1e-3) if unit == "kg" else (unit, 1.0)
    largest = max(map(abs, filter(None, map(finite, values))), default=0.0)
    shown = unit, 1.0
    if base in LARGEST_PREFIX and largest:
        most, least = PREFIXES[LARGEST_PREFIX[base]], PREFIXES[SMALLEST_PREFIX.get(base, "n")]
        for prefix, size in PREFIXES.items():
            if size == least or (least < size <= most and largest >= size * own * (1.0 - 1e-9)):
                shown = prefix + base, size * own
    return shown


def _relative(value: float | None, sign: str = "") -> str:
    """Return a relative number in per cent, or as a power of ten where it is small and as a multiple where it is large."""
    if not value or not math.isfinite(value):
        return "0" if value == 0.0 else "-"
    if 1e-4 <= abs(value) < 10.0:
        return f"{100.0 * value:{sign}.3g} %"
    return f"{value:{sign}.0e}" if abs(value) < 1.0 else f"{value:{sign}.2g} times"


LEAST_SIZE = 1e-12
"""Reference values below this, in SI units, count as zero; no relative difference from them is computed."""


def amount(value: float, unit: str, digits: int = 3) -> str:
    """Return a number with its unit, prefixed as an engineer writes it: ``2.75 mN s``."""
    shown, factor = readable_unit(unit, [value])
    written = {"deg": "°", "1": ""}.get(shown, f" {shown}")
    return f"{plain_number(value / factor, digits)}{written}"


def most_different(quantities: Iterable[Quantity], side: str, word: str) -> str:
    """Return the quantity whose simulated value is relatively farthest from a side, with both: ``x 3 N, printed 4 N``.

    Empty where no quantity has both values.
    """
    farthest = -1.0
    shown = ""
    for each in quantities:
        one, other = each.simulated, getattr(each, side) or 0.0
        if one is not None and abs(other) > LEAST_SIZE and abs(one / other - 1.0) > farthest:
            farthest = abs(one / other - 1.0)
            shown = f"{each.label} {amount(one, each.unit)}, {word} {amount(other, each.unit)}"
    return shown


def differences(quantities: Sequence[Quantity]) -> str:
    """Return a sentence on the largest differences from the formulas and from print; empty if there is nothing to compare."""
    formula = most_different(quantities, "theory", "by formula")
    printed = most_different(quantities, "printed", "printed")
    found = "; ".join(filter(None, (formula, printed)))
    return f" Largest differences: {found}." if found else ""


def agreement(quantities: Sequence[Quantity]) -> str:
    """Return whether the simulated values follow the closed forms: ``Yes, to 2e-16``, or the one that differs most."""
    judged = [each for each in quantities if each.ok is not None]
    missed = [each for each in judged if not each.ok]
    if judged and not missed:
        worst = max(abs(each.relative_difference or 0.0) for each in judged)
        return f"Yes, to {worst:.0e}" if worst else "Yes, to the last digit"
    differing = most_different(missed or quantities, "theory", "by formula")
    return (
        f"{'No' if missed else 'Not exactly'} ({differing})"
        if differing
        else "There is no closed form"
    )
