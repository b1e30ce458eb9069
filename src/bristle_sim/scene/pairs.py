"""Pairs of a link and an obstacle: the bar (a circle), the workpart (a half-plane) or a link of
another wire (a rectangle with round ends).

A gap is the distance between the link's contact point and the obstacle; it is positive in flight.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

from bristle_sim.scene.mechanism import Mechanism, Pose, Vector, cross

# largest difference between the gaps of two straight segments of a link that both count as
# touching, over the link's length
SAME_GAP = 1e-9

LEAST_REACH = 1e-9
"""Least distance of the wire's centre line from the bar's centre, over the link's length. It is a
hundred times the gap that counts as closed, so a rounding error of 1e-16 turns the normal by 1e-7.
"""

Line = tuple[Vector, ...]
"""A straight segment of a wire's centre line: its two ends."""


class ClosestApproach(NamedTuple):
    """The points at which a link and an obstacle are closest, and their relative motion; engine
    units.

    Attributes:
        gap: distance, negative inside the obstacle.
        arm: vector from the link's joint to the contact point, along world axes.
        normal: unit vector out of the obstacle.
        velocity: (normal, tangential) velocity of the link's contact point relative to the
            obstacle.
        kinks: values that pass through 0 where the motion of a sustained contact has a kink,
            because the contact passes from a straight segment of the centre line to a corner or the
            end, or back.
        piece: index of the closest straight segment of the centre line, from 0 at the joint. For
            two wires it is the index of the closest of the four ends of their segments.
        partner_arm: vector from the joint of the other wire's link to the contact point; None for a
            fixed obstacle.
    """

    gap: float
    arm: Vector
    normal: Vector
    velocity: Vector
    kinks: tuple[float, ...] = ()
    piece: int = 0
    partner_arm: Vector | None = None

    @property
    def tangent(self) -> Vector:
        """Unit tangent: the normal turned clockwise by 90 degrees, which is +x on the workpart."""
        return (self.normal[1], -self.normal[0])


class ClosedPair(NamedTuple):
    """A closed contact.

    Attributes:
        pair: the link and the obstacle.
        piece: index of the touching straight segment of the link; None for the closest segment.
        slip: sense of slip, +1 or -1; 0 in stick; None without friction.
    """

    pair: ContactPair
    piece: int | None
    slip: int | None


def _foot(point: Vector, line: Line) -> tuple[float, Vector]:
    """Return the projection of a point onto a segment, and the point of the segment nearest to the
    point.

    The projection is in segment lengths: 0 at the start, 1 at the end, and beyond these outside the
    segment.
    """
    (x, y), (u, v) = line
    along_x, along_y = u - x, v - y
    along = ((point[0] - x) * along_x + (point[1] - y) * along_y) / (along_x**2 + along_y**2)
    within = min(max(along, 0.0), 1.0)
    return along, (x + within * along_x, y + within * along_y)


def _relative(pose: Pose, rate: float, arm: Vector, normal: Vector) -> Vector:
    """Return the (normal, tangential) velocity of a point of a link, given by ``arm`` from the
    link's joint.
    """
    x = pose.joint_velocity[0] - rate * arm[1]
    y = pose.joint_velocity[1] + rate * arm[0]
    return (x * normal[0] + y * normal[1], x * normal[1] - y * normal[0])


