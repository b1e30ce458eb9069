"""Contact-space inverse mass of any pymunk bodies with any joints, and the impulse that acts on all of them at once.

With body velocities V, mass matrix M, joints J V = b and the contact's Jacobian C (rows: normal and tangential velocity
of the first body's point relative to the other's), an impulse p at the contact changes the velocities by
dV = M^-1 (C^T p + J^T lambda) with J dV = 0. In coordinates scaled by the square root of the mass this is a projection:
the part B' of B = M^-1/2 C^T that is orthogonal to the columns of A = M^-1/2 J^T gives

    K = B'^T B'    and    dV = M^-1/2 B' p.

One orthogonal factorization [A B] = Q R gives both, B' = Q_2 R_22, so K = R_22^T R_22 is symmetric and positive
semidefinite whatever the mass ratios. With the tangential column first, R_22 = ((t, c), (0, s)) also tells what K has lost
to rounding where a heavy body leaves a sticking tip hardly any compliance: the normal compliance in stick, s^2, which is
K_nn - K_nt^2/K_tt, to the square root of the error that this difference has. There the impulses are large, and their
effects nearly cancel in dV; the same dV comes without cancellation from what they do to the tip,

    dV = M^-1/2 Q_2 (dv_t/t, s p_n).

Rows of light bodies, the largest ones, come first, which keeps the factorization accurate row by row (Cox and Higham 1998).
Static and kinematic bodies have no inverse mass.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import pymunk

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
    scaled_jacobian,
)

CANCELS = 100.0
"""An impulse whose parts change the tangential velocity this many times as much as their sum does is applied by what it
does: two digits are kept in any case."""

SINGULAR = 64.0 * sys.float_info.epsilon
"""A compliance in stick whose root is below this fraction of the normal column is rounding: the contact has one degree of
freedom."""

WEAK = 1e-2
"""A compliance in stick whose root is below this fraction of the normal column has lost digits worth getting back."""

DEPENDENT = 1e-12
"""A joint whose scaled rows are shortened to this fraction by orthogonalization repeats what other joints already say."""

OPENS = 1e-9
"""A joint at its limit opens if its rate is above this fraction of the bodies' own speeds; the rest is rounding."""

NO_LIMITS = np.zeros((0, 2))


