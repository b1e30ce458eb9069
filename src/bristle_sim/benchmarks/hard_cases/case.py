"""A hard case: what is promised, and what was reached when it was tried."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

__all__ = ["Finding", "HardCase", "both", "refusal", "same_bits", "within"]


@dataclass(frozen=True, slots=True)
class Finding:
    """What a try has shown.

    Attributes:
        reached: in words, with the figure; the same at every run.
        ok: whether the promise was kept.
        steps: engine steps that it took.
    """

    reached: str
    ok: bool
    steps: int = 0


@dataclass(frozen=True, slots=True)
class HardCase:
    """One hard case.

    Attributes:
        theme: what makes it hard; the name of the module that holds it.
        name: what is tried, with the figures that make it hard.
        promise: what must hold, with its limit.
        measure: tries it.
    """

    theme: str
    name: str
    promise: str
    measure: Callable[[], Finding]

    def run(self) -> Finding:
        """Try it; an exception nobody promised breaks the promise."""
        try:
            return self.measure()
        except Exception as error:
            return Finding(f"{type(error).__name__}: {' '.join(str(error).split())}", False)


def within(value: float, limit: float, what: str, steps: int = 0) -> Finding:
    """A figure that must not exceed its limit in size; NaN does."""
    return Finding(f"{what} {value:.2g}", abs(value) <= limit, steps)


def same_bits(first: object, second: object, what: str, steps: int = 0) -> Finding:
    """Two results that must be equal to the last bit."""
    same = repr(first) == repr(second)
    return Finding(f"{what} {'the same' if same else 'different'}", same, steps)


def refusal(call: Callable[[], object], *words: str) -> Finding:
    """A ``ValueError`` in one line that has all of the words: the parameter, the value, what is allowed."""
    try:
        answer = call()
    except ValueError as error:
        line = str(error)
        missing = [word for word in words if word not in line]
        told = f"; does not say {', '.join(missing)}" if missing else ""
        return Finding(f"refused: {line}{told}", not missing and "\n" not in line)
    return Finding(f"accepted: {answer!r:.80}", False)


def both(*findings: Finding) -> Finding:
    """Several findings as one, kept if all are."""
    return Finding(
        "; ".join(each.reached for each in findings),
        all(each.ok for each in findings),
        sum(each.steps for each in findings),
    )


def worst(values: list[float]) -> float:
    """The largest size; NaN if one is."""
    return math.nan if any(math.isnan(value) for value in values) else max(map(abs, values))
