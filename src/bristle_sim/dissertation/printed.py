"""The numbers printed in the dissertation, and its statements that a computation can check.

They are stored in ``printed.toml``.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, SupportsFloat

import numpy as np


@dataclass(frozen=True, slots=True)
class Printed:
    """A number as printed in the dissertation, or a statement of the dissertation in words.

    Attributes:
        where: place of the number or statement in the dissertation.
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
    """Return all printed numbers and statements, by their places in the dissertation."""
    text = Path(__file__).with_name("printed.toml").read_text(encoding="utf-8")
    return {row["where"]: Printed(**row) for row in tomllib.loads(text)["row"]}


def printed_number(where: str) -> float:
    """Return the number printed at a place of the dissertation, in its printed unit.

    A place is for example ``eq. 2.33: speed ratio R``.
    """
    return float(printed_rows()[where].printed)


def printed_cue() -> dict[str, float]:
    """Return the printed position of the bar (eq. 2.3) and speed of the bristle (fig. 4.2).

    Returns:
        ``speed``: angular velocity of the bristle relative to the hub, rad/s. ``direction``: angle
        between the workpart's normal and the line from the hub's centre to the bar, deg.
        ``horizontal`` and ``vertical``: distances of the bar from the hub's centre, m.
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
    """Return the printed impulses of table 3.1 as text, one for each of the ten segments.

    Their unit is 1e-4 N s.
    """
    return tuple(
        printed_rows()[f"table 3.1: impulse of segment {number}"].printed for number in range(1, 11)
    )


@dataclass(frozen=True, slots=True)
class Figure:
    """The value that the equations give for a printed number or statement.

    Attributes:
        value: the value; None if it cannot be computed.
        why: the likeliest reason for a difference from print. Without a difference, it is a remark
            or empty.
        holds: whether the value confirms the statement.
        allowance: extra tolerance for a printed number that was computed from rounded numbers. It
            is added to half a unit of the last printed digit.
    """

    value: SupportsFloat | None
    why: str = ""
    holds: Any = False
    allowance: float = 0.0


Figures = Mapping[str, Figure | float]
"""Computed values, by the place of the printed number or statement in the dissertation.

A value that has neither a remark nor an allowance may be a plain number."""


def within(value: Any, bound: float, why: str = "") -> Figure:
    """Return a computed value, and whether it satisfies ``abs(value) < bound``.

    ``why`` is the remark on the value.
    """
    return Figure(value, why, holds=abs(value) < bound)


def above(value: Any, bound: float, why: str = "") -> Figure:
    """Return a computed value, and whether it satisfies ``value > bound``.

    ``why`` is the remark on the value.
    """
    return Figure(value, why, holds=value > bound)


def grows(*families: Any) -> Figure:
    """Return the smallest increase along curves, and whether all curves increase.

    Each array of ``families`` holds samples of one or several curves along its last axis. An
    increase is the difference between neighbouring samples, divided by the range of all samples in
    the array. All curves increase if the smallest increase is positive.
    """
    return above(min(np.min(np.diff(values)) / np.ptp(values) for values in families), 0.0)


def linear(values: Any) -> Figure:
    """Return the deviation of equally spaced samples from a straight line, and whether it is small.

    The deviation is the largest second difference, divided by the range of the samples. It
    counts as small if it does not exceed rounding error.
    """
    return within(np.max(np.abs(np.diff(values, 2))) / np.ptp(values), 1e-12)
