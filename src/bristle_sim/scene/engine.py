"""The engine's calls that a run makes thousands of times, without their wrappers where the engine offers them bare.

pymunk's wrappers serve what a scene never needs, such as bodies added during a step, and take more time than the
engine: 0.77 us a step, of which 0.34 us are the engine's. The bare calls are not part of pymunk's documented interface;
where a version does not have them, the documented ones do the same.
"""

from __future__ import annotations

import itertools
import math
from array import array
from collections.abc import Callable, Sequence
from functools import partial
from operator import attrgetter, sub
from typing import Any, Protocol

import pymunk

from bristle_sim.contact_space.engine_calls import bare_object, ffi, lib
from bristle_sim.scene.mechanism import Vector

ITERATIONS_OF_A_STEP = 100
"""Solver iterations that take as long as the rest of an engine step: measured, 35 ns each and 3 to 5 us a step with what
Python does around it."""

WARM, ALONE = 1e3, 2.0
"""Steps up to this many times as long as the one before start from its impulses; the rounding of impulses that are scaled
further would show. A step on its own bears less: the engine scales the impulse that it applies, by s, but not the one that
it remembers, which becomes 1 - s times what it was. Further steps of the same length put that right; one short and one long
step in turn would make it grow without bound."""


LOG_SOLVED = math.log(1e-17)
"""Iterations leave this fraction of the error: rounding."""

MOST_ITERATIONS = 40_000
"""Iterations of the engine's solver in a step; a link 1e-3 times as heavy as the next one takes them."""


class Placer(Protocol):
    """Sets centre (x, y), angle, velocity (u, v) and rate of every body, one body after the other.

    Attributes:
        values: these numbers, as they were last set or kept.
    """

    values: array[float]

    def __call__(self, values: Sequence[float] | None) -> None:
        """Set these numbers; None sets the last ones again."""

    def keep(self) -> None:
        """Take the bodies' own numbers for the last ones that were set."""


Reader = Callable[[], tuple[float, float, float, float]]
"""Place (x, y) and velocity (u, v) of a point fixed on a body."""

Pusher = Callable[[Vector, Vector], None]
"""Applies a force at a place until the next step is done."""


def stepper(space: pymunk.Space) -> Callable[[float], None]:
    """Return a step of a space whose bodies, joints and shapes are all in it by now."""
    space.step(0.0)
    bare = bare_object(space, "_space")
    return space.step if bare is None else partial(lib.cpSpaceStep, bare)


class EngineSteps:
    """Places the bodies of a space, takes its steps, and counts them.

    Attributes:
        space: the space, with all its bodies, joints and shapes.
        joints: pivots between them.
        steps: engine steps taken so far.
        work: the same, each counted once more for every ``ITERATIONS_OF_A_STEP`` iterations of the solver in it.
        place: puts the bodies somewhere.
    """

    def __init__(
        self,
        space: pymunk.Space,
        hub: pymunk.Body | None,
        links: Sequence[pymunk.Body],
        joints: Sequence[pymunk.Constraint],
    ) -> None:
        """Nothing is to be remembered yet."""
        self.space, self.joints = space, joints
        bodies = list(links) if hub is None else [hub, *links]
        self.steps = self.work = 0
        self.place, self._kept = placer(bodies), placer(bodies)
        self._readers = readers(links)
        self._last_length = math.inf
        self._step = stepper(space)
        self._price = 1

    @property
    def take_symmetric(self) -> Callable[..., list[float]] | None:
        """What takes steps symmetric in time; None of an engine that solves the joints by itself."""
        return None

    def set_iterations(self, count: int) -> None:
        """Have the solver take this many iterations in every step."""
        self.space.iterations = count
        self._price = 1 + count // ITERATIONS_OF_A_STEP

    def angles(self) -> list[float]:
        """Return the angles of the links."""
        angle, _, links = self._readers
        return list(map(angle, links))

    def rates(self) -> list[float]:
        """Return the rates of the links."""
        _, rate, links = self._readers
        return list(map(rate, links))

    def take(self, length: float, count: int, act: Callable[[], None] | None = None) -> list[float]:
        """Take ``count`` engine steps of one length, and return the links' angles, rates, and accelerations in the last step.

        ``act`` is called before each of them.
        """
        if length > (WARM if count > 2 else ALONE) * self._last_length:
            self._start_cold(length)
        self._last_length = length
        self.steps += count
        self.work += count * self._price
        advance = self._step
        if act is None:
            for _ in range(count - 1):
                advance(length)
        else:
            for _ in range(count - 1):
                act()
                advance(length)
            act()
        return self._last_step(length)

    def _last_step(self, length: float) -> list[float]:
        """Take one step, and return what :meth:`take` does."""
        angle, rate, links = self._readers
        if len(links) == 1:
            (link,) = links
            first = rate(link)
            self._step(length)
            last = rate(link)
            return [angle(link), last, (last - first) / length]
        before = list(map(rate, links))
        self._step(length)
        after = list(map(rate, links))
        return [*map(angle, links), *after, *[change / length for change in map(sub, after, before)]]

    def warm_up(self, length: float) -> None:
        """Take one step of a length and put the bodies, which have not moved since, back where they were placed.

        From step to step the engine keeps a contact's impulse. When the step changes it rescales what it applies of it,
        but not what it reports, nor what limits friction and push, until a step has been taken.
        """
        if length > ALONE * self._last_length:
            self._start_cold(length)
        self._last_length = length
        self.steps += 1
        self.work += self._price
        self._step(length)
        self.place(None)

    def _take_back(self, length: float) -> None:
        """Take a step and put the bodies back: the engine keeps its impulses."""
        self._kept.keep()
        self._step(length)
        self._kept(None)

    def _start_cold(self, length: float) -> None:
        """Have the engine forget the impulses of its last step, which it would scale to the length of the next one."""
        for joint in self.joints:
            joint.max_force = 0.0
        # The first step still applies them, to bodies that are put back; the second leaves those of contacts right.
        for _ in range(2):
            self._take_back(length)
        for joint in self.joints:
            joint.max_force = math.inf


