"""Velocity constraints of pymunk's joints: the Jacobian J and the rates b in J V = b, or J V >= b at a joint's limit.

V holds (v_x, v_y, angular velocity) of each body's mass centre. A joint transmits an impulse only if its force has no bound: in
an instantaneous impact springs and joints with a finite ``max_force`` transmit none, nor does a joint outside a space. Limits
(of slide, groove, rotary limit and ratchet joints) push one way only, while they are reached.

    pin, slide        velocity of anchor a relative to anchor b, along the line between them
    pivot             that velocity, both components
    groove            that velocity across the groove; along it at the groove's ends
    rotary limit, ratchet   w_b - w_a
    gear              ratio w_b - w_a
    motor             w_b - w_a = -rate

The signs are those of the Chipmunk sources (cpSlideJoint.c and its siblings).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np
import pymunk
from pymunk._chipmunk_cffi import lib

from bristle_sim.arrays import Array

Vector = tuple[float, float]
Entry = tuple[pymunk.Body, float, float, float]
"""A body and the factors of its v_x, v_y and angular velocity in one row of J."""

Connected = tuple[list[pymunk.Body], list[pymunk.Constraint]]
"""Dynamic bodies, the lightest first, and the joints that connect them."""

_SPRINGS = (pymunk.DampedSpring, pymunk.DampedRotarySpring)

REACHED = 1e-9
"""A limit counts as reached within this distance (relative to the joint's length, or in rad): positions are rounded."""


class JointRow(NamedTuple):
    """One row of J V = rate, or of J V >= rate for a limit, which can only push."""

    joint: pymunk.Constraint
    entries: tuple[Entry, ...]
    rate: float = 0.0
    limit: bool = False

    def excess(self) -> tuple[float, float]:
        """Return J V - rate at the bodies' velocities, and the sum of its terms' sizes, which scales its rounding."""
        value, size = -self.rate, abs(self.rate)
        for body, x, y, turn in self.entries:
            velocity = body.velocity
            for term in (x * velocity.x, y * velocity.y, turn * body.angular_velocity):
                value += term
                size += abs(term)
        return value, size


def world(body: pymunk.Body, point: Vector) -> Vector:
    """Return the world coordinates of a body's point."""
    place = lib.cpBodyLocalToWorld(body._body, point)
    return place.x, place.y


def mass_centre(body: pymunk.Body) -> Vector:
    """Return the world coordinates of a body's mass centre; ``position`` may be another point."""
    return world(body, lib.cpBodyGetCenterOfGravity(body._body))


def point_entry(body: pymunk.Body, point: Vector, direction: Vector, sign: float) -> Entry:
    """Return the row entry for the velocity of a body's world point along a direction."""
    (x, y), centre = direction, mass_centre(body)
    lever = (point[0] - centre[0]) * y - (point[1] - centre[1]) * x
    return body, sign * x, sign * y, sign * lever


def passes_impulse(joint: pymunk.Constraint) -> bool:
    """Whether a joint can transmit an impulse: it is in a space, is not a spring, and its force has no bound."""
    if isinstance(joint, _SPRINGS) or joint.max_force < math.inf:
        return False
    return any(space is not None and joint in space.constraints for space in (joint.a.space, joint.b.space))


def joined(ends: Sequence[pymunk.Body]) -> Connected:
    """Return the dynamic bodies connected by joints that transmit impulses, the lightest first, and those joints."""
    waiting = [each for each in ends if each.body_type == pymunk.Body.DYNAMIC]
    bodies: dict[pymunk.Body, None] = {}
    joints: list[pymunk.Constraint] = []
    while waiting:
        body = waiting.pop()
        if body in bodies:
            continue
        bodies[body] = None
        if body._constraints:
            for joint in body.constraints:
                if joint not in joints and passes_impulse(joint):
                    joints.append(joint)
                    waiting += [each for each in (joint.a, joint.b) if each.body_type == pymunk.Body.DYNAMIC]
    return (sorted(bodies, key=attrgetter("mass")) if len(bodies) > 1 else list(bodies)), joints


def scaled_columns(rows: Sequence[Sequence[Entry]], bodies: Sequence[pymunk.Body]) -> tuple[Array, Array]:
    """Return M^-1/2 J^T, shape (3 bodies, rows), and the diagonal of M^-1/2.

    Bodies of ``rows`` that are not among the dynamic ``bodies`` have no inverse mass.
    """
    places, scale = {}, []
    for at, each in enumerate(bodies):
        linear, angular = 1.0 / math.sqrt(each.mass), 1.0 / math.sqrt(each.moment)
        places[each] = 3 * at, linear, angular
        scale += [linear, linear, angular]
    columns = []
    for entries in rows:
        column = [0.0] * len(scale)
        for body, x, y, turn in entries:
            if body in places:
                first, linear, angular = places[body]
                column[first] += linear * x
                column[first + 1] += linear * y
                column[first + 2] += angular * turn
        columns.append(column)
    return np.array(columns).T, np.array(scale)


def joint_rows(joint: pymunk.Constraint) -> list[JointRow]:
    """Return the rows of a joint; none for limits that are not reached.

    Raises:
        ValueError: for a kind of joint that pymunk 7 does not have.
    """
    if isinstance(joint, pymunk.PivotJoint | pymunk.PinJoint | pymunk.SlideJoint):
        return _anchored(joint)
    return _groove(joint) if isinstance(joint, pymunk.GrooveJoint) else _turning(joint)


def _across(joint: pymunk.Constraint, ends: tuple[Vector, Vector], direction: Vector, limit: bool = False) -> JointRow:
    """Return the row of the velocity of body a's end relative to body b's along a direction."""
    a, b = point_entry(joint.a, ends[0], direction, 1.0), point_entry(joint.b, ends[1], direction, -1.0)
    return JointRow(joint, (a, b), 0.0, limit)


def _anchored(joint: pymunk.PivotJoint | pymunk.PinJoint | pymunk.SlideJoint) -> list[JointRow]:
    """Return the rows of joints between two anchors, which coincide, keep their distance, or keep it within limits."""
    ends = world(joint.a, joint.anchor_a), world(joint.b, joint.anchor_b)
    if isinstance(joint, pymunk.PivotJoint):
        return [_across(joint, ends, direction) for direction in ((1.0, 0.0), (0.0, 1.0))]
    distance, (x, y) = _between(*ends)
    if distance == 0.0:
        return []
    if isinstance(joint, pymunk.PinJoint) or joint.min >= joint.max:
        return [_across(joint, ends, (x, y))]
    margin = REACHED * max(distance, joint.max)
    if distance >= joint.max - margin:
        return [_across(joint, ends, (x, y), limit=True)]
    return [_across(joint, ends, (-x, -y), limit=True)] if distance <= joint.min + margin else []


def _between(start: Vector, end: Vector) -> tuple[float, Vector]:
    """Return the distance between two points and the direction from one to the other; (0, 0) where they coincide."""
    span = pymunk.Vec2d(end[0] - start[0], end[1] - start[1])
    return span.length, span.normalized()


def _groove(joint: pymunk.GrooveJoint) -> list[JointRow]:
    """Return rows that keep the anchor of b on a segment of a, which it may follow but not leave."""
    start, anchor = world(joint.a, joint.groove_a), world(joint.b, joint.anchor_b)
    length, (x, y) = _between(start, world(joint.a, joint.groove_b))
    reached = (anchor[0] - start[0]) * x + (anchor[1] - start[1]) * y
    within = min(max(reached, 0.0), length)
    ends = (start[0] + x * within, start[1] + y * within), anchor
    rows = [_across(joint, ends, (-y, x))]
    if reached <= REACHED * length:
        rows.append(_across(joint, ends, (-x, -y), limit=True))
    elif reached >= length * (1.0 - REACHED):
        rows.append(_across(joint, ends, (x, y), limit=True))
    return rows


def _turning(joint: Any) -> list[JointRow]:
    """Return the row of a joint between two angles."""
    a, b = joint.a, joint.b
    on_a, on_b, rate, limit = -1.0, 1.0, 0.0, False
    margin = REACHED * max(1.0, abs(a.angle), abs(b.angle))
    if isinstance(joint, pymunk.RotaryLimitJoint) and joint.min < joint.max:
        angle, limit = b.angle - a.angle, True
        if angle >= joint.max - margin:
            on_a, on_b = 1.0, -1.0
        elif angle > joint.min + margin:
            return []
    elif isinstance(joint, pymunk.RatchetJoint):
        way, limit = math.copysign(1.0, joint.ratchet), True
        on_a, on_b = -way, way
        if (b.angle - a.angle - joint.angle) * way > margin:
            return []
    elif isinstance(joint, pymunk.GearJoint):
        on_b = joint.ratio
    elif isinstance(joint, pymunk.SimpleMotor):
        rate = -joint.rate
    elif not isinstance(joint, pymunk.RotaryLimitJoint):
        raise ValueError(f"{type(joint).__name__}: must be a joint or spring of pymunk 7")
    return [JointRow(joint, ((a, 0.0, 0.0, on_a), (b, 0.0, 0.0, on_b)), rate, limit)]