@dataclass(slots=True)
class ContactSpace:
    """A contact as an impact law sees it.

    Attributes:
        inverse_mass: K, shape (2, 2), order (normal, tangential), 1/kg (in the scene's units).
        velocity: (v_n, v_t) of the first body's point relative to the other's; v_n < 0 approaches.
        bodies: the dynamic bodies that an impulse sets in motion.
        response: change of (v_x, v_y, angular velocity) of each body per unit impulse, shape (3 bodies, 2).
        stick_compliance: gain of v_n per unit normal impulse while the point does not slip, 1/kg; 0 where it cannot move.
        basis, factor: response, its columns in the other order, is basis times factor, which is upper triangular.
        limits: rows of the joints that are at a limit, taken as rigid here.
        limit_response: impulse of each of them, which must be >= 0, per unit impulse, shape (limits, 2); rows scaled to
            length 1 in the norm of the kinetic energy, and so comparable with ``sizes``, of the contact's own rows.
    """

    inverse_mass: Array
    velocity: Vector
    bodies: tuple[pymunk.Body, ...]
    response: Array
    stick_compliance: float
    basis: Array
    factor: Array
    limits: tuple[JointRow, ...] = ()
    limit_response: Array = field(default_factory=lambda: NO_LIMITS)
    sizes: Array = field(default_factory=lambda: np.zeros(2))

    def limits_push(self, impulse: Sequence[float]) -> bool:
        """Whether all limits push, or carry nothing but rounding, in an impact with this contact impulse."""
        if not self.limits:
            return True
        given = np.asarray(impulse, dtype=float)
        return bool((self.limit_response @ given >= -OPENS * (self.sizes @ np.abs(given))).all())

    def passes(self, limit: JointRow, impulse: Sequence[float]) -> bool:
        """Whether a limit that takes no part is passed after an impact with this contact impulse."""
        value, size = limit.excess()
        given = np.asarray(impulse, dtype=float)
        change = (self.response @ given).tolist()
        for body, *factors in limit.entries:
            if body in self.bodies:
                at = 3 * self.bodies.index(body)
                for factor, gain in zip(factors, change[at : at + 3], strict=True):
                    value += factor * gain
                    size += abs(factor * gain)
        # Where other joints stop these bodies, all terms are rounding of what the impulse would do without joints.
        return value < -OPENS * max(size, _row_length(limit, self.bodies) * float(self.sizes @ np.abs(given)))

    def apply(self, impulse: Sequence[float], velocity_after: Sequence[float] | None = None) -> None:
        """Change the velocities of all bodies by the contact impulse (normal, tangential) on the first body.

        ``velocity_after`` (v_n, v_t), where it is known, keeps the result accurate if parts of the impulse cancel.
        """
        if velocity_after is not None and self._cancels(impulse, velocity_after[1]):
            gain = velocity_after[1] - self.velocity[1]
            change = self.basis[:, :2] @ (gain / self.factor[0, 0], self.factor[1, 1] * impulse[0])
        else:
            change = self.response @ np.asarray(impulse, dtype=float)
        self._change(change.tolist())

    def _cancels(self, impulse: Sequence[float], after: float) -> bool:
        """Whether normal impulse and friction take each other's effect on v_t away, but for rounding."""
        coupling, tangential = self.inverse_mass[1].tolist()
        parts = abs(coupling * impulse[0]) + abs(tangential * impulse[1])
        return self.stick_compliance > 0.0 and parts > CANCELS * (abs(self.velocity[1]) + abs(after))

    def _change(self, change: Sequence[float]) -> None:
        for index, body in enumerate(self.bodies):
            x, y, turn = change[3 * index : 3 * index + 3]
            body.velocity = (body.velocity.x + x, body.velocity.y + y)
            body.angular_velocity += turn


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
        normal: unit vector from the other body towards ``body``; the tangent is the normal turned clockwise, so on a
            floor (normal +y) it is +x.
        other: the body that is touched; it takes the opposite impulse.
        surface_velocity: of the other body's surface (a conveyor's) less that of ``body``, added to their motion.
        released: joints whose limits take no part.
        connected: what ``joined`` returns for the two bodies, where it is known already.

    Returns:
        The contact space.

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
    columns, scale = scaled_jacobian([*[row.entries for row in rows], *contact], bodies)
    free, basis, factor = _free_part(columns, len(rows))
    stick = abs(float(factor[1, 1])) if len(factor) > 1 else 0.0
    response = free[:, ::-1]
    found = ContactSpace(
        inverse_mass=response.T @ response,
        velocity=velocity,
        bodies=tuple(bodies),
        response=scale[:, None] * response,
        stick_compliance=stick**2 if stick > SINGULAR * math.hypot(*columns[:, -1].tolist()) else 0.0,
        basis=scale[:, None] * basis,
        factor=factor,
    )
    return _with_limits(found, rows, columns) if limited else found


def _with_limits(space: ContactSpace, rows: Sequence[JointRow], columns: Array) -> ContactSpace:
    """Return a contact space with what tells whether limits push and are kept."""
    return replace(
        space,
        limits=tuple(row for row in rows if row.limit),
        limit_response=_limit_response(columns, [row.limit for row in rows]),
        sizes=_lengths(columns[:, :-3:-1]),
    )


def _relative_motion(
    ends: Sequence[pymunk.Body], centres: MassCentres, point: Vector, normal: Vector, surface_velocity: Vector
) -> tuple[list[list[Entry]], Vector]:
    """Return the rows of C in the order (tangential, normal), and the relative velocity (normal, tangential)."""
    signed = list(zip(ends, (1.0, -1.0), strict=False))
    moving = [each.velocity_at_world_point(point) for each in ends]
    rows, velocity = [], []
    for x, y in ((normal[1], -normal[0]), (normal[0], normal[1])):
        speed = 0.0
        for (_, sign), (u, v) in zip(signed, moving, strict=True):
            speed += sign * (u * x + v * y)
        rows.append([point_entry(each, centres[each], point, (x, y), sign) for each, sign in signed])
        velocity.append(speed - (surface_velocity[0] * x + surface_velocity[1] * y))
    return rows, (velocity[1], velocity[0])


