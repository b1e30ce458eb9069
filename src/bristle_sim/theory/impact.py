"""Planar impact at one point with Coulomb friction: one law for a body, a chain of bodies or a
whole machine.

An impact depends on the bodies only through the contact-space inverse mass K, which turns an
impulse p = (p_n, p_t) on the contact point into the change of its velocity, dv = K dp, and the
velocity v = (v_n, v_t) of the point before the impact. The tangential impulse opposes slip, dp_t =
-mu sign(v_t) dp_n, so within a phase of constant slip direction (or stick) the velocities are
linear and the works are quadratic in p_n, and every phase ends in closed form:

* slip continues until v_t = 0;
* then the point sticks if mu >= |K_nt| / K_tt, and otherwise slips in the direction of sign(K_nt);
* compression ends at v_n = 0;
* restitution ends by the coefficient of restitution: by the energetic one (Stronge 1990) when the
normal work in
  restitution is W_r = -e*^2 W_c, Poisson's when the normal impulse in restitution is e times that of compression,
  Newton's when v_n is -e times its value before the impact.

So compression and restitution have two phases each: the initial slip, and the stick or slip that
follows it. Where restitution's friction is larger than compression's, slip can drive the point back
into compression as soon as v_n > 0; the only motion that obeys both coefficients then keeps v_n = 0
until slip stops ("slip at rest").

Sources: W. J. Stronge, *Rigid body collisions with friction*, Proc. R. Soc. Lond. A 431 (1990)
169-181; J. Zhang (2020), eqs. 2.4-2.18, 2.46; Wang and Mason, J. Appl. Mech. 59 (1992) 635-642 for
the three coefficients.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.arrays import Number
from bristle_sim.theory.impact_arguments import check_result, single_impact, unpack
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
from bristle_sim.theory.numbers import numbers, quotient, require, select, square_root
from bristle_sim.units import shown

__all__ = [
    "LAWS", "NO_CONTACT", "NO_REBOUND", "OUTCOMES", "PHASES", "REBOUND", "STICTION", "Impact", "energetic_impact",
    "newton_impact", "poisson_impact",
]  # fmt: skip

LEAST_COMPLIANCE = 1e-4
MOST_COMPLIANCE = 1e4
"""Smallest eta^2 at which the springs are followed, and largest eta^2 accepted.

Each swing of the tangential spring is a phase, and there are some 0.65/eta phases. Below the
smallest value the impact is a mean of the rigid impact and that at the smallest value."""

BLOCK = 1 << 13  # number of rigid impacts resolved together: their arrays fit the cache


def energetic_impact(
    inverse_mass: ArrayLike,
    velocity: ArrayLike,
    friction: ArrayLike,
    restitution: ArrayLike,
    restitution_friction: ArrayLike | None = None,
    stick_compliance: ArrayLike | None = None,
    tangential_compliance: ArrayLike = 0.0,
) -> Impact:
    """Resolve an impact with Stronge's energetic coefficient of restitution, W_r = -e*^2 W_c (Zhang
    2020, eq. 2.46).

    The impact never gains energy, for any K, slip and friction.

    Args:
        inverse_mass: K, symmetric and positive semidefinite, order (normal, tangential), shape
            (..., 2, 2), 1/kg.
        velocity: (v_n, v_t) of the contact point before the impact, shape (..., 2), m/s; v_n < 0
            approaches.
        friction: Coulomb's mu, shape (...); only in compression if restitution_friction is given.
        restitution: e*, in [0, 1], shape (...).
        restitution_friction: mu in restitution; equal to ``friction`` by default.
        stick_compliance: gain of v_n per unit normal impulse while the point does not slip, K_nn -
            K_nt^2/K_tt, 1/kg, if known more accurately than from the rounded K: at a mass ratio of
            1e12 the difference keeps only four digits.
        tangential_compliance: eta^2, the contact's normal over its tangential stiffness, from 0
            (rigid along the surface) to 1e4, shape (...); (2 - nu)/(2 (1 - nu)) for two bodies of
            one elastic material (``impact_compliance``). Below 1e-4 the impact is a mean of the
            rigid impact and the impact at 1e-4, weighted linearly in eta, so that it is continuous.
            Measured for 20,000 random K (correlation up to 0.95, ratio of the entries up to 100, mu
            <= 2): the impulse at 1e-4 differs from the rigid impulse by less than 30 eta times its
            largest component; the mean differs from the impulse of the springs by less than 15 eta.
            In half of the cases the differences are below 0.001 eta.

    Returns:
        The impact; floats for a single one, arrays of the broadcast shape otherwise.

    Raises:
        ValueError: for non-finite values, a K that is not symmetric positive semidefinite, mu < 0,
            e* outside [0, 1], a stick_compliance < 0, eta^2 outside [0, 1e4], or impulses or works
            too large for a float.

    A body of 1 kg that slips throughout: p_c = 1, and W_r = 0.25 W_c with p_r = 0.5; friction takes
    0.2 of 1.5 N s.

    >>> impact = energetic_impact(np.eye(2), (-1.0, 0.5), 0.2, 0.5)
    >>> impact.velocity_normal, round(impact.velocity_tangential, 12), impact.impulse_normal
    (0.5, 0.2, 1.5)

    Springs of equal stiffness that stick, e* = 1: both swing through half a period, and both
    velocities are reversed.

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

