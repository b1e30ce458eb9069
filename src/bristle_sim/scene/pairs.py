"""Pairs of a link and an obstacle that can touch, with their gaps and relative velocities.

The obstacle is the bar (a circle), the workpart (a half-plane) or a link of another wire (a
rectangle with round ends). A gap is the distance between the link and the obstacle; it is positive
in flight. Points and vectors are complex numbers x + iy.
"""

from __future__ import annotations

import itertools
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import ClassVar, NamedTuple

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.scene.mechanism import Complexes, Mechanism, Pose, State, Vector

# Largest difference of the gaps of two straight segments of a link that both count as touching, as
# a fraction of the link's length.
SAME_GAP = 1e-9

LEAST_REACH = 1e-9
"""Least sum of the radii of bar and wire, as a fraction of the link's length. At this distance
between the bar's centre and the wire's centre line, a rounding error of 1e-16 turns the normal by
1e-7 rad. The distance is a hundred times the gap that counts as closed."""


class ClosestApproach(NamedTuple):
    """The contact point of a link, which is its point closest to an obstacle; engine units.

    Attributes:
        gap: distance of link and obstacle; negative if they overlap.
        arm: vector from the link's joint to the contact point, along world axes.
        normal: unit vector out of the obstacle. The tangent is the normal turned clockwise by 90
            degrees, which is +x on the workpart.
        velocity: (normal, tangential) velocity of the link's contact point relative to the
            obstacle.
        piece: index of the closest straight segment of the centre line, from 0 at the joint; 0 for
            two wires.
        partner_arm: vector from the joint of the other wire's link to the contact point; None for a
            fixed obstacle.
    """

    gap: float
    arm: complex
    normal: complex
    velocity: Vector
    piece: int = 0
    partner_arm: complex | None = None


@dataclass(slots=True, eq=False)
class ClosedPair:
    """A closed contact.

    Attributes:
        pair: the link and the obstacle.
        piece: index of the link's straight segment in contact with the bar; None for the closest
            segment.
        slip: sense of slip, +1 or -1; 0 in stick; None without friction, or if it is unknown.
    """

    pair: ContactPair
    piece: int | None = None
    slip: int | None = None


Line = tuple[complex, complex]
"""A straight segment of a wire's centre line: its two ends."""


SAME_FRICTION = property(attrgetter("friction"))
"""Property of a pair: its coefficient of friction in restitution, equal to that in compression."""


class FixedPair(ABC):
    """Base class of the pairs whose obstacle is fixed: the bar or the workpart."""

    link: int
    partner: ClassVar[None] = None

    @abstractmethod
    def lines(self, corners: tuple[complex, ...]) -> list[Line]:
        """Return the straight segments of a link that can touch the obstacle.

        ``corners`` are the positions of the link's joint, knees and tip.
        """

    @abstractmethod
    def touch(self, start: complex, end: complex) -> tuple[float, complex, complex]:
        """Return gap, contact point and normal for the segment from ``start`` to ``end``."""

    def closest(
        self, poses: Sequence[Pose], rates: Sequence[float], piece: int | None = None
    ) -> ClosestApproach:
        """Return the closest approach of the link.

        Of two equally close segments the one that approaches faster is taken.

        Args:
            poses: positions and joint velocities of all links.
            rates: angular velocities of all links.
            piece: index of a segment; the closest approach of this segment is then returned.
        """
        joint, carried, _, corners = poses[self.link]
        spin = 1j * rates[self.link]
        touches = []
        for index, (start, end) in enumerate(self.lines(corners)):
            gap, point, normal = self.touch(start, end)
            arm = point - joint
            turned = (carried + spin * arm) * normal.conjugate()
            velocity = (turned.real, -turned.imag)
            touches.append(ClosestApproach(gap, arm, normal, velocity, index))
        if piece is not None or len(touches) == 1:
            return touches[piece or 0]
        least = min(touch.gap for touch in touches)
        return min(
            (touch for touch in touches if touch.gap <= least + SAME_GAP),
            key=lambda touch: touch.velocity[0],
        )


