"""Contact-space inverse mass of any pymunk bodies with any joints, and the impulse that acts on all of them at once.

With body velocities V, mass matrix M, joints J V = b and the contact's Jacobian C (rows: normal and tangential velocity
of the first body's point relative to the other's), an impulse p at the contact changes the velocities by
dV = M^-1 (C^T p + J^T lambda) with J dV = 0. In coordinates scaled by the square root of the mass this is a projection:
the part (n, t) of M^-1/2 C^T that is orthogonal to the columns of A = M^-1/2 J^T gives

    K = (n, t)^T (n, t)    and    dV = M^-1/2 (n, t) p.

A^T A gives that part in a few operations; where it is ill-conditioned, as with dependent joints or masses of different size,
one orthogonal factorization [A M^-1/2 C^T] = Q R does. The part of n that is orthogonal to t as well, the motion in stick,
tells how much K has lost to rounding where a heavy body leaves a sticking tip hardly any compliance: its square is K_nn -
K_nt^2/K_tt, to the square root of the error that this difference has. There the impulses are large, and their effects nearly
cancel in dV; the same dV comes without cancellation from what they do to the tip, t dv_t/K_tt and the motion in stick.

Rows of light bodies, the largest ones, come first, which keeps the factorization accurate row by row (Cox and Higham 1998).
Static and kinematic bodies have no inverse mass.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from operator import mul

import numpy as np
import pymunk
from pymunk._chipmunk_cffi import lib

from bristle_sim.arrays import Array
from bristle_sim.contact_space.jacobian import (
    Connected,
    Entry,
    JointRow,
    MassCentres,
    Vector,
    joined,
    joint_rows,
    point_entry,
    scaled_columns,
)
from bristle_sim.contact_space.projection import DEPENDENT, of_length_one, span

CANCELS = 100.0  # parts of the tangential velocity over their sum from which that is applied: two digits are kept

SINGULAR = 64.0 * sys.float_info.epsilon  # motion in stick over the normal column below which it is rounding

WEAK = 1e-2  # the same below which it has lost digits worth getting back

WELL_CONDITIONED, SOFT = 30.0, 0.1
"""Largest product of entries of A^T A and its inverse, and least motion in stick over the normal column, with which the
joints' products serve: they leave an error of some roundings."""

OPENS = 1e-9  # rate of a joint at its limit over the bodies' own speeds above which it opens; the rest is rounding

Column = list[float]
"""A column, scaled or not: three numbers per body."""


