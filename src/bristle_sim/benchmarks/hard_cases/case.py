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
    """A difficult simulation with the condition that its result must satisfy, the promise.

    Attributes:
        name: name of the case, with the numbers that make it hard.
        promise: the condition in words, with its tolerance and the reason for the tolerance.
        measure: function that runs the simulation and checks the condition.
    """

    name: str
    promise: str
    measure: Callable[[], Finding]

    def run(self) -> Finding:
        """Run the case and return its result; an exception counts as a broken promise."""
        try:
            return self.measure()
        except Exception as error:
            return Finding(f"{type(error).__name__}: {' '.join(str(error).split())}", False)


def hard_case(
    name: str, promise: str, measure: Callable[..., Finding], *given: Any, **named: Any
) -> HardCase:
    """Return a hard case that calls ``measure`` with the arguments ``given`` and ``named``."""
    return HardCase(name, promise, partial(measure, *given, **named))


def within(value: float, limit: float, figure: str, steps: int = 0) -> Finding:
    """Return a finding that is ok if ``abs(value) <= limit``; a NaN is not ok.

    ``figure`` names the value in the finding's text, and ``steps`` is the number of engine steps.
    """
    return Finding(f"{figure} {value:.2g}", abs(value) <= limit, steps)


def all_of(*findings: Finding) -> Finding:
    """Combine several findings into one, which is ok if all of them are."""
    words = "; ".join(each.reached for each in findings)
    return Finding(words, all(each.ok for each in findings), sum(each.steps for each in findings))


def worst(values: Iterable[float]) -> float:
    """Return the largest magnitude of the values.

    It is 0 if there are no values, and NaN if a value is NaN.
    """
    return float(np.max(np.abs([0.0, *values])))
