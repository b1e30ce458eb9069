"""The engine's calls that a run makes thousands of times, without their wrappers.

pymunk's wrappers serve what a scene never needs, such as bodies added during a step, and take more time than the
engine: 0.77 us a step, of which 0.34 us are the engine's. The bare calls are not part of pymunk's documented interface;
all of pymunk 7 from 7.1 on has them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import pymunk
from pymunk._chipmunk_cffi import ffi, lib

from bristle_sim.scene.mechanism import Vector

__all__ = [
    "Approach",
    "EngineSteps",
    "Placer",
    "Pusher",
    "Reader",
    "approach_reader",
    "placer",
    "point_reader",
    "pusher",
    "stepper",
    "take_back",
    "tune_contact",
]

ITERATIONS_OF_A_STEP = 100
"""Solver iterations that take as long as the rest of an engine step: measured, 35 ns each and 3 to 5 us a step with what
Python does around it."""

WARM, ALONE = 1e3, 2.0
"""Steps up to this many times as long as the one before start from its impulses; the rounding of impulses that are scaled
further would show. A step on its own bears less: the engine scales the impulse that it applies, by s, but not the one that
it remembers, which becomes 1 - s times what it was. Further steps of the same length put that right; one short and one long
step in turn would make it grow without bound."""

Placer = Callable[[float, Vector, Vector, float], None]
"""Sets angle, centre, velocity and rate of a body."""

Reader = Callable[[], tuple[float, float, float, float]]
"""Place (x, y) and velocity (u, v) of a point fixed on a body."""

Pusher = Callable[[Vector, Vector], None]
"""Applies a force at a place until the next step is done."""

Approach = Callable[[pymunk.Arbiter], tuple[float, float]]
"""Speed at which the fastest point of a contact approaches, and the sum of the bodies' speeds there, to which it is rounded."""


def stepper(space: pymunk.Space) -> Callable[[float], None]:
    """Return a step of a space whose bodies, joints and shapes are all in it by now."""
    space.step(0.0)
    return partial(lib.cpSpaceStep, space._space)


class EngineSteps:
    """Takes the steps of a space, and counts them.

    Attributes:
        space: the space, with all its bodies, joints and shapes.
        bodies: those that move, the hub first.
        joints: pivots between them.
        steps: engine steps taken so far.
        work: the same, each counted once more for every ``ITERATIONS_OF_A_STEP`` iterations of the solver in it.
    """

    def __init__(self, space: pymunk.Space, bodies: Sequence[pymunk.Body], joints: Sequence[pymunk.Constraint]) -> None:
        """Nothing is to be remembered yet."""
        self.space, self.bodies, self.joints = space, bodies, joints
        self.steps = self.work = 0
        self._last_length = math.inf
        self._step = stepper(space)

    def take(self, length: float, count: int, act: Callable[[float], None] | None = None) -> None:
        """Take ``count`` engine steps of one length; ``act`` is called before each of them with the length."""
        if length > (WARM if count > 1 else ALONE) * self._last_length:
            self._start_cold(length)
        self._last_length = length
        advance = self._step
        for _ in range(count):
            if act is not None:
                act(length)
            advance(length)
        self.steps += count
        self.work += count * (1 + self.space.iterations // ITERATIONS_OF_A_STEP)

    def _start_cold(self, length: float) -> None:
        """Have the engine forget the impulses of its last step, which it would scale to the length of the next one."""
        for joint in self.joints:
            joint.max_force = 0.0
        # The first step still applies them, to bodies that are put back; the second leaves those of contacts right.
        for _ in range(2):
            take_back(self.bodies, lambda: self._step(length))
        for joint in self.joints:
            joint.max_force = math.inf


def take_back(bodies: Sequence[pymunk.Body], step: Callable[[], None]) -> None:
    """Take a step and put the bodies back where they were, with their velocities: the engine keeps its impulses."""
    kept = [(body.position, body.angle, body.velocity, body.angular_velocity) for body in bodies]
    step()
    for body, (position, angle, velocity, rate) in zip(bodies, kept, strict=True):
        body.position, body.angle, body.velocity, body.angular_velocity = position, angle, velocity, rate


def placer(body: pymunk.Body) -> Placer:
    """Return what puts a body somewhere, with its velocity."""
    bare = body._body

    def place(angle: float, centre: Vector, velocity: Vector, rate: float) -> None:
        lib.cpBodySetAngle(bare, angle)
        lib.cpBodySetPosition(bare, centre)
        lib.cpBodySetVelocity(bare, velocity)
        lib.cpBodySetAngularVelocity(bare, rate)

    return place


def point_reader(body: pymunk.Body, point: Vector) -> Reader:
    """Return what reads where a body's point is and how it moves."""
    bare = body._body

    def read() -> tuple[float, float, float, float]:
        place, velocity = lib.cpBodyLocalToWorld(bare, point), lib.cpBodyGetVelocityAtLocalPoint(bare, point)
        return place.x, place.y, velocity.x, velocity.y

    return read


def pusher(body: pymunk.Body) -> Pusher:
    """Return what pushes on a body."""
    return partial(lib.cpBodyApplyForceAtWorldPoint, body._body)


def approach_reader(space: pymunk.Space) -> Approach:
    """Return what measures within a step how fast a contact of the space approaches."""
    still = lib.cpSpaceGetStaticBody(space._space)
    return partial(_approach, still, ffi.new("cpBody *[1]"), ffi.new("cpBody *[1]"))


def _approach(still: Any, first: Any, second: Any, arbiter: pymunk.Arbiter) -> tuple[float, float]:
    lib.cpArbiterGetBodies(arbiter._arbiter, first, second)
    found = lib.cpArbiterGetContactPointSet(arbiter._arbiter)
    a, b, normal = first[0], second[0], found.normal
    x, y = normal.x, normal.y
    fastest = (0.0, 0.0)
    for index in range(found.count):
        point = found.points[index].pointA
        u = v = p = q = 0.0
        if a != still:
            moving = lib.cpBodyGetVelocityAtWorldPoint(a, point)
            u, v = moving.x, moving.y
        if b != still:
            moving = lib.cpBodyGetVelocityAtWorldPoint(b, point)
            p, q = moving.x, moving.y
        approach = (u - p) * x + (v - q) * y
        if approach > fastest[0]:
            fastest = (approach, abs(u) + abs(v) + abs(p) + abs(q))
    return fastest


def tune_contact(arbiter: pymunk.Arbiter, friction: float) -> None:
    """Give a contact a friction, and no restitution, until the next step."""
    lib.cpArbiterSetFriction(arbiter._arbiter, friction)
    lib.cpArbiterSetRestitution(arbiter._arbiter, 0.0)
