"""Operations that serve floats and arrays alike, and checks of arguments.

The operations return a float for a float, for speed in a scene. The checks raise ValueError for
arguments that are not real numbers or lie outside the range of a law or formula. The arguments of
an impact law are floats for one impact, or arrays that broadcast.
"""

from __future__ import annotations

import math
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.arrays import Array, Number
from bristle_sim.declared import Range
from bristle_sim.units import shown


def select(condition: Number, chosen: Number, other: Number) -> Number:
    """Return ``chosen`` where the condition holds, otherwise ``other``."""
    if isinstance(condition, bool):
        return chosen if condition else other
    return np.where(condition, chosen, other)


def sign(value: Number) -> Number:
    """Return the sign of a value: -1, 0 or 1."""
    if isinstance(value, float):
        return math.copysign(1.0, value) if value else 0.0
    return np.sign(value)


def square_root(value: Number) -> Number:
    """Return the square root of a value, which must not be negative."""
    return math.sqrt(value) if isinstance(value, float) else np.sqrt(value)


def isfinite(value: Number) -> Number:
    """Return whether a value is neither infinite nor NaN."""
    return math.isfinite(value) if isinstance(value, float) else np.isfinite(value)


def inverse(value: Number) -> Number:
    """Return 1/value, and infinity for zero."""
    if isinstance(value, float):
        return 1.0 / value if value else math.inf
    return 1.0 / value


def quotient(value: Number, divisor: Number) -> Number:
    """Return value/divisor where the divisor is positive, otherwise infinity."""
    if isinstance(divisor, float):
        return value / divisor if divisor > 0.0 else math.inf
    quotient = np.full_like(divisor, math.inf)
    np.divide(value, divisor, out=quotient, where=divisor > 0.0)
    return quotient


def numbers(name: str, value: Any, rule: str) -> Array:
    """Return the value as an array of floats; infinities and NaN are permitted.

    ``name`` and ``rule`` are for the message of an error.

    Raises:
        ValueError: if an entry is not a real number (text, truth value, complex number), or if rows
            differ in length.
    """
    try:
        array = np.asarray(value)
        kind = "?" if _has_truth_value(value) else array.dtype.kind
        if kind in "iuf" or (
            kind == "O" and all(isinstance(each, Real | None) for each in array.flat)
        ):
            with np.errstate(
                over="ignore"
            ):  # NumPy holds integers beyond 64 bits and fractions as objects
                return array.astype(float, copy=False)
    except (ValueError, OverflowError):  # rows of different lengths, numbers beyond a float
        pass
    raise ValueError(f"{name} = {shown(value)}: {rule}")


def require(name: str, value: Any, holds: Any, rule: str) -> None:
    """Raise ValueError unless a condition holds for all values.

    ``holds`` is the condition; it broadcasts with ``value``. The message has the argument's name,
    the first value for which the condition is false, and the rule.
    """
    values, passed = np.broadcast_arrays(numbers(name, value, rule), np.asarray(holds, dtype=bool))
    if not passed.all():
        raise ValueError(f"{name} = {values[~passed][0]:g}: {rule}")


def _has_truth_value(value: Any) -> bool:
    """Return whether True or False is among the values.

    NumPy would turn truth values beside numbers into 1 and 0.
    """
    if isinstance(value, list | tuple):
        return any(map(_has_truth_value, value))
    return isinstance(value, bool) or (
        isinstance(value, np.ndarray | np.generic) and value.dtype.kind == "b"
    )


MOST_FRICTION = 1e150  # largest coefficient of friction, so that impulses do not overflow


def single_impact(
    inverse_mass: Any, velocity: Any, coefficients: tuple[ArrayLike, ...]
) -> list[Number] | None:
    """Return the arguments of one impact as floats, or None if they need the conversion of arrays.

    This is the fast way for a scene, which has one impact at a time. The inverse mass must be an
    array and all coefficients floats; otherwise the function returns None.
    """
    if type(inverse_mass) is not np.ndarray or inverse_mass.shape != (2, 2):
        return None
    if type(velocity) is np.ndarray and velocity.shape == (2,):
        velocity = velocity.tolist()
    elif not isinstance(velocity, tuple) or len(velocity) != 2:
        return None
    (k_nn, k_nt), (k_tn, k_tt) = inverse_mass.tolist()
    values = [k_nn, k_nt, k_tt, *velocity, *coefficients]
    if {*map(type, values)} != {float}:
        return None
    _check(values, k_tn)
    return values


