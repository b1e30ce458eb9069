"""Direct calls of the engine for work done thousands of times a run, because pymunk's wrappers are
slow.

A wrapped step takes 0.77 us, of which the engine itself takes 0.34 us.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Callable, Sequence
from functools import cached_property, partial
from operator import sub
from typing import Any

import pymunk
from pymunk._chipmunk_cffi import ffi, lib

from bristle_sim.scene.mechanism import Vector
from bristle_sim.scene.pairs import ClosedPair

LONGEST_WARM_RATIO = 1e3
"""Largest ratio of two successive steps at which the longer one starts from the impulses of the
shorter one. Scaled further, the rounding of these impulses would show."""

LONGEST_SINGLE_RATIO = 2.0
"""The same ratio for a single step. The engine scales the impulse that it applies, by s, but not
the impulse that it remembers, which becomes 1 - s times as large. Further steps of the same length
correct the remembered impulse; without them, alternating short and long steps would make it grow
without bound."""

Pusher = Callable[[Vector, Vector], None]
"""Applies a force at a point until the end of the next step."""


LINKS_OF_A_STEP = 32  # links whose solve counts as one step: measured, 17, 21, 31 and 60 us for 8, 16, 32 and 64 links


class EngineSteps:
    """Places the bodies of a space, takes its steps, and counts them.

    A solver for joints, damping and contacts follows each engine step of a wire of several links,
    and of sustained contact. ``work`` counts a step once for every ``LINKS_OF_A_STEP`` links.
    """

    def __init__(
        self,
        space: pymunk.Space,
        hub: pymunk.Body | None,
        links: Sequence[pymunk.Body],
        joints: Sequence[pymunk.Constraint],
        make_solver: Callable[[], Any],
        *,
        several_links: bool,
    ) -> None:
        """Start without impulses of an earlier step; ``make_solver`` is called when the solver is
        first needed.
        """
        self.space = space
        self.joints = joints
        bodies = list(links) if hub is None else [hub, *links]
        self.steps = self.work = 0
        self.place = Placer(bodies)
        self._kept = Placer(bodies)
        self._links = [link._body for link in links]
        self._make_solver = make_solver
        self._several_links = several_links
        self._last_length = math.inf
        space.step(0.0)  # all that was added is in the space from here on
        self._engine_step: Callable[[float], None] = partial(lib.cpSpaceStep, bare_space(space))
        self._price = math.ceil(len(links) / LINKS_OF_A_STEP)
        springs = [
            each for each in space.constraints if isinstance(each, pymunk.DampedRotarySpring)
        ]
        self._dampings = [(spring, spring.damping) for spring in springs if spring.damping]
        self._solving = False
        self._step: Callable[[float], None] = self._engine_step
        self.keep_closed(())

    @cached_property
    def joint_solver(self) -> Any:
        """``solver.WireVelocities`` or ``link_solver.LinkVelocity``, made when it is first needed."""
        return self._make_solver()

    @property
    def take_symmetric(self) -> Callable[..., list[float]] | None:
        """The function that takes time-symmetric steps, or None while the engine's own solver
        handles the joints.
        """
        return self._take_symmetric if self._solving and self.joint_solver.reversible else None

    def keep_closed(self, contacts: Sequence[ClosedPair]) -> None:
        """Solve from now on for these sustained contacts together with the joints; () returns to
        the steps of free flight.
        """
        solving = bool(contacts) or self._several_links
        if solving is not self._solving:
            self._solving = solving
            self._step = self._step_and_solve if solving else self._engine_step
            for spring, damping in self._dampings:
                spring.damping = 0.0 if solving else damping
        if solving:
            self.joint_solver.set_contacts(contacts)

    def _step_and_solve(self, length: float) -> None:
        self._engine_step(length)
        self.joint_solver.solve(length)

    def step_alone(self, length: float) -> None:
        """Take one step of the engine and its own solver, whose impulses the next step forgets."""
        self.steps += 1
        self._engine_step(length)
        self._last_length = 0.0

    def angles(self) -> list[float]:
        """Return the angles of the links."""
        return list(map(lib.cpBodyGetAngle, self._links))

    def rates(self) -> list[float]:
        """Return the rates of the links."""
        return list(map(lib.cpBodyGetAngularVelocity, self._links))

    def take(self, length: float, count: int, act: Callable[[], None] | None = None) -> list[float]:
        """Take ``count`` engine steps of one length, calling ``act`` before each.

        Returns:
            The links' angles, then their rates, then their accelerations in the last step.
        """
        self._begin(length, count)
        advance = self._step
        links = self._links
        for _ in range(count - 1):
            if act is not None:
                act()
            advance(length)
        if act is not None:
            act()
        if len(links) == 1:
            (link,) = links
            first = lib.cpBodyGetAngularVelocity(link)
            advance(length)
            last = lib.cpBodyGetAngularVelocity(link)
            return [lib.cpBodyGetAngle(link), last, (last - first) / length]
        before = self.rates()
        advance(length)
        after = self.rates()
        changes = map(sub, after, before)
        return [*self.angles(), *after, *[change / length for change in changes]]

    def _take_symmetric(
        self, length: float, count: int, act: Callable[[], None] | None = None
    ) -> list[float]:
        """Take an even number of time-symmetric steps from bodies placed half a step early; return
        the same values as ``take``.
        """
        self._begin(length, count)
        solver = self.joint_solver
        solver.begin_symmetric()
        for left in range(count, 0, -1):
            if left == 2:
                before = self.rates()
            if act is not None:
                act()
            self._step(length)
        solver.symmetric = False
        after = self.rates()
        angles = [
            angle + 0.5 * length * rate for angle, rate in zip(self.angles(), after, strict=True)
        ]
        return [*angles, *after, *[0.5 * change / length for change in map(sub, after, before)]]

    def _begin(self, length: float, count: int) -> None:
        """Count steps that are to be taken; make the engine forget the last step's impulses where it
        would scale them too far to the length of these steps.
        """
        self.steps += count
        self.work += count * self._price
        ratio = LONGEST_WARM_RATIO if count > 1 else LONGEST_SINGLE_RATIO
        warm = length <= ratio * self._last_length
        self._last_length = length
        if warm:
            return
        for joint in self.joints:
            joint.max_force = 0.0
        # The first step still applies them, to bodies that are put back; the second leaves those of contacts right.
        for _ in range(2):
            self._kept.keep()
            self._engine_step(length)
            self._kept(None)
        for joint in self.joints:
            joint.max_force = math.inf


def bare_space(space: pymunk.Space) -> Any:
    """Return the engine's pointer to a space, valid only while the pymunk space exists.

    ``space._space`` owns the engine's space and frees it. It must not be kept beyond the
    pymunk.Space: by then bodies, shapes and constraints may be garbage too, and the garbage
    collector, in another thread, may remove them from the space while it is freed.
    """
    return ffi.cast("cpSpace *", space._space)


class Placer:
    """Set centre (x, y), angle, velocity (u, v) and rate of every body by one engine call for each
    body.

    Attributes:
        values: the numbers that were last set or kept, six for each body.
    """

    def __init__(self, bodies: Sequence[pymunk.Body]) -> None:
        """Prepare to place these bodies, in this order."""
        self._bodies = [body._body for body in bodies]
        # Room for another body, or the engine would move the numbers to a place of its own.
        self.values = array("d", bytes(6 * 8 * (len(bodies) + 1)))
        self._numbers = ffi.new(
            "pmFloatArray *", (0, len(self.values), ffi.from_buffer("double[]", self.values))
        )
        fields = lib.POSITION | lib.ANGLE | lib.VELOCITY | lib.ANGULAR_VELOCITY
        self._data = ffi.new("pmBatchedData *", (ffi.NULL, self._numbers, fields))

    def __call__(self, values: Sequence[float] | None) -> None:
        """Set these values; None sets the last ones again."""
        if values is not None:
            self.values[: len(values)] = array("d", values)
        self._numbers.num = 0
        put = lib.pmSpaceBodySetIteratorFuncBatched
        data = self._data
        for body in self._bodies:
            put(body, data)

    def keep(self) -> None:
        """Keep the bodies' present values, as if these had been set last."""
        self._numbers.num = 0
        for body in self._bodies:
            lib.pmSpaceBodyGetIteratorFuncBatched(body, self._data)


def point_calls(body: pymunk.Body, point: Vector) -> tuple[Callable[[], Any], Callable[[], Any]]:
    """Return two functions that give the place and the velocity of a body's point; each result has
    ``x`` and ``y``.
    """
    bare = body._body
    return partial(lib.cpBodyLocalToWorld, bare, point), partial(
        lib.cpBodyGetVelocityAtLocalPoint, bare, point
    )


def pusher(body: pymunk.Body) -> Pusher:
    """Return the function that pushes on a body."""
    return partial(lib.cpBodyApplyForceAtWorldPoint, body._body)
