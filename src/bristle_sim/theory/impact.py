"""Planar impact at one point with Coulomb friction: one law for a body, a chain of bodies or a
whole machine.

Two properties of the bodies determine an impact: the velocity v = (v_n, v_t) that the contact point
has before the impact, and the point's inverse mass matrix K. An impulse dp = (dp_n, dp_t) changes
the velocity by dv = K dp. The tangential impulse opposes slip, dp_t = -mu sign(v_t) dp_n. Within a
phase of constant slip direction (or stick) the velocities are therefore linear in p_n, and the
works are quadratic. The end of every phase is thus known in closed form:

* slip continues until v_t = 0;
* then the point sticks if mu >= |K_nt| / K_tt, and otherwise slips in the direction of sign(K_nt);
* compression ends at v_n = 0;
* the coefficient of restitution determines the end of restitution. With the energetic coefficient
  (Stronge 1990) the normal work in restitution is W_r = -e*^2 W_c, where W_c is the work in
  compression. With Poisson's the normal impulse in restitution is e times the impulse in
  compression. With Newton's v_n is -e times its value before the impact.

So compression and restitution have two phases each: the initial slip, and the stick or slip that
follows it. If friction is larger in restitution than in compression, it can drive the point back
into compression as soon as v_n > 0. The only motion that obeys both coefficients of friction then
keeps v_n = 0 until slip stops ("slip at rest").

Sources: W. J. Stronge, *Rigid body collisions with friction*, Proc. R. Soc. Lond. A 431 (1990)
169-181; J. Zhang (2020), eqs. 2.4-2.18, 2.46; Wang and Mason, J. Appl. Mech. 59 (1992) 635-642 for
the three coefficients.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.arrays import Number
from bristle_sim.theory.impact_arguments import Arguments, first_text, impacts_of, single_impact
from bristle_sim.theory.impact_phases import (
    OUTCOMES,
    PHASES,
    End,
    Impact,
    Target,
    energetic_end,
    resolve_phases,
)
from bristle_sim.theory.numbers import quotient, select
from bristle_sim.units import shown

__all__ = [
    "LAWS", "OUTCOMES", "PHASES", "Impact", "energetic_impact", "newton_impact", "poisson_impact",
]  # fmt: skip

LEAST_COMPLIANCE = 1e-4
"""Smallest tangential compliance eta^2 at which the springs are followed.

