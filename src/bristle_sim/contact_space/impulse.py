"""Contact-space inverse mass of any pymunk bodies with any joints, and the impulse that acts on all
of them at once.

With body velocities V, mass matrix M, joints J V = b and the contact's Jacobian C (rows: normal and
tangential velocity of the first body's point relative to the other's), an impulse p at the contact
changes the velocities by dV = M^-1 (C^T p + J^T lambda) with J dV = 0. In coordinates scaled by the
square root of the mass this is a projection: the part (n, t) of M^-1/2 C^T that is orthogonal to
the columns of A = M^-1/2 J^T gives

    K = (n, t)^T (n, t)    and    dV = M^-1/2 (n, t) p.

An orthogonal factorization [A M^-1/2 C^T] = Q R gives that part. The part of n that is also
orthogonal to t is the motion in stick. Its square is the compliance in stick, K_nn - K_nt^2/K_tt.
This difference loses its digits where a heavy body leaves a sticking tip hardly any compliance. The
impulses are then large, and their effects nearly cancel in dV. The same dV follows without
cancellation from the motion of the tip: t dv_t/K_tt, and the motion in stick.

Rows of light bodies, the largest ones, come first, which keeps the factorization accurate row by
row (Cox and Higham 1998). Static and kinematic bodies have no inverse mass.
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

# Parts of the change of v_t, over v_t before and after, above which the tip's motion is used.
# Two digits have cancelled there.
CANCELS = 100.0

SINGULAR = (
    64.0 * sys.float_info.epsilon
)  # motion in stick over the normal column below which it is rounding
WEAK = 1e-2  # motion in stick over the normal column below which its lost digits are restored
# Opening rate of a joint at its limit, over the speeds of the bodies, above which it opens; a
# smaller rate is rounding.
OPENS = 1e-9


class Limits(NamedTuple):
    """Joints at a limit.

    Attributes:
        rows: their rows.
        response: impulse of each of them, which must be >= 0, per unit impulse at the contact, shape
            (limits, 2), in the norm of the kinetic energy.
        sizes: lengths of the contact's own rows in that norm, for comparison.
    """

    rows: list[JointRow]
    response: Array
    sizes: Array


@dataclass(slots=True)
class ContactSpace:
    """The data of a contact that an impact law uses.

    Attributes:
        inverse_mass: K, order (normal, tangential), 1/kg (in the scene's units).
        velocity: (v_n, v_t) of the first body's point relative to the other's; v_n < 0 approaches.
        bodies: the dynamic bodies that an impulse sets in motion.
        response: change of (v_x, v_y, angular velocity) of each body per unit normal and per unit
            tangential impulse, shape (3 bodies, 2).
        in_stick: the same change per unit normal impulse while the point does not slip, shape (3
        bodies,).
        stick_compliance: gain of v_n per unit normal impulse in stick, 1/kg; 0 if the point cannot
            move.
        limits: the joints that are at a limit; they are treated as rigid.
    """

    inverse_mass: Array
    velocity: Vector
    bodies: tuple[pymunk.Body, ...]
    response: Array
    in_stick: Array
    stick_compliance: float
    limits: Limits | None = None

    def pulling_limit(self, impulse: Vector) -> JointRow | None:
        """Return the limit that pulls hardest at a contact impulse; None if no limit pulls beyond
        rounding.
        """
        if self.limits is None:
            return None
        rows, response, sizes = self.limits
        pushes = response @ impulse
        least = int(pushes.argmin())
        return rows[least] if pushes[least] < -OPENS * (sizes @ np.abs(impulse)) else None

    def apply(self, impulse: Vector, velocity_after: Vector) -> None:
        """Apply an impulse to the velocities of all bodies.

        ``velocity_after``, the contact velocity after the impulse, keeps the result accurate under
        cancellation.
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
    point: Vector,
    normal: Vector,
    other: pymunk.Body | None = None,
    *,
    surface_velocity: Vector = (0.0, 0.0),
    released: Collection[pymunk.Constraint] = (),
    connected: Connected | None = None,
) -> ContactSpace:
    """Return the data of the contact of ``body`` at a world point with ``other``, or with a fixed
    obstacle.

    Args:
        body: the body that the impulse acts on; it may be joined to others by any joints.
        point: world coordinates of the contact.
        normal: unit vector from the other body towards ``body``; the tangent is the normal turned
            clockwise.
        other: the touched body, on which the opposite impulse acts.
        surface_velocity: velocity of the other body's surface, as of a conveyor, less that of the
        surface of ``body``; it is added to the motion of the bodies.
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
    ends: Sequence[pymunk.Body], point: Vector, normal: Vector, surface_velocity: Vector
) -> tuple[list[tuple[Entry, ...]], Vector]:
    """Return the rows of C in the order (tangential, normal), and the relative velocity (normal, tangential)."""
    x, y = normal
    relative_x = -surface_velocity[0]
    relative_y = -surface_velocity[1]
    entries = []
    for body, sign in zip(ends, (1.0, -1.0), strict=False):
        moving = lib.cpBodyGetVelocityAtWorldPoint(body._body, point)
        relative_x += sign * moving.x
        relative_y += sign * moving.y
        entries.append(point_entries(body, point, ((y, -x), (x, y)), sign))
    return list(zip(*entries, strict=True)), (
        relative_x * x + relative_y * y,
        relative_x * y - relative_y * x,
    )


def _free_part(columns: Array, joints: int) -> tuple[Array, Array]:
    """Return the part of the last two columns, (t, n), that is orthogonal to the joints' columns.

    Returns:
        An orthonormal basis of this part, and the triangle with part = basis @ triangle.
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
    """Return the motion in stick per unit normal impulse, and the compliance in stick.

    Both are 0 if the point cannot move in stick. A point whose tangential motion is rounding cannot
    slip: normal impulses move it as in stick. Its tangential motion is set to zero in ``triangle``.
    """
    tangential, normal = np.abs(columns[:, -2:]).max(axis=0).tolist()
    if max(map(abs, triangle[:, 0].tolist())) <= SINGULAR * tangential:
        triangle[:, 0] = 0.0
        return basis @ triangle[:, 1], float(triangle[:, 1] @ triangle[:, 1])
    if len(triangle) == 2 and abs(triangle[1, 1]) > SINGULAR * normal:
        return basis[:, 1] * triangle[1, 1], float(triangle[1, 1]) ** 2
    return np.zeros(len(columns)), 0.0


def _refine(basis: Array, triangle: Array, columns: Array) -> None:
    """Restore the lost digits of the motion in stick, the last column of the basis, and of its
    length.

    Nearly all of it is motion of the heavy bodies; the motion of the light ones is small compared
    with the rounding of the whole. The other columns, the joints and stick, determine it. This
    correction is accurate (iterative refinement).
    """
    others = basis[:, :-1]
    out = basis[:, -1]
    for _ in range(2):
        out -= others @ np.linalg.solve(triangle[:-1, :-1].T, columns[:, :-1].T @ out)
    triangle[-1, -1] = columns[:, -1] @ out


def _opens(limit: JointRow, bodies: Sequence[pymunk.Body]) -> bool:
    """Return whether a reached limit is opening already, so that it cannot push.

    The rates are compared in the norm of the kinetic energy.
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