NAMES = (
    "inverse_mass",
    "velocity",
    "friction",
    "restitution",
    "restitution_friction",
    "stick_compliance",
)


def unpack(
    inverse_mass: ArrayLike, velocity: ArrayLike, *others: ArrayLike
) -> tuple[list[Number], tuple[int, ...]]:
    """Return the arguments of an array of impacts as single quantities, broadcast.

    Returns:
        The entries K_nn, K_nt and K_tt of the inverse mass, the normal and the tangential velocity
        and the coefficients in their order; and the common shape.
    """
    given = zip(NAMES, (inverse_mass, velocity, *others), strict=False)
    matrix, speeds, *coefficients = (
        numbers(name, each, "must be real numbers") for name, each in given
    )
    if matrix.shape[-2:] != (2, 2) or speeds.shape[-1:] != (2,):
        raise ValueError(
            f"inverse_mass, velocity of shapes {matrix.shape}, {speeds.shape}: must be (..., 2, 2) and (..., 2)"
        )
    (k_nn, k_nt), (k_tn, k_tt) = np.moveaxis(matrix, (-2, -1), (0, 1))
    entries = (k_nn, k_nt, k_tt, *np.moveaxis(speeds, -1, 0), *coefficients)
    try:
        values: list[Number] = list(np.broadcast_arrays(*entries))
    except ValueError:
        shapes = [matrix.shape[:-2], speeds.shape[:-1], *map(np.shape, coefficients)]
        found = ", ".join(f"{name} {shape}" for name, shape in zip(NAMES, shapes, strict=False))
        raise ValueError(
            f"arrays of impacts of shapes {found}: must be shapes that broadcast against each other"
        ) from None
    _check(values, k_tn)
    return values, np.shape(values[0])


def _check(values: list[Number], k_tn: Number) -> None:
    k_nn, k_nt, k_tt, normal, tangential, mu_1, e, mu_2, *given = values
    matrix = (k_nn, k_nt, k_tn, k_tt)
    finite = isfinite(k_nn) & isfinite(k_nt) & isfinite(k_tt) & isfinite(k_tn)
    # The product of the roots neither overflows nor underflows, unlike the root of the product.
    mean = square_root(abs(k_nn)) * square_root(abs(k_tt))
    symmetric = abs(k_nt - k_tn) <= 1e-9 * mean
    semidefinite = (k_nn >= 0.0) & (k_tt >= 0.0) & (abs(k_nt) <= mean * (1.0 + 5e-10))
    least = f"from 0 to {MOST_FRICTION:g} (dimensionless)"
    rules = [
        ("inverse_mass", "finite (1/kg)", finite, matrix),
        ("inverse_mass", "symmetric (1/kg)", symmetric, matrix),
        ("inverse_mass", "positive semidefinite (1/kg)", semidefinite, matrix),
        ("velocity", "finite (m/s)", isfinite(normal) & isfinite(tangential), (normal, tangential)),
        ("friction", least, (mu_1 >= 0.0) & (mu_1 <= MOST_FRICTION), (mu_1,)),
        ("restitution_friction", least, (mu_2 >= 0.0) & (mu_2 <= MOST_FRICTION), (mu_2,)),
        ("restitution", "0 <= restitution <= 1 (dimensionless)", (e >= 0.0) & (e <= 1.0), (e,)),
    ]
    for each in given:
        rules.append(
            ("stick_compliance", "finite and >= 0 (1/kg)", isfinite(each) & (each >= 0.0), (each,))
        )
    for name, rule, holds, checked in rules:
        if holds is not True and not np.all(holds):
            raise ValueError(f"{name} = {first_text(checked, holds)}: must be {rule}")


def first_text(values: tuple[Number, ...], holds: Number) -> str:
    """Return, for an error message, the values at the first place where a rule is broken, as text.

    ``holds`` is true where the rule is kept.
    """
    chosen = (
        values
        if isinstance(holds, bool)
        else [np.broadcast_to(each, holds.shape)[~holds][0] for each in values]
    )
    text = ", ".join(f"{float(each):g}" for each in chosen)
    return text if len(values) == 1 else f"({text})"


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
"""Range of each argument by its name. The last entry of a range gives the reason for its bounds."""


def checked_numbers(**values: float) -> list[float]:
    """Check each argument against the range declared for its name in ``RANGES``; return floats.

    Raises:
        ValueError: for an argument outside its range.
    """
    return [RANGES[name].check(value) for name, value in values.items()]