They differ in the normal impulse at which restitution ends. To add a law, write the function of
that impulse, the law, and its name here."""


def _energetic_end(velocity: Number, compliance: Number, target: Target) -> Number:
    # The root of v p + a p^2/2 = W in the form without cancellation; a work that underflows takes
    # no impulse.
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
    """Check and unpack the arguments, then resolve the impacts.

    Impacts without tangential compliance are rigid; the others are on springs.
    """
    matrix, velocity, friction, restitution, later, stick = given
    coefficients = (friction, restitution, friction if later is None else later)
    coefficients += () if stick is None else (stick,)
    rigid = type(compliance) in (float, int) and compliance == 0
    floats = single_impact(matrix, velocity, coefficients) if rigid else None
    if floats is not None:
        impact = resolve_phases(end, *floats)
        check_result(impact, floats)
        return impact
    squared = numbers("tangential_compliance", compliance, "must be real numbers")
    within = (squared >= 0.0) & (squared <= MOST_COMPLIANCE)
    rule = f"must be from 0 to {MOST_COMPLIANCE:g} (dimensionless)"
    require("tangential_compliance", squared, within, rule)
    values, shape = unpack(matrix, velocity, *coefficients)
    shape = np.broadcast_shapes(shape, squared.shape)
    values = [np.broadcast_to(value, shape).ravel() for value in values]
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        impact = _row(end, values, np.broadcast_to(squared, shape).ravel())
        check_result(impact, values)
    shaped = [getattr(impact, each.name) for each in fields(Impact)]
    shaped = [each.reshape(shape + each.shape[1:]) for each in shaped]
    return Impact(*(each if each.ndim else each.item() for each in shaped))


def _row(end: End, values: list[Number], squared: Number) -> Impact:
    """Resolve a row of impacts, rigid or with tangential springs.

    Below ``LEAST_COMPLIANCE`` an impact is a mean of the rigid impact and the impact on springs.
    """
    elastic = (squared > 0.0) & (values[3] < 0.0) & (values[0] > 0.0)
    if not elastic.any():
        return _rigid_row(end, values)
    # Imported only where a contact has this effect.
    from bristle_sim.theory.impact_compliance import compliant_impact

    if (elastic & (squared >= LEAST_COMPLIANCE)).all():
        return compliant_impact(values, squared)
    impact = _rigid_row(end, values)
    followed = np.maximum(squared[elastic], LEAST_COMPLIANCE)
    springs = compliant_impact([value[elastic] for value in values], followed)
    rigid = Impact(*(getattr(impact, entry.name)[elastic] for entry in fields(Impact)))
    mean = _mean(rigid, springs, np.sqrt(squared[elastic] / followed))
    for entry in fields(Impact):
        getattr(impact, entry.name)[elastic] = getattr(mean, entry.name)
    return impact


def _mean(rigid: Impact, springs: Impact, weight: Number) -> Impact:
    """Return the mean of a rigid impact and one on springs; ``weight`` is that of the springs.

    Where their outcomes differ and the weight is below 1, the rigid impact is returned. Friction's
    cone and the normal works are linear in the impulses. The kinetic energy is a convex function of
    the impulse, so the mean impulse leaves less of it, by w (1 - w) dp.dv/2. Friction takes this
    difference in the last phase. The phases and the end of slip are those of the rigid impact.
    """
    weight = np.where((rigid.outcome == springs.outcome) | (weight == 1.0), weight, 0.0)
    means = {}
    for entry in fields(Impact):
        one = getattr(rigid, entry.name)
        other = getattr(springs, entry.name)
        factor = weight.reshape(weight.shape + (1,) * (one.ndim - 1))
        means[entry.name] = np.where(factor < 1.0, one * (1.0 - factor) + other * factor, other)
    loss = (springs.impulse_normal - rigid.impulse_normal) * (
        springs.velocity_normal - rigid.velocity_normal
    ) + (springs.impulse_tangential - rigid.impulse_tangential) * (
        springs.velocity_tangential - rigid.velocity_tangential
    )
    last = np.where(means["phase_impulse"] > 0.0, np.arange(len(PHASES)), 0).max(axis=-1)
    means["phase_work_tangential"][np.arange(weight.size), last] -= (
        0.5 * weight * (1.0 - weight) * loss
    )
    alone = weight == 1.0
    own = alone[:, np.newaxis] | (rigid.phase_impulse == 0.0)
    means["phase_slip"] = np.where(own, springs.phase_slip, rigid.phase_slip)
    for name in ("slip_stop_impulse", "outcome"):
        means[name] = np.where(alone, getattr(springs, name), getattr(rigid, name))
    return Impact(**means)


def _rigid_row(end: End, values: list[Number]) -> Impact:
    """Resolve a row of rigid impacts in blocks that fit the cache."""
    starts = range(0, max(values[0].size, 1), BLOCK)
    parts = [
        resolve_phases(end, *(value[start : start + BLOCK] for value in values)) for start in starts
    ]
    columns = ([getattr(part, entry.name) for part in parts] for entry in fields(Impact))
    return Impact(*map(np.concatenate, columns))