@dataclass(slots=True)
class ContactSpace:
    """A contact as an impact law sees it.

    Attributes:
        inverse_mass: K, order (normal, tangential), 1/kg (in the scene's units).
        velocity: (v_n, v_t) of the first body's point relative to the other's; v_n < 0 approaches.
        bodies: the dynamic bodies that an impulse sets in motion.
        response: change of (v_x, v_y, angular velocity) of each body per unit normal and per unit tangential impulse.
        in_stick: that change per unit normal impulse while the point does not slip.
        stick_compliance: gain of v_n per unit normal impulse in stick, 1/kg; 0 if the point cannot move.
        limits: rows of the joints that are at a limit, taken as rigid here.
        limit_response: impulse of each of them, which must be >= 0, per unit impulse, shape (limits, 2), in the norm of the
            kinetic energy.
        sizes: of the contact's own rows in that norm, for comparison.
    """

    inverse_mass: Array
    velocity: Vector
    bodies: tuple[pymunk.Body, ...]
    response: tuple[Column, Column]
    in_stick: Column
    stick_compliance: float
    limits: tuple[JointRow, ...] = ()
    limit_response: Array = field(default_factory=lambda: np.zeros((0, 2)))
    sizes: Array = field(default_factory=lambda: np.zeros(2))

    def limits_push(self, impulse: Sequence[float]) -> bool:
        """Whether no limit pulls, beyond rounding, in an impact with this contact impulse."""
        if not self.limits:
            return True
        given = np.asarray(impulse, dtype=float)
        return bool((self.limit_response @ given >= -OPENS * (self.sizes @ np.abs(given))).all())

    def passes(self, limit: JointRow, impulse: Sequence[float]) -> bool:
        """Whether a limit left out of the impact would be passed after this contact impulse."""
        value, size = limit.excess()
        change = _sum(*self.response, *impulse)
        for body, *factors in limit.entries:
            if body in self.bodies:
                at = 3 * self.bodies.index(body)
                for factor, gain in zip(factors, change[at : at + 3], strict=True):
                    value += factor * gain
                    size += abs(factor * gain)
        # Where other joints stop these bodies, all terms are rounding of what the impulse would do without joints.
        alone = float(self.sizes @ np.abs(np.asarray(impulse, dtype=float)))
        return value < -OPENS * max(size, _row_length(limit, self.bodies) * alone)

    def apply(self, impulse: Sequence[float], velocity_after: Sequence[float] | None = None) -> None:
        """Apply an impulse to all bodies' velocities; ``velocity_after``, if known, keeps them accurate under cancellation."""
        coupling, tangential = self.inverse_mass[1].tolist()
        change = _sum(*self.response, *impulse)
        if velocity_after is not None and self.stick_compliance > 0.0:
            parts = abs(coupling * impulse[0]) + abs(tangential * impulse[1])
            if parts > CANCELS * (abs(self.velocity[1]) + abs(velocity_after[1])):
                gain = (velocity_after[1] - self.velocity[1]) / tangential
                change = _sum(self.in_stick, self.response[1], impulse[0], gain)
        for index, body in enumerate(self.bodies):
            raw, (x, y, turn) = body._body, change[3 * index : 3 * index + 3]
            velocity = lib.cpBodyGetVelocity(raw)
            lib.cpBodySetVelocity(raw, (velocity.x + x, velocity.y + y))
            lib.cpBodySetAngularVelocity(raw, lib.cpBodyGetAngularVelocity(raw) + turn)


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
    """Describe the contact of ``body`` at a world point with ``other``, or with something fixed.

    Args:
        body: the body that the impulse acts on; it may be joined to others by any joints.
        point: world coordinates of the contact.
        normal: unit vector from the other body towards ``body``; the tangent is the normal turned clockwise.
        other: the body that is touched; it takes the opposite impulse.
        surface_velocity: of the other body's surface (a conveyor's) less that of ``body``, added to their motion.
        released: joints whose limits take no part.
        connected: the result of ``joined`` for the two bodies, where it is known already.

    Raises:
        ValueError: if the normal is not a unit vector.
    """
    if not abs(normal[0] ** 2 + normal[1] ** 2 - 1.0) < 1e-9:
        raise ValueError(f"normal = {tuple(normal)}: must be a vector of length 1")
    ends = [body] if other is None else [body, other]
    bodies, joints = connected or joined(ends)
    centres = MassCentres()
    rows = [row for joint in joints for row in joint_rows(joint, centres)]
    limited = any(row.limit for row in rows)
    if limited:
        rows = [row for row in rows if not (row.limit and (row.joint in released or _opens(row, bodies)))]
    contact, velocity = _relative_motion(ends, centres, point, normal, surface_velocity)
    columns, scale = scaled_columns([*[row.entries for row in rows], *contact], bodies)
    n, t, in_stick, size = _free_part(columns)
    coupling, tangential = _dot(n, t), _dot(t, t)
    found = ContactSpace(
        inverse_mass=np.array([[_dot(n, n), coupling], [coupling, tangential]]),
        velocity=velocity,
        bodies=tuple(bodies),
        response=(list(map(mul, scale, n)), list(map(mul, scale, t))),
        in_stick=list(map(mul, scale, in_stick)),
        stick_compliance=size * size if size > SINGULAR * math.hypot(*columns[-1]) else 0.0,
    )
    if limited:
        matrix, limits = np.array(columns).T, [row.limit for row in rows]
        found.limits = tuple(row for row in rows if row.limit)
        found.sizes = np.sqrt((matrix[:, :-3:-1] ** 2).sum(axis=0))
        if any(limits):
            rigid = of_length_one(matrix[:, :-2])
            impulses = np.asarray(np.linalg.lstsq(rigid, matrix[:, :-3:-1], rcond=DEPENDENT)[0], dtype=float)
            found.limit_response = -impulses[limits]
    return found


def _relative_motion(
    ends: Sequence[pymunk.Body], centres: MassCentres, point: Vector, normal: Vector, surface_velocity: Vector
) -> tuple[list[list[Entry]], Vector]:
    """Return the rows of C in the order (tangential, normal), and the relative velocity (normal, tangential)."""
    x, y = normal
    relative_x, relative_y = -surface_velocity[0], -surface_velocity[1]
    tangential, across = [], []
    for body, sign in zip(ends, (1.0, -1.0), strict=False):
        moving, centre = lib.cpBodyGetVelocityAtWorldPoint(body._body, point), centres[body]
        relative_x += sign * moving.x
        relative_y += sign * moving.y
        tangential.append(point_entry(body, centre, point, (y, -x), sign))
        across.append(point_entry(body, centre, point, (x, y), sign))
    return [tangential, across], (relative_x * x + relative_y * y, relative_x * y - relative_y * x)


