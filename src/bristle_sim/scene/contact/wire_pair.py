"""Pairs of links of two wires: capsules, of which the end of one touches the other's flank or end."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from bristle_sim.scene.contact.laws import ENERGETIC, ContactLaw
from bristle_sim.scene.contact.obstacles import ClosestApproach
from bristle_sim.scene.mechanism import Mechanism, Pose, Vector, cross

Line = tuple[Vector, Vector]


@dataclass(frozen=True, slots=True)
class WirePair:
    """A straight piece of a link and one of a link of another wire, ``partner``; both have the radius ``wire_radius``.

    The normal points from the partner to the link. A touch's ``piece`` tells which end touches: 0 and 1 are the start and the
    end of the link's own piece, 2 and 3 those of the partner's.
    """

    link: int
    own_piece: int
    partner: int
    partner_piece: int
    wire_radius: float
    friction: float
    restitution: float
    name: str = "wire"
    law: ContactLaw = ENERGETIC
    first_touch: str = "wire touch"
    dent: float = 0.0
    corner: None = None

    @property
    def restitution_friction(self) -> float:
        """Friction in restitution is that in compression."""
        return self.friction

    def closest(self, poses: Sequence[Pose], rates: Sequence[float], piece: int | None = None) -> ClosestApproach:
        """Return the closest approach of the two pieces, or of one named end and the other piece."""
        own, other = _piece(poses[self.link], self.own_piece), _piece(poses[self.partner], self.partner_piece)
        found = [_nearest(own, other, each) for each in (range(4) if piece is None else (piece,))]
        ends = min(found, key=lambda each: math.dist(*each))
        piece = found.index(ends) if piece is None else piece
        (x, y), (u, v) = ends
        distance = math.dist(*ends)
        scale = distance or 1.0  # where centre lines meet no direction is the normal's
        normal = ((x - u) / scale, (y - v) / scale)
        point = (x - self.wire_radius * normal[0], y - self.wire_radius * normal[1])
        arms = [
            (point[0] - poses[link].joint[0], point[1] - poses[link].joint[1]) for link in (self.link, self.partner)
        ]
        parts = zip((self.link, self.partner), arms, (1.0, -1.0), strict=True)
        velocity = [0.0, 0.0]
        for link, arm, sign in parts:
            moving = (
                poses[link].joint_velocity[0] - rates[link] * arm[1],
                poses[link].joint_velocity[1] + rates[link] * arm[0],
            )
            velocity[0] += sign * (moving[0] * normal[0] + moving[1] * normal[1])
            velocity[1] += sign * (moving[0] * normal[1] - moving[1] * normal[0])
        gap = (-1.0 if _crossed(own, other) else 1.0) * distance - 2.0 * self.wire_radius + self.dent
        return ClosestApproach(gap, arms[0], normal, (velocity[0], velocity[1]), (), piece, arms[1])


def wire_pairs(mechanism: Mechanism, wire_radius: float, friction: float, restitution: float) -> Iterator[WirePair]:
    """Yield every pair of straight pieces of links of two wires."""
    numbered = [(link, piece) for link, each in enumerate(mechanism.links) for piece in range(len(each.knees) + 1)]
    for (link, own), (partner, other) in itertools.combinations(numbered, 2):
        if link // mechanism.wire_links != partner // mechanism.wire_links:
            yield WirePair(link, own, partner, other, wire_radius, friction, restitution)


def _piece(pose: Pose, number: int) -> Line:
    if not pose.knees:
        return pose.joint, pose.tip
    return pose.corners[number], pose.corners[number + 1]


def _nearest(own: Line, other: Line, piece: int) -> tuple[Vector, Vector]:
    """Return an end of one piece and its foot on the other, the own piece's point first."""
    if piece < 2:
        return own[piece], _foot(own[piece], other)
    return _foot(other[piece - 2], own), other[piece - 2]


def _foot(point: Vector, line: Line) -> Vector:
    (x, y), (u, v) = line
    along = (u - x, v - y)
    fraction = ((point[0] - x) * along[0] + (point[1] - y) * along[1]) / (along[0] ** 2 + along[1] ** 2)
    fraction = min(max(fraction, 0.0), 1.0)
    return x + fraction * along[0], y + fraction * along[1]


def _crossed(first: Line, second: Line) -> bool:
    """Whether two straight pieces cross."""

    def sides(line: Line, points: Line) -> float:
        """Return a number that is negative if the points lie on different sides of the line."""
        along = (line[1][0] - line[0][0], line[1][1] - line[0][1])
        one, other = (cross(along, (each[0] - line[0][0], each[1] - line[0][1])) for each in points)
        return one * other

    return sides(first, second) < 0.0 and sides(second, first) < 0.0
