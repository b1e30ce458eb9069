"""Velocity constraints of pymunk's joints.

V holds the velocity (v_x, v_y) of each body's mass centre and the body's angular velocity. A joint
constrains V by J V = b, with its Jacobian J and its prescribed rates b; at a limit the constraint
is J V >= b. In an instantaneous impact a joint transmits an impulse only if its force has no bound.
Springs and joints with a finite ``max_force`` transmit none, nor do joints that have not been added
to a space. A limit (of a slide, groove, rotary limit or ratchet joint) acts only while it is
reached, and pushes in one direction. The signs are those of the Chipmunk sources (cpSlideJoint.c
and its siblings). Each joint constrains one of the following velocities, where w_a and w_b are the
angular velocities of its bodies a and b:

    pin, slide        velocity of anchor a relative to anchor b, along the line between them
    pivot             velocity of anchor a relative to anchor b, both components
    groove            the component of this velocity across the groove; at an end of the groove
                      also the component along the groove
    rotary limit, ratchet   w_a - w_b
    gear              w_a - ratio w_b
    motor             w_a - w_b = rate
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
import pymunk

from bristle_sim.arrays import Array

Vector = tuple[float, float]
"""Two components of a vector: (normal, tangential) at a contact, or (x, y) in a report. All other
places, directions and velocities are complex numbers x + iy."""

Entry = tuple[pymunk.Body, float, float, float]
"""A body, and the factors of its v_x, v_y and angular velocity in one row of the Jacobian J."""

Connected = tuple[list[pymunk.Body], list[pymunk.Constraint]]
"""Dynamic bodies, and the joints that connect them."""

REACHED = 1e-9
"""Distance from a joint's limit, as a fraction of the joint's length or in rad, at which the limit
counts as reached."""


class JointRow(NamedTuple):
    """One row of a joint's velocity constraint: J V = rate, or J V >= rate for a limit.

    V holds v_x, v_y and the angular velocity of each body.

    Attributes:
        joint: the joint.
        entries: for each body, the body and the factors of its three velocities in the row J.
        rate: prescribed value of J V; 0 except for a motor.
        limit: whether the row belongs to a limit, which can only push.
    """

    joint: pymunk.Constraint
    entries: tuple[Entry, ...]
    rate: float = 0.0
    limit: bool = False

    def excess(self) -> tuple[float, float]:
        """Return the velocity error J V - rate, and the sum of the magnitudes of its terms.

        The rounding error of the first value is proportional to the second.
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
    """Return the Jacobian rows for the velocity of one point relative to another.

    Args:
        ends: for each of the two points, the body that carries the point, and the point's world
            coordinates. If only one point is given, the other is at rest.
        directions: unit vectors. For each of them a row gives the component, along the vector, of
            the velocity of the first point relative to the second.
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
    """Return the world coordinates of a point that is given in the coordinates of a body."""
    return complex(*body.local_to_world(place))


def joined(ends: Iterable[pymunk.Body]) -> Connected:
    """Return all dynamic bodies that joints connect to ``ends``, and these joints.

    A body may be connected through other dynamic bodies. The returned bodies include the dynamic
    bodies in ``ends``. Joints that transmit no impulse are ignored.
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
    """Return the Jacobian in coordinates that are scaled by the square root of the mass.

    Bodies of ``rows`` that are not among the dynamic ``bodies`` have zero inverse mass.

    Returns:
        The matrix M^-1/2 J^T, shape (3 * len(bodies), len(rows)), with the mass matrix M and the
        Jacobian J of ``rows``.
        The diagonal of M^-1/2.
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
    """Return the rows of a joint's velocity constraint J V = rate, with the bodies' velocities V.

    A limit that is not reached has no row.

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
"""World coordinates of a joint's two anchors, and the directions in which the anchor on body a
cannot move relative to the anchor on body b. True beside a direction states that only a limit
prevents this motion.
"""


def _reached(value: float, least: float, most: float, margin: float) -> list[tuple[float, bool]]:
    """Return the senses (+1 or -1) in which the limits of a coordinate prevent its motion.

    Args:
        value: the coordinate.
        least: lower limit of the coordinate.
        most: upper limit of the coordinate.
        margin: distance at which a limit counts as reached.

    Returns:
        Pairs of a sense, and True if a limit prevents the motion. The list is [(1.0, True)] at the
        upper limit, [(-1.0, True)] at the lower limit, and [] between them. For equal limits the
        coordinate is fixed, and the list is [(1.0, False)].
    """
    if least >= most:
        return [(1.0, False)]
    if value >= most - margin:
        return [(1.0, True)]
    return [(-1.0, True)] if value <= least + margin else []


def _anchored(joint: Any) -> Guided:
    """Return the anchors and the constrained directions of a pivot, pin or slide joint.

    A pivot joint keeps the two anchors together, a pin joint keeps their distance constant, and a
    slide joint keeps their distance within limits.
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
    """Return the anchors and the constrained directions of a groove joint.

    The joint keeps an anchor of body b on a segment of body a, the groove.
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
    """Return the Jacobian rows of a joint that constrains the angles of two bodies.

    A joint between its limits has no row.
    """
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