def _free_part(columns: list[Column]) -> tuple[Column, Column, Column, float]:
    """Return the parts n, t of the last two columns orthogonal to the others, the motion in stick and its size."""
    *_, t, n = columns
    joints = len(columns) - 2
    if joints:
        matrix = np.array(columns).T
        free = _by_products(matrix, joints)
        if free is None:
            return _by_factorization(matrix, joints)
        t, n = free
    if len(t) - joints == 1:
        return n, t, [0.0] * len(n), 0.0
    in_stick, square = n, _dot(t, t)
    # Twice is enough: the second pass removes what rounding left of the first (Kahan and Parlett).
    for _ in range(2 if square else 0):
        factor = _dot(in_stick, t) / square
        in_stick = [a - factor * b for a, b in zip(in_stick, t, strict=True)]
    size = math.sqrt(_dot(in_stick, in_stick))
    if joints and size < SOFT * math.hypot(*n):
        return _by_factorization(matrix, joints)
    return n, t, in_stick, size


def _sum(normal: Column, tangential: Column, push: float, rub: float) -> Column:
    return [push * a + rub * b for a, b in zip(normal, tangential, strict=True)]


def _dot(first: Column, second: Column) -> float:
    return sum(map(mul, first, second), 0.0)


def _by_products(columns: Array, joints: int) -> list[Column] | None:
    """Return the free part by the joints' products; None where they are ill-conditioned."""
    rigid, contact = columns[:, :joints], columns[:, joints:]
    products = rigid.T @ rigid
    try:
        inverse = np.linalg.inv(products)
    except np.linalg.LinAlgError:
        return None
    if not np.abs(inverse).max() * products.max() < WELL_CONDITIONED:
        return None
    solved = rigid @ inverse
    for _ in range(2):
        contact = contact - solved @ (rigid.T @ contact)
    free: list[Column] = contact.T.tolist()
    return free


def _by_factorization(columns: Array, joints: int) -> tuple[Column, Column, Column, float]:
    """Return the free part by an orthogonal factorization, which suits any masses and joints."""
    basis, triangle = np.linalg.qr(columns)
    lengths = np.sqrt((columns**2).sum(axis=0))
    pivots = np.abs(triangle.diagonal())
    if len(pivots) >= joints and (pivots[:joints] > DEPENDENT * lengths[:joints]).all():
        moves = len(pivots) == joints + 2 and pivots[-2] > SINGULAR * lengths[-2]
        if moves and pivots[-1] < WEAK * max(abs(float(triangle[-2, -1])), float(pivots[-1])):
            _refine(basis, triangle, columns)
        basis, triangle = basis[:, joints:], triangle[joints:, joints:]
    else:
        free, rigid = columns[:, joints:], span(columns[:, :joints])
        for _ in range(2):
            free = free - rigid @ (rigid.T @ free)
        basis, triangle = np.linalg.qr(free)
    t, n = (basis @ triangle).T.tolist()
    if len(triangle) < 2:
        return n, t, [0.0] * len(n), 0.0
    return n, t, (basis[:, 1] * triangle[1, 1]).tolist(), abs(float(triangle[1, 1]))


def _refine(basis: Array, triangle: Array, columns: Array) -> None:
    """Restore the lost digits of the motion in stick (the last column of the basis) and of its part of the normal column.

    Nearly all of it is motion of the heavy bodies; that of the light ones is small compared with the rounding of the whole. The
    joints and stick, the other columns, determine it, and that correction is accurate (iterative refinement).
    """
    others, out = basis[:, :-1], basis[:, -1]
    for _ in range(2):
        out -= others @ np.linalg.solve(triangle[:-1, :-1].T, columns[:, :-1].T @ out)
    triangle[-1, -1] = columns[:, -1] @ out


def _opens(limit: JointRow, bodies: Sequence[pymunk.Body]) -> bool:
    """Whether a reached limit is opening already, so that it cannot push; compared in the norm of the kinetic energy."""
    excess, size = limit.excess()
    moving = [each.mass * each.velocity.dot(each.velocity) for each in bodies]
    turning = [each.moment * each.angular_velocity**2 for each in bodies if each.moment < math.inf]
    return excess > OPENS * max(size, _row_length(limit, bodies) * math.sqrt(sum(moving) + sum(turning)))


def _row_length(row: JointRow, bodies: Sequence[pymunk.Body]) -> float:
    parts = ((x * x + y * y) / body.mass + turn**2 / body.moment for body, x, y, turn in row.entries if body in bodies)
    return math.sqrt(sum(parts))
