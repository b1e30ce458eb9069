"""Contact-space inverse mass of any pymunk bodies joined by pivots, and the impulse that acts on all of them at once.

With body velocities V, mass matrix M, joints J V = b and the contact's Jacobian C (rows: normal and tangential velocity
of the first body's point relative to the other's), an impulse p at the contact changes the velocities by
dV = M^-1 (C^T p + J^T lambda) with J dV = 0. In coordinates scaled by the square root of the mass this is a projection:
the part B' of B = M^-1/2 C^T that is orthogonal to the columns of A = M^-1/2 J^T gives

    K = B'^T B'    and    dV = M^-1/2 B' p.

One orthogonal factorization [A B] = Q R holds both, B' = Q_2 R_22, so K = R_22^T R_22 is symmetric and positive
semidefinite whatever the mass ratios. Static and kinematic bodies have no inverse mass.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pymunk
from numpy.typing import NDArray

__all__ = ["ContactSpace", "contact_space"]

Array = NDArray[np.float64]
Vector = tuple[float, float]
Rigid = pymunk.PivotJoint | pymunk.PinJoint

_SOFT = (pymunk.DampedSpring, pymunk.DampedRotarySpring)
"""Constraints of finite force: they pass no impulse."""

DEPENDENT = 1e-12
"""A joint whose scaled rows are shorter than this after orthogonalization repeats what other joints already say."""


@dataclass(frozen=True, slots=True)
class ContactSpace:
    """A contact as an impact law sees it.

    Attributes:
        inverse_mass: K, shape (2, 2), order (normal, tangential), 1/kg (in the scene's units).
        velocity: (v_n, v_t) of the first body's point relative to the other's; v_n < 0 approaches.
        bodies: the dynamic bodies that an impulse sets in motion.
        response: change of (v_x, v_y, angular velocity) of each body per unit impulse, shape (3 bodies, 2).
    """

    inverse_mass: Array
    velocity: tuple[float, float]
    bodies: tuple[pymunk.Body, ...]
    response: Array

    def apply(self, impulse: Sequence[float]) -> None:
        """Change the velocities of all bodies by the contact impulse (normal, tangential) on the first body."""
        change = (self.response @ np.asarray(impulse, dtype=float)).tolist()
        for index, body in enumerate(self.bodies):
            x, y, turn = change[3 * index : 3 * index + 3]
            body.velocity = (body.velocity.x + x, body.velocity.y + y)
            body.angular_velocity += turn


def contact_space(
    body: pymunk.Body,
    point: tuple[float, float],
    normal: tuple[float, float],
    other: pymunk.Body | None = None,
) -> ContactSpace:
    """Contact of ``body`` at a world point with ``other``, or with something fixed.

    Args:
        body: the body that the impulse acts on; it may be joined to others by pivot and pin joints.
        point: world coordinates of the contact.
        normal: unit vector from the other body towards ``body``; the tangent is the normal turned clockwise, so on a
            floor (normal +y) it is +x.
        other: the body that is touched; it takes the opposite impulse.

    Returns:
        The contact space.

    Raises:
        ValueError: if the normal is not a unit vector, or a rigid constraint is neither pivot nor pin joint.
    """
    if not abs(normal[0] ** 2 + normal[1] ** 2 - 1.0) < 1e-9:
        raise ValueError(f"normal = {tuple(normal)}: a vector of length 1 is allowed")
    ends = [each for each in (body, other) if each is not None]
    bodies, joints = _joined(ends)
    frames = {each: _Frame.of(each, 3 * index) for index, each in enumerate(bodies)}
    size = 3 * len(bodies)
    columns = [column for joint in joints for column in _joint_columns(joint, frames, size)]
    constraints = len(columns)
    velocity = []
    for direction in (normal, (normal[1], -normal[0])):
        column = [0.0] * size
        speed = 0.0
        for each, sign in zip(ends, (1.0, -1.0), strict=False):
            if each in frames:
                frames[each].fill(column, point, direction, sign)
            moving = each.velocity_at_world_point(point)
            speed += sign * (moving.x * direction[0] + moving.y * direction[1])
        columns.append(column)
        velocity.append(speed)
    scale = np.array([share for frame in frames.values() for share in (frame.linear, frame.linear, frame.angular)])
    free = _free_part(np.array(columns).T, constraints)
    return ContactSpace(free.T @ free, (velocity[0], velocity[1]), tuple(bodies), scale[:, None] * free)


class _Frame(NamedTuple):
    """Where a body is and the inverse roots of its mass and moment; ``at`` is its first row."""

    x: float
    y: float
    linear: float
    angular: float
    at: int

    @classmethod
    def of(cls, body: pymunk.Body, at: int) -> _Frame:
        x, y = body.position
        return cls(x, y, 1.0 / math.sqrt(body.mass), 1.0 / math.sqrt(body.moment), at)

    def fill(self, column: list[float], point: Vector, direction: Vector, sign: float) -> None:
        """Add the scaled Jacobian of the velocity of a world point of the body along a direction."""
        lever = (point[0] - self.x) * direction[1] - (point[1] - self.y) * direction[0]
        column[self.at] += sign * self.linear * direction[0]
        column[self.at + 1] += sign * self.linear * direction[1]
        column[self.at + 2] += sign * self.angular * lever


def _joined(ends: Sequence[pymunk.Body]) -> tuple[list[pymunk.Body], list[Rigid]]:
    """Dynamic bodies reachable from the contact over rigid joints, and those joints."""
    bodies: list[pymunk.Body] = []
    joints: list[Rigid] = []
    waiting = [each for each in ends if each.body_type == pymunk.Body.DYNAMIC]
    while waiting:
        body = waiting.pop()
        if body in bodies:
            continue
        bodies.append(body)
        for constraint in body.constraints:
            if isinstance(constraint, _SOFT) or constraint in joints:
                continue
            if not isinstance(constraint, Rigid):
                raise ValueError(
                    f"{type(constraint).__name__}: only pivot and pin joints (and springs) are allowed on bodies that"
                    " take an impact"
                )
            joints.append(constraint)
            waiting += [each for each in (constraint.a, constraint.b) if each.body_type == pymunk.Body.DYNAMIC]
    return bodies, joints


def _joint_columns(joint: Rigid, frames: dict[pymunk.Body, _Frame], size: int) -> list[list[float]]:
    """Scaled Jacobian of a pivot (two columns) or of a pin (one, along itself)."""
    first, second = joint.a.local_to_world(joint.anchor_a), joint.b.local_to_world(joint.anchor_b)
    directions: tuple[Vector, ...] = ((1.0, 0.0), (0.0, 1.0))
    if isinstance(joint, pymunk.PinJoint):
        along = (second - first).normalized()
        directions = ((along.x, along.y),)
    columns = []
    for direction in directions:
        column = [0.0] * size
        for body, anchor, sign in ((joint.a, first, 1.0), (joint.b, second, -1.0)):
            if body in frames:
                frames[body].fill(column, anchor, direction, sign)
        columns.append(column)
    return columns


def _free_part(columns: Array, constraints: int) -> Array:
    """The part of the last columns that is orthogonal to the first ``constraints`` ones."""
    if not constraints:
        return columns
    basis, triangle = np.linalg.qr(columns)
    pivots = np.abs(np.diagonal(triangle))[:constraints]
    if len(pivots) == constraints and pivots.min() > DEPENDENT * pivots.max():
        return np.asarray(basis[:, constraints:] @ triangle[constraints:, constraints:])
    span, vectors = columns[:, :constraints], columns[:, constraints:]
    directions, sizes, _ = np.linalg.svd(span, full_matrices=False)
    kept = directions[:, sizes > DEPENDENT * sizes[0]]
    # Twice is enough: the second pass removes what rounding left of the first (Kahan and Parlett).
    for _ in range(2):
        vectors = vectors - kept @ (kept.T @ vectors)
    return vectors
