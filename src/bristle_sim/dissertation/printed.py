"""All printed numbers and decidable statements of the dissertation, with their digits and places, from ``printed.toml``."""

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
    """A number as printed, or a statement in words; where it stands, its unit, and why a computed figure may differ.

    ``why`` has places for the figure, such as ``{figure:.2f}``, and for further figures, such as ``{0:.2f}``.
    """

    where: str
    printed: str = ""
    statement: str = ""
    unit: str = "1"
    why: str = ""


@cache
def printed_rows() -> dict[str, Printed]:
    """Return all rows by their places, in order."""
    rows = tomllib.loads(Path(__file__).with_name("printed.toml").read_text(encoding="utf-8"))[
        "row"
    ]
    return {row["where"]: Printed(**row) for row in rows}


def printed_number(where: str) -> float:
    """Return a printed number in its printed unit."""
    return float(printed_rows()[where].printed)


def printed_cue() -> dict[str, float]:
    """Return the printed place of the bar, deg and m, and the bristle's speed relative to the hub, rad/s (eqs. 2.2 and 2.3)."""
    horizontal, vertical = (
        1e-3 * printed_number(f"eq. 2.3: bar position {name}") for name in ("S_H", "S_V")
    )
    return {
        "speed": printed_number("fig. 4.2: rate before the impact"),
        "direction": math.degrees(math.atan2(horizontal, vertical)),
        "horizontal": horizontal,
        "vertical": vertical,
    }


def printed_segments() -> tuple[str, ...]:
    """Return the ten-segment impulses of the bristle with their digits in print, 1e-4 N s (table 3.1)."""
    return tuple(
        printed_rows()[f"table 3.1: impulse of segment {number}"].printed for number in range(1, 11)
    )


class Figure:
    """The figure that the equations give for a printed number or statement.

    Args:
        value: the figure, or None where nothing can be computed.
        further: figures for the places in the row's ``why``.
        holds: whether the figure decides that a statement holds.
        allowance: widens half a unit of the last printed digit, where a number was worked out from rounded ones.
    """

    __slots__ = ("allowance", "further", "holds", "value")

    def __init__(
        self, value: SupportsFloat | None, *further: Any, holds: Any = False, allowance: float = 0.0
    ) -> None:
        self.value = None if value is None else float(value)
        self.further = further
        self.holds = bool(holds)
        self.allowance = float(allowance)


Figures = dict[str, Figure]
"""Figures by the places of their rows."""


def within(value: Any, bound: float, *further: Any) -> Figure:
    """Return the figure of a statement that holds where its magnitude is below a bound."""
    return Figure(value, *further, holds=abs(value) < bound)


def above(value: Any, bound: float, *further: Any) -> Figure:
    """Return the figure of a statement that holds where it is above a bound."""
    return Figure(value, *further, holds=value > bound)


def grows(*families: Any) -> Figure:
    """Return the least increase along the last axis, relative to the values' range; the statement is that all grow."""
    return above(min(np.min(np.diff(values)) / np.ptp(values) for values in families), 0.0)


def linear(values: Any) -> Figure:
    """Return the largest second difference over the range, which is rounding for a straight line."""
    return within(np.max(np.abs(np.diff(values, 2))) / np.ptp(values), 1e-12)
