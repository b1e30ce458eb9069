"""The engine's own contact of a link with a fixed obstacle: its shapes, ignored until engaged, and its impulses."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial

import pymunk
from pymunk._chipmunk_cffi import ffi, lib

from bristle_sim.scene.contact.obstacles import Obstacle, WirePair
from bristle_sim.scene.mechanism import Mechanism, Vector

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

    def engage(
        self, obstacle: Obstacle, *, friction: float, elasticity: float, iterations: int, piece: int = 0
    ) -> None:
        """From now on, let the engine act only on the contact of this straight piece of a link with the obstacle."""
        # Its surface may be another one by now, as that of a dent is.
        key = obstacle.name, obstacle.link, obstacle.corner
        if key not in self._shapes:
            self._shapes[key] = self._add(obstacle)
        shapes = self._shapes[key]
        # An obstacle's shape, larger than the obstacle, would touch a neighbouring piece before its time.
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
        """Make the engine ignore all obstacles again."""
        self._ignore()
        self._set_iterations(self.in_flight)

    def totals(self, obstacle: Obstacle) -> tuple[float, float, float]:
        """Return (normal, tangential) impulse of the last step on a pair's link, and its slip if there is friction."""
        body, found = self.links[obstacle.link], (0.0, 0.0, 0.0)

        def look(arbiter: pymunk.Arbiter) -> None:
            """Record the impulse of one of the body's contacts; its normal part can only push."""
            nonlocal found
            normal, impulse = arbiter.normal, arbiter.total_impulse
            tangent = (normal.y, -normal.x)
            push, slip = impulse.dot(normal), 0.0
            first = arbiter.shapes[0].body is body
            for each in arbiter.contact_point_set.points if obstacle.friction else ():
                velocity = body.velocity_at_world_point(each.point_a if first else each.point_b)
                slip = (-1.0 if first else 1.0) * velocity.dot(tangent)
            found = (abs(push), math.copysign(1.0, push) * impulse.dot(tangent), slip)

        body.each_arbiter(look)
        return found

    def _ignore(self) -> None:
        for shape in self._engaged:
            shape.filter, shape.surface_velocity = _NOWHERE, (0.0, 0.0)
        self._engaged = ()

    def _add(self, obstacle: Obstacle) -> list[pymunk.Shape]:
        """Add the shapes of a pair, which the engine ignores until they are engaged."""
        assert not isinstance(obstacle, WirePair), "the engine's own contacts are those of a lone link"
        link = self.mechanism.links[obstacle.link]
        corners = [(x - link.centre[0], y - link.centre[1]) for x, y in ((0.0, 0.0), *link.knees, link.tip)]
        shapes = obstacle.shapes(self.space, self.links[obstacle.link], corners)
        for shape in shapes:
            shape.filter = _NOWHERE
            shape.friction = 1.0
            shape.elasticity = 1.0
        self.space.add(*shapes)
        return shapes


class ImpulseRecord:
    """Makes the engine record the impulses of all contacts step by step, so that they can be read at once."""

    def __init__(self, space: pymunk.Space) -> None:
        self._numbers = ffi.gc(lib.pmFloatArrayNew(0), lib.pmFloatArrayFree)
        self._data = ffi.new("pmBatchedData *", (ffi.NULL, self._numbers, lib.TOTAL_IMPULSE | lib.NORMAL))
        write = ffi.addressof(lib, "pmSpaceArbiterIteratorFuncBatched")
        self.note = partial(lib.cpSpaceEachCachedArbiter, space._space, write, self._data)
        self._stale = 0

    def begin(self) -> None:
        """Reset the record. The impulse before the interval is noted twice: here and before the first step."""
        self._numbers.num = 0
        self.note()
        self._stale = 2 * self._numbers.num

    def pushes(self) -> list[float]:
        """Return the normal impulse of each step of the interval.

        The sign of the engine's normal and impulse depends on the order of the shapes inside the engine; a contact only
        pushes, which settles both.
        """
        self.note()
        numbers: list[float] = ffi.unpack(self._numbers.arr, self._numbers.num)
        each = [iter(numbers[self._stale :])] * 4
        return [abs(p * x + q * y) for p, q, x, y in zip(*each, strict=True)]
