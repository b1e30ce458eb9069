"""Velocity constraints of pymunk's joints: the Jacobian J and the rates b in J V = b, or J V >= b at a joint's limit.

V holds (v_x, v_y, angular velocity) of each body's mass centre. A joint passes an impulse at once only if its force has no
bound: springs, and joints with a finite ``max_force``, pass none in an impact that takes no time; neither does a joint
that is not in a space. Limits (of slide, groove, rotary limit and ratchet joints) push one way only, while they are reached.

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
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import pymunk

from bristle_sim.arrays import Array

Vector = tuple[float, float]
Entry = tuple[pymunk.Body, float, float, float]
"""A body and the factors of its v_x, v_y and angular velocity in one row of J."""

Connected = tuple[list[pymunk.Body], list[pymunk.Constraint]]
"""Dynamic bodies, the lightest first, and the joints that connect them."""

_SPRINGS = (pymunk.DampedSpring, pymunk.DampedRotarySpring)

REACHED = 1e-9
"""A limit is reached at this distance before it, relative to the joint's length, or in rad: positions are rounded."""


class JointRow(NamedTuple):
    """One row of J V = rate, or of J V >= rate for a limit, which can only push."""

    joint: pymunk.Constraint
    entries: tuple[Entry, ...]
    rate: float = 0.0
    limit: bool = False

    def excess(self) -> tuple[float, float]:
        """Return J V - rate of the bodies as they move now, and the sum of its terms' sizes, to which it is rounded."""
        value, size = -self.rate, abs(self.rate)
        for body, x, y, turn in self.entries:
            velocity = body.velocity
            for term in (x * velocity.x, y * velocity.y, turn * body.angular_velocity):
                value += term
                size += abs(term)
        return value, size


class MassCentres(dict[pymunk.Body, Vector]):
    """Places of bodies' centres of gravity, where their velocities are, each looked up once; positions may be elsewhere."""

    def __missing__(self, body: pymunk.Body) -> Vector:
        x, y = body.local_to_world(body.center_of_gravity)
        self[body] = x, y
        return x, y


def point_entry(body: pymunk.Body, centre: Vector, point: Vector, direction: Vector, sign: float) -> Entry:
    """Return the factors of the velocity of a world point of the body, whose mass centre is given, along a direction."""
    x, y = direction
    lever = (point[0] - centre[0]) * y - (point[1] - centre[1]) * x
    return body, sign * x, sign * y, sign * lever


def passes_impulse(joint: pymunk.Constraint) -> bool:
    """Whether a joint can pass an impulse in no time: it is in a space, is no spring, and its force has no bound."""
    if isinstance(joint, _SPRINGS) or joint.max_force < math.inf:
        return False
    return any(space is not None and joint in space.constraints for space in (joint.a.space, joint.b.space))


def joined(ends: Sequence[pymunk.Body]) -> Connected:
    """Return the dynamic bodies reached over joints that pass impulses, the lightest first, and those joints."""
    bodies: list[pymunk.Body] = []
    joints: list[pymunk.Constraint] = []
    waiting = [each for each in ends if each.body_type == pymunk.Body.DYNAMIC]
    while waiting:
        body = waiting.pop()
        if body in bodies:
            continue
        bodies.append(body)
        for joint in body.constraints:
            if joint in joints or not passes_impulse(joint):
                continue
            joints.append(joint)
            waiting += [each for each in (joint.a, joint.b) if each.body_type == pymunk.Body.DYNAMIC]
    return sorted(bodies, key=lambda each: each.mass), joints


def joint_rows(joint: pymunk.Constraint, centres: MassCentres) -> list[JointRow]:
    """Return the rows of a joint; none for limits that are not reached.

    Raises:
        ValueError: for a kind of joint that pymunk 7 does not have.
    """
    known = (_ROWS[kind] for kind in type(joint).__mro__ if kind in _ROWS)
    rows = next(known, None)
    if rows is not None:
        return list(rows(joint, centres))
    raise ValueError(f"{type(joint).__name__}: must be a joint or spring of pymunk 7")


def scaled_jacobian(rows: Sequence[Sequence[Entry]], bodies: Sequence[pymunk.Body]) -> tuple[Array, Array]:
    """Return the columns of M^-1/2 J^T, shape (3 bodies, rows), and the diagonal of M^-1/2.

    Bodies of ``rows`` that are not among the dynamic ``bodies`` have no inverse mass.
    """
    roots = [(1.0 / math.sqrt(each.mass), 1.0 / math.sqrt(each.moment)) for each in bodies]
    places = {each: index for index, each in enumerate(bodies)}
    columns = []
    for entries in rows:
        column = [0.0] * (3 * len(bodies))
        for body, x, y, turn in entries:
            if body in places:
                at, (linear, angular) = 3 * places[body], roots[places[body]]
                column[at] += linear * x
                column[at + 1] += linear * y
                column[at + 2] += angular * turn
        columns.append(column)
    scale = np.array([root for linear, angular in roots for root in (linear, linear, angular)])
    return np.array(columns).T, scale


def _across(
    joint: pymunk.Constraint, centres: MassCentres, ends: tuple[Vector, Vector], direction: Vector, limit: bool = False
) -> JointRow:
    """Return the row of the velocity of body a's end relative to body b's along a direction."""
    a, b = joint.a, joint.b
    entries = (
        point_entry(a, centres[a], ends[0], direction, 1.0),
        point_entry(b, centres[b], ends[1], direction, -1.0),
    )
    return JointRow(joint, entries, 0.0, limit)


