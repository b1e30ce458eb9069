"""Planar impact at one point with Coulomb friction: one law for a body, a chain of bodies or a whole machine.

An impact depends on the bodies only through the contact-space inverse mass K, which turns an impulse p = (p_n, p_t) on the
contact point into the change of its velocity, dv = K dp, and the velocity v = (v_n, v_t) of the point before the impact.
The tangential impulse opposes slip, dp_t = -mu sign(v_t) dp_n, so within a phase of constant slip direction (or stick) the
velocities are linear and the works are quadratic in p_n, and every phase ends in closed form:

* slip continues until v_t = 0;
* then the point sticks if mu >= |K_nt| / K_tt, and otherwise slips in the direction of sign(K_nt);
* compression ends at v_n = 0;
* restitution ends where the coefficient of restitution says: the energetic one (Stronge 1990) when the normal work in
  restitution is W_r = -e*^2 W_c, Poisson's when the normal impulse in restitution is e times that of compression,
  Newton's when v_n is -e times its value before the impact.

So compression and restitution have two phases each: the initial slip, and the stick or slip that follows it. Where
restitution's friction is larger than compression's, slip can drive the point back into compression as soon as v_n > 0; the
only motion that obeys both coefficients then keeps v_n = 0 until slip stops ("slip at rest").

Sources: W. J. Stronge, *Rigid body collisions with friction*, Proc. R. Soc. Lond. A 431 (1990) 169-181;
J. Zhang (2020), eqs. 2.4-2.18, 2.46; Wang and Mason, J. Appl. Mech. 59 (1992) 635-642 for the three coefficients.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.arrays import Number
from bristle_sim.theory.impact_phases import (
    NO_CONTACT,
    NO_REBOUND,
    OUTCOMES,
    PHASES,
    REBOUND,
    STICTION,
    End,
    Impact,
    Target,
    resolve_phases,
)
from bristle_sim.theory.numbers import isfinite, numbers, quotient, require, select, square_root
from bristle_sim.units import shown

__all__ = [
    "LAWS", "NO_CONTACT", "NO_REBOUND", "OUTCOMES", "PHASES", "REBOUND", "STICTION", "Impact", "energetic_impact",
    "newton_impact", "poisson_impact",
]  # fmt: skip

MOST_FRICTION = 1e150  # more makes impulses that overflow

LEAST_COMPLIANCE = 1e-4
MOST_COMPLIANCE = 1e4
"""Least eta^2 whose springs are followed, and the largest that is accepted. Each swing of the tangential spring is a phase of its own,
some 0.65/eta of them; below the least value the impact is a mean of the rigid one and the one at that value."""

BLOCK = 1 << 13


def energetic_impact(
    inverse_mass: ArrayLike,
    velocity: ArrayLike,
    friction: ArrayLike,
    restitution: ArrayLike,
    restitution_friction: ArrayLike | None = None,
    stick_compliance: ArrayLike | None = None,
    tangential_compliance: ArrayLike = 0.0,
) -> Impact:
    """Resolve an impact with Stronge's energetic coefficient of restitution, W_r = -e*^2 W_c (Zhang 2020, eq. 2.46).

    The impact never gains energy, for any K, slip and friction.

    Args:
        inverse_mass: K, symmetric and positive semidefinite, order (normal, tangential), shape (..., 2, 2), 1/kg.
        velocity: (v_n, v_t) of the contact point before the impact, shape (..., 2), m/s; v_n < 0 approaches.
        friction: Coulomb's mu, shape (...); only in compression if restitution_friction is given.
        restitution: e*, in [0, 1], shape (...).
        restitution_friction: mu in restitution; equal to ``friction`` by default.
        stick_compliance: gain of v_n per unit normal impulse while the point does not slip, K_nn - K_nt^2/K_tt, 1/kg,
            if known more accurately than from the rounded K: at a mass ratio of 1e12 the difference keeps only four digits.
        tangential_compliance: eta^2, the contact's normal over its tangential stiffness, from 0 (rigid along the
            surface) to 1e4, shape (...); (2 - nu)/(2 (1 - nu)) for two bodies of one elastic material
            (``impact_compliance``). Below 1e-4 the impact is a mean of the rigid one and that at 1e-4, weighted
            linearly in eta, so that it is continuous. In 20,000 random K, of a correlation up to 0.95 and a ratio of the
            entries up to 100, with mu <= 2, the impulse at 1e-4 differs from the rigid one by less than 30 eta of its
            largest component, and the mean by less than 15 eta from the springs' own. Half of them differ by less than
            0.001 eta.

    Returns:
        The impact; floats for a single one, arrays of the broadcast shape otherwise.

    Raises:
        ValueError: for non-finite values, a K that is not symmetric positive semidefinite, mu < 0, e* outside [0, 1], a
            stick_compliance < 0, eta^2 outside [0, 1e4], or impulses or works too large for a float.

    A body of 1 kg that slips throughout: p_c = 1, and W_r = 0.25 W_c with p_r = 0.5; friction takes 0.2 of 1.5 N s.

    >>> impact = energetic_impact(np.eye(2), (-1.0, 0.5), 0.2, 0.5)
    >>> impact.velocity_normal, round(impact.velocity_tangential, 12), impact.impulse_normal
    (0.5, 0.2, 1.5)

    Springs of equal stiffness that stick, e* = 1: both swing through half a period, and both velocities are reversed.

    >>> impact = energetic_impact(np.eye(2), (-1.0, 0.5), 9.0, 1.0, tangential_compliance=1.0)
    >>> round(impact.velocity_normal, 12), round(impact.velocity_tangential, 12)
    (1.0, -0.5)
    """
    given = (inverse_mass, velocity, friction, restitution, restitution_friction, stick_compliance)
    return _resolve(_energetic_end, given, tangential_compliance)


def poisson_impact(
    inverse_mass: ArrayLike,
    velocity: ArrayLike,
    friction: ArrayLike,
    restitution: ArrayLike,
    restitution_friction: ArrayLike | None = None,
    stick_compliance: ArrayLike | None = None,
    tangential_compliance: ArrayLike = 0.0,
) -> Impact:
    """Resolve an impact with Poisson's coefficient e: restitution ends at p_r = e p_c (Wang and Mason 1992).

    Arguments, result and errors are those of ``energetic_impact``. With one coefficient of friction no energy is gained;
    with a ``restitution_friction`` of its own it can be. Springs define no impulse of restitution, so that the tangential
    compliance must be 0.

    A body of 1 kg without friction: p_c = 1 and p_r = 0.5 N s.

    >>> poisson_impact(np.eye(2), (-1.0, 0.0), 0.0, 0.5).impulse_normal
    1.5
    """
    _require_rigid(tangential_compliance)
    return _resolve(
        _poisson_end,
        (inverse_mass, velocity, friction, restitution, restitution_friction, stick_compliance),
    )


def newton_impact(
    inverse_mass: ArrayLike,
    velocity: ArrayLike,
    friction: ArrayLike,
    restitution: ArrayLike,
    restitution_friction: ArrayLike | None = None,
    stick_compliance: ArrayLike | None = None,
    tangential_compliance: ArrayLike = 0.0,
) -> Impact:
    """Resolve an impact with Newton's coefficient e: restitution ends at the normal velocity v_n = -e v_n(0).

    Arguments, result and errors are those of ``energetic_impact``. Where slip stops or reverses it can gain energy, as in
    Kane and Levinson's double pendulum (*Dynamics: Theory and Applications*, 1985); it serves for comparison. Springs
    define no velocity of separation, so that the tangential compliance must be 0.

    A body of 1 kg that approaches at 2 m/s leaves at half that speed.

    >>> newton_impact(np.eye(2), (-2.0, 0.0), 0.3, 0.5).velocity_normal
    1.0
    """
    _require_rigid(tangential_compliance)
    return _resolve(
        _newton_end,
        (inverse_mass, velocity, friction, restitution, restitution_friction, stick_compliance),
    )


LAWS: dict[str, Callable[..., Impact]] = {
    "energetic": energetic_impact,
    "poisson": poisson_impact,
    "newton": newton_impact,
}
"""The impact laws by name; all take the same arguments, so that they are interchangeable.

