"""The inverse mass matrix at a contact of pymunk bodies with any joints, and the motion that an
impulse at the contact causes.

The bodies have the velocities V and the mass matrix M, and the joints require J V = b. The two rows
of the contact's Jacobian C give the normal and the tangential velocity of the first body's point
relative to the other body's point. An impulse p at the contact causes joint impulses lambda and the
velocity changes dV = M^-1 (C^T p + J^T lambda), with J dV = 0. Let n and t be the parts of the two
columns of M^-1/2 C^T that are orthogonal to the columns of M^-1/2 J^T. The inverse mass matrix K
and the velocity changes are

    K = (n, t)^T (n, t)    and    dV = M^-1/2 (n, t) p.

The part of n that is also orthogonal to t is the motion in stick. The square of its length is the
compliance in stick, which equals K_nn - K_nt^2/K_tt. Computed as a square it has no error from
cancellation. Static and kinematic bodies have zero inverse mass.
"""

from __future__ import annotations

import itertools
import math
import sys
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
import pymunk
from pymunk._chipmunk_cffi import lib

from bristle_sim.arrays import Array
from bristle_sim.contact_space.joints import (
    Connected,
    Entry,
    JointRow,
    Vector,
    joint_rows,
    relative_rows,
    scaled_columns,
)
from bristle_sim.contact_space.projection import (
    DEPENDENT,
    of_length_one,
    orthogonal_part,
    set_in_motion,
)

# Smallest ratio of the motion that an impulse causes with joints to the motion that it causes
# without joints. Below this ratio the motion is rounding error, and the contact point cannot move.
SINGULAR = 64.0 * sys.float_info.epsilon
# Rounding error of the velocity at which a joint leaves its limit, divided by the largest such
# velocity that the bodies' kinetic energy permits. The rounding error of the impulse with which a
# limit pulls is the same fraction of the impulse at the contact.
OPENS = 1e-9


@dataclass(slots=True)
class ContactSpace:
    """The data of a contact that an impact law uses, in the units of the space.

    Attributes:
        inverse_mass: inverse mass matrix of the contact point, order (normal, tangential).
        velocity: (normal, tangential) velocity of the first body's point relative to the other
            body's point; the normal velocity is negative in approach.
        stick_compliance: change of the normal velocity per unit normal impulse while the point does
            not slip; 0 if the point cannot move.
        bodies: the dynamic bodies that an impulse sets in motion.
        response: change of (v_x, v_y, angular velocity) of each body per unit normal impulse
            (column 0) and per unit tangential impulse (column 1), shape (3 * len(bodies), 2).
        limits: joints that are at a limit: first those whose limit acts as a rigid stop, then those
            whose limit is released, so that it transmits no impulse.
        partings: effect of a unit normal (column 0) and a unit tangential impulse (column 1) at the
            contact on each of ``limits``, shape (len(limits), 2). The row of a rigid stop holds the
            impulse in the stop. The row of a released limit holds the velocity at which the bodies
            separate from it. The limits' Jacobian rows are scaled by M^-1/2, with the mass matrix
            M, and then to length 1.
        sizes: lengths of the contact's two Jacobian rows, scaled by M^-1/2, shape (2,). They give
            the scale of the rounding error of ``partings``.
    """

    inverse_mass: Array
    velocity: Vector
    stick_compliance: float
    bodies: Sequence[pymunk.Body]
    response: Array
    limits: Sequence[pymunk.Constraint]
    partings: Array
    sizes: Array

    def wrong_limit(self, impulse: Vector) -> pymunk.Constraint | None:
        """Return the joint whose limit an impact violates most; None if no limit is violated.

        A rigid stop is violated if it would have to pull. A released limit is violated if the
        bodies would pass it. Violations by no more than rounding error do not count.

        Args:
            impulse: (normal, tangential) impulse at the contact.
        """
        values = self.partings @ impulse
        wrong = values.min(initial=0.0) < -OPENS * (self.sizes @ np.abs(impulse))
        return self.limits[int(values.argmin())] if wrong else None

    def apply(self, impulse: Vector) -> None:
        """Change the velocities of all bodies by an impulse (normal, tangential) at the contact."""
        set_in_motion(self.bodies, self.response @ impulse)


