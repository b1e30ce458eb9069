"""One line of the audit: a printed number or statement, recomputed, and a verdict.

A number counts as reproduced when the computed value lies within half a unit of the last printed digit. Where a printed
number was itself worked out from rounded ones, ``allowance`` adds what their rounding can do, and ``why`` says so. A
statement in words has a computed figure that decides whether it holds.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

REPRODUCED, DIFFERS, NOT_COMPUTABLE = "reproduced", "differs", "not computable"

SLACK = 1e-9
"""Allowance for rounding where a value lies exactly half a unit away, as a fraction of the printed number."""


@dataclass(frozen=True, slots=True)
class AuditRow:
    """A printed number or statement and what the equations give.

    Attributes:
        where: place in the dissertation, unique.
        printed: the number, or the statement in words.
        unit: of printed and computed; ``1`` for none.
        computed: the figure, or None where nothing can be computed.
        function: dotted name of the function that computes it, below ``bristle_sim``; empty where nothing does.
        status: ``reproduced``, ``differs`` or ``not computable``.
        why: for ``differs`` the likeliest reason, with figures; else a remark, or empty.
        tolerance: largest difference that counts as reproduced; None for statements.
    """

    where: str
    printed: float | str
    unit: str
    computed: float | None
    function: str
    status: str
    why: str = ""
    tolerance: float | None = None


def half_unit(printed: str) -> float:
    """Half a unit of the last digit of a number as printed, e.g. 0.5e-6 for ``1.619e-3``."""
    exponent = Decimal(printed).as_tuple().exponent
    assert isinstance(exponent, int)
    return 0.5 * 10.0**exponent


@dataclass(frozen=True, slots=True)
class Found:
    """What is computed for a row.

    Attributes:
        computed: the figure; None where nothing can be computed.
        holds: whether a statement holds; None for a number.
        told: further figures that the row's reason states.
        allowance: for a number that was itself worked out from rounded ones, absolute.
    """

    computed: float | None
    holds: bool | None = None
    told: tuple[float, ...] = ()
    allowance: float = 0.0


def audit_row(entry: Mapping[str, Any], found: Found) -> AuditRow:
    """Return the row of an entry of the table of printed numbers and statements.

    Raises:
        ArithmeticError: if a figure is not finite.
    """
    where, unit, by = entry["where"], entry.get("unit", "1"), entry.get("by", "")
    why = entry.get("why", "").format(*found.told)
    printed = entry["statement"] if "statement" in entry else float(entry["printed"])
    if found.computed is None:
        return AuditRow(where, printed, unit, None, by, NOT_COMPUTABLE, why)
    figure = _finite(where, found.computed)
    if isinstance(printed, str):
        return AuditRow(where, printed, unit, figure, by, REPRODUCED if found.holds else DIFFERS, why)
    tolerance = half_unit(entry["printed"]) + found.allowance
    same = abs(figure - printed) <= tolerance + SLACK * abs(printed)
    return AuditRow(where, printed, unit, figure, by, REPRODUCED if same else DIFFERS, why, tolerance)


def _finite(where: str, value: float) -> float:
    figure = float(value)
    if not math.isfinite(figure):
        raise ArithmeticError(f"{where}: computed {figure:g}")
    return figure
