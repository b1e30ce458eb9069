"""All printed numbers and decidable statements of the dissertation, with digits and places.

They are stored in ``printed.toml``.
"""

from __future__ import annotations

import math
import tomllib
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, SupportsFloat

import numpy as np


@dataclass(frozen=True, slots=True)
class Printed:
    """A number as printed, or a statement in words.

    Attributes:
        where: its place in the dissertation.
        printed: the number with its printed digits; empty for a statement.
        statement: the statement; empty for a number.
        unit: unit of the number.
    """

    where: str
    printed: str = ""
    statement: str = ""
    unit: str = "1"


@cache
def printed_rows() -> dict[str, Printed]:
    """Return all rows by their places, in the order of the file."""
    text = Path(__file__).with_name("printed.toml").read_text(encoding="utf-8")
    return {row["where"]: Printed(**row) for row in tomllib.loads(text)["row"]}


def printed_number(where: str) -> float:
    """Return a printed number in the unit of its row."""
    return float(printed_rows()[where].printed)


def printed_cue() -> dict[str, float]:
    """Return the printed position of the bar and speed of the bristle (eqs. 2.2 and 2.3).

    Returns:
        ``speed`` of the bristle relative to the hub, rad/s; ``direction`` of the bar, deg; and its
        coordinates ``horizontal`` and ``vertical``, m.
    """
    horizontal = 1e-3 * printed_number("eq. 2.3: bar position S_H")
    vertical = 1e-3 * printed_number("eq. 2.3: bar position S_V")
    return {
        "speed": printed_number("fig. 4.2: rate before the impact"),
        "direction": math.degrees(math.atan2(horizontal, vertical)),
        "horizontal": horizontal,
        "vertical": vertical,
    }


def printed_segments() -> tuple[str, ...]:
    """Return the printed impulses of the ten segments of table 3.1, in 1e-4 N s, with their
    digits."""
    return tuple(
        printed_rows()[f"table 3.1: impulse of segment {number}"].printed for number in range(1, 11)
    )


@dataclass(frozen=True, slots=True)
class Figure:
    """The figure that the equations give for a printed number or statement.

    Attributes:
        value: the figure; None if it cannot be computed.
        why: the likeliest reason of a difference from print; otherwise a remark, or empty.
        holds: whether the statement holds by the figure.
        allowance: addition to half a unit of the last printed digit, for a number that was computed
            from rounded ones.
    """

    value: SupportsFloat | None
    why: str = ""
    holds: Any = False
    allowance: float = 0.0


Figures = dict[str, Figure]
"""Figures by the place of their row in the dissertation."""


def within(value: Any, bound: float, why: str = "") -> Figure:
    """Return the figure of a statement that holds if the magnitude of the value is below a
    bound."""
    return Figure(value, why, holds=abs(value) < bound)


def above(value: Any, bound: float, why: str = "") -> Figure:
    """Return the figure of a statement that holds if the value is above a bound."""
    return Figure(value, why, holds=value > bound)


def grows(*families: Any) -> Figure:
    """Return the figure of the statement that all families of values grow along their last axis.

    The figure is the least increase between neighbours over the range of the values.
    """
    return above(min(np.min(np.diff(values)) / np.ptp(values) for values in families), 0.0)


def linear(values: Any) -> Figure:
    """Return the figure of the statement that the values lie on a straight line, but for rounding.

    The figure is the largest second difference over the range of the values.
    """
    return within(np.max(np.abs(np.diff(values, 2))) / np.ptp(values), 1e-12)
