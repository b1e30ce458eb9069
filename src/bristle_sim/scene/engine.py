"""Direct calls of the physics engine (Chipmunk), for operations done thousands of times per
simulation.

They bypass pymunk's wrappers: a wrapped step takes 0.77 us, of which the engine itself takes
0.34 us.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Callable, Sequence
from functools import partial
from operator import sub
from typing import Any

import pymunk
from pymunk._chipmunk_cffi import ffi, lib

from bristle_sim.scene.mechanism import Vector
from bristle_sim.scene.pairs import ClosedPair

LONGEST_WARM_RATIO = 1e3
"""Largest ratio of a step to the step before it at which the engine starts from the joint impulses
of the step before. With a larger ratio, the scaled rounding error of these impulses would show."""

LONGEST_SINGLE_RATIO = 2.0
"""The same ratio where a single step of a length is taken. The engine scales the impulse that it
applies, by the ratio s, but not the impulse that it remembers, which becomes 1 - s times as large.
Further steps of the same length correct the remembered impulse. Without them, alternating short and
long steps would make it grow without bound."""

Pusher = Callable[[Vector, Vector], None]
"""Function that applies a force (first argument) at a point (second argument) until the end of the
next step."""


# number of links up to which a step counts once in ``work``; measured, the solver of the joints
# takes 17, 21, 31 and 60 us for 8, 16, 32 and 64 links
LINKS_OF_A_STEP = 32


class EngineSpace:
    """A space of the engine, its bodies and joints, and the steps taken in it.

    After each engine step, ``joint_solver`` corrects the velocities if a wire has several links or
    a sustained contact is closed.

    Attributes:
        space: the pymunk space.
        hub: kinematic body that carries the roots; None without a hub.
        links: bodies of the links, in order from the root.
        joints: pivots of the links, in order from the root.
        steps: number of steps taken.
        work: cost of the steps taken: a step counts once for every ``LINKS_OF_A_STEP`` links, or
            part of them.
        put: sets positions and velocities of all bodies.
        joint_solver: solver of joints, damping and sustained contacts.
    """

    def __init__(
        self,
        space: pymunk.Space,
        hub: pymunk.Body | None,
        links: Sequence[pymunk.Body],
        joints: Sequence[pymunk.Constraint],
        joint_solver: Any,
        *,
        jointed: bool,
    ) -> None:
        """Prepare the steps of a space.

        ``joint_solver`` is a ``solver.WireVelocities``, or a ``solver.LinkVelocity`` for a single
        link. ``jointed`` is whether a wire has several links.
        """
        self.space = space
        self.hub = hub
        self.links = links
        self.joints = joints
        bodies = list(links) if hub is None else [hub, *links]
        self.steps = self.work = 0
        self.put = Placer(bodies)
        self._kept = Placer(bodies)
        self._links = [link._body for link in links]
        self.joint_solver = joint_solver
        self._jointed = jointed
        self._last_length = math.inf
        space.step(0.0)  # all that was added is in the space from here on
        # The pointer does not own the space. A reference to space._space, which frees it, must not
        # outlive the pymunk space: the garbage collector, in another thread, may then remove
        # bodies, shapes and constraints from the space while it is being freed.
        bare = ffi.cast("cpSpace *", space._space)
        self._engine_step: Callable[[float], None] = partial(lib.cpSpaceStep, bare)
        self._price = math.ceil(len(links) / LINKS_OF_A_STEP)
        springs = [
            each for each in space.constraints if isinstance(each, pymunk.DampedRotarySpring)
        ]
        self._dampings = [(spring, spring.damping) for spring in springs if spring.damping]
        self._solve: Callable[[float], None] | None = None
        self.keep_closed(())

    def keep_closed(self, contacts: Sequence[ClosedPair]) -> None:
        """Keep the given sustained contacts closed from now on; () returns to steps without
        contacts.
        """
        solving = bool(contacts) or self._jointed
        if solving is (self._solve is None):
            self._solve = self.joint_solver.solve if solving else None
            for spring, damping in self._dampings:
                spring.damping = 0.0 if solving else damping
        if solving:
            self.joint_solver.set_contacts(contacts)

    def step_alone(self, length: float) -> None:
        """Take one step of the engine without ``joint_solver``.

        The next step does not start from the joint impulses of this step.
        """
        self.steps += 1
        self._engine_step(length)
        self._last_length = 0.0

    def angles(self) -> list[float]:
        """Return the angles of the links, rad."""
        return list(map(lib.cpBodyGetAngle, self._links))

    def rates(self) -> list[float]:
        """Return the rates of the links, rad per time unit."""
        return list(map(lib.cpBodyGetAngularVelocity, self._links))

    def step(
        self,
        length: float,
        count: int,
        act: Callable[[], None] | None = None,
        *,
        symmetric: bool = False,
        middle: list[list[float]] | None = None,
    ) -> list[float]:
        """Take engine steps of equal length.

        Args:
            length: length of a step.
            count: number of steps; even for symmetric steps.
            act: function that is called before each step.
            symmetric: whether the steps are symmetric in time. The bodies must have been placed
                where they would have been half a step earlier.
            middle: list to which the angles and rates of all links after half of the steps are
                added; None without them.

        Returns:
            The angles of all links, then their rates, then their accelerations in the last step, or
                in the last two symmetric steps.
        """
        self.steps += count
        self.work += count * self._price
        if length > LONGEST_SINGLE_RATIO * self._last_length and (
            count == 1 or length > LONGEST_WARM_RATIO * self._last_length
        ):
            self._forget_impulses(length)
        self._last_length = length
        if symmetric:
            self.joint_solver.begin_symmetric()
        engine_step = self._engine_step
        solve = self._solve
        half = count // 2
        last = 2 if symmetric else 1
        links = self._links
        angle = lib.cpBodyGetAngle
        rate = lib.cpBodyGetAngularVelocity
        for left in range(count, 0, -1):
            if left == half and middle is not None:
                middle.append([*map(angle, links), *map(rate, links)])
            if left == last:
                before = [*map(rate, links)]
            if act is not None:
                act()
            engine_step(length)
            if solve is not None:
                solve(length)
        after = [*map(rate, links)]
        if len(links) == 1:
            # A single link needs no lists, which would make a pass slower by a thirtieth.
            return [angle(links[0]), *after, (after[0] - before[0]) / length]
        angles = [*map(angle, links)]
        if symmetric:
            self.joint_solver.symmetric = False
            angles = [a + 0.5 * length * rate for a, rate in zip(angles, after, strict=True)]
        return [*angles, *after, *[each / (last * length) for each in map(sub, after, before)]]

    def _forget_impulses(self, length: float) -> None:
        """Make the engine forget the joint impulses of the last step before much longer steps,
        because it would scale them by the ratio of the lengths.
        """
        for joint in self.joints:
            joint.max_force = 0.0
        # The first step still applies them, to bodies that are put back; the second leaves those of
        # contacts right.
        for _ in range(2):
            self._kept.keep()
            self._engine_step(length)
            self._kept(None)
        for joint in self.joints:
            joint.max_force = math.inf


class Placer:
    """Sets and reads the positions and velocities of bodies, by one engine call for each body.

    Attributes:
        values: six numbers for each body, as last set or read: centre x and y, angle, velocity of
            the centre along x and y, rate.
    """

    def __init__(self, bodies: Sequence[pymunk.Body]) -> None:
        """Prepare to place the given bodies, in the given order."""
        self._bodies = [body._body for body in bodies]
        # Room for another body, or the engine would move the numbers to a place of its own.
        self.values = array("d", bytes(6 * 8 * (len(bodies) + 1)))
        self._numbers = ffi.new(
            "pmFloatArray *", (0, len(self.values), ffi.from_buffer("double[]", self.values))
        )
        fields = lib.POSITION | lib.ANGLE | lib.VELOCITY | lib.ANGULAR_VELOCITY
        self._data = ffi.new("pmBatchedData *", (ffi.NULL, self._numbers, fields))

    def __call__(self, values: Sequence[float] | None) -> None:
        """Set the bodies' positions and velocities, six numbers for each body as in ``values``;
        None sets ``values`` again.
        """
        if values is not None:
            self.values[: len(values)] = array("d", values)
        self._numbers.num = 0
        put = lib.pmSpaceBodySetIteratorFuncBatched
        data = self._data
        for body in self._bodies:
            put(body, data)

    def keep(self) -> None:
        """Read the bodies' present positions and velocities into ``values``."""
        self._numbers.num = 0
        for body in self._bodies:
            lib.pmSpaceBodyGetIteratorFuncBatched(body, self._data)


def point_calls(body: pymunk.Body, point: Vector) -> tuple[Callable[[], Any], Callable[[], Any]]:
    """Return two functions without arguments: the first returns the position of a body's point,
    the second its velocity.

    ``point`` is measured from the centre of mass along the body's axes. Each result has the
    attributes ``x`` and ``y``.
    """
    bare = body._body
    return partial(lib.cpBodyLocalToWorld, bare, point), partial(
        lib.cpBodyGetVelocityAtLocalPoint, bare, point
    )


def pusher(body: pymunk.Body) -> Pusher:
    """Return the function that applies a force to a body at a point."""
    return partial(lib.cpBodyApplyForceAtWorldPoint, body._body)