def placer(bodies: Sequence[pymunk.Body]) -> Placer:
    """Return what puts bodies somewhere, with their velocities."""
    bare = [bare_object(body, "_body") for body in bodies]
    return _Placer(bodies) if None in bare else _BarePlacer(bare)


class _Placer:
    """Places bodies by pymunk's documented calls."""

    def __init__(self, bodies: Sequence[pymunk.Body]) -> None:
        self._bodies = bodies
        self.values = array("d", bytes(6 * 8 * len(bodies)))

    def __call__(self, values: Sequence[float] | None) -> None:
        if values is not None:
            self.values[:] = array("d", values)
        numbers = iter(self.values)
        for body, x, y, angle, u, v, rate in zip(self._bodies, *[numbers] * 6, strict=False):
            body.angle, body.position, body.velocity, body.angular_velocity = angle, (x, y), (u, v), rate

    def keep(self) -> None:
        """Take down where the bodies are and how they move."""
        moving = [(*each.position, each.angle, *each.velocity, each.angular_velocity) for each in self._bodies]
        self.values[:] = array("d", itertools.chain.from_iterable(moving))


class _BarePlacer:
    """Places each body by one call, from numbers that the engine reads where they lie."""

    def __init__(self, bodies: Sequence[Any]) -> None:
        self._bodies = bodies
        # Room for another body, or the engine would move the numbers to a place of its own.
        self.values = array("d", bytes(6 * 8 * (len(bodies) + 1)))
        self._numbers = ffi.new("pmFloatArray *", (0, len(self.values), ffi.from_buffer("double[]", self.values)))
        fields = lib.POSITION | lib.ANGLE | lib.VELOCITY | lib.ANGULAR_VELOCITY
        self._data = ffi.new("pmBatchedData *", (ffi.NULL, self._numbers, fields))

    def __call__(self, values: Sequence[float] | None) -> None:
        if values is not None:
            self.values[: len(values)] = array("d", values)
        self._numbers.num = 0
        put, data = lib.pmSpaceBodySetIteratorFuncBatched, self._data
        for body in self._bodies:
            put(body, data)

    def keep(self) -> None:
        """Take down where the bodies are and how they move."""
        self._numbers.num = 0
        for body in self._bodies:
            lib.pmSpaceBodyGetIteratorFuncBatched(body, self._data)


def readers(bodies: Sequence[pymunk.Body]) -> tuple[Callable[[Any], float], Callable[[Any], float], Sequence[Any]]:
    """Return what reads an angle, what reads a rate, and what they take for each of these bodies."""
    bare = [bare_object(body, "_body") for body in bodies]
    if None in bare:
        return attrgetter("angle"), attrgetter("angular_velocity"), bodies
    return lib.cpBodyGetAngle, lib.cpBodyGetAngularVelocity, bare


def point_reader(body: pymunk.Body, point: Vector) -> Reader:
    """Return what tells where a body's point is and how it moves."""
    bare = bare_object(body, "_body")
    return partial(_read, body, point) if bare is None else partial(_read_bare, bare, point)


def _read(body: pymunk.Body, point: Vector) -> tuple[float, float, float, float]:
    return (*body.local_to_world(point), *body.velocity_at_local_point(point))


def _read_bare(body: Any, point: Vector) -> tuple[float, float, float, float]:
    place, velocity = lib.cpBodyLocalToWorld(body, point), lib.cpBodyGetVelocityAtLocalPoint(body, point)
    return place.x, place.y, velocity.x, velocity.y


def pusher(body: pymunk.Body) -> Pusher:
    """Return what pushes on a body."""
    bare = bare_object(body, "_body")
    return body.apply_force_at_world_point if bare is None else partial(lib.cpBodyApplyForceAtWorldPoint, bare)
