"""Impacts of one step, resolved one by one until no contact point approaches.

The earliest touch is resolved first. Of touches at the same instant, the fastest is resolved first.
After an impact at one point, other contact points may start to approach, on the same bodies or on
bodies joined to them. Bodies connected by contacts and joints form a group; groups are independent.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from operator import attrgetter

import pymunk

from bristle_sim.contact_space.collision_rule import LocatedImpact
from bristle_sim.contact_space.impulse import ContactSpace, contact_space
from bristle_sim.contact_space.joints import Connected, joined
from bristle_sim.contact_space.projection import close_joints
from bristle_sim.contact_space.rest_filter import RestFilter
from bristle_sim.contact_space.simultaneous import resolve_at_once
from bristle_sim.contact_space.touching import APPROACH_ROUNDING, Collision, TouchingPoint
from bristle_sim.theory.impact_phases import JAM, Impact

# Number of impacts at one point in a step, after which all contacts of its group are resolved
# simultaneously: a sequence of ever smaller bounces may have no end.
COLLAPSE = 12
# Number of impacts in a group in a step, after which all contacts of the group are resolved
# simultaneously. This limit bounds the cost of a step.
MOST = 40
# Largest number of trials in the search for the joint limits that push in an impact, minus twice
# the number of joints. The first trial usually finds these limits.
LIMIT_TRIALS = 8


class Groups:
    """The contact points of a step, and the groups of bodies that contacts and joints connect.

    The contact points of a body are read from the engine when an impact first moves the body.

    Attributes:
        points: contact points of each body, for bodies whose points have been read.
        impacts: number of impacts so far in each group; the key is the body that represents the
            group.
    """

    def __init__(self, contacts: Iterable[Collision]) -> None:
        self._met: dict[pymunk.Body, list[Collision]] = {}
        for met in contacts:
            for body in met.bodies():
                self._met.setdefault(body, []).append(met)
        self._read: dict[Collision, list[TouchingPoint]] = {}
        self._heads: dict[pymunk.Body, pymunk.Body] = {}
        self.points: dict[pymunk.Body, list[TouchingPoint]] = {}
        self.impacts: dict[pymunk.Body, int] = {}

    def read(self, bodies: Iterable[pymunk.Body]) -> list[TouchingPoint]:
        """Read the contact points of bodies, and return the points that had not been read before.

        The points of a body must be read before an impact changes its velocity.
        """
        new: list[TouchingPoint] = []
        for body in bodies:
            if body not in self.points:
                self.points[body] = []
                for met in self._met.get(body, ()):
                    if met not in self._read:
                        self._read[met] = met.points()
                        new += self._read[met]
                        self.unite(met.bodies())
                    self.points[body] += self._read[met]
        return new

    def head(self, body: pymunk.Body) -> pymunk.Body:
        """Return the body that represents the group to which ``body`` belongs."""
        while body in self._heads:
            body = self._heads[body]
        return body

    def unite(self, bodies: Iterable[pymunk.Body]) -> None:
        """Merge the groups of all ``bodies`` into one group, and add up their counts of impacts."""
        first, *others = dict.fromkeys(map(self.head, bodies))
        for each in others:
            self._heads[each] = first
            self.impacts[first] = self.impacts.get(first, 0) + self.impacts.pop(each, 0)


class ImpactSequence:
    """Resolves the impacts of an engine step one by one, after the step.

    Args:
        contacts: contacts of the step, divided into contacts at rest and impacts.
        report: function that is called with each impact faster than a contact at rest, or None.
        end: time of the end of the step.

    Attributes:
        struck: time from a body's last impact to the end of the step, for each body that an impact
            has moved.
    """

    def __init__(
        self, contacts: RestFilter, report: Callable[[LocatedImpact], None] | None, end: float
    ) -> None:
        self._filter = contacts
        self._motion = contacts.motion
        self._report = report
        self._end = end
        self._groups = Groups(contacts.at_rest + contacts.impacts)
        self._approaching: dict[TouchingPoint, None] = {}
        self.struck: dict[pymunk.Body, float] = {}

    def resolve(self) -> None:
        """Resolve all approaching contacts, also those that approach because of another impact."""
        groups = self._groups
        struck = [body for each in self._filter.impacts for body in each.bodies()]
        self._measure(groups.read(struck))
        while self._approaching:
            point = max(self._approaching, key=attrgetter("time", "approach"))
            head = groups.head(point.bodies[0])
            impacts = groups.impacts.get(head, 0)
            if point.impacts == COLLAPSE or impacts == MOST:
                self._strike_all(point)
            else:
                groups.impacts[head] = impacts + 1
                self._strike(point)

    def _measure(self, points: Iterable[TouchingPoint], since: float = 0.0) -> None:
        """Update the approach speeds of points, and the set of points that still approach.

        ``since`` is the time from the last change of velocities to the end of the step.
        """
        for point in points:
            point.measure(self._motion, since, self._latest(point))
            least = self._filter.resting if point.rests else 0.0
            if point.approach > max(least, APPROACH_ROUNDING * point.speed):
                self._approaching[point] = None
            else:
                self._approaching.pop(point, None)

    def _latest(self, point: TouchingPoint) -> float:
        """Return the time from the last impact of either body of a point to the end of the step.

        If neither body has had an impact, return the duration of the step.
        """
        return min(self.struck.get(body, self._motion.duration) for body in point.bodies)

    def _strike(self, point: TouchingPoint) -> None:
        """Resolve the impact at one point at the instant of its touch.

        If the point jams, no impulse at this point alone ends its approach. All contacts of the
        group are then resolved simultaneously.
        """
        point.impacts += 1
        motion = self._motion
        groups = self._groups
        connected = joined(point.bodies)
        bodies, joints = connected
        groups.unite(bodies)
        self._measure(groups.read(bodies))
        others = dict.fromkeys(
            [*point.bodies, *[end for joint in joints for end in (joint.a, joint.b)]]
        )
        moved = [*bodies, *[each for each in others if each.body_type == pymunk.Body.KINEMATIC]]
        point.go_back(motion, moved, self._latest(point))
        steps = motion.steps(point.time)
        motion.kick(bodies, -steps)
        if joints:
            close_joints(bodies, joints)
        space, impact, rests = self._impact(point, connected)
        space.apply((impact.impulse_normal, impact.impulse_tangential))
        motion.kick(bodies, steps)
        motion.drift(moved, point.time)
        if self._report is not None and not rests:
            self._report(point.located(impact, self._end))
        self.struck.update(dict.fromkeys(bodies, point.time))
        self._measure(
            dict.fromkeys(each for body in bodies for each in groups.points[body]), point.time
        )
        if impact.outcome == JAM:
            self._strike_all(point)

    def _strike_all(self, point: TouchingPoint) -> None:
        """Resolve all contacts of a point's group simultaneously, at the end of the step.

        The group includes bodies that are connected through other bodies.
        """
        groups = self._groups
        reached: dict[pymunk.Body, None] = {}
        waiting: Iterable[pymunk.Body] = point.bodies
        while new := [body for body in joined(waiting)[0] if body not in reached]:
            reached.update(dict.fromkeys(new))
            groups.read(new)
            waiting = [end for body in new for each in groups.points[body] for end in each.bodies]
        points = list(dict.fromkeys(each for body in reached for each in groups.points[body]))
        impacts = resolve_at_once(points, joined(reached), self._motion, self._filter.resting)
        self.struck.update(dict.fromkeys(reached, 0.0))
        for each, impact in zip(points, impacts, strict=True):
            self._approaching.pop(each, None)
            each.time = 0.0
            if self._report is not None and impact.impulse_normal > 0.0:
                self._report(each.located(impact, self._end))

    def _impact(
        self, point: TouchingPoint, connected: Connected
    ) -> tuple[ContactSpace, Impact, bool]:
        """Find by trial which joint limits push in an impact, and return the impact at a point.

        A joint limit that would pull transmits no impulse, unless the bodies would then pass it.

        Returns:
            The data of the contact.
            The impact.
            Whether the point approaches so slowly that its contact counts as at rest.
        """
        place, normal, _ = point.overlap
        released: set[pymunk.Constraint] = set()
        for _ in range(2 * len(connected[1]) + LIMIT_TRIALS):
            space = contact_space(
                point.bodies,
                place,
                normal,
                connected,
                surface_velocity=point.surface_velocity,
                released=released,
            )
            rests = -space.velocity[0] <= max(self._filter.resting, APPROACH_ROUNDING * point.speed)
            impact = point.pair.impact(
                space.inverse_mass, space.velocity, space.stick_compliance, rests=rests
            )
            wrong = space.wrong_limit((impact.impulse_normal, impact.impulse_tangential))
            if wrong is None:
                break
            released ^= {wrong}
        return space, impact, rests
