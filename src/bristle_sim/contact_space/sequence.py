"""Impacts of one instant, one after the other: the fastest approach first, until no point approaches.

An impact at one point can drive others of the same bodies, or of bodies joined to them, into their surfaces. Contacts of
bodies that have nothing to do with each other do not notice each other's order.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence

import pymunk

from bristle_sim.contact_space.impulse import ContactSpace, contact_space
from bristle_sim.contact_space.jacobian import Connected, JointRow, joined
from bristle_sim.contact_space.projection import close_joints
from bristle_sim.contact_space.simultaneous import resolve_at_once
from bristle_sim.contact_space.step_motion import StepMotion
from bristle_sim.contact_space.touching import Contacts, Shapes, TouchingPoint
from bristle_sim.theory.impact_result import JAM, Impact

ROUNDING = 1e-9
"""Fraction of the bodies' speed at a point below which its approach is rounding."""

COLLAPSE = 12
"""Impacts at one point after which all are resolved at once, this one without restitution: it would bounce without end."""

TRIALS = 255
"""Sets of limits that are tried, all of them for up to eight limits reached at once; if none will do, all are rigid."""

MOST = 40
"""Impacts of a step, one after the other, after which all are resolved at once, which bounds the cost of a step."""


class ImpactSequence:
    """Resolve what touches and approaches at the end of a step.

    Args:
        points_of: adds the contacts of a body to the known ones, and returns the shapes of all of its.
        skipped: shapes of contacts which the engine was kept from responding to; others are its own if they approach slowly.
        resting_speed: slower approach takes no restitution, and is left to the engine where it can be.
        motion: of the step.
        record: called with each faster impact.

    Attributes:
        struck: bodies set in motion anew, and the time before the end of the step since which they move so.
        jammed: shapes of contacts that no impulse can part.
    """

    def __init__(
        self,
        points_of: Callable[[pymunk.Body, Contacts], Iterable[Shapes]],
        skipped: Collection[Shapes],
        resting_speed: float,
        motion: StepMotion,
        record: Callable[[TouchingPoint, Impact], None],
    ) -> None:
        """See the class."""
        self._points_of, self._skipped, self._resting_speed = points_of, skipped, resting_speed
        self._motion, self._record = motion, record
        self._contacts: Contacts = {}
        self._points: dict[pymunk.Body, list[TouchingPoint]] = {}
        self._approaching: dict[TouchingPoint, None] = {}
        self.struck: dict[pymunk.Body, float] = {}
        self.jammed: set[Shapes] = set()

    def resolve(self, bodies: Iterable[pymunk.Body]) -> None:
        """Resolve the contacts of these dynamic bodies, and those that their impacts reach."""
        self._measure(self._read(bodies))
        for _ in range(MOST):
            if not self._approaching:
                return
            point = max(self._approaching, key=lambda each: (each.time, each.approach))
            if point.impacts == COLLAPSE:
                break
            self._strike(point)
        if self._approaching:
            self._strike_all()

    def _read(self, bodies: Iterable[pymunk.Body]) -> list[TouchingPoint]:
        """Read the points of bodies, before they are set in motion anew, and return those that were not known."""
        known = len(self._contacts)
        for body in bodies:
            if body not in self._points:
                shapes = self._points_of(body, self._contacts)
                self._points[body] = [point for each in shapes for point in self._contacts[each]]
        return [point for each in itertools.islice(self._contacts.values(), known, None) for point in each]

    def _measure(self, points: Iterable[TouchingPoint], since: float = 0.0) -> None:
        """Find out which points approach."""
        for point in points:
            point.measure(self._motion, since, self._latest(point))
            shapes = frozenset(point.shapes)
            least = 0.0 if shapes in self._skipped else self._resting_speed
            if point.approach > max(least, ROUNDING * point.speed) and shapes not in self.jammed:
                self._approaching[point] = None
            else:
                self._approaching.pop(point, None)

    def _latest(self, point: TouchingPoint) -> float:
        """Return the time before the end of the step since which both bodies have moved as they do."""
        return min(self.struck.get(each, self._motion.duration) for each in point.bodies)

    def _rests(self, approach: float, point: TouchingPoint) -> bool:
        return approach <= max(self._resting_speed, ROUNDING * point.speed)

    def _strike(self, point: TouchingPoint) -> None:
        """Resolve one point at the instant of its touch."""
        point.impacts += 1
        motion, connected = self._motion, joined(point.bodies)
        bodies, joints = connected
        self._measure(self._read(bodies))
        others = dict.fromkeys([*point.bodies, *(end for joint in joints for end in (joint.a, joint.b))])
        moved = [*bodies, *(each for each in others if each.body_type == pymunk.Body.KINEMATIC)]
        point.go_back(motion, moved, self._latest(point))
        steps = motion.steps(point.time)
        motion.kick(bodies, -steps)
        close_joints(bodies, joints)
        space, impact = self._law(point, connected)
        space.apply(
            (impact.impulse_normal, impact.impulse_tangential), (impact.velocity_normal, impact.velocity_tangential)
        )
        motion.kick(bodies, steps)
        motion.drift(moved, point.time)
        if point.time:
            close_joints(bodies, joints, with_limits=False)
        if impact.outcome == JAM:
            self.jammed.add(frozenset(point.shapes))
        if not self._rests(-space.velocity[0], point):
            self._record(point, impact)
        motion.forget(bodies)
        self.struck.update(dict.fromkeys(bodies, point.time))
        self._measure(dict.fromkeys(each for body in bodies for each in self._points[body]), point.time)

    def _strike_all(self) -> None:
        """Resolve all contacts that touch these, directly or over further bodies, at once, at the end of the step."""
        reached = dict.fromkeys(self._points)
        for body in (rest := list(reached)):
            ends = [end for point in self._points[body] for end in point.bodies if end not in reached]
            found, _ = joined(ends)
            self._read(found)
            reached.update(dict.fromkeys(found))
            rest += found
        points = [each for shapes, contact in self._contacts.items() if shapes not in self.jammed for each in contact]
        restitution = [0.0 if self._rests(each.approach, each) else each.pair.restitution for each in points]
        self._motion.kick(reached, -0.5)
        impacts = resolve_at_once(points, restitution)
        self._motion.kick(reached, 0.5)
        for point, impact in zip(points, impacts, strict=True):
            if impact.impulse_normal > 0.0:
                point.time = 0.0
                self._record(point, impact)

    def _law(self, point: TouchingPoint, connected: Connected) -> tuple[ContactSpace, Impact]:
        """Return the impact in which limits of joints push only and are not passed."""
        rigid = self._with_limits(point, connected, ())
        if _agrees(*rigid, ()):
            return rigid
        for released in itertools.islice(_subsets(rigid[0].limits), TRIALS):
            found = self._with_limits(point, connected, released)
            if _agrees(*found, released):
                return found
        return rigid

    def _with_limits(
        self, point: TouchingPoint, connected: Connected, released: Sequence[JointRow]
    ) -> tuple[ContactSpace, Impact]:
        first, second = point.bodies
        space = contact_space(
            first,
            point.overlap.point,
            point.overlap.normal,
            second,
            surface_velocity=point.surface_velocity,
            released=[each.joint for each in released],
            connected=connected,
        )
        rests = self._rests(-space.velocity[0], point)
        return space, point.pair.impact(space, 0.0 if rests else point.pair.restitution)


def _subsets(limits: Sequence[JointRow]) -> Iterator[tuple[JointRow, ...]]:
    """Return every choice of some of the limits, few first."""
    return itertools.chain.from_iterable(itertools.combinations(limits, count + 1) for count in range(len(limits)))


def _agrees(space: ContactSpace, impact: Impact, released: Sequence[JointRow]) -> bool:
    """Whether all limits that are rigid push, and none of the others is passed."""
    impulse = (impact.impulse_normal, impact.impulse_tangential)
    return space.limits_push(impulse) and not any(space.passes(each, impulse) for each in released)
