"""One line of the audit: a printed number or statement, recomputed, and a verdict.

A number counts as reproduced when the computed value lies within half a unit of the last printed digit. Where a printed
number was itself worked out from rounded ones, ``allowance`` adds what their rounding can do, and ``why`` says so. A
statement in words has a computed figure that decides whether it holds.
"""

from __future__ import annotations

import math
from collections.abc import Callable
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


def number(
    where: str,
    printed: str,
    unit: str,
    computed: float,
    by: Callable[..., Any],
    why: str = "",
    *,
    allowance: float = 0.0,
) -> AuditRow:
    """Row of a printed number, given with the digits it has in print; allowance is absolute."""
    value, figure = float(printed), _finite(where, computed)
    tolerance = half_unit(printed) + allowance
    same = abs(figure - value) <= tolerance + SLACK * abs(value)
    return AuditRow(where, value, unit, figure, _name(by), REPRODUCED if same else DIFFERS, why, tolerance)


def claim(
    where: str, statement: str, unit: str, computed: float, holds: bool, by: Callable[..., Any], why: str = ""
) -> AuditRow:
    """Row of a statement in words, with the figure that decides it."""
    status = REPRODUCED if holds else DIFFERS
    return AuditRow(where, statement, unit, _finite(where, computed), _name(by), status, why)


def missing(where: str, printed: str, unit: str, why: str) -> AuditRow:
    """Row of a number that the text does not allow to compute."""
    return AuditRow(where, float(printed), unit, None, "", NOT_COMPUTABLE, why)


def _finite(where: str, value: float) -> float:
    figure = float(value)
    if not math.isfinite(figure):
        raise ArithmeticError(f"{where}: computed {figure:g}")
    return figure


def _name(function: Callable[..., Any]) -> str:
    return f"{function.__module__.removeprefix('bristle_sim.')}.{function.__qualname__}"