def _free_part(columns: Array, constraints: int) -> tuple[Array, Array, Array]:
    """Return the part of the last two columns that is orthogonal to the first ones, and its factors Q_2 and R_22."""
    if not constraints and columns[:, 0].any():
        return columns, *_of_two(columns)
    basis, triangle = np.linalg.qr(columns)
    if not constraints:
        return columns, basis, triangle
    lengths, pivots = _lengths(columns).tolist(), list(map(abs, triangle.diagonal().tolist()))
    independent = [pivot > DEPENDENT * length for pivot, length in zip(pivots, lengths[:constraints], strict=False)]
    if len(independent) == constraints and all(independent):
        moves = len(pivots) == constraints + 2 and pivots[-2] > SINGULAR * lengths[-2]
        if moves and pivots[-1] < WEAK * max(abs(float(triangle[-2, -1])), pivots[-1]):
            _refine(basis, triangle, columns)
        basis, triangle = basis[:, constraints:], triangle[constraints:, constraints:]
        return basis @ triangle, basis, triangle
    free = _orthogonal(columns[:, constraints:], columns[:, :constraints])
    return free, *np.linalg.qr(free)


def _of_two(columns: Array) -> tuple[Array, Array]:
    """Return Q and R of two columns by Gram and Schmidt, twice: what two free bodies need, in a quarter of the time."""
    first, rest = columns.T
    length = math.sqrt(first @ first)
    first = first / length
    coupling = first @ rest
    rest = rest - coupling * first
    again = first @ rest
    rest = rest - again * first
    size = math.sqrt(rest @ rest)
    unit = rest / size if size > 0.0 else np.zeros_like(rest)
    return np.array([first, unit]).T, np.array([[length, coupling + again], [0.0, size]])


def _refine(basis: Array, triangle: Array, columns: Array) -> None:
    """Restore the digits of the motion left in stick, the last column of the basis, and of its part of the normal column.

    Nearly all of it is motion of the heavy bodies; what the light ones do is small beside rounding of the whole. It is
    what the joints and stick, the other columns, make of it, and that correction is accurate (iterative refinement).
    """
    others, out = basis[:, :-1], basis[:, -1]
    for _ in range(2):
        out -= others @ np.linalg.solve(triangle[:-1, :-1].T, columns[:, :-1].T @ out)
    triangle[-1, -1] = columns[:, -1] @ out


def _orthogonal(vectors: Array, span: Array) -> Array:
    """Return the part of vectors that is orthogonal to columns some of which repeat the others."""
    directions, sizes, _ = np.linalg.svd(_of_length_one(span), full_matrices=False)
    kept = directions[:, sizes > DEPENDENT * sizes[0]]
    # Twice is enough: the second pass removes what rounding left of the first (Kahan and Parlett).
    for _ in range(2):
        vectors = vectors - kept @ (kept.T @ vectors)
    return vectors


def _limit_response(columns: Array, limits: list[bool]) -> Array:
    """Return the limits' impulses per unit contact impulse (normal, tangential): lambda of J dV = 0, but for units."""
    if not any(limits):
        return np.zeros((0, 2))
    joints = _of_length_one(columns[:, : len(limits)])
    impulses = np.asarray(np.linalg.lstsq(joints, columns[:, :-3:-1], rcond=DEPENDENT)[0], dtype=float)
    return -impulses[limits]


def _opens(limit: JointRow, bodies: Sequence[pymunk.Body]) -> bool:
    """Whether a limit that is reached opens already, and cannot push: its rate is more than rounding.

    It is compared in the norm of the kinetic energy, where rates of turning and shifting have the same units.
    """
    excess, size = limit.excess()
    energies = (each.mass * each.velocity.dot(each.velocity) for each in bodies)
    turning = (each.moment * each.angular_velocity**2 for each in bodies if each.moment < math.inf)
    return excess > OPENS * max(size, _row_length(limit, bodies) * math.sqrt(sum(energies) + sum(turning)))


def _row_length(row: JointRow, bodies: Sequence[pymunk.Body]) -> float:
    """Return the length of a joint's row in the norm of the kinetic energy."""
    parts = ((x * x + y * y) / body.mass + turn**2 / body.moment for body, x, y, turn in row.entries if body in bodies)
    return math.sqrt(sum(parts))


def _lengths(columns: Array) -> Array:
    return np.asarray(np.sqrt(np.einsum("ij,ij->j", columns, columns)))


def _of_length_one(columns: Array) -> Array:
    """Return the columns scaled to length 1: joints that turn and joints that shift have different units."""
    lengths = _lengths(columns)
    return columns / np.where(lengths > 0.0, lengths, 1.0)
