"""Checks of the arguments and of the result of an impact law.

The arguments are floats for one impact, or arrays that broadcast.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.arrays import Number
from bristle_sim.theory.impact_phases import Impact
from bristle_sim.theory.numbers import isfinite, numbers, square_root

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
            raise ValueError(f"{name} = {_first(checked, holds)}: must be {rule}")


def _first(values: tuple[Number, ...], holds: Number) -> str:
    """Return, for an error message, the text of the first values that break a rule.

    ``holds`` tells where the rule holds.
    """
    chosen = (
        values
        if isinstance(holds, bool)
        else [np.broadcast_to(each, holds.shape)[~holds][0] for each in values]
    )
    text = ", ".join(f"{float(each):g}" for each in chosen)
    return text if len(values) == 1 else f"({text})"


def check_result(impact: Impact, arguments: list[Number]) -> None:
    """Raise ValueError if an impulse, a velocity or a work of an impact is not finite.

    Such a value has overflowed, or the inverse mass is too small to be inverted.
    """
    entries = (
        impact.impulse_normal,
        impact.impulse_tangential,
        impact.velocity_normal,
        impact.velocity_tangential,
    )
    total = sum(entries)
    works = (impact.phase_work_normal, impact.phase_work_tangential)
    if isinstance(total, float):
        holds = isfinite(sum([total, *works[0].tolist(), *works[1].tolist()]))
    else:
        holds = isfinite(total + works[0].sum(axis=-1) + works[1].sum(axis=-1))
    if holds is not True and not np.all(holds):
        k_nn, _, k_tt, normal, tangential, *_ = arguments
        raise ValueError(
            f"velocity = {_first((normal, tangential), holds)} with inverse_mass of diagonal {_first((k_nn, k_tt), holds)}:"
            " must be values whose impulse p = v/K and work v^2/K are finite numbers (m/s, 1/kg)"
        )