def contact_space(
    ends: Sequence[pymunk.Body],
    point: complex,
    normal: complex,
    connected: Connected,
    *,
    surface_velocity: complex = 0j,
    released: Collection[pymunk.Constraint] = (),
) -> ContactSpace:
    """Return the data of a contact that an impact law uses: inverse mass and contact velocity.

    Args:
        ends: the body on which the impulse acts, and the body on which the opposite impulse acts.
            If only the first body is given, the obstacle is at rest.
        point: world coordinates of the contact.
        normal: unit vector towards the first body; the tangent is the normal turned clockwise.
        connected: the bodies that joints connect to ``ends``, and these joints.
        surface_velocity: velocity of the other body's surface relative to the surface of the first
            body, in addition to the motion of the bodies, as on a conveyor belt.
        released: joints whose limits transmit no impulse.
    """
    bodies, joints = connected
    rows: list[JointRow] = []
    parting: list[JointRow] = []
    for row in itertools.chain(*map(joint_rows, joints)):
        if not (row.limit and _opens(row, bodies)):
            (parting if row.limit and row.joint in released else rows).append(row)
    contact, velocity = relative_motion(ends, point, normal, surface_velocity)
    entries = [row.entries for row in (*rows, *parting)]
    columns, scale = scaled_columns([*contact, *entries], bodies)
    touch = columns[:, :2]
    rigid = columns[:, 2 : 2 + len(rows)]
    free = orthogonal_part(touch, rigid)
    sizes = np.sqrt((touch**2).sum(axis=0))
    normal_part, slip = free.T
    # A point whose tangential motion is rounding error cannot slip: impulses move it as in stick.
    if math.sqrt(slip @ slip) <= SINGULAR * sizes[1]:
        slip[:] = 0.0
        in_stick = normal_part
    else:
        in_stick = normal_part - slip * ((slip @ normal_part) / (slip @ slip))
    moves = math.sqrt(in_stick @ in_stick) > SINGULAR * sizes[0]
    limits = [number for number, row in enumerate(rows) if row.limit]
    partings = of_length_one(columns[:, 2 + len(rows) :])[0].T @ free
    if limits:
        impulses = np.linalg.lstsq(of_length_one(rigid)[0], touch, rcond=DEPENDENT)[0]
        partings = np.concatenate([-impulses[limits], partings])
    return ContactSpace(
        inverse_mass=free.T @ free,
        velocity=velocity,
        stick_compliance=float(in_stick @ in_stick) if moves else 0.0,
        bodies=bodies,
        response=scale[:, None] * free,
        limits=[row.joint for row in (*rows, *parting) if row.limit],
        partings=partings,
        sizes=sizes,
    )


def relative_motion(
    ends: Sequence[pymunk.Body], point: complex, normal: complex, surface_velocity: complex
) -> tuple[list[tuple[Entry, ...]], Vector]:
    """Return the Jacobian rows of a contact and the relative velocity of its points.

    The arguments are those of ``contact_space``.

    Returns:
        The Jacobian rows for the velocity of the first body's point relative to the other body's
        point, in the order (normal, tangential).
        The (normal, tangential) components of this relative velocity.
    """
    relative = -surface_velocity
    for body, sign in zip(ends, (1.0, -1.0), strict=False):
        moving = lib.cpBodyGetVelocityAtWorldPoint(body._body, (point.real, point.imag))
        relative += sign * complex(moving.x, moving.y)
    relative *= normal.conjugate()
    rows = relative_rows([(body, point) for body in ends], (normal, -1j * normal))
    return rows, (relative.real, -relative.imag)


def _opens(limit: JointRow, bodies: Sequence[pymunk.Body]) -> bool:
    """Return whether a joint is already moving away from its limit, so that the limit cannot push.

    The velocity away from the limit is compared with the largest such velocity that the kinetic
    energy of the bodies permits.
    """
    length = sum(
        (x * x + y * y) / body.mass + turn**2 / body.moment
        for body, x, y, turn in limit.entries
        if body in bodies
    )
    twice_energy = sum(each.kinetic_energy for each in bodies)  # m v^2 + I w^2, by the engine
    return limit.excess()[0] > OPENS * math.sqrt(length * twice_energy)
