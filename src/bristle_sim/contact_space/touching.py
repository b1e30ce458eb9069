"""The motion of bodies in the engine's last step, and their contact points at the instant of touch.

The engine integrates by the leapfrog method: a step moves the position by the old velocity, and
then changes the velocity. Let a step of length h change the velocity from V by g to V_end = V + g.
Then V applies at the middle of the step, and V_end half a step after the step's end. With the
position x at the end of the step, the position and the velocity at the time s before the end are

    x_s = x - s (V_end - g)    and    V_s = V_end - (s/h + 1/2) g.

After an impact at that instant has changed V_s, the same equations lead back to the end of the
step. If only gravity acts and the coefficient of restitution is 1, the kinetic plus potential
energy at the end of a step is then conserved exactly. Any other error is of second order in h.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from operator import sub
from typing import Any, NamedTuple

import numpy as np
import pymunk
from pymunk._chipmunk_cffi import ffi, lib

from bristle_sim.arrays import Array
from bristle_sim.contact_space.collision_rule import CollisionRule, LocatedImpact
from bristle_sim.contact_space.joints import Connected, world
from bristle_sim.contact_space.projection import allowed_part, set_in_motion
from bristle_sim.theory.impact import Impact

# Largest approach speed that counts as rounding error, divided by the bodies' speed at the point.
APPROACH_ROUNDING = 1e-9

HALVINGS = 4
"""Largest number of trials in the search for the instant of touch.

