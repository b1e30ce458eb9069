"""The engine's calls that a run makes thousands of times, without their wrappers where the engine offers them bare.

pymunk's wrappers serve what a scene never asks for, such as bodies added during a step, and take more time than the
engine: 0.77 us a step, of which 0.34 us are the engine's. The bare calls are not part of pymunk's documented interface;
where a version does not have them, the documented ones do the same.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import pymunk

try:
    from pymunk._chipmunk_cffi import lib
except ImportError:  # pragma: no cover - a pymunk built otherwise
    lib = None

from bristle_sim.scene.mechanism import Vector

__all__ = ["Placer", "Pusher", "Reader", "placer", "point_reader", "pusher", "stepper"]

Placer = Callable[[float, Vector, Vector, float], None]
"""Sets angle, centre, velocity and rate of a body."""

Reader = Callable[[], tuple[float, float, float, float]]
"""Place (x, y) and velocity (u, v) of a point fixed on a body."""

Pusher = Callable[[Vector, Vector], None]
"""Applies a force at a place until the next step is done."""

_CALLS = (
    "cpSpaceStep",
    "cpBodySetAngle",
    "cpBodySetPosition",
    "cpBodySetVelocity",
    "cpBodySetAngularVelocity",
    "cpBodyLocalToWorld",
    "cpBodyGetVelocityAtLocalPoint",
    "cpBodyApplyForceAtWorldPoint",
)


def _bare(owner: object, attribute: str) -> Any:
    """The engine's own object behind pymunk's, or None where it cannot be had."""
    return getattr(owner, attribute, None) if all(hasattr(lib, call) for call in _CALLS) else None


def stepper(space: pymunk.Space) -> Callable[[float], None]:
    """A step of a space whose bodies, joints and shapes are all in it by now."""
    space.step(0.0)
    bare = _bare(space, "_space")
    return space.step if bare is None else partial(lib.cpSpaceStep, bare)


def placer(body: pymunk.Body) -> Placer:
    """What puts a body somewhere, with its velocity."""
    bare = _bare(body, "_body")
    return partial(_place, body) if bare is None else partial(_place_bare, bare)


def _place(body: pymunk.Body, angle: float, centre: Vector, velocity: Vector, rate: float) -> None:
    body.angle, body.position = angle, centre
    body.velocity, body.angular_velocity = velocity, rate


def _place_bare(body: Any, angle: float, centre: Vector, velocity: Vector, rate: float) -> None:
    lib.cpBodySetAngle(body, angle)
    lib.cpBodySetPosition(body, centre)
    lib.cpBodySetVelocity(body, velocity)
    lib.cpBodySetAngularVelocity(body, rate)


def point_reader(body: pymunk.Body, point: Vector) -> Reader:
    """What tells where a body's point is and how it moves."""
    bare = _bare(body, "_body")
    return partial(_read, body, point) if bare is None else partial(_read_bare, bare, point)


def _read(body: pymunk.Body, point: Vector) -> tuple[float, float, float, float]:
    return (*body.local_to_world(point), *body.velocity_at_local_point(point))


def _read_bare(body: Any, point: Vector) -> tuple[float, float, float, float]:
    place, velocity = lib.cpBodyLocalToWorld(body, point), lib.cpBodyGetVelocityAtLocalPoint(body, point)
    return place.x, place.y, velocity.x, velocity.y


def pusher(body: pymunk.Body) -> Pusher:
    """What pushes on a body."""
    bare = _bare(body, "_body")
    return body.apply_force_at_world_point if bare is None else partial(lib.cpBodyApplyForceAtWorldPoint, bare)
