"""The impacts of many contacts resolved simultaneously, at a bounded cost and without a gain of
energy.

Let the columns of B be the contacts' Jacobian rows, scaled by the inverse square root of the mass
and made orthogonal to the joints' rows. Impulses p change the contact velocities from v to
u = v + W p with W = B^T B, and the kinetic energy by p.(v + W p/2). Compression ends with the
impulses after which no contact approaches (Moreau's plastic impact). The conditions are

    u_n >= 0,  p_n >= 0,  u_n p_n = 0,  |p_t| <= mu p_n,  and in slip p_t = -mu p_n sign(u_t).

Without friction these impulses minimise the kinetic energy. The impulses, with or without friction,
are found by the projected gradient method with Nesterov's momentum. The momentum is set to zero
where it leads uphill (O'Donoghue and Candes 2015). The gradient is multiplied by D^-1, with the
diagonal matrix D_ii = sum_kj |B_ki B_kj|, for which D - W is positive semidefinite.

Restitution adds the impulses e p_n and e p_t (Poisson). If contacts approach afterwards, a second
plastic impact follows. The conditions give p.u <= 0, that is p.v <= -p.W p. The impulses (1 + e) p
therefore do not increase the energy for any e <= 1. Finally the sum p of all impulses is multiplied
by -2 p.v/(p.W p), limited to the range from 0 to 1. The impulses remain in the friction cones, and
no energy is gained even if the iteration has not converged.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.sparse import csr_array

from bristle_sim.arrays import Array
from bristle_sim.contact_space.impulse import relative_motion
from bristle_sim.contact_space.joints import Connected, scaled_columns
from bristle_sim.contact_space.projection import (
    close_joints,
    joint_columns,
    orthogonal_part,
    set_in_motion,
)
from bristle_sim.contact_space.touching import StepMotion, TouchingPoint
from bristle_sim.theory.impact_phases import NO_REBOUND, REBOUND, Impact

# Largest product of the number of iterations and the number of contacts. This permits the 640
# iterations that a row of 40 balls needs, and takes some 10 ms for any number of contacts.
EFFORT = 25_000
# Change of the impulses in an iteration, as a fraction of the largest impulse, at which the
# iteration has converged.
SETTLED = 1e-8


def resolve_at_once(
    points: Sequence[TouchingPoint], connected: Connected, motion: StepMotion, resting: float
) -> list[Impact]:
    """Resolve the impacts at all contact points of connected bodies simultaneously.

    The function changes the bodies' velocities.

    Args:
        points: all contact points of the bodies.
        connected: the bodies and the joints between them.
        motion: velocity changes in the step. They are needed because the impact takes place at the
            end of the step, while the engine's velocities apply half a step later.
        resting: approach speed up to which a point has no restitution.

    Returns:
        The impact of each point. The work of all impacts is the change of the kinetic energy.
    """
    bodies, joints = connected
    motion.kick(bodies, -0.5)
    close_joints(bodies, joints)
    seen = [
        relative_motion(each.bodies, *each.overlap[:2], each.surface_velocity) for each in points
    ]
    before = np.array([velocity for _, velocity in seen])
    columns, scale = scaled_columns([row for rows, _ in seen for row in rows], bodies)
    contacts = csr_array(orthogonal_part(columns, joint_columns(bodies, joints)[0]))
    transposed = contacts.T
    size = abs(transposed) @ abs(contacts).sum(axis=1)
    step = np.divide(1.0, size, out=np.zeros_like(size), where=size > 0.0).reshape(-1, 2)
    friction = np.array([each.pair.friction for each in points])
    restitution = np.array([each.pair.restitution for each in points])
    restitution[-before[:, 0] <= resting] = 0.0

    def gain(impulse: Array) -> Array:
        """Return the velocity changes that impulses cause at the m contacts, shape (m, 2)."""
        return np.asarray(transposed @ (contacts @ impulse.ravel())).reshape(-1, 2)

    first = _plastic(gain, step, friction, before)
    second = restitution[:, None] * first
    if second.any():
        driven = before + gain(first + second)
        second += _plastic(gain, step, friction, driven)
    total = first + second
    work = (total * gain(total)).sum()
    fraction = min(1.0, max(-2.0 * (total * before).sum() / work, 0.0)) if work > 0.0 else 0.0
    first, second, total = fraction * first, fraction * second, fraction * total
    set_in_motion(bodies, scale * (contacts @ total.ravel()))
    motion.kick(bodies, 0.5)
    middle = before + gain(first)
    after = before + gain(total)
    return list(map(_record, first, second, before, middle, after))


def _plastic(
    gain: Callable[[Array], Array], step: Array, friction: Array, velocity: Array
) -> Array:
    """Return the impulses of a plastic impact at m contacts, shape (m, 2).

    Args:
        gain: function that returns the changes of the contact velocities that impulses cause.
        step: factor of the gradient for each impulse component, the diagonal of D^-1, shape (m, 2).
        friction: coefficient of friction of each contact.
        velocity: contact velocities before the impact, shape (m, 2).
    """
    impulse = ahead = np.zeros_like(velocity)
    momentum = 1.0
    for _ in range(EFFORT // len(velocity)):
        slope = velocity + gain(ahead)
        projected = ahead - step * slope
        projected[:, 0] = np.maximum(projected[:, 0], 0.0)
        bound = friction * projected[:, 0]
        projected[:, 1] = np.clip(projected[:, 1], -bound, bound)
        moved = projected - impulse
        impulse = projected
        if np.abs(moved).max() <= SETTLED * np.abs(impulse).max():
            break
        if (slope * moved).sum() > 0.0:
            momentum = 1.0
            ahead = impulse
        else:
            following = 0.5 * (1.0 + np.sqrt(1.0 + 4.0 * momentum**2))
            ahead = impulse + (momentum - 1.0) / following * moved
            momentum = following
    return impulse


def _record(first: Array, second: Array, before: Array, middle: Array, after: Array) -> Impact:
    """Return the impact of one contact; all arguments are (normal, tangential) pairs.

    Args:
        first: impulse of compression.
        second: impulse of restitution.
        before: velocity before the impact.
        middle: velocity at the end of compression.
        after: velocity after the impact.
    """
    nothing = np.zeros(2)
    impulses = np.array([first, nothing, second, nothing])
    works = impulses * np.array([before + middle, nothing, middle + after, nothing]) / 2.0
    entries = (
        *np.concatenate([first + second, after, first]).tolist(),
        np.inf,
        impulses[:, 0],
        np.sign([before[1], 0.0, middle[1], 0.0]),
        works[:, 0],
        works[:, 1],
        REBOUND if after[0] > 0.0 else NO_REBOUND,
    )
    return Impact(*entries)
