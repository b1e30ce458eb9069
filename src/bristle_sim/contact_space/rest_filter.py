"""The division of a step's contacts into impacts and contacts at rest.

The engine resolves the contacts at rest. An impact law resolves the impacts, which the engine
ignores. Contacts are read by direct calls of the engine, without pymunk's wrappers, for speed: a
space at rest has many contacts.
"""

from __future__ import annotations

from typing import Any

import pymunk
from pymunk._chipmunk_cffi import ffi, lib

from bristle_sim.contact_space.collision_rule import CollisionRule
from bristle_sim.contact_space.joints import joined
from bristle_sim.contact_space.touching import (
    APPROACH_ROUNDING,
    Collision,
    StepMotion,
    room_for_bodies,
    seen,
)

STEPS_OF_GRAVITY = 2.0
"""Largest approach speed of a contact at rest, as a multiple of the speed that gravity adds in one
step.

One step passes before the engine finds a new contact, and a bounce shorter than two steps cannot be
resolved."""

# Surface velocity along the normal, in units of the space, at which the engine computes that a
# contact separates, so that the contact has no impulse.
OUT_OF_REACH = 1e100


class RestFilter:
    """Divides the contacts of a step into contacts at rest and impacts.

    Attributes:
        space: the space.
        resting_speed: the user's bound on the approach speed of a contact at rest.
        resting: bound on the approach speed of a contact at rest in this step. The bound also takes
            account of gravity, and is negative until the step's first contact.
        at_rest: contacts at rest of this step, which the engine resolves.
        impacts: impacts of this step, which the engine ignores.
        motion: velocity changes in this step of the bodies in ``impacts``, and of bodies joined to
            them.
    """

    def __init__(self, space: pymunk.Space) -> None:
        self.space = space
        self.motion = StepMotion()
        self.resting_speed = 0.0
        self.resting = -1.0
        self.at_rest: list[Collision] = []
        self.impacts: list[Collision] = []
        # Memory for the bodies of an arbiter. It cannot be copied, so it exists only within a step.
        self._bodies: Any = None

    def begin(self, resting_speed: float) -> None:
        """Prepare for an engine step.

        In the step, contacts that approach no faster than ``resting_speed`` count as at rest.
        """
        self.resting_speed = resting_speed
        self.resting = -1.0
        self._bodies = room_for_bodies()

    def end(self) -> None:
        """Release the memory that is needed only during an engine step."""
        self._bodies = None

    def clear(self) -> None:
        """Discard the contacts of the step."""
        self.at_rest.clear()
        self.impacts.clear()
        self.motion.clear()

    def filter_impact(self, rule: CollisionRule, arbiter: pymunk.Arbiter) -> None:
        """Classify a contact as at rest or as an impact, and record it.

        The engine resolves a contact at rest with the friction of its rule and without restitution.
        The shapes of such a contact are not read, because a space may have many contacts at rest.
        The engine ignores an impact.

        Args:
            rule: coefficients of the two collision types.
            arbiter: the engine's object for the contact.
        """
        if self._bodies is None:
            return
        if self.resting < 0.0:
            gravity = STEPS_OF_GRAVITY * self.space.gravity.length * self.space.current_time_step
            self.resting = max(self.resting_speed, gravity)
        raw = arbiter._arbiter
        lib.cpArbiterSetRestitution(raw, 0.0)
        approach, speeds = _approach(raw, self._bodies)
        if approach <= self.resting or approach <= APPROACH_ROUNDING * speeds:
            lib.cpArbiterSetFriction(raw, rule.friction)
            self.at_rest.append(Collision(arbiter, rule))
        else:
            self._skip(rule, arbiter)

    def _skip(self, rule: CollisionRule, arbiter: pymunk.Arbiter) -> None:
        """Record an impact, and make the engine ignore it.

        The engine's data of the contact are changed to those of a separating contact without
        overlap. The engine thus applies no impulse, but keeps the contact and wakes its bodies. The
        arguments are those of ``filter_impact``.
        """
        for body in arbiter.bodies:
            self.motion.note(joined([body]))
        self.impacts.append(Collision(arbiter, rule, seen(arbiter)))
        arbiter.friction = 0.0
        # pymunk's own setter of the points sets all points to the position of the first point.
        contact = lib.cpArbiterGetContactPointSet(arbiter._arbiter)
        for index in range(contact.count):
            contact.points[index].pointB = contact.points[index].pointA
        lib.cpArbiterSetContactPointSet(arbiter._arbiter, ffi.addressof(contact))
        arbiter.surface_velocity = OUT_OF_REACH * arbiter.normal


def _approach(raw: Any, bodies: tuple[Any, Any]) -> tuple[float, float]:
    """Return the largest approach speed of a contact's points, and the scale of its rounding error.

    The scale is the sum of the magnitudes of the velocity components of both bodies at the fastest
    point. ``raw`` is the engine's pointer to the contact. ``bodies`` is memory into which the
    engine writes its pointers to the two bodies.
    """
    first, second = bodies
    lib.cpArbiterGetBodies(raw, first, second)
    normal = lib.cpArbiterGetNormal(raw)
    fastest = 0.0
    speeds = 0.0
    for index in range(lib.cpArbiterGetCount(raw)):
        point = lib.cpArbiterGetPointA(raw, index)
        one = lib.cpBodyGetVelocityAtWorldPoint(first[0], point)
        other = lib.cpBodyGetVelocityAtWorldPoint(second[0], point)
        u = one.x
        v = one.y
        p = other.x
        q = other.y
        approach = (u - p) * normal.x + (v - q) * normal.y
        if approach > fastest:
            fastest = approach
            speeds = abs(u) + abs(v) + abs(p) + abs(q)
    return fastest, speeds