Each oscillation of the tangential spring is a phase, and there are some 0.65/eta phases. Below this
value the impact is a weighted mean of the rigid impact and the impact at this value."""


def energetic_impact(
    inverse_mass: ArrayLike,
    velocity: ArrayLike,
    friction: ArrayLike,
    restitution: ArrayLike,
    restitution_friction: ArrayLike | None = None,
    stick_compliance: ArrayLike | None = None,
    tangential_compliance: ArrayLike = 0.0,
) -> Impact:
    """Resolve an impact with Coulomb friction and Stronge's energetic coefficient of restitution.

    The normal works W_c of compression and W_r of restitution satisfy W_r = -e*^2 W_c (Zhang 2020,
    eq. 2.46). Whatever the inverse mass matrix, the slip and the friction, the impact gains no
    energy.

    Args:
        inverse_mass: inverse mass matrix K of the contact point, 1/kg: the change of the point's
            velocity per unit impulse. The matrix is symmetric and positive semidefinite, in the
            order (normal, tangential), shape (..., 2, 2).
        velocity: velocity (v_n, v_t) of the contact point before the impact, shape (..., 2), m/s.
            The bodies approach if v_n < 0.
        friction: Coulomb's coefficient of friction, shape (...). If ``restitution_friction`` is
            given, this coefficient holds in compression only.
        restitution: energetic coefficient of restitution e*, in [0, 1], shape (...).
        restitution_friction: coefficient of friction in restitution, by default equal to
            ``friction``.
        stick_compliance: change of v_n per unit normal impulse while the point does not slip, K_nn
            - K_nt^2/K_tt, 1/kg; by default this difference. Give the value if it is known to more
            digits: at a mass ratio of 1e12 the difference has only four correct digits.
        tangential_compliance: ratio eta^2 of the contact's normal to its tangential stiffness, from
            0 (rigid along the surface) to 1e4, shape (...). Two bodies of one elastic material have
            (2 - nu)/(2 (1 - nu)), nu being Poisson's ratio (``impact_compliance``). Below 1e-4 the
            result is a mean of the rigid impact and of the impact at 1e-4, weighted linearly in
            eta, so that the result is continuous.

    Returns:
        The impact, with floats for a single impact and arrays of the broadcast shape otherwise.

    Raises:
        ValueError: for values that are not finite or out of range, for an inverse mass that is not
            symmetric positive semidefinite, and for impulses or works too large for a float.

    The error of the mean below eta^2 = 1e-4 was measured for 20,000 random K (correlation up to
    0.95, ratio of the entries up to 100, friction <= 2), relative to the largest component of the
    impulse. The impulse at 1e-4 differs from the rigid impulse by less than 30 eta, the mean from
    the impulse on springs by less than 15 eta. In half of the cases both differences are below
    0.001 eta.

    A body of 1 kg slips throughout. The normal impulse is 1 N s in compression and 0.5 N s in
    restitution, whose work is 0.25 times the work of compression. The friction impulse is 0.2 times
    1.5 N s.

    >>> impact = energetic_impact(np.eye(2), (-1.0, 0.5), 0.2, 0.5)
    >>> impact.velocity_normal, round(impact.velocity_tangential, 12), impact.impulse_normal
    (0.5, 0.2, 1.5)

    The normal and the tangential spring are equally stiff, the tip sticks, and e* = 1. Both springs
    swing through half a period, and both velocities are reversed.

    >>> impact = energetic_impact(np.eye(2), (-1.0, 0.5), 9.0, 1.0, tangential_compliance=1.0)
    >>> round(impact.velocity_normal, 12), round(impact.velocity_tangential, 12)
    (1.0, -0.5)
    """
    coefficients = (friction, restitution, restitution_friction, stick_compliance)
    return _resolve(energetic_end, inverse_mass, velocity, *coefficients, tangential_compliance)


def poisson_impact(
    inverse_mass: ArrayLike,
    velocity: ArrayLike,
    friction: ArrayLike,
    restitution: ArrayLike,
    restitution_friction: ArrayLike | None = None,
    stick_compliance: ArrayLike | None = None,
    tangential_compliance: ArrayLike = 0.0,
) -> Impact:
    """Resolve an impact with Coulomb friction and Poisson's coefficient of restitution.

    The normal impulse of restitution is e times the normal impulse of compression (Wang and Mason
    1992). Arguments, result and errors are those of ``energetic_impact``. The impact can gain
    energy only if ``restitution_friction`` differs from ``friction``. The tangential compliance
    must be 0, since the impulse of restitution on springs cannot be prescribed.

    A body of 1 kg without friction has impulses of 1 N s in compression and 0.5 N s in restitution.

    >>> poisson_impact(np.eye(2), (-1.0, 0.0), 0.0, 0.5).impulse_normal
    1.5
    """
    coefficients = (friction, restitution, restitution_friction, stick_compliance)
    return _resolve(_poisson_end, inverse_mass, velocity, *coefficients, tangential_compliance)


def newton_impact(
    inverse_mass: ArrayLike,
    velocity: ArrayLike,
    friction: ArrayLike,
    restitution: ArrayLike,
    restitution_friction: ArrayLike | None = None,
    stick_compliance: ArrayLike | None = None,
    tangential_compliance: ArrayLike = 0.0,
) -> Impact:
    """Resolve an impact with Coulomb friction and Newton's coefficient of restitution.

    The normal velocity after the impact is -e times the normal velocity before it. Arguments,
    result and errors are those of ``energetic_impact``. The tangential compliance must be 0, since
    the velocity of separation on springs cannot be prescribed.

    This law serves for comparison only: where slip stops or reverses, the impact can gain energy.
    An example is Kane and Levinson's double pendulum (*Dynamics: Theory and Applications*, 1985).

    A body of 1 kg that approaches at 2 m/s leaves at half that speed.

    >>> newton_impact(np.eye(2), (-2.0, 0.0), 0.3, 0.5).velocity_normal
    1.0
    """
    coefficients = (friction, restitution, restitution_friction, stick_compliance)
    return _resolve(_newton_end, inverse_mass, velocity, *coefficients, tangential_compliance)


LAWS: dict[str, Callable[..., Impact]] = {
    "energetic": energetic_impact,
    "poisson": poisson_impact,
    "newton": newton_impact,
}
"""The impact laws by name. All take the same arguments, so that they are interchangeable.