@dataclass(frozen=True, slots=True, eq=False)
class BarPair(FixedPair):
    """A pair of the bar, which is a fixed circle, and one link of the wire.

    The link touches the bar if its centre line is at the distance ``radius + wire_radius`` from
    ``centre``. The attributes from ``friction`` on are common to all pairs.

    Attributes:
        centre: centre of the bar.
        radius: radius of the bar.
        wire_radius: radius of the wire.
        friction: Coulomb's coefficient of friction mu.
        restitution: coefficient of restitution e*.
        name: name of the obstacle in events and contact records.
        link: index of the link; -1 is the last link.
        partner: index of the other wire's link; None for a fixed obstacle.
        dent: depth of the dent, the indentation that an earlier compliant contact has left in the
            surface.
    """

    centre: complex
    radius: float
    wire_radius: float
    friction: float
    restitution: float
    name: ClassVar[str] = "bar"
    link: int = -1
    dent: float = 0.0
    restitution_friction = SAME_FRICTION

    def __post_init__(self) -> None:
        """Refuse a bar so thin that rounding errors could put the wire on its other side."""
        reach = self.radius + self.wire_radius
        if not reach >= LEAST_REACH:
            raise ValueError(
                f"bar_radius + wire_diameter / 2 = {reach:.3g} of the bristle's length: must be at least"
                f" {LEAST_REACH:g} (dimensionless)"
            )

    def lines(self, corners: tuple[complex, ...]) -> list[Line]:
        """Return all straight segments of the link."""
        return [*itertools.pairwise(corners)]

    def touch(self, start: complex, end: complex) -> tuple[float, complex, complex]:
        """Return gap, contact point and normal of a straight segment.

        The segment has round ends; the contact point is on the segment's surface.
        """
        centre = self.centre
        span = end - start
        along = ((centre - start) / span).real
        place = start + along * span if 0.0 < along < 1.0 else start if along <= 0.0 else end
        away = place - centre
        distance = abs(away)
        normal = away / (distance or 1.0)  # at the centre the normal is undefined
        thickness = self.wire_radius
        return distance - self.radius - thickness + self.dent, place - thickness * normal, normal

    def ends_passed(self, pose: Pose) -> list[float]:
        """Return the distances by which the bar's centre is past the ends of each straight segment.

        They are measured along the segment, in lengths of the segment: past its start, then past
            its end. The segment at the joint comes first. Where a distance is 0, the contact point
            passes a joint, a knee or the tip.
        """
        lines = self.lines(pose.corners)
        feet = [((self.centre - start) / (end - start)).real for start, end in lines]
        return [distance for foot in feet for distance in (foot, foot - 1.0)]

    def gap_beside(self, pose: Pose, piece: int) -> float:
        """Return the smallest gap between the bar and the link's segments that do not touch yet.

        Segment ``piece`` touches. A segment does not count if its closest point is its end towards
        segment ``piece``. If no segment counts, the gap is infinite.
        """
        gaps = [math.inf]
        ends = self.ends_passed(pose)
        for index, line in enumerate(self.lines(pose.corners)):
            beside = ends[2 * index + 1] < 0.0 if index < piece else ends[2 * index] > 0.0
            if beside and index != piece:
                gaps.append(self.touch(*line)[0])
        return min(gaps)


@dataclass(frozen=True, slots=True, eq=False)
class WorkpartPair(FixedPair):
    """A pair of the workpart, the half-plane y <= -depth, and the tip or a knee of a link.

    Attributes:
        depth: distance of the workpart's surface from the origin.
        restitution_friction: coefficient of friction in restitution.
        corner: index of the corner of the link's centre line that can touch; -1 for the tip.

    The other attributes are those of ``BarPair``.
    """

    depth: float
    friction: float
    restitution_friction: float
    restitution: float
    name: ClassVar[str] = "workpart"
    link: int = -1
    dent: float = 0.0
    corner: int = -1

    def lines(self, corners: tuple[complex, ...]) -> list[Line]:
        """Return a list of one segment, from the link's joint to the corner that can touch."""
        return [(corners[0], corners[self.corner])]

    def touch(self, _: complex, end: complex) -> tuple[float, complex, complex]:
        """Return the gap of the corner ``end``, then the corner itself, then the normal (+y)."""
        return end.imag + self.depth + self.dent, end, 1j


