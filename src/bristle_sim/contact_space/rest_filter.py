"""Divide the contacts of a step into those at rest, which the engine keeps, and impacts, which a law resolves.

Contacts are read by direct engine calls, without wrappers: a space at rest has many.
"""

from __future__ import annotations

from typing import Any

import pymunk
from pymunk._chipmunk_cffi import ffi, lib

from bristle_sim.contact_space.contact_pair import ContactPair
from bristle_sim.contact_space.joints import joined
from bristle_sim.contact_space.touching import (
    APPROACH_ROUNDING,
    Met,
    Shapes,
    StepMotion,
    overlaps,
    room_for_bodies,
    shapes_of,
)

STEPS_OF_GRAVITY = 2.0
"""An approach no faster than gravity's gain in this number of steps counts as rest: one step passes before the engine finds a
new contact, and a bounce that lasts less than two cannot be resolved."""

OUT_OF_REACH = 1e100  # a surface velocity apart, at which the engine's contact has no impulse to give


class RestFilter:
    """Keep the engine from responding to contacts that approach faster than at rest.

    Attributes:
        space: the space.
        resting_speed: a contact that approaches more slowly is at rest.
        met: contacts of this step. skipped: shapes of the contacts to which the engine does not respond.
        jammed: contacts that jammed in the last step; they are left to the engine while they last.
        motion: motion in the step of the bodies of skipped contacts and of bodies joined to them.
    """

    def __init__(self, space: pymunk.Space) -> None:
        self.space, self.motion = space, StepMotion()
        self.resting_speed, self._resting, self._active = 0.0, -1.0, False
        self.met: list[Met] = []
        self.skipped: set[Shapes] = set()
        self.jammed: set[Shapes] = set()
        self._still_jammed: set[Shapes] = set()
        self._bodies: Any = None  # room for an arbiter's bodies within a step; a copy cannot take it along

    @property
    def resting(self) -> float:
        """The largest approach that counts as rest in this step."""
        if self._resting < 0.0:
            gravity = STEPS_OF_GRAVITY * self.space.gravity.length * self.space.current_time_step
            self._resting = max(self.resting_speed, gravity)
        return self._resting

    def begin(self, resting_speed: float) -> None:
        """Begin a step."""
        self.resting_speed, self._resting, self._active = resting_speed, -1.0, True
        self._bodies = room_for_bodies()

    def end(self) -> None:
        """End a step: contacts that jammed and were not met again are over."""
        self._active, self._bodies = False, None
        if self.jammed:
            self.jammed, self._still_jammed = self._still_jammed, set()

    def clear(self) -> None:
        """Forget the contacts of the step."""
        self.met.clear()
        self.skipped.clear()
        self.motion.clear()

    def divide(self, pair: ContactPair, arbiter: pymunk.Arbiter) -> None:
        """Leave a contact at rest to the engine (with the pair's friction, without restitution); make it ignore an impact."""
        if not self._active:
            return
        raw = arbiter._arbiter
        found = lib.cpArbiterGetContactPointSet(raw)
        approach, speeds = _approach(raw, found, self._bodies)
        lib.cpArbiterSetRestitution(raw, 0.0)
        rests = approach <= max(self.resting, APPROACH_ROUNDING * speeds)
        # Contacts at rest are many; their shapes are not even looked up.
        if not rests or self.jammed:
            shapes = shapes_of(raw)
            if (key := frozenset(shapes)) in self.jammed:
                self._still_jammed.add(key)
                rests = True
        if rests:
            lib.cpArbiterSetFriction(raw, pair.friction)
            self.met.append(Met(raw, pair))
            return
        # The engine keeps the contact and wakes its bodies, but takes it to fly apart, and to have no overlap to reduce.
        for each in shapes:
            if each.body is not None:
                self.motion.note(joined([each.body]))
        slide = lib.cpArbiterGetSurfaceVelocity(raw)
        self.skipped.add(key)
        self.met.append(Met(raw, pair, (shapes, overlaps(found), (slide.x, slide.y))))
        lib.cpArbiterSetFriction(raw, 0.0)
        for index in range(found.count):
            found.points[index].pointB = found.points[index].pointA
        lib.cpArbiterSetContactPointSet(raw, ffi.addressof(found))
        lib.cpArbiterSetSurfaceVelocity(raw, (OUT_OF_REACH * found.normal.x, OUT_OF_REACH * found.normal.y))


def _approach(raw: Any, found: Any, bodies: tuple[Any, Any]) -> tuple[float, float]:
    """Return the approach speed of the fastest point, and the bodies' speeds there, which scale its rounding.

    ``bodies``: where the engine writes the bodies.
    """
    first, second = bodies
    lib.cpArbiterGetBodies(raw, first, second)
    fastest = (0.0, 0.0)
    for index in range(found.count):
        point = found.points[index].pointA
        one = lib.cpBodyGetVelocityAtWorldPoint(first[0], point)
        other = lib.cpBodyGetVelocityAtWorldPoint(second[0], point)
        u, v, p, q = one.x, one.y, other.x, other.y
        approach = (u - p) * found.normal.x + (v - q) * found.normal.y
        if approach > fastest[0]:
            fastest = (approach, abs(u) + abs(v) + abs(p) + abs(q))
    return fastest