def _turn(joint: pymunk.Constraint, on_a: float, on_b: float, rate: float = 0.0, limit: bool = False) -> JointRow:
    return JointRow(joint, ((joint.a, 0.0, 0.0, on_a), (joint.b, 0.0, 0.0, on_b)), rate, limit)


def _anchors(joint: pymunk.PivotJoint | pymunk.PinJoint | pymunk.SlideJoint) -> tuple[Vector, Vector]:
    first, second = joint.a.local_to_world(joint.anchor_a), joint.b.local_to_world(joint.anchor_b)
    return (first.x, first.y), (second.x, second.y)


def _pivot(joint: pymunk.PivotJoint, centres: MassCentres) -> Iterator[JointRow]:
    a, b = joint.a, joint.b
    (x, y), (u, v) = _anchors(joint)
    (centre_x, centre_y), (other_x, other_y) = centres[a], centres[b]
    yield JointRow(joint, ((a, 1.0, 0.0, centre_y - y), (b, -1.0, 0.0, v - other_y)))
    yield JointRow(joint, ((a, 0.0, 1.0, x - centre_x), (b, 0.0, -1.0, other_x - u)))


def _between(ends: tuple[Vector, Vector]) -> tuple[float, Vector]:
    """Return the distance of the second anchor from the first, and its direction; (0, 0) where they coincide."""
    span = pymunk.Vec2d(*ends[1]) - pymunk.Vec2d(*ends[0])
    along = span.normalized()
    return span.length, (along.x, along.y)


def _pin(joint: pymunk.PinJoint, centres: MassCentres) -> Iterator[JointRow]:
    ends = _anchors(joint)
    distance, along = _between(ends)
    if distance > 0.0:
        yield _across(joint, centres, ends, along)


def _slide(joint: pymunk.SlideJoint, centres: MassCentres) -> Iterator[JointRow]:
    """Yield rows that keep the anchors' distance between ``min`` and ``max``."""
    ends = _anchors(joint)
    distance, (x, y) = _between(ends)
    margin = REACHED * max(distance, joint.max)
    if distance == 0.0:
        return
    if joint.min >= joint.max:
        yield _across(joint, centres, ends, (x, y))
    elif distance >= joint.max - margin:
        yield _across(joint, centres, ends, (x, y), limit=True)
    elif distance <= joint.min + margin:
        yield _across(joint, centres, ends, (-x, -y), limit=True)


def _groove(joint: pymunk.GrooveJoint, centres: MassCentres) -> Iterator[JointRow]:
    """Yield rows that keep the anchor of b on a segment of a, which it may follow but not leave."""
    start, end = joint.a.local_to_world(joint.groove_a), joint.a.local_to_world(joint.groove_b)
    anchor = joint.b.local_to_world(joint.anchor_b)
    length, along = (end - start).length, (end - start).normalized()
    reached = (anchor - start).dot(along)
    on_groove = start + along * min(max(reached, 0.0), length)
    ends = (on_groove.x, on_groove.y), (anchor.x, anchor.y)
    yield _across(joint, centres, ends, (-along.y, along.x))
    if reached <= REACHED * length:
        yield _across(joint, centres, ends, (-along.x, -along.y), limit=True)
    elif reached >= length * (1.0 - REACHED):
        yield _across(joint, centres, ends, (along.x, along.y), limit=True)


def _rotary_limit(joint: pymunk.RotaryLimitJoint, _: MassCentres) -> Iterator[JointRow]:
    """Yield rows that keep the angle of b relative to a between ``min`` and ``max``."""
    angle = joint.b.angle - joint.a.angle
    margin = REACHED * max(1.0, abs(joint.a.angle), abs(joint.b.angle))
    if joint.min >= joint.max:
        yield _turn(joint, -1.0, 1.0)
    elif angle >= joint.max - margin:
        yield _turn(joint, 1.0, -1.0, limit=True)
    elif angle <= joint.min + margin:
        yield _turn(joint, -1.0, 1.0, limit=True)


def _ratchet(joint: pymunk.RatchetJoint, _: MassCentres) -> Iterator[JointRow]:
    """Yield rows that keep the angle of b relative to a from falling behind the tooth that it has passed, ``angle``."""
    way = math.copysign(1.0, joint.ratchet)
    past = (joint.b.angle - joint.a.angle - joint.angle) * way
    if past <= REACHED * max(1.0, abs(joint.a.angle), abs(joint.b.angle)):
        yield _turn(joint, -way, way, limit=True)


def _gear(joint: pymunk.GearJoint, _: MassCentres) -> Iterator[JointRow]:
    yield _turn(joint, -1.0, joint.ratio)


def _motor(joint: pymunk.SimpleMotor, _: MassCentres) -> Iterator[JointRow]:
    yield _turn(joint, -1.0, 1.0, rate=-joint.rate)


_ROWS: dict[type[pymunk.Constraint], Any] = {
    pymunk.PivotJoint: _pivot,
    pymunk.PinJoint: _pin,
    pymunk.SlideJoint: _slide,
    pymunk.GrooveJoint: _groove,
    pymunk.RotaryLimitJoint: _rotary_limit,
    pymunk.RatchetJoint: _ratchet,
    pymunk.GearJoint: _gear,
    pymunk.SimpleMotor: _motor,
}
