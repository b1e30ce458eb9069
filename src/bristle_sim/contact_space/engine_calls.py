"""The engine's calls without their wrappers, where the engine offers them bare: how fast a contact approaches, and its friction.

The bare calls are not part of pymunk's documented interface; where a version does not have them, the documented ones do
the same.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from functools import partial
from typing import Any

import pymunk

try:
    from pymunk._chipmunk_cffi import ffi as ffi  # noqa: PLC0414 - for the contacts' reader too
    from pymunk._chipmunk_cffi import lib as lib  # noqa: PLC0414
except ImportError:  # pragma: no cover - a pymunk built otherwise
    ffi = lib = None

Approach = Callable[[pymunk.Arbiter], tuple[float, float]]
"""Speed at which the fastest point of a contact approaches, and the sum of the bodies' speeds there, to which it is rounded."""

Tuner = Callable[[pymunk.Arbiter, float], None]
"""Gives a contact a friction, and no restitution, until the next step."""

_CALLS = (
    "cpSpaceStep",
    "cpBodyGetAngle",
    "cpBodyGetAngularVelocity",
    "pmSpaceBodyGetIteratorFuncBatched",
    "pmSpaceBodySetIteratorFuncBatched",
    "cpBodyLocalToWorld",
    "cpBodyGetVelocityAtLocalPoint",
    "cpBodyApplyForceAtWorldPoint",
    "cpSpaceGetStaticBody",
    "cpArbiterGetBodies",
    "cpArbiterGetContactPointSet",
    "cpSpaceEachCachedArbiter",
    "pmSpaceArbiterIteratorFuncBatched",
    "cpArbiterSetFriction",
    "cpArbiterSetRestitution",
    "cpBodyGetVelocityAtWorldPoint",
)


def bare_object(owner: object, attribute: str) -> Any:
    """Return the engine's own object behind pymunk's, or None where it cannot be had."""
    return getattr(owner, attribute, None) if _offers_calls(lib) else None


@functools.cache
def _offers_calls(library: Any) -> bool:
    return all(hasattr(library, call) for call in _CALLS)


def approach_reader(space: pymunk.Space) -> Approach:
    """Return what tells within a step how fast a contact of the space approaches."""
    bare = bare_object(space, "_space")
    if bare is None or ffi is None:
        return partial(_approach, space.static_body)
    return partial(_approach_bare, lib.cpSpaceGetStaticBody(bare), ffi.new("cpBody *[1]"), ffi.new("cpBody *[1]"))


def _approach(still: pymunk.Body, arbiter: pymunk.Arbiter) -> tuple[float, float]:
    first, second = arbiter.bodies
    found = arbiter.contact_point_set
    fastest = (0.0, 0.0)
    for each in found.points:
        u, v = (0.0, 0.0) if first is still else first.velocity_at_world_point(each.point_a)
        p, q = (0.0, 0.0) if second is still else second.velocity_at_world_point(each.point_a)
        approach = (u - p) * found.normal.x + (v - q) * found.normal.y
        fastest = max(fastest, (approach, abs(u) + abs(v) + abs(p) + abs(q)))
    return fastest


def _approach_bare(still: Any, first: Any, second: Any, arbiter: pymunk.Arbiter) -> tuple[float, float]:
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


def contact_tuner(space: pymunk.Space) -> Tuner:
    """Return what gives a contact of the space its friction."""
    return _tune if bare_object(space, "_space") is None else _tune_bare


def _tune(arbiter: pymunk.Arbiter, friction: float) -> None:
    arbiter.friction, arbiter.restitution = friction, 0.0


def _tune_bare(arbiter: pymunk.Arbiter, friction: float) -> None:
    lib.cpArbiterSetFriction(arbiter._arbiter, friction)
    lib.cpArbiterSetRestitution(arbiter._arbiter, 0.0)
