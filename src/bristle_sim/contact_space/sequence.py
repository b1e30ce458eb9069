"""Impacts of one instant, one after the other: the fastest approach first, until no point approaches.

An impact at one point can drive others of the same bodies, or of bodies joined to them, into their surfaces. Contacts of
bodies that have nothing to do with each other do not notice each other's order.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Sequence

import pymunk

from bristle_sim.contact_space.contact_pair import TouchingPoint
from bristle_sim.contact_space.impulse import ContactSpace, contact_space
from bristle_sim.contact_space.jacobian import JointRow, Vector
from bristle_sim.contact_space.projection import close_joints
from bristle_sim.theory.impact_result import JAM, Impact

ROUNDING = 1e-9
"""Fraction of the bodies' speed at a point below which its approach is rounding."""

COLLAPSE = 50
"""Impacts at one point after which it gives no restitution: bodies that bounce without end within an instant come to rest."""

TRIALS = 255
"""Sets of limits that are tried, all of them for up to eight limits reached at once; if none will do, all are rigid."""

MOST = 10_000
"""Impacts at one point after which the step is given up."""


class ImpactSequence:
    """Resolve what touches and approaches at the end of a step.

    Args:
        points_of: reads the touching points of a body, of all pairs.
        resting_speed: slower approach takes no restitution, and is left to the engine where it can be.
        record: called with each faster impact.
    """

    def __init__(
        self,
        points_of: Callable[[pymunk.Body], Iterable[TouchingPoint]],
        resting_speed: float,
        record: Callable[[TouchingPoint, Impact], None],
    ) -> None:
        """See the class."""
        self._points_of = points_of
        self._resting_speed = resting_speed
        self._record = record
        self._points: dict[pymunk.Body, list[TouchingPoint]] = {}
        self._known: dict[tuple[frozenset[pymunk.Shape], Vector], TouchingPoint] = {}
        self.jammed: set[frozenset[pymunk.Shape]] = set()

    def resolve(self, bodies: Iterable[pymunk.Body], skipped: set[frozenset[pymunk.Shape]]) -> None:
        """Resolve the contacts of these bodies, and those that their impacts reach.

        Args:
            bodies: the dynamic ones of contacts which the engine was kept from responding to.
            skipped: the shapes of these contacts; others are the engine's if they approach slowly.

        Raises:
            RuntimeError: if impacts at one point come to no end.
        """
        self._notice(bodies)
        while True:
            approaching = [each for each in self._known.values() if self._approaches(each, skipped)]
            if not approaching:
                return
            self._notice(self._strike(max(approaching, key=lambda each: each.approach)))

    def _approaches(self, point: TouchingPoint, skipped: set[frozenset[pymunk.Shape]]) -> bool:
        least = 0.0 if point.shapes in skipped else self._resting_speed
        return point.approach > max(least, ROUNDING * point.speed) and point.shapes not in self.jammed

    def _notice(self, bodies: Iterable[pymunk.Body]) -> None:
        """Measure the points of bodies that were set in motion anew."""
        for body in bodies:
            if body not in self._points:
                found = self._points_of(body)
                self._points[body] = [self._known.setdefault((each.shapes, each.point), each) for each in found]
            for point in self._points[body]:
                point.measure()

    def _strike(self, point: TouchingPoint) -> tuple[pymunk.Body, ...]:
        """Resolve one point, and return the bodies whose velocities changed."""
        point.impacts += 1
        if point.impacts > MOST:
            x, y = point.point
            raise RuntimeError(f"{MOST} impacts at ({x:g}, {y:g}) in one step: increase resting_speed")
        close_joints(*point.bodies)
        space, impact, rests = self._law(point)
        space.apply(
            (impact.impulse_normal, impact.impulse_tangential), (impact.velocity_normal, impact.velocity_tangential)
        )
        if impact.outcome == JAM:
            self.jammed.add(point.shapes)
        if not rests:
            self._record(point, impact)
        return space.bodies

    def _law(self, point: TouchingPoint) -> tuple[ContactSpace, Impact, bool]:
        """Return the impact in which limits of joints push only and are not passed, and whether it is one of bodies at rest."""
        rigid = self._with_limits(point, ())
        limits = rigid[0].limits
        if _agrees(*rigid[:2], ()):
            return rigid
        for released in itertools.islice(_subsets(limits), TRIALS):
            found = self._with_limits(point, released)
            if _agrees(*found[:2], released):
                return found
        return rigid

    def _with_limits(self, point: TouchingPoint, released: Sequence[JointRow]) -> tuple[ContactSpace, Impact, bool]:
        first, second = point.bodies
        space = contact_space(
            first,
            point.point,
            point.normal,
            second,
            surface_velocity=point.surface_velocity,
            released=[each.joint for each in released],
        )
        rests = -space.velocity[0] <= max(self._resting_speed, ROUNDING * point.speed)
        spent = rests or point.impacts > COLLAPSE
        return space, point.pair.impact(space, 0.0 if spent else point.pair.restitution), rests


def _subsets(limits: Sequence[JointRow]) -> Iterator[tuple[JointRow, ...]]:
    """Return every choice of some of the limits, few first."""
    return itertools.chain.from_iterable(itertools.combinations(limits, count + 1) for count in range(len(limits)))


def _agrees(space: ContactSpace, impact: Impact, released: Sequence[JointRow]) -> bool:
    """Whether all limits that are rigid push, and none of the others is passed."""
    impulse = (impact.impulse_normal, impact.impulse_tangential)
    return space.limits_push(impulse) and not any(space.passes(each, impulse) for each in released)