Each trial goes back half as far as the trial before, until the shapes overlap."""
_BODY = ffi.typeof("cpBody *[1]")


def room_for_bodies() -> tuple[Any, Any]:
    """Return memory into which the engine writes pointers to the two bodies of a contact.

    Threads must not share this memory.
    """
    return ffi.new(_BODY), ffi.new(_BODY)


Motion = Sequence[float]
"""Velocity v_x, v_y and angular velocity of a body, or the changes of these in a step by forces,
joints and contacts at rest."""

NONE = (0.0, 0.0, 0.0)


def velocity_of(body: pymunk.Body) -> Motion:
    """Return the velocity and the angular velocity of a body."""
    velocity = lib.cpBodyGetVelocity(body._body)
    return velocity.x, velocity.y, lib.cpBodyGetAngularVelocity(body._body)


class StepMotion:
    """The velocity changes, in one engine step, of all bodies that an impact may move.

    Attributes:
        duration: duration of the step.
        gains: change of velocity and angular velocity of each body in the step. The velocity of a
            body without an entry does not change.
    """

    def __init__(self) -> None:
        self.duration = 0.0
        self.gains: dict[pymunk.Body, Motion] = {}
        self._groups: list[Connected] = []

    def note(self, connected: Connected) -> None:
        """Record the velocities of connected bodies before the engine changes them in the step."""
        if connected[0] and connected[0][0] not in self.gains:
            self._groups.append(connected)
            self.gains.update({body: velocity_of(body) for body in connected[0]})

    def finish(self, duration: float) -> None:
        """Compute the velocity changes of a step that has just ended.

        The part of a change that violates the joints is left out, because the engine has added it
        to correct joint positions.
        """
        self.duration = duration
        for bodies, joints in self._groups:
            for body in bodies:
                self.gains[body] = tuple(map(sub, velocity_of(body), self.gains[body]))
            if joints:
                allowed = allowed_part(bodies, joints, self.changes(bodies)).reshape(-1, 3)
                self.gains.update(zip(bodies, allowed.tolist(), strict=True))

    def changes(self, bodies: Sequence[pymunk.Body]) -> Array:
        """Return the velocity changes of bodies in the step, shape (3 * len(bodies),).

        The changes of v_x, v_y and the angular velocity of the first body come first.
        """
        return np.array([self.gains.get(each, NONE) for each in bodies]).ravel()

    def clear(self) -> None:
        """Discard the data of the step."""
        self.gains.clear()
        self._groups.clear()

    def steps(self, time: float) -> float:
        """Return how many steps after a given instant the engine's velocities apply.

        The engine's velocities apply half a step after the end of the last step. ``time`` is the
        time from the given instant to the end of that step.
        """
        return time / self.duration + 0.5 if self.duration else 0.5

    def drift(self, bodies: Iterable[pymunk.Body], time: float) -> None:
        """Move bodies for a time, at the velocities at which the last engine step moved them.

        The bodies' velocities after that step are different. A negative time moves the bodies back.
        """
        for body in bodies if time else ():
            raw = body._body
            x, y, turn = map(sub, velocity_of(body), self.gains.get(body, NONE))
            # about the mass centre
            lib.cpBodySetAngle(raw, lib.cpBodyGetAngle(raw) + time * turn)
            place = lib.cpBodyGetPosition(raw)
            lib.cpBodySetPosition(raw, (place.x + time * x, place.y + time * y))

    def kick(self, bodies: Sequence[pymunk.Body], steps: float) -> None:
        """Add ``steps`` times the velocity changes of the step to the velocities of bodies."""
        set_in_motion(bodies, steps * self.changes(bodies))


class Overlap(NamedTuple):
    """The geometry of a contact point.

    Attributes:
        point: world coordinates of the contact.
        normal: unit vector towards the first body.
        depth: depth of the overlap.
    """

    point: complex
    normal: complex
    depth: float

    def ahead(self, later: Overlap, factor: float) -> Overlap:
        """Return the overlap at another instant, with point and normal extrapolated linearly.

        ``factor`` is 0 at the instant of this overlap and 1 at that of ``later``. The depth stays.
        """
        normal = self.normal + factor * (later.normal - self.normal)
        point = self.point + factor * (later.point - self.point)
        return Overlap(point, normal / abs(normal), self.depth)


def overlaps(contact: Any) -> list[Overlap]:
    """Return point, normal and depth of each overlap in a contact point set of the engine.

    The normals point towards the first shape.
    """
    normal = -complex(contact.normal.x, contact.normal.y)
    found = []
    for index in range(contact.count):
        each = contact.points[index]
        a = complex(each.pointA.x, each.pointA.y)
        b = complex(each.pointB.x, each.pointB.y)
        # The engine's own distance has the right sign for one of the two orders of the shapes only.
        depth = (normal.conjugate() * (b - a)).real
        found.append(Overlap(0.5 * (a + b), normal, depth))
    return found


Seen = tuple[tuple[pymunk.Shape, pymunk.Shape], list[Overlap], complex]
"""The two shapes of a contact, the geometry of its points, and the surface velocity of the second
shape relative to the first shape."""


def seen(arbiter: pymunk.Arbiter) -> Seen:
    """Return shapes, contact points and surface velocity of a contact that the engine has found."""
    points = lib.cpArbiterGetContactPointSet(arbiter._arbiter)
    return arbiter.shapes, overlaps(points), complex(*arbiter.surface_velocity)


@dataclass(slots=True, eq=False)
class Collision:
    """A contact that the engine found in a step.

    Attributes:
        arbiter: the engine's object for the contact. Outside callbacks the order of its two shapes
            may be reversed.
        pair: rule of the two collision types.
        before: geometry of an impact before ``RestFilter`` changed the engine's data; None for a
            contact at rest.
    """

    arbiter: pymunk.Arbiter
    pair: CollisionRule
    before: Seen | None = None

    def bodies(self) -> list[pymunk.Body]:
        """Return the dynamic bodies of the contact, in any order."""
        return [each for each in self.arbiter.bodies if each.body_type == pymunk.Body.DYNAMIC]

    def points(self) -> list[TouchingPoint]:
        """Return the points where the shapes touch.

        The list is empty for a sensor and for a contact that the user's callback ignores.
        """
        shapes, found, sliding = self.before or seen(self.arbiter)
        if not self.arbiter.process_collision or shapes[0].sensor or shapes[1].sensor:
            return []
        bodies: Any = [each.body for each in shapes]
        if bodies[0].body_type != pymunk.Body.DYNAMIC:
            shapes = shapes[::-1]
            bodies = bodies[::-1]
            sliding = -sliding
            found = [each._replace(normal=-each.normal) for each in found]
        rests = self.before is None
        known = (self.pair, shapes, tuple(bodies), sliding, rests)
        return [TouchingPoint(*known, each) for each in found]


@dataclass(slots=True, eq=False)
class TouchingPoint:
    """A point where two shapes touch, during one step.

    Attributes:
        pair: rule of the two collision types.
        shapes: the two shapes.
        bodies: the two bodies; the first is dynamic.
        surface_velocity: velocity of the second body's surface relative to the first body's
            surface, in addition to the motion of the bodies, as on a conveyor belt.
        rests: whether the contact was at rest before the step, so that the engine has resolved it
            and no impact occurs.
        overlap: place, normal and depth of the shapes' overlap. The depth is that at the end of the
            step. Place and normal are those at the instant of touch once that instant has been
            located.
        drift: mean speed at which the depth of the overlap grew in the step. Depth and drift give
            the instant of touch.
        time: time from the touch to the end of the step.
        approach: speed at which the two bodies approach each other along the normal at the instant
            of touch. An impact begins with this speed. The forces in the step make it differ from
            ``drift``.
        speed: largest speed that either body has had at the point in this step. The rounding error
            of ``approach`` is proportional to it.
        impacts: number of impacts at the point so far.
    """

    pair: CollisionRule
    shapes: tuple[pymunk.Shape, pymunk.Shape]
    bodies: tuple[pymunk.Body, pymunk.Body]
    surface_velocity: complex
    rests: bool
    overlap: Overlap
    drift: float = 0.0
    time: float = 0.0
    approach: float = 0.0
    speed: float = 0.0
    impacts: int = 0

    def measure(self, motion: StepMotion, since: float, latest: float) -> None:
        """Compute the approach speed and the time of the touch from the present velocities.

        Args:
            motion: velocity changes in the step.
            since: time from the last change of the velocities to the end of the step.
            latest: upper bound of the time from the touch to the end of the step.
        """
        point, normal, depth = self.overlap
        relative = self.surface_velocity
        gained = 0j
        for body, sign in zip(self.bodies, (-1.0, 1.0), strict=True):
            x, y, turn = velocity_of(body)
            gain_x, gain_y, turning = motion.gains.get(body, NONE)
            arm = 1j * (point - world(body, body.center_of_gravity))
            velocity = complex(x, y) + turn * arm
            relative += sign * velocity
            gained += sign * (complex(gain_x, gain_y) + turning * arm)
            self.speed = max(self.speed, abs(velocity.real) + abs(velocity.imag))
        growth = (normal.conjugate() * relative).real
        gain = (normal.conjugate() * gained).real
        drift = growth - gain
        if since:
            depth += since * (drift - self.drift)
            self.overlap = self.overlap._replace(depth=depth)
        self.drift = drift
        self.time = min(
            max(depth, 0.0) / drift if drift > 0.0 else math.inf if depth > 0.0 else 0.0, latest
        )
        self.approach = growth - motion.steps(self.time) * gain

    def go_back(self, motion: StepMotion, bodies: Sequence[pymunk.Body], latest: float) -> None:
        """Move bodies back to the instant of touch, and correct the touch's time, point and normal.

        The instant is estimated from two overlaps of the shapes: at an earlier position of the
        bodies, and at the end of the step.

        Args:
            motion: velocity changes in the step.
            bodies: the bodies to move.
            latest: upper bound of the time from the touch to the end of the step.
        """
        time = self.time
        after = self._look() if time else None
        for _ in range(HALVINGS if after else 0):
            motion.drift(bodies, -0.5 * time)
            half = self._look()
            if after and half and half.depth > 0.0:
                growth = after.depth - half.depth
                touch = 0.5 * time * after.depth / growth if growth > 0.0 else math.inf
                self.time = min(touch, latest)
                self.overlap = after.ahead(half, 2.0 * self.time / time)
                self.drift = 2.0 * growth / time
                motion.drift(bodies, 0.5 * time - self.time)
                return
            motion.drift(bodies, 0.5 * time)
            time *= 0.5
        self.time = 0.0

    def _look(self) -> Overlap | None:
        """Return the overlap of the two shapes in their present positions; None if they are apart.

        Of several overlaps, the overlap closest to the previous contact point is returned.
        """
        first, second = self.shapes
        first.cache_bb()
        second.cache_bb()
        found = overlaps(lib.cpShapesCollide(first._shape, second._shape))
        return min(found, key=lambda each: abs(each.point - self.overlap.point), default=None)

    def located(self, impact: Impact, end: float) -> LocatedImpact:
        """Return the ``LocatedImpact`` of an impact at this point, for a report.

        ``end`` is the time at the end of the step.
        """
        point, normal, _ = self.overlap
        entries: dict[str, Any] = {each.name: getattr(impact, each.name) for each in fields(Impact)}
        return LocatedImpact(
            **entries,
            time=end - self.time,
            point=(point.real, point.imag),
            normal=(normal.real, normal.imag),
            bodies=self.bodies,
        )
