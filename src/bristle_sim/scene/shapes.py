"""The engine's own contact of a link with a fixed pair: its shapes, ignored until engaged, and its impulses."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import pymunk
from pymunk._chipmunk_cffi import ffi, lib

from bristle_sim.scene.engine import bare_space
from bristle_sim.scene.mechanism import Mechanism, Vector
from bristle_sim.scene.pairs import ContactPair, WirePair

FAST_SLIP = 10.0
"""Surface velocity (scene units) that fixes the sense of slip in the engine. It exceeds the change of slip within an interval,
but not by much, because its rounding disturbs the normal velocity."""

_NOWHERE = pymunk.ShapeFilter(categories=0, mask=0)


class ContactShapes:
    """Shapes of pairs in a space, one of which may be engaged.

    Attributes:
        space, mechanism, links: of the scene.
        in_flight: iterations of the engine's solver where nothing is engaged.
    """

    def __init__(
        self,
        space: pymunk.Space,
        mechanism: Mechanism,
        links: Sequence[pymunk.Body],
        set_iterations: Callable[[int], None],
    ) -> None:
        self.space, self.mechanism, self.links = space, mechanism, links
        self.in_flight, self._set_iterations = space.iterations, set_iterations
        self._shapes: dict[tuple[str, int, int | None], list[pymunk.Shape]] = {}
        self._engaged: tuple[pymunk.Shape, ...] = ()

    def engage(self, pair: ContactPair, *, friction: float, elasticity: float, iterations: int, piece: int = 0) -> None:
        """From now on, let the engine act only on the contact of this straight piece of a link with the pair."""
        # Its surface may have changed, as in a dent.
        key = pair.name, pair.link, pair.corner
        if key not in self._shapes:
            self._shapes[key] = self._add(pair)
        shapes = self._shapes[key]
        # A pair's shape, larger than the pair, would touch a neighbouring piece before its time.
        touching = shapes[0], shapes[1 + piece]
        if self._engaged != touching:
            self._ignore()
            self._engaged = touching
            for shape in touching:
                shape.filter = pymunk.ShapeFilter()
        touching[0].friction, touching[0].elasticity = friction, elasticity
        self._set_iterations(iterations)

    def direct_friction(self, slip: int, tangent: Vector) -> None:
        """Let friction of the engaged pair oppose slip in the given sense.

        If slip could stop within a step, the motion would have a kink there. So the engine is shown slip of one sense until the
        run changes it.
        """
        self._engaged[0].surface_velocity = (-FAST_SLIP * slip * tangent[0], -FAST_SLIP * slip * tangent[1])

    def release(self) -> None:
        """Make the engine ignore all pairs again."""
        self._ignore()
        self._set_iterations(self.in_flight)

    def record(self, pair: ContactPair, *, slips: bool) -> ImpulseRecord:
        """Return a record of the engaged contact's impulses, and of its slip if it ``slips`` with friction."""
        return ImpulseRecord(self.space, self.links[pair.link], slips=slips)

    def _ignore(self) -> None:
        for shape in self._engaged:
            shape.filter, shape.surface_velocity = _NOWHERE, (0.0, 0.0)
        self._engaged = ()

    def _add(self, pair: ContactPair) -> list[pymunk.Shape]:
        """Add the shapes of a pair, which the engine ignores until they are engaged."""
        assert not isinstance(pair, WirePair), "the engine's own contacts are those of a lone link"
        link = self.mechanism.links[pair.link]
        corners = [(x - link.centre[0], y - link.centre[1]) for x, y in ((0.0, 0.0), *link.knees, link.tip)]
        shapes = pair.shapes(self.space, self.links[pair.link], corners)
        for shape in shapes:
            shape.filter, shape.friction, shape.elasticity = _NOWHERE, 1.0, 1.0
        self.space.add(*shapes)
        return shapes


class ImpulseRecord:
    """Make the engine record a contact's impulses step by step, and the link's motion where it slips with friction.

    All are read at once, as a Python callback at each step would take longer than the step.

    Attributes:
        note: records those of the last step.
    """

    def __init__(self, space: pymunk.Space, link: pymunk.Body, *, slips: bool) -> None:
        self._space, self._slips, self._stale = space, slips, 0
        self._impulses, impulses = _numbers(lib.TOTAL_IMPULSE | lib.NORMAL | lib.POINT_A_1 | lib.POINT_B_1)
        self._motion, motion = _numbers(lib.POSITION | lib.VELOCITY | lib.ANGULAR_VELOCITY)
        write = ffi.addressof(lib, "pmSpaceArbiterIteratorFuncBatched")
        note = partial(lib.cpSpaceEachCachedArbiter, bare_space(space), write, impulses)
        follow = partial(lib.pmSpaceBodyGetIteratorFuncBatched, link._body, motion)

        def note_both() -> None:
            note()
            follow()

        self.note: Callable[[], None] = note_both if slips else note

    def begin(self) -> None:
        """Reset the record. The step before the interval is noted twice: here and before the first step."""
        self._impulses.num = self._motion.num = 0
        self.note()
        self._stale = 2 * self._impulses.num

    def read(self, normal: Vector) -> list[tuple[float, float, float]]:
        """Return normal and tangential impulse on the link in each step, and its slip, for a normal out of the pair.

        The signs of the engine's normal and impulse depend on the order of the shapes inside the engine; a contact only pushes,
        which settles the latter.
        """
        self.note()
        found, numbers = [], ffi.unpack(self._impulses.arr, self._impulses.num)
        motion = ffi.unpack(self._motion.arr, self._motion.num)[10:] if self._slips else []
        records = (numbers[at : at + 8] for at in range(self._stale, len(numbers), 8))
        # The engine remembers a pair of shapes that does not touch without its points.
        for step, (p, q, x, y, *points) in enumerate(each for each in records if any(each[4:])):
            sense = 1.0 if x * normal[0] + y * normal[1] > 0.0 else -1.0
            push, rub, slip = p * x + q * y, sense * (p * y - q * x), 0.0
            if self._slips:
                # The first shape is the pair's if the engine's normal leads out of it.
                place = points[2:] if sense > 0.0 else points[:2]
                centre_x, centre_y, u, v, rate = motion[5 * step : 5 * step + 5]
                u, v = u - rate * (place[1] - centre_y), v + rate * (place[0] - centre_x)
                slip = sense * (u * y - v * x)
            found.append((abs(push), math.copysign(1.0, sense * push) * rub, slip))
        return found


def _numbers(fields: int) -> tuple[Any, Any]:
    """Return a list of numbers that the engine can write to, and the data by which it writes these fields."""
    numbers = ffi.gc(lib.pmFloatArrayNew(0), lib.pmFloatArrayFree)
    return numbers, ffi.new("pmBatchedData *", (ffi.NULL, numbers, fields))
