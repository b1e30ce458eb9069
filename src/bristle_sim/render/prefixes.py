"""Units with the prefix that makes numbers readable: 1.2e-3 N s is 1.2 mN·s."""

from __future__ import annotations

import math
from dataclasses import dataclass

__all__ = ["Scale", "scale_for"]

_PREFIXES = {-15: "f", -12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T"}


@dataclass(frozen=True, slots=True)
class Scale:
    """Shown numbers are ``factor`` times those in the plain unit."""

    factor: float
    unit: str


def scale_for(largest: float, unit: str) -> Scale:
    """The scale on which a number of that size lies between 1 and 1000, as far as there are prefixes from f to T."""
    size = abs(largest)
    if not 0.0 < size < math.inf:
        return Scale(1.0, unit)
    # A hair above: 999.9996 should not be written as 1000 of the smaller unit.
    exponent = 3 * math.floor(math.log10(size * (1.0 + 1e-6)) / 3.0)
    exponent = min(max(exponent, min(_PREFIXES)), max(_PREFIXES))
    return Scale(10.0**-exponent, _PREFIXES[exponent] + unit)
