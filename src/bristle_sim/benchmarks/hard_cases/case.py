"""A hard case, the result of its trial, and the functions that build both."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np


@dataclass(frozen=True, slots=True)
class Finding:
    """The result of one trial.

    Attributes:
        reached: the result in words, the same in every run.
        ok: whether the promise was kept.
        steps: number of engine steps.
    """

    reached: str
    ok: bool
    steps: int = 0


@dataclass(frozen=True, slots=True)
class HardCase:
    """One trial with the promise that it must keep; a row of the tables.

    Attributes:
        name: name of the trial, with the numbers that make it hard.
        promise: statement that must hold, with its tolerance and the origin of the tolerance.
        measure: function that runs the trial.
    """

    name: str
    promise: str
    measure: Callable[[], Finding]

    def run(self) -> Finding:
        """Run the trial and return its result; an exception counts as a broken promise."""
        try:
            return self.measure()
        except Exception as error:
            return Finding(f"{type(error).__name__}: {' '.join(str(error).split())}", False)


def hard_case(
    name: str, promise: str, measure: Callable[..., Finding], *given: Any, **named: Any
) -> HardCase:
    """Return a case whose trial calls ``measure`` with the given arguments."""
    return HardCase(name, promise, partial(measure, *given, **named))


def within(value: float, limit: float, figure: str, steps: int = 0) -> Finding:
    """Return the finding whether the magnitude of a value is at most a limit; NaN is not."""
    return Finding(f"{figure} {value:.2g}", abs(value) <= limit, steps)


def all_of(*findings: Finding) -> Finding:
    """Join several findings into one, which keeps the promise if each of them does."""
    words = "; ".join(each.reached for each in findings)
    return Finding(words, all(each.ok for each in findings), sum(each.steps for each in findings))


def worst(values: Iterable[float]) -> float:
    """Return the largest magnitude of the values; 0 without values, NaN if any value is NaN."""
    return float(np.max(np.abs([0.0, *values])))