@dataclass(frozen=True, slots=True, eq=False)
class WirePair:
    """A pair of a corner of one wire and a straight segment of another wire.

    The corner is a root, a knee, a joint between two links or a tip. At least one of the two points
    at which wires touch is a corner. The normal points from the segment to the corner.

    Attributes:
        link: index of the corner's link. A joint belongs to the link nearer to the root.
        corner: index of the corner in the centre line of ``link``; 0 is a root.
        partner: index of the other wire's link.
        segment: index of the straight segment in ``partner``.
        wire_radius: radius of both wires.

    The other attributes are those of ``BarPair``.
    """

    link: int
    corner: int
    partner: int
    segment: int
    wire_radius: float
    friction: float
    restitution: float
    name: ClassVar[str] = "wire"
    dent: float = 0.0
    restitution_friction = SAME_FRICTION

    def closest(
        self, poses: Sequence[Pose], rates: Sequence[float], _: int | None = None
    ) -> ClosestApproach:
        """Return the closest approach of corner and segment."""
        pose = poses[self.link]
        partner = poses[self.partner]
        corner = pose.corners[self.corner]
        start, end = partner.corners[self.segment : self.segment + 2]
        apart = corner - start - min(max(self.foot(poses), 0.0), 1.0) * (end - start)
        distance = abs(apart)
        normal = apart / (distance or 1.0)  # undefined where centre lines meet
        point = corner - self.wire_radius * normal
        arm = point - pose.joint
        partner_arm = point - partner.joint
        velocity = pose.velocity + 1j * rates[self.link] * arm
        velocity -= partner.velocity + 1j * rates[self.partner] * partner_arm
        velocity *= normal.conjugate()
        gap = distance - 2.0 * self.wire_radius + self.dent
        components = (velocity.real, -velocity.imag)
        return ClosestApproach(gap, arm, normal, components, 0, partner_arm)

    def foot(self, poses: Sequence[Pose]) -> float:
        """Return how far along the segment the corner is: 0 at the segment's start, 1 at its end."""
        start, end = poses[self.partner].corners[self.segment : self.segment + 2]
        return ((poses[self.link].corners[self.corner] - start) / (end - start)).real


ContactPair = BarPair | WorkpartPair | WirePair
"""A link and an obstacle that can touch."""

Closest = Callable[[ContactPair, State], ClosestApproach]
"""Function that returns the closest approach of a pair in a state."""


def contact_rows(
    mechanism: Mechanism,
    turn: Complexes,
    pairs: Sequence[ContactPair],
    touches: Sequence[ClosestApproach],
) -> Array:
    """Return the Jacobian of the contact points' velocities in the links' angular velocities.

    It has one column for each link: first a row for the normal velocity of each pair, then a row
    for each tangential velocity. The normal n points from the obstacle to the wire. With an arm r,
    a link's entry is Re(i conj(n) r) in a normal row and -Im(i conj(n) r) in a tangential row. The
    arm of the touching link is the vector from its joint to the contact point, that of the links
    before it the vector from joint to tip. An obstacle that is a wire has the opposite signs.

    Args:
        mechanism: the mechanism.
        turn: e^{i angle} of each link.
        pairs: the pairs in contact.
        touches: closest approach of each pair.
    """
    rows = np.zeros((len(pairs), len(turn)), complex)
    for row, pair, touch in zip(rows, pairs, touches, strict=True):
        across = 1j * touch.normal.conjugate()
        for link, arm, factor in (
            (pair.link, touch.arm, across),
            (pair.partner, touch.partner_arm, -across),
        ):
            if link is not None and arm is not None:
                first = link - link % mechanism.wire_links
                if first != link:
                    carriers = slice(first, link)
                    row[carriers] += factor * mechanism.tips[carriers] * turn[carriers]
                row[link] += factor * arm
    return np.concatenate([rows.real, -rows.imag])