The laws differ in the normal impulse at which restitution ends. A new law needs two functions: one
that returns this impulse, and one with the arguments of ``energetic_impact``, entered here."""


def _poisson_end(_velocity: Number, _compliance: Number, target: Target) -> Number:
    return target.impulse


def _newton_end(velocity: Number, compliance: Number, target: Target) -> Number:
    return quotient(select(target.velocity > velocity, target.velocity - velocity, 0.0), compliance)


def _resolve(
    end: End,
    inverse_mass: Any,
    velocity: Any,
    friction: Any,
    restitution: Any,
    restitution_friction: Any,
    stick_compliance: Any,
    tangential_compliance: Any,
) -> Impact:
    """Check the arguments of one of the laws, and resolve the impacts.

    ``end`` is the function by which the laws differ: it returns the normal impulse at which
    restitution ends. The other arguments are those of ``energetic_impact``. Impacts with a
    tangential compliance are resolved on springs, all others as rigid impacts.
    """
    later = friction if restitution_friction is None else restitution_friction
    given = {"friction": friction, "restitution": restitution, "restitution_friction": later}
    if stick_compliance is not None:
        given["stick_compliance"] = stick_compliance
    rigid = type(tangential_compliance) in (float, int) and tangential_compliance == 0
    floats = single_impact(inverse_mass, velocity, given) if rigid else None
    if floats is not None:
        impact = resolve_phases(**floats, end=end)
        _check_result(impact, floats)
        return impact
    given["tangential_compliance"] = tangential_compliance
    values, shape = impacts_of(inverse_mass, velocity, given)
    if end is not energetic_end and values["tangential_compliance"].any():
        raise ValueError(
            f"tangential_compliance = {shown(tangential_compliance)}: must be 0 in this law (dimensionless)"
        )
    values = {name: value.ravel() for name, value in values.items()}
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        impact = _row(end, values.pop("tangential_compliance"), values)
        _check_result(impact, values)
    shaped = [getattr(impact, each.name) for each in fields(Impact)]
    shaped = [each.reshape(shape + each.shape[1:]) for each in shaped]
    return Impact(*(each if each.ndim else each.item() for each in shaped))


def _check_result(impact: Impact, arguments: Arguments) -> None:
    """Raise ValueError if an impulse, a velocity or a bound of an impact's works is not finite.

    Such a value has overflowed, or the inverse mass is too small to be inverted. ``arguments`` are
    those of the impact, for the message.
    """
    normal = arguments["normal"]
    tangential = arguments["tangential"]
    normal_work = abs(impact.impulse_normal) * (abs(normal) + abs(impact.velocity_normal))
    speeds = abs(tangential) + abs(impact.velocity_tangential)
    finite = normal_work + abs(impact.impulse_tangential) * speeds < math.inf
    if finite is not True and not np.all(finite):
        velocity = first_text((normal, tangential), finite)
        diagonal = first_text((arguments["k_nn"], arguments["k_tt"]), finite)
        raise ValueError(
            f"velocity = {velocity} with inverse_mass of diagonal {diagonal}:"
            " must be values whose impulse p = v/K and work v^2/K are finite numbers (m/s, 1/kg)"
        )


def _row(end: End, squared: Number, values: Arguments) -> Impact:
    """Resolve a one-dimensional array of impacts, rigid or with tangential springs.

    Where the tangential compliance eta^2 (``squared``) is below ``LEAST_COMPLIANCE``, the result is
    a mean of the rigid impact and of the impact on springs. Without friction the tangential spring
    has no force, and the impact is rigid. ``values`` are the other arguments by name. ``end``
    returns the normal impulse at which restitution ends.
    """
    impact = resolve_phases(**values, end=end)
    rubs = (values["friction"] > 0.0) | (values["restitution_friction"] > 0.0)
    elastic = (squared > 0.0) & (values["normal"] < 0.0) & (values["k_nn"] > 0.0) & rubs
    if not elastic.any():
        return impact
    # Imported only where a contact has this effect.
    from bristle_sim.theory.impact_compliance import compliant_impact

    followed = np.maximum(squared[elastic], LEAST_COMPLIANCE)
    springs = compliant_impact({name: each[elastic] for name, each in values.items()}, followed)
    rigid = Impact(*(getattr(impact, entry.name)[elastic] for entry in fields(Impact)))
    mean = _mean(rigid, springs, np.sqrt(squared[elastic] / followed))
    for entry in fields(Impact):
        getattr(impact, entry.name)[elastic] = getattr(mean, entry.name)
    return impact


def _mean(rigid: Impact, springs: Impact, weight: Number) -> Impact:
    """Return the weighted mean of rigid impacts and impacts on springs.

    ``weight`` is the weight w of the impacts on springs. Where the outcomes differ and w < 1, the
    rigid impact is returned. Coulomb's law and the normal works are linear in the impulses. So the
    mean obeys Coulomb's law, and its normal works are exact. Phases and the end of slip are those
    of the rigid impact.

    The kinetic energy is a convex function of the impulse. The mean impulse therefore leaves less
    energy than the mean of the energies, by w (1 - w) dp.dv/2 with the differences dp of the
    impulses and dv of the velocities. This energy is added to the work of friction in the last
    phase.
    """
    weight = np.where((rigid.outcome == springs.outcome) | (weight == 1.0), weight, 0.0)
    means = {}
    for entry in fields(Impact):
        one = getattr(rigid, entry.name)
        other = getattr(springs, entry.name)
        factor = weight.reshape(weight.shape + (1,) * (one.ndim - 1))
        means[entry.name] = one * (1.0 - factor) + other * factor
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
