"""Operations that serve floats and arrays alike, and checks of arguments.

The operations return a float for a float: an impact of floats takes a twentieth of the time of an
impact of arrays with one entry. The checks raise ValueError for
arguments that are not real numbers or lie outside the range of a law or formula.
"""

from __future__ import annotations

import math
from numbers import Real
from typing import Any

import numpy as np

from bristle_sim.arrays import Array, Number
from bristle_sim.declared import Range
from bristle_sim.units import shown


def select(condition: Number, chosen: Number, other: Number) -> Number:
    """Return ``chosen`` where the condition holds, and ``other`` elsewhere."""
    if isinstance(condition, bool):
        return chosen if condition else other
    return np.where(condition, chosen, other)


def sign(value: Number) -> Number:
    """Return the sign of a value: -1, 0 or 1."""
    return 1.0 * (value > 0.0) - 1.0 * (value < 0.0)


def square_root(value: Number) -> Number:
    """Return the square root of a value, which must not be negative."""
    return math.sqrt(value) if isinstance(value, float) else np.sqrt(value)


def quotient(value: Number, divisor: Number) -> Number:
    """Return value/divisor where the divisor is positive, and infinity elsewhere."""
    if isinstance(divisor, float):
        return value / divisor if divisor > 0.0 else math.inf
    quotient = np.full_like(divisor, math.inf)
    np.divide(value, divisor, out=quotient, where=divisor > 0.0)
    return quotient


def numbers(name: str, value: Any, rule: str) -> Array:
    """Convert a value to an array of floats, which may be infinite or NaN.

    ``name`` is the name of the argument, and ``rule`` the text of the requirement. Both appear in
    the message of an error.

    Raises:
        ValueError: if an entry is not a real number (text, truth value, complex number), or if rows
            differ in length.
    """
    try:
        array = np.asarray(value)
        # NumPy holds integers beyond 64 bits and fractions as objects, and would turn truth values
        # beside numbers into 1 and 0.
        plain = isinstance(value, np.ndarray) and array.dtype.kind != "O"
        entries = () if plain else np.asarray(value, dtype=object).flat
        real = all(isinstance(each, Real | None) and not isinstance(each, bool) for each in entries)
        if real and array.dtype.kind in "iufO":
            with np.errstate(over="ignore"):
                return array.astype(float, copy=False)
    except (ValueError, OverflowError):  # rows of different lengths, numbers beyond a float
        pass
    raise ValueError(f"{name} = {shown(value)}: {rule}")


def require(name: str, value: Any, holds: Any, rule: str) -> None:
    """Raise ValueError if a condition is false for any entry of a value.

    The message contains the argument's name, the first entry for which the condition is false, and
    the rule.

    Args:
        name: name of the argument.
        value: value of the argument.
        holds: the condition, which broadcasts with the value.
        rule: text of the requirement, for the message.
    """
    values, passed = np.broadcast_arrays(numbers(name, value, rule), np.asarray(holds, dtype=bool))
    if not passed.all():
        raise ValueError(f"{name} = {values[~passed][0]:g}: {rule}")


RANGES: dict[str, Range] = {
    key: Range(key, unit, low, high, source=why)
    for keys, unit, low, high, why in (
        ("rod_mass", "kg", 1e-30, 1e6, "rounding: m v^2 and v/m of the extremes are floats"),
        ("rod_length", "m", 1e-9, 1e3, "rounding: m L^2 of the extremes is a float"),
        (
            "impact_angle",
            "rad",
            0.0,
            0.5 * math.pi,
            "physics: from along the surface to straight down",
        ),
        ("friction restitution_friction", "1", 0.0, 1e9, "physics: Coulomb's; rounding: 1 + mu^2"),
        ("restitution", "1", 0.0, 1.0, "physics: no energy is gained"),
        (
            "mass_ratio",
            "1",
            1e-30,
            1e12,
            "physics: positive; rounding: n + 3 keeps either's digits",
        ),
        (
            "angle_1 angle_2",
            "rad",
            -0.5 * math.pi,
            0.5 * math.pi,
            "physics: the rods reach the surface from above",
        ),
        ("rate rate_1 rate_2", "rad/s", -1e9, 1e9, "rounding: L^2 rate^2 keeps its digits"),
        ("tangential_compliance", "1", 0.0, 1e4, "rounding: as for the energetic law"),
        ("resting_speed", "length/time", 0.0, 1e300, "physics: any finite speed"),
        ("duration", "time", 0.0, 1e9, "physics: a finite step; the engine would take NaN"),
    )
    for key in keys.split()
}
"""Range of each argument by its name, with unit, bounds and the reason for the bounds."""


def checked_numbers(**values: float) -> list[float]:
    """Check each keyword argument against its range in ``RANGES``, and return the values as floats.

    Raises:
        ValueError: for an argument outside its range.
    """
    return [RANGES[name].check(value) for name, value in values.items()]
