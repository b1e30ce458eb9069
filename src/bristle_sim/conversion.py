"""Numbers with units as a person types them, and the factors between units."""

from __future__ import annotations

import difflib
import functools
import math
import re
from pathlib import Path
from typing import Any

_UNIT = r"[A-Za-z%\u00b0\u00b5\u03bc]+(?:(?:\^|\*\*)-?\d|[\u00b2\u00b3])?"

TYPED = re.compile(
    rf"(?P<number>[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(?P<unit>{_UNIT}(?:\s*[*/\u00b7 ]\s*{_UNIT})*)?",
    re.ASCII,
)
"""A decimal number and perhaps a product of powers of units. Python's float() takes more: grouped digits, those of other
scripts, which nobody types on purpose here."""

TYPICAL_UNITS = (
    *("m", "mm", "um", "cm", "inch", "metre", "millimetre", "micrometre", "kg", "g", "mg", "gram", "s", "ms", "us", "second"),
    *("rad/s", "rpm", "deg/s", "rad", "deg", "degree", "N m/rad", "N m/deg", "mN m/rad", "mN m/deg", "N mm/rad", "N mm/deg", "N", "mN", "kN", "Hz", "kHz", "m/s", "m/s^2"),
    *("Pa", "kPa", "MPa", "GPa", "N/mm^2", "N/m", "N/V", "N/mV", "percent"),
)  # fmt: skip
"""Units that a mistyped one is compared with."""


def conversion(unit: str, to: str) -> float | None:
    """Return the factor that converts a number from one unit to another; None between different dimensions.

    An angle is a dimension of its own here: 250 Hz are not 250 rad/s, nor N m the same as N m/rad.
    """
    try:
        factor = float(_registry().Quantity(1.0, unit).to(to.replace(" ", "*")).magnitude)
    except Exception:  # pint passes on whatever its parser meets: TokenError, ZeroDivisionError, AssertionError, ...
        return None
    return factor if math.isfinite(factor) and factor > 0.0 else None


def likely_unit(unit: str, to: str) -> str:
    """Return advice: the convertible unit with the most similar name; empty if none is similar."""
    fitting = {_unspaced(name): name for name in TYPICAL_UNITS if conversion(name, to) is not None}
    closeness = (
        0.6 if conversion(unit, unit) is None else 1.0
    )  # an existing unit matches only the same letters
    likely = difflib.get_close_matches(_unspaced(unit), fitting, n=1, cutoff=closeness)
    return f"; did you mean {fitting[likely[0]]}?" if likely else ""


def _unspaced(unit: str) -> str:
    """Return a unit in small letters without blanks and signs of multiplication."""
    return re.sub(r"[\s*\u00b7]", "", unit).lower()


@functools.cache
def _registry() -> Any:
    import pint

    registry: Any = pint.UnitRegistry(filename=None)
    registry.load_definitions(Path(pint.__file__).with_name("default_en.txt"))
    registry.define("radian = [plane_angle] = rad")
    return registry