@dataclass(frozen=True, slots=True)
class BarPair:
    """A pair of the bar, which is a fixed circle, and one link of the wire.

    The link's centre line stays at least ``radius + wire_radius`` from the circle's ``centre``. The
    attributes from ``friction`` on are common to all pairs.

    Attributes:
        centre: centre of the bar.
        radius: radius of the bar.
        wire_radius: radius of the wire.
        friction: Coulomb's coefficient of friction mu.
        restitution: coefficient of restitution e*.
        name: name of the obstacle in events and contact records.
        link: index of the link; -1 is the last link.
        partner: index of the other wire's link; None for a fixed obstacle.
        first_touch: name of the event of a first touch.
        dent: depth by which an earlier compliant contact has moved the surface back.
        corner: index of the corner of the centre line that touches, -1 for the tip; None where the
            contact slides along the link.
    """

    centre: Vector
    radius: float
    wire_radius: float
    friction: float
    restitution: float
    name: ClassVar[str] = "bar"
    link: int = -1
    partner: ClassVar[None] = None
    first_touch: ClassVar[str] = "bar touch"
    dent: float = 0.0
    corner: ClassVar[None] = None

    def __post_init__(self) -> None:
        """Check that the bar is so thick that rounding errors cannot put the wire on its other side.

        Raises:
            ValueError: if it is too thin.
        """
        reach = self.radius + self.wire_radius
        if not reach >= LEAST_REACH:
            raise ValueError(
                f"bar_radius + wire_diameter / 2 = {reach:.3g} of the bristle's length: must be at least"
                f" {LEAST_REACH:g} (dimensionless)"
            )

    @property
    def restitution_friction(self) -> float:
        """Coefficient of friction in restitution; it equals the coefficient in compression."""
        return self.friction

    def closest(
        self, poses: Sequence[Pose], rates: Sequence[float], piece: int | None = None
    ) -> ClosestApproach:
        """Return the closest approach of the link's centre line, which has round ends; the contact
        point is on the wire's surface.

        If two straight segments touch, the segment that approaches faster is used. ``piece``
        selects a segment by index instead.
        """
        pose = poses[self.link]
        rate = rates[self.link]
        if not pose.knees:
            along, place = _foot(self.centre, (pose.joint, pose.tip))
            return self._approach(pose, rate, 0, place, (along - 1.0,))
        pieces = [_foot(self.centre, line) for line in itertools.pairwise(pose.corners)]
        kinks = tuple(kink for along, _ in pieces for kink in (along, along - 1.0))[1:]
        touches = [
            self._approach(pose, rate, index, place, kinks)
            for index, (_, place) in enumerate(pieces)
        ]
        if piece is not None:
            return touches[piece]
        least = min(touch.gap for touch in touches)
        return min(
            (touch for touch in touches if touch.gap <= least + SAME_GAP),
            key=lambda touch: touch.velocity[0],
        )

    def _approach(
        self, pose: Pose, rate: float, piece: int, place: Vector, kinks: tuple[float, ...]
    ) -> ClosestApproach:
        x, y = place[0] - self.centre[0], place[1] - self.centre[1]
        distance = math.hypot(x, y)
        scale = distance or 1.0  # at the centre the normal is undefined
        normal = (x / scale, y / scale)
        arm = (
            place[0] - pose.joint[0] - self.wire_radius * normal[0],
            place[1] - pose.joint[1] - self.wire_radius * normal[1],
        )
        gap = distance - self.radius - self.wire_radius + self.dent
        return ClosestApproach(gap, arm, normal, _relative(pose, rate, arm, normal), kinks, piece)

    def gap_beside(self, pose: Pose, piece: int) -> float:
        """Return the smallest gap between the bar and any other straight segment of the link.

        ``piece`` is the index of the segment that already touches. A segment whose closest point is
        its corner towards ``piece`` is left out. Without another segment the gap is infinite.
        """
        gaps = [math.inf]
        for index, line in enumerate(itertools.pairwise(pose.corners)):
            along, place = _foot(self.centre, line)
            at_shared_corner = along >= 1.0 if index < piece else along <= 0.0
            if index != piece and not at_shared_corner:
                gaps.append(
                    math.dist(place, self.centre) - self.radius - self.wire_radius + self.dent
                )
        return min(gaps)

    def foot(self, pose: Pose) -> tuple[float, float]:
        """Return the position of the bar's centre along the first straight segment of the link, and
        along the last one.

        The first position is measured from the segment's start, the second from the segment's end.
        Each is in lengths of its segment.
        """
        corners = pose.corners
        return _foot(self.centre, corners[:2])[0], _foot(self.centre, corners[-2:])[0] - 1.0