They differ in the normal impulse at which restitution ends. To add a law, write that and name the law here."""


def _energetic_end(velocity: Number, compliance: Number, target: Target) -> Number:
    # The root of v p + a p^2/2 = W in the form that does not cancel; a work below the smallest float is done at once.
    work = select(target.work > 0.0, target.work, 0.0)
    root = square_root(velocity * velocity + 2.0 * compliance * work)
    return select(work > 0.0, quotient(2.0 * work, velocity + root), 0.0)


def _poisson_end(_velocity: Number, _compliance: Number, target: Target) -> Number:
    return target.impulse


def _newton_end(velocity: Number, compliance: Number, target: Target) -> Number:
    return quotient(select(target.velocity > velocity, target.velocity - velocity, 0.0), compliance)


def _require_rigid(compliance: ArrayLike) -> None:
    if np.any(numbers("tangential_compliance", compliance, "must be real numbers")):
        raise ValueError(
            f"tangential_compliance = {shown(compliance)}: must be 0 in this law (dimensionless)"
        )


def _resolve(end: End, given: tuple[Any, ...], compliance: Any = 0.0) -> Impact:
    """Check and unpack the arguments, then resolve the rigid impacts and those with a tangential compliance."""
    matrix, velocity, friction, restitution, later, stick = given
    coefficients = (
        friction,
        restitution,
        friction if later is None else later,
        *(() if stick is None else (stick,)),
    )
    rigid = (
        isinstance(compliance, float | int) and not isinstance(compliance, bool) and compliance == 0
    )
    single = _single(matrix, velocity, coefficients) if rigid else None
    values, shape = single or _unpack(matrix, velocity, *coefficients)
    if rigid and shape is None:
        impact = resolve_phases(end, *values)
        _check_result(impact, values)
        return impact
    squared = numbers("tangential_compliance", compliance, "must be real numbers")
    within = (squared >= 0.0) & (squared <= MOST_COMPLIANCE)
    require(
        "tangential_compliance",
        squared,
        within,
        f"must be from 0 to {MOST_COMPLIANCE:g} (dimensionless)",
    )
    shape = np.broadcast_shapes(shape or (), squared.shape)
    values = [np.broadcast_to(value, shape).ravel() for value in values]
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        impact = _row(end, values, None if rigid else np.broadcast_to(squared, shape).ravel())
        _check_result(impact, values)
    shaped = [getattr(impact, each.name) for each in fields(Impact)]
    shaped = [each.reshape(shape + each.shape[1:]) for each in shaped]
    return Impact(*(each if each.ndim else each.item() for each in shaped))


def _row(end: End, values: list[Number], squared: Number | None) -> Impact:
    """Resolve a row of impacts: with a tangential compliance by springs, or by a mean with the rigid impact where it is small."""
    if squared is None:
        return _rigid_row(end, values)
    elastic = (squared > 0.0) & (values[3] < 0.0) & (values[0] > 0.0)
    if not elastic.any():
        return _rigid_row(end, values)
    from bristle_sim.theory.impact_compliance import (  # only where a contact has this effect
        compliant_impact,
        mean_impact,
    )

    if (elastic & (squared >= LEAST_COMPLIANCE)).all():
        return compliant_impact(values, squared)
    rigid = _rigid_row(end, values)
    followed = np.maximum(squared[elastic], LEAST_COMPLIANCE)
    springs = compliant_impact([value[elastic] for value in values], followed)
    chosen = Impact(*(getattr(rigid, entry.name)[elastic] for entry in fields(Impact)))
    mean = mean_impact(chosen, springs, np.sqrt(squared[elastic] / followed))
    columns = []
    for entry in fields(Impact):
        column = np.array(getattr(rigid, entry.name))
        column[elastic] = getattr(mean, entry.name)
        columns.append(column)
    return Impact(*columns)


def _rigid_row(end: End, values: list[Number]) -> Impact:
    """Resolve a row of rigid impacts in blocks that fit the cache."""
    starts = range(0, max(values[0].size, 1), BLOCK)
    parts = [
        resolve_phases(end, *(value[start : start + BLOCK] for value in values)) for start in starts
    ]
    if len(parts) == 1:
        return parts[0]
    return Impact(
        *(np.concatenate([getattr(part, entry.name) for part in parts]) for entry in fields(Impact))
    )


def _single(
    inverse_mass: Any, velocity: Any, coefficients: tuple[ArrayLike, ...]
) -> tuple[list[Number], None] | None:
    """Return the floats of one impact that is given as floats and an array, as a scene does; None for all else."""
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
    return values, None


NAMES = (
    "inverse_mass",
    "velocity",
    "friction",
    "restitution",
    "restitution_friction",
    "stick_compliance",
)


def _unpack(
    inverse_mass: ArrayLike, velocity: ArrayLike, *others: ArrayLike
) -> tuple[list[Number], tuple[int, ...] | None]:
    """Return K's entries, velocities and coefficients: floats for one impact (shape None), else broadcast arrays."""
    given = zip(NAMES, (inverse_mass, velocity, *others), strict=False)
    matrix, velocity, *coefficients = (
        numbers(name, each, "must be real numbers") for name, each in given
    )
    if matrix.shape[-2:] != (2, 2) or velocity.shape[-1:] != (2,):
        raise ValueError(
            f"inverse_mass, velocity of shapes {matrix.shape}, {velocity.shape}: must be (..., 2, 2) and (..., 2)"
        )
    shape = np.broadcast_shapes(
        matrix.shape[:-2], velocity.shape[:-1], *(each.shape for each in coefficients)
    )
    entries = (
        matrix[..., 0, 0],
        matrix[..., 0, 1],
        matrix[..., 1, 1],
        velocity[..., 0],
        velocity[..., 1],
    )
    values: list[Number] = [np.broadcast_to(each, shape) for each in (*entries, *coefficients)]
    if not shape:
        values = [each.item() for each in values]
    _check(values, matrix[..., 1, 0][()])
    return values, shape or None


def _check(values: list[Number], k_tn: Number) -> None:
    k_nn, k_nt, k_tt, normal, tangential, mu_1, e, mu_2, *given = values
    matrix = (k_nn, k_nt, k_tn, k_tt)
    finite = isfinite(k_nn) & isfinite(k_nt) & isfinite(k_tt) & isfinite(k_tn)
    # The product of roots neither overflows nor vanishes, as the root of the product may.
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
    """Return the first of the values for which a rule does not hold, for a message."""
    chosen = (
        values
        if isinstance(holds, bool)
        else [np.broadcast_to(each, holds.shape)[~holds][0] for each in values]
    )
    text = ", ".join(f"{float(each):g}" for each in chosen)
    return text if len(values) == 1 else f"({text})"


def _check_result(impact: Impact, arguments: list[Number]) -> None:
    """Refuse impulses, velocities and works that are not finite: they overflow, or K is too small for its inverse."""
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
