"""What the engine knows of its contacts, without pymunk's wrappers where it offers that bare.

Within a step: how fast a contact approaches, and its friction; after it: the impulse on a body.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Protocol

import pymunk

from bristle_sim.scene.engine import bare_object, ffi, lib

Approach = Callable[[pymunk.Arbiter], tuple[float, float]]
"""Speed at which the fastest point of a contact approaches, and the sum of the bodies' speeds there, to which it is rounded."""

Tuner = Callable[[pymunk.Arbiter, float], None]
"""Gives a contact a friction, and no restitution, until the next step."""


class ImpulseRecord(Protocol):
    """Notes the impulses of contacts, step after step."""

    def begin(self) -> int:
        """Forget what was noted, note the last step's, and return how many numbers that are."""

    def note(self) -> None:
        """Note the last step's."""

    def read(self) -> Sequence[float]:
        """Return what was noted: impulse (x, y) and normal (x, y) of one contact after the other."""


def impulse_record(space: pymunk.Space, body: pymunk.Body) -> ImpulseRecord:
    """Return a record of a body's contacts, which are all that the space has while it is used."""
    bare = bare_object(space, "_space")
    return _Record(body) if bare is None else _BareRecord(bare)


class _Record:
    """Notes a body's contacts by pymunk's documented calls."""

    def __init__(self, body: pymunk.Body) -> None:
        self._body = body
        self._numbers: list[float] = []

    def begin(self) -> int:
        """Forget what was noted, note the last step's contacts, and return how many numbers that are."""
        self._numbers.clear()
        self.note()
        return len(self._numbers)

    def note(self) -> None:
        """Note the last step's contacts."""
        self._body.each_arbiter(lambda each: self._numbers.extend((*each.total_impulse, *each.normal)))

    def read(self) -> Sequence[float]:
        """Return what was noted."""
        return self._numbers


class _BareRecord:
    """Has the engine write down all its contacts, one step after the other, to be read at once."""

    def __init__(self, space: Any) -> None:
        self._numbers = ffi.gc(lib.pmFloatArrayNew(0), lib.pmFloatArrayFree)
        self._data = ffi.new("pmBatchedData *", (ffi.NULL, self._numbers, lib.TOTAL_IMPULSE | lib.NORMAL))
        write = ffi.addressof(lib, "pmSpaceArbiterIteratorFuncBatched")
        self.note = partial(lib.cpSpaceEachCachedArbiter, space, write, self._data)

    def begin(self) -> int:
        """Forget what was noted, note the last step's contacts, and return how many numbers that are."""
        self._numbers.num = 0
        self.note()
        count: int = self._numbers.num
        return count

    def read(self) -> Sequence[float]:
        """Return what was noted."""
        numbers: list[float] = ffi.unpack(self._numbers.arr, self._numbers.num)
        return numbers


def pushes(numbers: Sequence[float]) -> list[float]:
    """Return the normal part of each impulse of a record.

    Which way the engine's normal points, and the sign of its impulse, depend on the order of the shapes inside the engine; a
    contact only pushes, which settles both.
    """
    each = [iter(numbers)] * 4
    return [abs(p * x + q * y) for p, q, x, y in zip(*each, strict=True)]


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
