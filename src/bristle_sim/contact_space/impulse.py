"""Inverse mass matrix at a contact of pymunk bodies with any joints, and the impulse that acts on
all of them at once.

With body velocities V, mass matrix M, joints J V = b and the contact's Jacobian C (its rows give
the normal and tangential velocity of the first body's point relative to the other body's point), an
impulse p at the contact changes the velocities by dV = M^-1 (C^T p + J^T lambda) with J dV = 0. In
coordinates scaled by the square root of the mass this is a projection: the part (n, t) of M^-1/2
C^T that is orthogonal to the columns of A = M^-1/2 J^T gives

    K = (n, t)^T (n, t)    and    dV = M^-1/2 (n, t) p.

An orthogonal factorization [A M^-1/2 C^T] = Q R gives the part (n, t). The part of n that is also
orthogonal to t is the motion in stick. Its square is the compliance in stick, K_nn - K_nt^2/K_tt.
This difference loses its digits where a heavy body leaves a sticking contact point hardly any
compliance. The impulses are then large, and their effects nearly cancel in dV. The same dV follows
without cancellation from the motion of the contact point: it is t dv_t/K_tt plus the motion in
stick.

The rows of light bodies are the largest and come first, which keeps the factorization accurate row
by row (Cox and Higham 1998). Static and kinematic bodies have zero inverse mass.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pymunk
from pymunk._chipmunk_cffi import lib

from bristle_sim.arrays import Array
from bristle_sim.contact_space.joints import (
    DEPENDENT,
    Connected,
    Entry,
    JointRow,
    Vector,
    joined,
    joint_rows,
    of_length_one,
    point_entries,
    scaled_columns,
    set_in_motion,
    span,
)

# Ratio of the terms of the change of v_t to v_t before and after, above which the change of all
# velocities is computed from the motion of the contact point: two digits have cancelled there.
CANCELS = 100.0

# Motion in stick, as a fraction of the motion by a normal impulse without joints, below which it is
# rounding error.
SINGULAR = 64.0 * sys.float_info.epsilon
# Motion in stick, as a fraction of the motion by a normal impulse, below which its lost digits are
# restored.
WEAK = 1e-2
# Opening rate of a joint at its limit, over the speeds of the bodies, above which the joint opens.
# A smaller rate is rounding error.
OPENS = 1e-9


class Limits(NamedTuple):
    """The joints that are at a limit, and their impulses in an impact at the contact.

    Attributes:
        rows: Jacobian rows of the limits.
        response: impulse of each limit per unit impulse at the contact, shape (limits, 2), in the
            norm of the kinetic energy. The impulse of a limit must be >= 0.
        sizes: lengths of the contact's own Jacobian rows in this norm, for comparison, shape (2,).
    """

    rows: list[JointRow]
    response: Array
    sizes: Array


@dataclass(slots=True)
class ContactSpace:
    """The data of a contact that an impact law uses, in the units of the space.

    Attributes:
        inverse_mass: inverse mass matrix of the contact point, order (normal, tangential).
        velocity: (normal, tangential) velocity of the first body's point relative to the other
            body's point; a negative normal velocity approaches.
        bodies: the dynamic bodies that an impulse sets in motion.
        response: change of (v_x, v_y, angular velocity) of each body per unit normal and per unit
            tangential impulse, shape (3 * len(bodies), 2).
        in_stick: the same change per unit normal impulse while the point does not slip, shape
            (3 * len(bodies),).
        stick_compliance: change of the normal velocity per unit normal impulse while the point does
            not slip; 0 if the point cannot move.
        limits: the joints that are at a limit, which are treated as rigid; None without them.
    """

    inverse_mass: Array
    velocity: Vector
    bodies: tuple[pymunk.Body, ...]
    response: Array
    in_stick: Array
    stick_compliance: float
    limits: Limits | None = None

    def pulling_limit(self, impulse: Vector) -> JointRow | None:
        """Return the joint limit that would pull hardest in an impact of given impulse.

        A limit can only push. Return None if no limit pulls by more than rounding error.
        """
        if self.limits is None:
            return None
        rows, response, sizes = self.limits
        pushes = response @ impulse
        least = int(pushes.argmin())
        return rows[least] if pushes[least] < -OPENS * (sizes @ np.abs(impulse)) else None

    def apply(self, impulse: Vector, velocity_after: Vector) -> None:
        """Change the velocities of all bodies by an impulse (normal, tangential) at the contact.

        The contact velocity after the impulse, ``velocity_after``, serves to avoid cancellation.
        """
        change = self.response @ impulse
        if self.stick_compliance > 0.0:
            coupling, tangential = self.inverse_mass[1].tolist()
            parts = abs(coupling * impulse[0]) + abs(tangential * impulse[1])
            if parts > CANCELS * (abs(self.velocity[1]) + abs(velocity_after[1])):
                gain = (velocity_after[1] - self.velocity[1]) / tangential
                change = self.in_stick * impulse[0] + self.response[:, 1] * gain
        set_in_motion(self.bodies, change)


def contact_space(
    body: pymunk.Body,
    point: complex,
    normal: complex,
    other: pymunk.Body | None = None,
    *,
    surface_velocity: complex = 0j,
    released: Collection[pymunk.Constraint] = (),
    connected: Connected | None = None,
) -> ContactSpace:
    """Return the data of a contact that an impact law uses: inverse mass and contact velocity.

    Args:
        body: the body that the impulse acts on; it may be joined to others by any joints.
        point: world coordinates of the contact, x + iy, as all vectors.
        normal: unit vector from the other body towards ``body``; the tangent is the normal turned
            clockwise.
        other: the touched body, on which the opposite impulse acts; None for a fixed obstacle.
        surface_velocity: velocity of the other body's surface relative to the surface of ``body``,
            in addition to the motion of the bodies, as of a conveyor.
        released: joints whose limits take no part.
        connected: the result of ``joined`` for the two bodies, if it is known already.
    """
    ends = [body] if other is None else [body, other]
    bodies, joints = connected or joined(ends)
    rows = [row for joint in joints for row in joint_rows(joint)]
    rows = [
        row for row in rows if not (row.limit and (row.joint in released or _opens(row, bodies)))
    ]
    contact, velocity = relative_motion(ends, point, normal, surface_velocity)
    columns, scale = scaled_columns([*[row.entries for row in rows], *contact], bodies)
    basis, triangle = _free_part(columns, len(rows))
    stick, compliance = _in_stick(columns, basis, triangle)
    space = ContactSpace(
        inverse_mass=(triangle.T @ triangle)[::-1, ::-1],
        velocity=velocity,
        bodies=tuple(bodies),
        response=scale[:, None] * (basis @ triangle[:, ::-1]),
        in_stick=scale * stick,
        stick_compliance=compliance,
    )
    if any(limits := [row.limit for row in rows]):
        touch = columns[:, :-3:-1]
        impulses = np.asarray(
            np.linalg.lstsq(of_length_one(columns[:, :-2])[0], touch, rcond=DEPENDENT)[0],
            dtype=float,
        )
        sizes = np.sqrt((touch**2).sum(axis=0))
        space.limits = Limits([row for row in rows if row.limit], -impulses[limits], sizes)
    return space


def relative_motion(
    ends: Sequence[pymunk.Body], point: complex, normal: complex, surface_velocity: complex
) -> tuple[list[tuple[Entry, ...]], Vector]:
    """Return the Jacobian rows of a contact and the relative velocity of its points.

    Returns:
        The rows for the velocity of the first body's point relative to the other body's point, in
        the order (tangential, normal); and this velocity, in the order (normal, tangential).
    """
    relative = -surface_velocity
    entries = []
    for body, sign in zip(ends, (1.0, -1.0), strict=False):
        moving = lib.cpBodyGetVelocityAtWorldPoint(body._body, (point.real, point.imag))
        relative += sign * complex(moving.x, moving.y)
        entries.append(point_entries(body, point, (-1j * normal, normal), sign))
    relative *= normal.conjugate()
    return list(zip(*entries, strict=True)), (relative.real, -relative.imag)


def _free_part(columns: Array, joints: int) -> tuple[Array, Array]:
    """Return the part of the contact's columns that is orthogonal to the columns of the joints.

    The contact's columns are the last two of ``columns``, (tangential, normal). ``joints`` is the
    number of the joints' columns before them.

    Returns:
        An orthonormal basis of this part, and the triangular matrix with part = basis @ triangle.
    """
    basis, triangle = np.linalg.qr(columns)
    pivots: list[float] = np.abs(triangle.diagonal()).tolist()
    lengths: list[float] = np.sqrt((columns[:, : joints + 1] ** 2).sum(axis=0)).tolist()
    apart = [
        pivot > DEPENDENT * length for pivot, length in zip(pivots, lengths[:joints], strict=False)
    ]
    if len(pivots) >= joints and all(apart):
        moves = len(pivots) == joints + 2 and pivots[-2] > SINGULAR * lengths[-1]
        if moves and pivots[-1] < WEAK * max(abs(triangle[-2, -1]), pivots[-1]):
            _refine(basis, triangle, columns)
        return basis[:, joints:], triangle[joints:, joints:]
    free = columns[:, joints:]
    rigid = span(columns[:, :joints])
    # Twice is enough: the second pass removes the remainder that rounding left (Kahan and Parlett).
    for _ in range(2):
        free = free - rigid @ (rigid.T @ free)
    basis, triangle = np.linalg.qr(free)
    return basis, triangle


def _in_stick(columns: Array, basis: Array, triangle: Array) -> tuple[Array, float]:
    """Return the motion of the bodies while the contact point does not slip.

    A point whose tangential motion is rounding error cannot slip, so normal impulses move it as in
    stick. Its tangential motion is set to zero in ``triangle``.

    Returns:
        The scaled change of the bodies' velocities per unit normal impulse, and the change of the
        contact's normal velocity. Both are 0 if the point cannot move in stick.
    """
    tangential, normal = np.abs(columns[:, -2:]).max(axis=0).tolist()
    if max(map(abs, triangle[:, 0].tolist())) <= SINGULAR * tangential:
        triangle[:, 0] = 0.0
        return basis @ triangle[:, 1], float(triangle[:, 1] @ triangle[:, 1])
    if len(triangle) == 2 and abs(triangle[1, 1]) > SINGULAR * normal:
        return basis[:, 1] * triangle[1, 1], float(triangle[1, 1]) ** 2
    return np.zeros(len(columns)), 0.0


def _refine(basis: Array, triangle: Array, columns: Array) -> None:
    """Restore the lost digits of the motion in stick by iterative refinement.

    The motion in stick is the last column of ``basis``, its length the last entry of ``triangle``.
    Nearly all of it is motion of the heavy bodies. The motion of the light bodies is small compared
    with the rounding error of the whole; the condition that joints and contact point do not move
    along the other columns determines it.
    """
    others = basis[:, :-1]
    out = basis[:, -1]
    for _ in range(2):
        out -= others @ np.linalg.solve(triangle[:-1, :-1].T, columns[:, :-1].T @ out)
    triangle[-1, -1] = columns[:, -1] @ out


def _opens(limit: JointRow, bodies: Sequence[pymunk.Body]) -> bool:
    """Return whether a joint at its limit is opening already, so that the limit cannot push.

    The opening rate is compared with the speeds of the bodies in the norm of the kinetic energy.
    """
    energies = [each.mass * each.velocity.dot(each.velocity) for each in bodies]
    energies += [
        each.moment * each.angular_velocity**2 for each in bodies if each.moment < math.inf
    ]
    entries = [entry for entry in limit.entries if entry[0] in bodies]
    length = sum(
        (x * x + y * y) / body.mass + turn**2 / body.moment for body, x, y, turn in entries
    )
    excess, size = limit.excess()
    return excess > OPENS * max(size, math.sqrt(length * sum(energies)))
