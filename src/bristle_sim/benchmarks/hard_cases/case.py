"""A hard case: a trial, its promise and its result."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np


@dataclass(frozen=True, slots=True)
class Finding:
    """Result of one trial: a reproducible text, whether the promise was kept, and the number of engine steps."""

    reached: str
    ok: bool
    steps: int = 0


@dataclass(frozen=True, slots=True)
class HardCase:
    """One row of the tables.

    Attributes:
        name: of the trial, with the figures that make it hard.
        promise: the rule that must hold, with its limit and the limit's origin.
        measure: runs the case.
        quick: whether it is tried at quick effort too.
    """

    theme: str
    name: str
    promise: str
    measure: Callable[[], Finding]
    quick: bool = True

    def run(self) -> Finding:
        """Measure the case; an exception that was not promised breaks the promise."""
        try:
            return self.measure()
        except Exception as error:
            return Finding(f"{type(error).__name__}: {' '.join(str(error).split())}", False)


def row(
    theme: str,
    name: str,
    promise: str,
    measure: Callable[..., Finding],
    *given: Any,
    quick: bool = True,
    **named: Any,
) -> HardCase:
    """Return a case whose measure is called with the given arguments."""
    return HardCase(theme, name, promise, partial(measure, *given, **named), quick)


def within(value: float, limit: float, figure: str, steps: int = 0) -> Finding:
    """Return whether a figure's magnitude is at most its limit; NaN never is."""
    return Finding(f"{figure} {value:.2g}", abs(value) <= limit, steps)


def refusal(call: Callable[[], object], *words: str) -> Finding:
    """Return whether a call raises ``ValueError`` in one line with all of the words: parameter, value, unit."""
    try:
        answer = call()
    except ValueError as error:
        line = str(error)
        missing = [word for word in words if word not in line]
        lacking = f"; does not say {', '.join(missing)}" if missing else ""
        return Finding(f"refused: {line}{lacking}", not missing and "\n" not in line)
    return Finding(f"accepted: {answer!r:.80}", False)


def all_of(*findings: Finding) -> Finding:
    """Join several findings into one, which is kept if all of them are."""
    words = "; ".join(each.reached for each in findings)
    return Finding(words, all(each.ok for each in findings), sum(each.steps for each in findings))


def worst(values: Iterable[float]) -> float:
    """Return the largest magnitude: 0 without values, NaN if any value is NaN."""
    return float(np.max(np.abs([0.0, *values])))
