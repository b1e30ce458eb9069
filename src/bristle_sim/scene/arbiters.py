"""What the engine knows of its contacts, without pymunk's wrappers where it offers that bare.

Within a step: how fast a contact approaches, and its friction; after it: the impulse on a body.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

import pymunk

from bristle_sim.scene.engine import bare_object, ffi, lib
from bristle_sim.scene.mechanism import Vector

__all__ = ["Approach", "Impulse", "Tuner", "approach_reader", "contact_tuner", "impulse_reader"]

Approach = Callable[[pymunk.Arbiter], tuple[float, float]]
"""Speed at which the fastest point of a contact approaches, and the sum of the bodies' speeds there, to which it is rounded."""

Impulse = Callable[[], tuple[float, float]]
"""(Normal, tangential) impulse of the last step on a body."""

Tuner = Callable[[pymunk.Arbiter, float], None]
"""Gives a contact a friction, and no restitution, until the next step."""


def impulse_reader(space: pymunk.Space, body: pymunk.Body) -> Impulse:
    """Return what tells the impulse of the last step on a body, whatever it touches."""
    bare = bare_object(space, "_space")
    return partial(_impulse, body) if bare is None else _BareImpulse(bare, body.id)


def _impulse(body: pymunk.Body) -> tuple[float, float]:
    found: list[tuple[Vector, Vector]] = []
    body.each_arbiter(lambda arbiter: found.append((arbiter.total_impulse, arbiter.normal)))
    return _push_and_rub(found)


def _push_and_rub(contacts: Iterable[tuple[Vector, Vector]]) -> tuple[float, float]:
    """Return the (normal, tangential) parts of contacts' impulses, added up, from impulse and normal of each.

    Which way the engine's normal points, and the sign of its impulse, depend on the order of the shapes inside the engine; a
    contact only pushes, which settles both.
    """
    pushes = rubs = 0.0
    for (p, q), (x, y) in contacts:
        push = p * x + q * y
        pushes += abs(push)
        rubs += math.copysign(1.0, push) * (p * y + q * -x)
    return pushes, rubs


class _BareImpulse:
    """Has the engine write down all its contacts at one call, and adds up those of a body."""

    def __init__(self, space: Any, body: int) -> None:
        self._body = body
        self._numbers = ffi.gc(lib.pmFloatArrayNew(0), lib.pmFloatArrayFree)
        self._ids = ffi.gc(lib.pmIntArrayNew(0), lib.pmIntArrayFree)
        fields = lib.TOTAL_IMPULSE | lib.NORMAL | lib.BODY_A_ID | lib.BODY_B_ID
        self._data = ffi.new("pmBatchedData *", (self._ids, self._numbers, fields))
        write = ffi.addressof(lib, "pmSpaceArbiterIteratorFuncBatched")
        self._look = partial(lib.cpSpaceEachCachedArbiter, space, write, self._data)

    def __call__(self) -> tuple[float, float]:
        numbers, ids, body = self._numbers, self._ids, self._body
        numbers.num = ids.num = 0
        self._look()
        found, who = ffi.unpack(numbers.arr, numbers.num), ffi.unpack(ids.arr, ids.num)
        return _push_and_rub(
            (found[2 * at : 2 * at + 2], found[2 * at + 2 : 2 * at + 4])
            for at in range(0, len(who), 2)
            if body in who[at : at + 2]
        )


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
