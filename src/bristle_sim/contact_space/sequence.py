"""Impacts of one step, one by one: the earliest touch first, of simultaneous ones the fastest, until no point approaches.

An impact at one point can drive others of the same bodies, or of bodies joined to them, into their surfaces. Bodies connected
by contacts and joints are a group; groups are independent.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Sequence
from operator import attrgetter
from typing import Any

import pymunk

from bristle_sim.contact_space.impulse import ContactSpace, contact_space
from bristle_sim.contact_space.jacobian import Connected, JointRow, joined
from bristle_sim.contact_space.projection import close_joints
from bristle_sim.contact_space.rest_filter import RestFilter
from bristle_sim.contact_space.simultaneous import resolve_at_once
from bristle_sim.contact_space.touching import APPROACH_ROUNDING, Met, Shapes, TouchingPoint
from bristle_sim.theory.impact_result import JAM, Impact

COLLAPSE = 12  # impacts at one point after which its group is resolved at once: it would bounce without end

TRIALS = 256  # sets of limits that are tried: all of them for up to eight limits reached at once

MOST = 40
"""Number of single impacts in a group after which all of it is resolved at once; this bounds the cost of a step."""

LOOKED = 8  # impacts in a group after which its points that approach are counted; MOST is a multiple of it


class ImpactSequence:
    """Resolve the contacts that approach at the end of a step.

    Args:
        found: contacts of the step; the engine ignores those in ``skipped``, and keeps others that approach slowly.
        record: called with each faster impact.

    Attributes:
        struck: bodies with new velocities, and how long before the end of the step they got them.
        jammed: shapes of contacts that no impulse can separate.
    """

    def __init__(self, found: RestFilter, record: Callable[[TouchingPoint, Impact], None]) -> None:
        self._found, self._motion, self._record = found, found.motion, record
        self._resting = found.resting_approach()
        self._met: dict[pymunk.Body, list[tuple[Met, list[pymunk.Body]]]] = {}
        for met in found.met:
            ends = [each for each in met.bodies() if each.body_type == pymunk.Body.DYNAMIC]
            for body in ends:
                self._met.setdefault(body, []).append((met, ends))
        self._contacts: dict[Any, list[TouchingPoint]] = {}
        self._points: dict[pymunk.Body, list[TouchingPoint]] = {}
        self._approaching: dict[TouchingPoint, None] = {}
        self._heads: dict[pymunk.Body, pymunk.Body] = {}
        self._impacts: dict[pymunk.Body, int] = {}
        self.struck: dict[pymunk.Body, float] = {}
        self.jammed: set[Shapes] = set()

    def resolve(self) -> None:
        """Resolve all contacts that approach, and those that their impacts reach."""
        touching = (each.body for shapes in self._found.skipped for each in shapes)
        self._measure(self._read(dict.fromkeys(each for each in touching if each in self._met)))
        while self._approaching:
            point = max(self._approaching, key=attrgetter("time", "approach"))
            head = self._head(point.bodies[0])
            impacts = self._impacts.get(head, 0)
            if point.impacts == COLLAPSE or (impacts % LOOKED == 0 and self._too_many(head, impacts)):
                self._strike_all(point)
            else:
                self._impacts[head] = impacts + 1
                self._strike(point)

    def _too_many(self, head: pymunk.Body, impacts: int) -> bool:
        """Whether a group has had ``MOST`` impacts, or is expected to, from its impacts so far and its approaching points."""
        waiting = sum(1 for each in self._approaching if self._head(each.bodies[0]) is head)
        return impacts + waiting > MOST or impacts * waiting > 2 * MOST or impacts == MOST

    def _read(self, bodies: Iterable[pymunk.Body]) -> list[TouchingPoint]:
        """Read the contact points of bodies before their velocities change; return the new ones."""
        new: list[TouchingPoint] = []
        for body in bodies:
            if body not in self._points:
                self._points[body] = []
                for met, ends in self._met.get(body, ()):
                    points = self._contacts.get(met.arbiter)
                    if points is None:
                        points = self._contacts[met.arbiter] = met.points()
                        new += points
                        if len(ends) > 1:
                            self._unite(ends)
                    self._points[body] += points
        return new

    def _head(self, body: pymunk.Body) -> pymunk.Body:
        """Return the body that stands for its group."""
        while body in self._heads:
            body = self._heads[body]
        return body

    def _unite(self, bodies: Iterable[pymunk.Body]) -> None:
        """Merge bodies into one group, adding up their impacts."""
        first, *others = dict.fromkeys(map(self._head, bodies))
        for each in others:
            self._heads[each] = first
            self._impacts[first] = self._impacts.get(first, 0) + self._impacts.pop(each, 0)

    def _measure(self, points: Iterable[TouchingPoint], since: float = 0.0) -> None:
        """Determine which points approach."""
        for point in points:
            point.measure(self._motion, since, self._latest(point))
            least = 0.0 if point.key in self._found.skipped else self._resting
            if point.approach > max(least, APPROACH_ROUNDING * point.speed) and point.key not in self.jammed:
                self._approaching[point] = None
            else:
                self._approaching.pop(point, None)

    def _latest(self, point: TouchingPoint) -> float:
        """Return the time before the end of the step since which both bodies have had their present velocities."""
        first, second = point.bodies
        step = self._motion.duration
        return min(self.struck.get(first, step), self.struck.get(second, step))

    def _rests(self, approach: float, point: TouchingPoint) -> bool:
        return approach <= max(self._resting, APPROACH_ROUNDING * point.speed)

    def _strike(self, point: TouchingPoint) -> None:
        """Resolve one point at the instant of its touch."""
        point.impacts += 1
        motion, connected = self._motion, joined(point.bodies)
        bodies, joints = connected
        if len(bodies) > 1:
            self._unite(bodies)
        self._measure(self._read(bodies))
        others = dict.fromkeys([*point.bodies, *[end for joint in joints for end in (joint.a, joint.b)]])
        moved = [*bodies, *[each for each in others if each.body_type == pymunk.Body.KINEMATIC]]
        point.go_back(motion, moved, self._latest(point))
        steps = motion.steps(point.time)
        motion.kick(bodies, -steps)
        if joints:
            close_joints(bodies, joints)
        space, impact = self._law(point, connected)
        space.apply(
            (impact.impulse_normal, impact.impulse_tangential), (impact.velocity_normal, impact.velocity_tangential)
        )
        motion.kick(bodies, steps)
        motion.drift(moved, point.time)
        if joints and point.time:
            close_joints(bodies, joints, with_limits=False)
        if impact.outcome == JAM:
            self.jammed.add(point.key)
        if not self._rests(-space.velocity[0], point):
            self._record(point, impact)
        motion.forget(bodies)
        self.struck.update(dict.fromkeys(bodies, point.time))
        self._measure(dict.fromkeys(each for body in bodies for each in self._points[body]), point.time)

    def _strike_all(self, point: TouchingPoint) -> None:
        """Resolve all contacts of a point's group, directly or over further bodies, at once, at the end of the step."""
        reached: dict[pymunk.Body, None] = {}
        waiting = [each for each in point.bodies if each.body_type == pymunk.Body.DYNAMIC]
        while waiting:
            found = [each for each in joined(waiting)[0] if each not in reached]
            reached.update(dict.fromkeys(found))
            self._read(found)
            touched = dict.fromkeys(end for body in found for each in self._points[body] for end in each.bodies)
            waiting = [each for each in touched if each not in reached and each.body_type == pymunk.Body.DYNAMIC]
        every = dict.fromkeys(each for body in reached for each in self._points[body])
        points = [each for each in every if each.key not in self.jammed]
        impacts = resolve_at_once(points, self._rests, self._motion)
        self.struck.update(dict.fromkeys(reached, 0.0))
        for each, impact in zip(points, impacts, strict=True):
            self._approaching.pop(each, None)
            if impact.impulse_normal > 0.0:
                each.time = 0.0
                self._record(each, impact)

    def _law(self, point: TouchingPoint, connected: Connected) -> tuple[ContactSpace, Impact]:
        """Return the impact in which limits of joints push only and are not passed; if there is none, all are rigid."""
        rigid = self._impact(point, connected, ())
        limits = rigid[0].limits
        subsets = (itertools.combinations(limits, count) for count in range(len(limits) + 1))
        for released in itertools.islice(itertools.chain.from_iterable(subsets), TRIALS):
            space, impact = self._impact(point, connected, released) if released else rigid
            impulse = (impact.impulse_normal, impact.impulse_tangential)
            if space.limits_push(impulse) and not any(space.passes(each, impulse) for each in released):
                return space, impact
        return rigid

    def _impact(
        self, point: TouchingPoint, connected: Connected, released: Sequence[JointRow]
    ) -> tuple[ContactSpace, Impact]:
        """Return the impact in which the limits of these joints take no part."""
        (first, second), (place, normal, _) = point.bodies, point.overlap
        slide, joints = point.surface_velocity, [each.joint for each in released]
        space = contact_space(
            first, place, normal, second, surface_velocity=slide, released=joints, connected=connected
        )
        return space, point.pair.impact(space, rests=self._rests(-space.velocity[0], point))