@dataclass(frozen=True, slots=True)
class WorkpartPair:
    """The workpart, a half-plane y <= -depth, and a corner of the link's centre line: its tip, or a
    knee.

    ``corner`` is -1 for the tip, or the index of a knee. The other attributes are those of
    ``BarPair``.
    """

    depth: float
    friction: float
    restitution_friction: float
    restitution: float
    name: ClassVar[str] = "workpart"
    link: int = -1
    partner: ClassVar[None] = None
    first_touch: ClassVar[str] = "strike"
    dent: float = 0.0
    corner: int = -1

    def closest(
        self, poses: Sequence[Pose], rates: Sequence[float], piece: int | None = None
    ) -> ClosestApproach:
        """Return the closest approach of the corner. The normal is +y and the tangent +x; ``piece``
        has no effect.
        """
        del piece
        pose = poses[self.link]
        x, y = pose.tip if self.corner == -1 else pose.knees[self.corner]
        arm = (x - pose.joint[0], y - pose.joint[1])
        normal = (0.0, 1.0)
        velocity = _relative(pose, rates[self.link], arm, normal)
        return ClosestApproach(y + self.depth + self.dent, arm, normal, velocity)


@dataclass(frozen=True, slots=True)
class WirePair:
    """Two straight segments of links of different wires; an end of one segment touches the other
    segment.

    The normal points from the other wire's link, ``partner``, to the link. The ``piece`` of a
    closest approach is the index of the end that touches: 0 and 1 are the start and the end of the
    link's own segment, 2 and 3 those of the partner's segment.

    Attributes:
        own_piece: index of the straight segment in the link.
        partner_piece: index of the straight segment in the partner.
        wire_radius: radius of both wires.

    The other attributes are those of ``BarPair``.
    """

    link: int
    own_piece: int
    partner: int
    partner_piece: int
    wire_radius: float
    friction: float
    restitution: float
    name: ClassVar[str] = "wire"
    first_touch: ClassVar[str] = "wire touch"
    dent: float = 0.0
    corner: ClassVar[None] = None

    @property
    def restitution_friction(self) -> float:
        """Coefficient of friction in restitution; it equals the coefficient in compression."""
        return self.friction

    def closest(
        self, poses: Sequence[Pose], rates: Sequence[float], piece: int | None = None
    ) -> ClosestApproach:
        """Return the closest approach of the two segments. If ``piece`` is given, return the
        closest approach of the end with this index to the other segment.
        """
        links = (self.link, self.partner)
        own, other = (
            poses[link].corners[number : number + 2]
            for link, number in zip(links, (self.own_piece, self.partner_piece), strict=True)
        )
        found = [(end, _foot(end, other)[1]) for end in own] + [
            (_foot(end, own)[1], end) for end in other
        ]
        if piece is None:
            piece = min(range(4), key=lambda end: math.dist(*found[end]))
        (x, y), (u, v) = found[piece]
        distance = math.hypot(x - u, y - v)
        scale = distance or 1.0  # where centre lines meet the normal is undefined
        normal = ((x - u) / scale, (y - v) / scale)
        x, y = x - self.wire_radius * normal[0], y - self.wire_radius * normal[1]
        arms = [(x - poses[link].joint[0], y - poses[link].joint[1]) for link in links]
        first, second = (
            _relative(poses[link], rates[link], arm, normal)
            for link, arm in zip(links, arms, strict=True)
        )
        crossed = _sides(own, other) < 0.0 and _sides(other, own) < 0.0
        gap = (-distance if crossed else distance) - 2.0 * self.wire_radius + self.dent
        velocity = (first[0] - second[0], first[1] - second[1])
        return ClosestApproach(gap, arms[0], normal, velocity, (), piece, arms[1])


def _sides(line: Line, points: Line) -> float:
    """Return a number that is negative if the two points lie on different sides of the infinite
    line.
    """
    (x, y), (u, v) = line
    one, other = (cross((u - x, v - y), (each[0] - x, each[1] - y)) for each in points)
    return one * other


ContactPair = BarPair | WorkpartPair | WirePair
"""A link and an obstacle that can touch."""


def wire_pairs(
    mechanism: Mechanism, wire_radius: float, friction: float, restitution: float
) -> Iterator[WirePair]:
    """Yield a pair for every two straight segments of links of different wires."""
    numbered = [
        (link, piece)
        for link, each in enumerate(mechanism.links)
        for piece in range(len(each.knees) + 1)
    ]
    for (link, own), (partner, other) in itertools.combinations(numbered, 2):
        if link // mechanism.wire_links != partner // mechanism.wire_links:
            yield WirePair(link, own, partner, other, wire_radius, friction, restitution)
