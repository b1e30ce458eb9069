"""Attempts with bad values: what is tried, and whether each was refused in one clear line or answered with numbers."""

from __future__ import annotations

import dataclasses
import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np

from bristle_sim.declared import UnusualValueWarning

T = TypeVar("T")

BAD: tuple[Any, ...] = (
    *(math.nan, math.inf, -math.inf, 0.0, -0.0, -1.0, 5e-324, 1.7e308, -1.7e308),
    *(
        0,
        1,
        -1,
        10**400,
        -(10**400),
        True,
        False,
        None,
        "",
        "1",
        "abc",
        "one\nline",
        b"1",
        1j,
        1 + 0j,
    ),
    *(
        np.float64(0.5),
        np.float64("nan"),
        np.float32(0.5),
        np.int64(1),
        np.finfo(np.longdouble).max,
        np.bool_(True),
    ),
    *(
        np.array(0.5),
        np.array([0.5, math.nan]),
        np.array([[1, 2], [3, 4]]),
        np.array([]),
        [0.5],
        [[1], [1, 2]],
        {},
    ),
    *(object(), len, float),
)
"""What somebody might hand over for a number, and numbers themselves."""

LONGEST_LINE = 400
"""Characters of a refusal."""


@dataclass(slots=True)
class Tally:
    """Number of calls that were refused and answered, and those that did neither."""

    refused: int = 0
    taken: int = 0
    faults: list[str] = field(default_factory=list)

    def attempt(
        self, what: str, call: Callable[[], T], good: Callable[[T], bool], *words: str
    ) -> None:
        """Require a good answer, without a warning, or a refusal that has one of the words."""
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                warnings.simplefilter("ignore", UnusualValueWarning)
                kept = good(call())
        except ValueError as error:
            line = str(error)
            told = any(words in line for words in ("must be", "must have", "shape"))
            clear = "\n" not in line and len(line) <= LONGEST_LINE and told
            self._count(
                clear and (not words or any(word in line for word in words)),
                "refused",
                f"{what}: {line}",
            )
        except Exception as error:
            self._count(False, "", f"{what}: {type(error).__name__}: {error}")
        else:
            self._count(kept, "taken", f"{what}: accepted")

    def _count(self, kept: bool, how: str, told: str) -> None:
        if not kept:
            self.faults.append(" ".join(told.split()))
        elif how == "refused":
            self.refused += 1
        else:
            self.taken += 1


def finite(result: object) -> bool:
    """Return whether no number in a result is NaN or infinite."""
    if dataclasses.is_dataclass(result) and not isinstance(result, type):
        # An impulse at which slip stops is infinite where it never does.
        parts = [
            each.name for each in dataclasses.fields(result) if each.name != "slip_stop_impulse"
        ]
        return all(finite(getattr(result, name)) for name in parts)
    if isinstance(result, dict | tuple | list):
        return all(map(finite, result.values() if isinstance(result, dict) else result))
    return (
        isinstance(result, str | None)
        or callable(result)
        or bool(np.isfinite(np.asarray(result)).all())
    )
