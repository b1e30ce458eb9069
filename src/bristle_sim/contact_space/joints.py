"""Velocity constraints of pymunk's joints, and the nearest velocities that obey them.

A joint obeys J V = b, and J V >= b at a limit. V holds (v_x, v_y) of each body's mass centre and
its angular velocity. A joint transmits an impulse only if its force has no bound. In an
instantaneous impact springs, joints with a finite ``max_force`` and joints outside a space transmit
no impulse. Limits (of slide, groove, rotary limit and ratchet joints) push in one direction only,
while they are reached. The signs are those of the Chipmunk sources (cpSlideJoint.c and its
siblings).

    pin, slide        velocity of anchor a relative to anchor b, along the line between them
    pivot             velocity of anchor a relative to anchor b, both components
    groove            the same velocity across the groove; at its ends also along it
    rotary limit, ratchet   w_a - w_b
    gear              w_a - ratio w_b
    motor             w_a - w_b = rate

After the engine's step the joints open at some rate, because of the solver's tolerance and of the
velocities that it adds to correct positions. With the mass matrix M and A = M^-1/2 J^T, the
smallest change of M^1/2 V after which the joints do not open is dU = -A (A^T A)^+ (J V - b). With b
= 0 (no motors) the energy falls by |dU|^2/2, as in a plastic impact of the joints. Limits take part
only if they would be passed, and only push.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
import pymunk
from numpy.typing import NDArray

from bristle_sim.arrays import Array

Vector = tuple[float, float]
"""A pair (normal, tangential) of a contact, or (x, y) in a report. All other places, directions and
velocities are complex numbers x + iy."""

Entry = tuple[pymunk.Body, float, float, float]
"""A body, and the factors of its v_x, v_y and angular velocity in one row of the Jacobian J."""

Connected = tuple[list[pymunk.Body], list[pymunk.Constraint]]
"""Dynamic bodies, and the joints that connect them."""

REACHED = 1e-9
"""Distance at which a joint's limit counts as reached, over the joint's length or in rad."""
CLOSED = 1e-14  # opening rate over the terms of its sum, below which it is rounding error
# Singular value, as a fraction of the largest one, below which a joint repeats other joints.
DEPENDENT = 1e-12


class JointRow(NamedTuple):
    """One row of a joint's velocity constraint: J V = rate, or J V >= rate for a limit.

    ``entries`` hold the factors of the bodies' velocities V. A limit can only push.
    """

    joint: pymunk.Constraint
    entries: tuple[Entry, ...]
    rate: float = 0.0
    limit: bool = False

    def excess(self) -> tuple[float, float]:
        """Return the rate J V - rate at which the joint opens, and the scale of its rounding error.

        The scale is the sum of the magnitudes of its terms.
        """
        value = -self.rate
        size = abs(self.rate)
        for body, x, y, turn in self.entries:
            velocity = body.velocity
            for term in (x * velocity.x, y * velocity.y, turn * body.angular_velocity):
                value += term
                size += abs(term)
        return value, size


def relative_rows(
    ends: Iterable[tuple[pymunk.Body, complex]], directions: Sequence[complex]
) -> list[tuple[Entry, ...]]:
    """Return the Jacobian rows of a relative velocity along directions.

    ``ends`` holds the first body with the world coordinates of its point, and the body with the
    point to which the velocity is relative.
    """
    entries = []
    for (body, point), sign in zip(ends, (1.0, -1.0), strict=False):
        arm = point - world(body, body.center_of_gravity)
        entries.append(
            [
                (body, sign * each.real, sign * each.imag, sign * (arm.conjugate() * each).imag)
                for each in directions
            ]
        )
    return list(zip(*entries, strict=True))


def world(body: pymunk.Body, place: tuple[float, float]) -> complex:
    """Return the world coordinates of a place on a body."""
    return complex(*body.local_to_world(place))


def joined(ends: Iterable[pymunk.Body]) -> Connected:
    """Return all dynamic bodies that joints connect to ``ends``, and these joints.

    The bodies include ``ends``. Only joints that transmit impulses count.
    """
    waiting = list(ends)
    bodies: dict[pymunk.Body, None] = {}
    joints: list[pymunk.Constraint] = []
    while waiting:
        body = waiting.pop()
        if body in bodies or body.body_type != pymunk.Body.DYNAMIC:
            continue
        bodies[body] = None
        # The property copies the set of joints; the check without a copy is faster.
        for joint in body.constraints if body._constraints else ():
            if joint not in joints and _transmits_impulse(joint):
                joints.append(joint)
                waiting += (joint.a, joint.b)
    return list(bodies), joints


def _transmits_impulse(joint: pymunk.Constraint) -> bool:
    if (
        isinstance(joint, pymunk.DampedSpring | pymunk.DampedRotarySpring)
        or joint.max_force < math.inf
    ):
        return False
    return any(
        space is not None and joint in space.constraints for space in (joint.a.space, joint.b.space)
    )


def scaled_columns(
    rows: Sequence[Sequence[Entry]], bodies: Sequence[pymunk.Body]
) -> tuple[Array, Array]:
    """Return Jacobian rows in coordinates that are scaled by the square root of the mass.

    Bodies of ``rows`` that are not among the dynamic ``bodies`` have zero inverse mass.

    Returns:
        M^-1/2 J^T, shape (3 * len(bodies), rows), with the mass matrix M and the Jacobian J; and
        the diagonal of M^-1/2.
    """
    places = {each: 3 * at for at, each in enumerate(bodies)}
    masses = [number for each in bodies for number in (each.mass, each.mass, each.moment)]
    scale = np.array(masses) ** -0.5
    columns = [[0.0] * len(scale) for _ in rows]
    for column, entries in zip(columns, rows, strict=True):
        for body, x, y, turn in entries:
            if (first := places.get(body)) is not None:
                column[first] += x
                column[first + 1] += y
                column[first + 2] += turn
    return (np.array(columns).reshape(-1, len(scale)) * scale).T, scale


def joint_rows(joint: pymunk.Constraint) -> list[JointRow]:
    """Return the rows of a joint's velocity constraint, J V = rate.

    A joint with a limit that is not reached has no row for it.

    Raises:
        ValueError: for a kind of joint that pymunk 7 does not have.
    """
    if isinstance(joint, pymunk.GrooveJoint):
        ends, guided = _groove(joint)
    elif isinstance(joint, pymunk.PivotJoint | pymunk.PinJoint | pymunk.SlideJoint):
        ends, guided = _anchored(joint)
    else:
        return _turning(joint)
    rows = relative_rows(zip((joint.a, joint.b), ends, strict=True), [each for each, _ in guided])
    return [JointRow(joint, row, 0.0, limit) for row, (_, limit) in zip(rows, guided, strict=True)]


Guided = tuple[tuple[complex, complex], list[tuple[complex, bool]]]
"""World coordinates of a joint's ends on its bodies, and the directions in which the end on body a
does not move relative to the end on body b, each with True if it is a limit."""


def _reached(value: float, least: float, most: float, margin: float) -> list[tuple[float, bool]]:
    """Return the senses in which a coordinate cannot grow, 1 or -1, each with True if it is a limit.

    A coordinate between its limits has none; one whose limits coincide is fixed.
    """
    if least >= most:
        return [(1.0, False)]
    if value >= most - margin:
        return [(1.0, True)]
    return [(-1.0, True)] if value <= least + margin else []


def _anchored(joint: Any) -> Guided:
    """Return the ends and directions of a pivot, pin or slide joint, which keeps two anchors
    together, at a distance, or at a distance within limits.
    """
    ends = world(joint.a, joint.anchor_a), world(joint.b, joint.anchor_b)
    if isinstance(joint, pymunk.PivotJoint):
        return ends, [(1.0, False), (1j, False)]
    distance = abs(ends[1] - ends[0])
    if distance == 0.0:
        return ends, []
    along = (ends[1] - ends[0]) / distance
    if isinstance(joint, pymunk.PinJoint):
        return ends, [(along, False)]
    senses = _reached(distance, joint.min, joint.max, REACHED * max(distance, joint.max))
    return ends, [(sense * along, limit) for sense, limit in senses]


def _groove(joint: pymunk.GrooveJoint) -> Guided:
    """Return the ends and directions of a groove joint, which keeps an anchor of body b on a
    segment of body a.
    """
    start = world(joint.a, joint.groove_a)
    anchor = world(joint.b, joint.anchor_b)
    groove = world(joint.a, joint.groove_b) - start
    length = abs(groove)
    along = groove / length
    place = (along.conjugate() * (anchor - start)).real
    senses = _reached(place, 0.0, length, REACHED * length)
    guided = [(1j * along, False), *[(sense * along, limit) for sense, limit in senses]]
    return (start + along * min(max(place, 0.0), length), anchor), guided


def _turning(joint: Any) -> list[JointRow]:
    """Return the row of a joint between the angles of two bodies; none for a limit not reached."""
    a = joint.a
    b = joint.b
    angle = b.angle - a.angle
    margin = REACHED * max(1.0, abs(a.angle), abs(b.angle))
    ratio = 1.0
    rate = 0.0
    senses = [(1.0, False)]
    match joint:
        case pymunk.GearJoint():
            ratio = joint.ratio
        case pymunk.SimpleMotor():
            rate = joint.rate
        case pymunk.RatchetJoint():
            way = math.copysign(1.0, joint.ratchet)
            reached = _reached((angle - joint.angle) * way, 0.0, math.inf, margin)
            senses = [(sense * way, limit) for sense, limit in reached]
        case pymunk.RotaryLimitJoint():
            senses = _reached(angle, joint.min, joint.max, margin)
        case _:
            raise ValueError(f"{type(joint).__name__}: must be a joint or spring of pymunk 7")
    return [
        JointRow(joint, ((a, 0.0, 0.0, sense), (b, 0.0, 0.0, -sense * ratio)), rate, limit)
        for sense, limit in senses
    ]


def of_length_one(columns: Array) -> tuple[Array, Array]:
    """Return the columns scaled to length 1, and their lengths.

    This makes joints of rotation and of translation, which have different units, comparable. A
    column of zeros is not changed; its length is returned as 1.
    """
    lengths = np.sqrt((columns**2).sum(axis=0))
    lengths[lengths == 0.0] = 1.0
    return columns / lengths, lengths


def span(columns: Array) -> Array:
    """Return an orthonormal basis of the span of columns, shape (rows, rank).

    The columns may be linearly dependent.
    """
    directions, sizes, _ = np.linalg.svd(of_length_one(columns)[0], full_matrices=False)
    return np.asarray(directions[:, sizes > DEPENDENT * sizes.max(initial=0.0)])


def joint_basis(
    bodies: Sequence[pymunk.Body], joints: Sequence[pymunk.Constraint]
) -> tuple[Array, Array]:
    """Return an orthonormal basis of the velocities that joints prevent, and its scale.

    Limits that are reached are treated as rigid.

    Returns:
        The basis, shape (3 * len(bodies), rank), in coordinates scaled by the square root of the
        mass; and the inverse square root of the mass for each coordinate.
    """
    rows = [row.entries for joint in joints for row in joint_rows(joint)]
    columns, scale = scaled_columns(rows, bodies)
    return span(columns), scale


def allowed_part(
    bodies: Sequence[pymunk.Body], joints: Sequence[pymunk.Constraint], changes: Array
) -> Array:
    """Return the part of velocity changes that the joints permit, shape (3 * len(bodies),).

    It is the orthogonal projection in the norm of the kinetic energy.
    """
    rigid, scale = joint_basis(bodies, joints)
    scaled = np.divide(changes, scale, out=np.zeros_like(changes), where=scale > 0.0)
    return np.asarray(scale * (scaled - rigid @ (rigid.T @ scaled)))


def close_joints(bodies: Sequence[pymunk.Body], joints: Sequence[pymunk.Constraint]) -> None:
    """Apply to bodies the velocity change of least kinetic energy after which no joint opens.

    Raises:
        RuntimeError: if no set of pushing limits is found.
    """
    rows = [row for joint in joints for row in joint_rows(joint)]
    if not rows:
        return
    rates, sizes = np.array([row.excess() for row in rows]).T
    limits: NDArray[np.bool_] = np.array([row.limit for row in rows])
    if not (np.where(limits, -rates, np.abs(rates)) > CLOSED * sizes).any():
        return
    columns, scale = scaled_columns([row.entries for row in rows], bodies)
    columns, lengths = of_length_one(columns)
    change = _least_change(columns, rates / lengths, CLOSED * sizes / lengths, limits)
    set_in_motion(bodies, scale * change)


def set_in_motion(bodies: Sequence[pymunk.Body], change: Array) -> None:
    """Add ``change``, shape (3 * len(bodies),), to v_x, v_y and the angular velocity of each body."""
    for body, (x, y, turn) in zip(bodies, change.reshape(-1, 3).tolist(), strict=True):
        body.velocity += (x, y)
        body.angular_velocity += turn


def _least_change(
    columns: Array, rates: Array, rounding: Array, limits: NDArray[np.bool_]
) -> Array:
    """Return the shortest vector dU with rates + A^T dU = 0, where A are the columns.

    At a limit rates + A^T dU must be >= 0, and the impulse of the limit must be >= 0. ``rounding``
    is the rounding error of the rates.
    """
    active = ~limits | (rates < -rounding)
    for _ in range(2 * len(rates) + 8):
        rigid = columns[:, active]
        change = np.asarray(
            np.linalg.lstsq(rigid.T, -rates[active], rcond=DEPENDENT)[0], dtype=float
        )
        impulses = np.zeros(len(rates))
        impulses[active] = np.linalg.lstsq(rigid, change, rcond=DEPENDENT)[0]
        after = rates + columns.T @ change
        pulls = limits & active & (impulses < -DEPENDENT * np.abs(impulses).max(initial=0.0))
        passed = limits & ~active & (after < -rounding - DEPENDENT * np.abs(rates).max())
        if pulls.any():
            active[np.argmin(np.where(pulls, impulses, np.inf))] = False
        elif passed.any():
            active[np.argmin(np.where(passed, after, np.inf))] = True
        else:
            return change
    raise RuntimeError(
        "limits of joints: no set of them pushes and keeps the others; remove joints that contradict each other"
    )
