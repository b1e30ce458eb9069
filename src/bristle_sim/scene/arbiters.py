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

Approach = Callable[[pymunk.Arbiter], tuple[float, float]]
"""Speed at which the fastest point of a contact approaches, and the sum of the bodies' speeds there, to which it is rounded."""

Impulse = Callable[[], tuple[float, float]]
"""(Normal, tangential) impulse of the last step on a body."""

Tuner = Callable[[pymunk.Arbiter, float], None]
"""Gives a contact a friction, and no restitution, until the next step."""


def impulse_reader(space: pymunk.Space, body: pymunk.Body) -> Impulse:
    """Return what tells the impulse of the last step on a body, whatever it touches; the space has all its shapes."""
    bare = bare_object(space, "_space")
    if bare is None:
        return partial(_impulse, body)
    alone = all(shape.body in (body, space.static_body) for shape in space.shapes)
    return _BareImpulse(bare, None if alone else body.id)


def _impulse(body: pymunk.Body) -> tuple[float, float]:
    parts: list[tuple[float, float]] = []
    body.each_arbiter(lambda arbiter: parts.append(_push_and_rub(*arbiter.total_impulse, *arbiter.normal)))
    return _added(parts)


def _added(parts: Iterable[tuple[float, float]]) -> tuple[float, float]:
    push = rub = 0.0
    for normal, tangential in parts:
        push += normal
        rub += tangential
    return push, rub


def _push_and_rub(p: float, q: float, x: float, y: float) -> tuple[float, float]:
    """Return the (normal, tangential) parts of a contact's impulse (p, q), whose normal is (x, y).

    Which way the engine's normal points, and the sign of its impulse, depend on the order of the shapes inside the engine; a
    contact only pushes, which settles both.
    """
    push = p * x + q * y
    return abs(push), 0.0 + math.copysign(1.0, push) * (p * y + q * -x)


class _BareImpulse:
    """Has the engine write down all its contacts at one call, and adds up those of a body, or all if no other can touch."""

    def __init__(self, space: Any, body: int | None) -> None:
        self._body = body
        self._numbers = ffi.gc(lib.pmFloatArrayNew(0), lib.pmFloatArrayFree)
        self._ids = ffi.gc(lib.pmIntArrayNew(0), lib.pmIntArrayFree)
        fields = lib.TOTAL_IMPULSE | lib.NORMAL
        if body is not None:
            fields |= lib.BODY_A_ID | lib.BODY_B_ID
        self._data = ffi.new("pmBatchedData *", (self._ids, self._numbers, fields))
        write = ffi.addressof(lib, "pmSpaceArbiterIteratorFuncBatched")
        self._look = partial(lib.cpSpaceEachCachedArbiter, space, write, self._data)

    def __call__(self) -> tuple[float, float]:
        numbers, ids, body = self._numbers, self._ids, self._body
        numbers.num = 0
        if body is not None:
            ids.num = 0
        self._look()
        found = ffi.unpack(numbers.arr, numbers.num)
        if len(found) == 4 and body is None:
            return _push_and_rub(*found)
        who = [body] * (len(found) // 2) if body is None else ffi.unpack(ids.arr, ids.num)
        own = [2 * at for at in range(0, len(who), 2) if body in who[at : at + 2]]
        return _added([_push_and_rub(*found[at : at + 4]) for at in own])


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
