"""Simulated beside theory, reference and print: one row a quantity, one rule for what agrees."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

__all__ = ["Quantity", "Report", "table"]


@dataclass(frozen=True, slots=True)
class Quantity:
    """One number seen from several sides; None where a side does not know it.

    Attributes:
        name, unit: what it is; unit "1" for pure numbers.
        simulated: from the pymunk scene.
        theory: from a closed form.
        reference: from the independent solution.
        printed: in the dissertation.
        tolerance: allowed relative difference (absolute where the other side is 0), or None where a difference is a
            finding rather than an error.
    """

    name: str
    unit: str
    simulated: float | None
    theory: float | None = None
    reference: float | None = None
    printed: float | None = None
    tolerance: float | None = None

    @property
    def judge(self) -> float | None:
        """What the simulated value is compared with: the reference if there is one, else theory, else print."""
        for side in (self.reference, self.theory, self.printed):
            if side is not None:
                return side
        return None

    @property
    def relative_difference(self) -> float | None:
        """(simulated - judge) / |judge|; None where it has no meaning."""
        return _relative(self.simulated, self.judge)

    @property
    def difference_from_print(self) -> float | None:
        """(simulated - printed) / |printed|."""
        return _relative(self.simulated, self.printed)

    @property
    def ok(self) -> bool | None:
        """Whether the difference is within the tolerance, which NaN never is; None where nothing is asked."""
        if self.tolerance is None or self.judge is None:
            return None
        if self.simulated is None:
            return False
        if self.judge == 0.0:
            return bool(abs(self.simulated) <= self.tolerance)
        difference = self.relative_difference
        return difference is not None and bool(abs(difference) <= self.tolerance)

    def as_dict(self) -> dict[str, Any]:
        """The row as plain values, finite or None."""
        return {
            "name": self.name,
            "unit": self.unit,
            "simulated": finite(self.simulated),
            "theory": finite(self.theory),
            "reference": finite(self.reference),
            "printed": finite(self.printed),
            "relative_difference": finite(self.relative_difference),
            "tolerance": finite(self.tolerance),
            "ok": self.ok,
        }


@dataclass(frozen=True, slots=True)
class Report:
    """What a scenario found.

    Attributes:
        outcome: ``rebound``, ``no rebound``, ``stiction`` or ``no contact``; None where no impact is asked about.
        quantities: the comparison.
        phases: of the impact, in order.
        events: (name, time in s), in order.
        wall_s, steps: what the simulation cost.
        remarks: sentences a reader of the table should know.
        extra: what a scenario adds to the JSON.
        subject: what pictures are made of.
    """

    outcome: str | None
    quantities: tuple[Quantity, ...]
    phases: tuple[str, ...] = ()
    events: tuple[tuple[str, float], ...] = ()
    wall_s: float = 0.0
    steps: int = 0
    remarks: tuple[str, ...] = ()
    extra: dict[str, Any] = field(default_factory=dict)
    subject: Any = None


def finite(value: float | None) -> float | None:
    """The number, or None for what is not one."""
    return float(value) if value is not None and math.isfinite(value) else None


def table(quantities: Sequence[Quantity]) -> str:
    """An aligned table for the terminal: quantity, unit, simulated, theory, relative difference, printed."""
    with_reference = any(row.reference is not None for row in quantities)
    head = ["quantity", "unit", "simulated", "theory"]
    head += ["reference"] if with_reference else []
    head += ["rel. diff.", "tolerance", "ok", "printed", "diff. from print"]
    rows = [head]
    for each in quantities:
        row = [each.name, each.unit, _number(each.simulated), _number(each.theory)]
        row += [_number(each.reference)] if with_reference else []
        row += [_small(each.relative_difference), _small(each.tolerance)]
        row += [{True: "yes", False: "NO", None: "-"}[each.ok], _number(each.printed)]
        row += [_small(each.difference_from_print)]
        rows.append(row)
    widths = [max(len(row[column]) for row in rows) for column in range(len(head))]
    lines = []
    for row in rows:
        words = [cell.ljust(width) for cell, width in zip(row[:2], widths[:2], strict=True)]
        words += [cell.rjust(width) for cell, width in zip(row[2:], widths[2:], strict=True)]
        lines.append("  ".join(words).rstrip())
    lines.insert(1, "-" * max(map(len, lines)))
    return "\n".join(lines)


def _relative(value: float | None, other: float | None) -> float | None:
    if value is None or other is None or other == 0.0:
        return None
    return (value - other) / abs(other)


def _number(value: float | None) -> str:
    return "-" if value is None or not math.isfinite(value) else f"{value:.7g}"


def _small(value: float | None) -> str:
    return "-" if value is None or not math.isfinite(value) else f"{value:.1e}"
