"""The arguments of an impact law: floats for one impact, or arrays that broadcast."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.arrays import Number
from bristle_sim.theory.numbers import numbers

MOST_FRICTION = 1e150  # largest coefficient of friction for which impulses do not overflow
# Largest tangential compliance eta^2. The tangential spring is then so soft that it hardly matters.
MOST_COMPLIANCE = 1e4

ROUNDING = 1e-9
"""Largest relative rounding error that is accepted in an inverse mass matrix.

The errors are the difference K_nt - K_tn, and twice the amount by which |K_nt| exceeds
sqrt(K_nn K_tt). Both errors are divided by sqrt(K_nn K_tt)."""

COEFFICIENTS = {
    "friction": (MOST_FRICTION, f"from 0 to {MOST_FRICTION:g} (dimensionless)"),
    "restitution": (1.0, "0 <= restitution <= 1 (dimensionless)"),
    "restitution_friction": (MOST_FRICTION, f"from 0 to {MOST_FRICTION:g} (dimensionless)"),
    "stick_compliance": (sys.float_info.max, "finite and >= 0 (1/kg)"),
    "tangential_compliance": (MOST_COMPLIANCE, f"from 0 to {MOST_COMPLIANCE:g} (dimensionless)"),
}
"""Largest value of each coefficient, and its range as text for messages. The least value is 0."""

Arguments = dict[str, Number]
"""Arguments by name: the entries ``k_nn``, ``k_nt`` and ``k_tt`` of the inverse mass, the velocity
``normal`` and ``tangential``, and the coefficients."""


def single_impact(inverse_mass: Any, velocity: Any, coefficients: Arguments) -> Arguments | None:
    """Return the arguments of a single impact as floats, or None if they are not plain floats.

    This saves time for the engine's contacts, which are resolved one at a time. The inverse mass
    must be an array, the velocity a tuple, and all coefficients floats; otherwise the result is
    None.
    """
    if type(inverse_mass) is not np.ndarray or inverse_mass.shape != (2, 2):
        return None
    if type(velocity) is not tuple or len(velocity) != 2:
        return None
    (k_nn, k_nt), (k_tn, k_tt) = inverse_mass.tolist()
    normal, tangential = velocity
    kinds = {*map(type, (k_nn, normal, tangential, *coefficients.values()))}
    if kinds != {float}:
        return None
    return _checked(k_nn, k_nt, k_tn, k_tt, normal, tangential, coefficients)


def impacts_of(
    inverse_mass: ArrayLike, velocity: ArrayLike, coefficients: dict[str, ArrayLike]
) -> tuple[Arguments, tuple[int, ...]]:
    """Return the arguments of an array of impacts by name, and the shape to which they broadcast.

    Raises:
        ValueError: for an argument that is not a number or is out of range, or if the shapes do not
            broadcast.
    """
    given = {"inverse_mass": inverse_mass, "velocity": velocity, **coefficients}
    arrays = {name: numbers(name, each, "must be real numbers") for name, each in given.items()}
    matrix = arrays.pop("inverse_mass")
    speeds = arrays.pop("velocity")
    if matrix.shape[-2:] != (2, 2) or speeds.shape[-1:] != (2,):
        raise ValueError(
            f"inverse_mass, velocity of shapes {matrix.shape}, {speeds.shape}: must be (..., 2, 2) and (..., 2)"
        )
    shapes = {"inverse_mass": matrix.shape[:-2], "velocity": speeds.shape[:-1]}
    shapes |= {name: each.shape for name, each in arrays.items()}
    try:
        shape = np.broadcast_shapes(*shapes.values())
    except ValueError:
        found = ", ".join(f"{name} {each}" for name, each in shapes.items())
        raise ValueError(
            f"arrays of impacts of shapes {found}: must be shapes that broadcast against each other"
        ) from None
    (k_nn, k_nt), (k_tn, k_tt) = np.moveaxis(matrix, (-2, -1), (0, 1))
    normal, tangential = np.moveaxis(speeds, -1, 0)
    values = _checked(k_nn, k_nt, k_tn, k_tt, normal, tangential, arrays)
    return {name: np.broadcast_to(each, shape) for name, each in values.items()}, shape


def _checked(
    k_nn: Number,
    k_nt: Number,
    k_tn: Number,
    k_tt: Number,
    normal: Number,
    tangential: Number,
    coefficients: Arguments,
) -> Arguments:
    """Check the ranges of the arguments, and return the arguments by name.

    Raises:
        ValueError: for an argument out of its range.
    """
    matrix = (k_nn, k_nt, k_tn, k_tt)
    speeds = (normal, tangential)
    most = sys.float_info.max
    finite = (abs(k_nn) <= most) & (abs(k_nt) <= most) & (abs(k_tn) <= most) & (abs(k_tt) <= most)
    # The product of the roots neither overflows nor underflows, unlike the root of the product.
    mean = abs(k_nn) ** 0.5 * abs(k_tt) ** 0.5
    symmetric = abs(k_nt - k_tn) <= ROUNDING * mean
    semidefinite = (k_nn >= 0.0) & (k_tt >= 0.0) & (abs(k_nt) <= mean * (1.0 + 0.5 * ROUNDING))
    moves = (abs(normal) <= most) & (abs(tangential) <= most)
    rules = [
        ("inverse_mass", "finite (1/kg)", finite, matrix),
        ("inverse_mass", "symmetric (1/kg)", symmetric, matrix),
        ("inverse_mass", "positive semidefinite (1/kg)", semidefinite, matrix),
        ("velocity", "finite (m/s)", moves, speeds),
    ]
    for name, value in coefficients.items():
        largest, rule = COEFFICIENTS[name]
        rules.append((name, rule, (value >= 0.0) & (value <= largest), (value,)))
    for name, rule, holds, checked in rules:
        if holds is not True and not np.all(holds):
            raise ValueError(f"{name} = {first_text(checked, holds)}: must be {rule}")
    velocity = {"normal": normal, "tangential": tangential}
    return {"k_nn": k_nn, "k_nt": k_nt, "k_tt": k_tt, **velocity, **coefficients}


def first_text(values: tuple[Number, ...], holds: Number) -> str:
    """Return the first values for which a condition is false, as text for an error message.

    ``holds`` is the condition; it broadcasts with every entry of ``values``.
    """
    broken = np.logical_not(holds)
    text = ", ".join(f"{np.broadcast_to(each, broken.shape)[broken][0]:g}" for each in values)
    return text if len(values) == 1 else f"({text})"
