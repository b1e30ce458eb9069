"""Contact-space inverse mass of any pymunk bodies joined by pivots, and the impulse that acts on all of them at once.

With body velocities V, mass matrix M, joints J V = b and the contact's Jacobian C (rows: normal and tangential velocity
of the first body's point relative to the other's), an impulse p at the contact changes the velocities by
dV = M^-1 (C^T p + J^T lambda) with J dV = 0. In coordinates scaled by the square root of the mass this is a projection:
with A = M^-1/2 J^T and B = M^-1/2 C^T, what is left of B after taking away its part in the span of A gives

    K = B'^T B'    and    dV = M^-1/2 B' p,

so K is symmetric and positive semidefinite whatever the mass ratios. Static and kinematic bodies have no inverse mass.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pymunk
from numpy.typing import NDArray

__all__ = ["ContactSpace", "contact_space"]

Array = NDArray[np.float64]

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
    columns = {each: 3 * index for index, each in enumerate(bodies)}
    axes = (normal, (normal[1], -normal[0]))

    scaled_contact = np.zeros((3 * len(bodies), 2))
    velocity = [0.0, 0.0]
    for each, sign in zip(ends, (1.0, -1.0), strict=False):
        arm = (point[0] - each.position.x, point[1] - each.position.y)
        moving = each.velocity_at_world_point(point)
        for axis, direction in enumerate(axes):
            velocity[axis] += sign * (moving.x * direction[0] + moving.y * direction[1])
            _fill(scaled_contact[:, axis], columns, each, direction, arm, sign)
    scaled_joints = np.zeros((3 * len(bodies), 2 * len(joints)))
    for index, joint in enumerate(joints):
        _fill_joint(scaled_joints[:, 2 * index : 2 * index + 2], columns, joint)

    scale = np.array([_root_inverse(value) for each in bodies for value in (each.mass, each.mass, each.moment)])
    free = _project_out(scale[:, None] * scaled_joints, scale[:, None] * scaled_contact)
    return ContactSpace(free.T @ free, (velocity[0], velocity[1]), tuple(bodies), scale[:, None] * free)


def _joined(ends: Sequence[pymunk.Body]) -> tuple[list[pymunk.Body], list[pymunk.Constraint]]:
    """Dynamic bodies reachable from the contact over rigid joints, and those joints."""
    bodies: list[pymunk.Body] = []
    joints: list[pymunk.Constraint] = []
    waiting = [each for each in ends if each.body_type == pymunk.Body.DYNAMIC]
    while waiting:
        body = waiting.pop()
        if body in bodies:
            continue
        bodies.append(body)
        for constraint in body.constraints:
            if isinstance(constraint, _SOFT) or constraint in joints:
                continue
            if not isinstance(constraint, pymunk.PivotJoint | pymunk.PinJoint):
                raise ValueError(
                    f"{type(constraint).__name__}: only pivot and pin joints (and springs) are allowed on bodies that"
                    " take an impact"
                )
            joints.append(constraint)
            waiting += [each for each in (constraint.a, constraint.b) if each.body_type == pymunk.Body.DYNAMIC]
    return bodies, joints


def _fill(
    column: Array,
    columns: dict[pymunk.Body, int],
    body: pymunk.Body,
    direction: tuple[float, float],
    arm: tuple[float, float],
    sign: float,
) -> None:
    """Jacobian of a body point's velocity along a direction, into the body's rows of a column."""
    if body in columns:
        at = columns[body]
        column[at] += sign * direction[0]
        column[at + 1] += sign * direction[1]
        column[at + 2] += sign * (arm[0] * direction[1] - arm[1] * direction[0])


def _fill_joint(pair: Array, columns: dict[pymunk.Body, int], joint: pymunk.Constraint) -> None:
    """Jacobian of a pivot (both axes) or of a pin (along itself, the second column left empty)."""
    assert isinstance(joint, pymunk.PivotJoint | pymunk.PinJoint)
    first, second = joint.a.local_to_world(joint.anchor_a), joint.b.local_to_world(joint.anchor_b)
    directions = [(1.0, 0.0), (0.0, 1.0)]
    if isinstance(joint, pymunk.PinJoint):
        along = (second - first).normalized()
        directions = [(along.x, along.y)]
    for axis, direction in enumerate(directions):
        for body, anchor, sign in ((joint.a, first, 1.0), (joint.b, second, -1.0)):
            arm = (anchor.x - body.position.x, anchor.y - body.position.y)
            _fill(pair[:, axis], columns, body, direction, arm, sign)


def _root_inverse(mass: float) -> float:
    return 1.0 / float(np.sqrt(mass))


def _project_out(span: Array, vectors: Array) -> Array:
    """What is left of the vectors' columns outside the span of the other columns."""
    if span.shape[1] == 0:
        return vectors
    basis, triangle = np.linalg.qr(span)
    pivots = np.abs(np.diagonal(triangle))
    if pivots.min() <= DEPENDENT * pivots.max():
        basis, sizes, _ = np.linalg.svd(span, full_matrices=False)
        basis = basis[:, sizes > DEPENDENT * sizes[0]]
    # Twice is enough: the second pass removes what rounding left of the first (Kahan and Parlett).
    for _ in range(2):
        vectors = vectors - basis @ (basis.T @ vectors)
    return vectors
