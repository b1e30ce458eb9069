"""Pairs of a link and what it can touch: the bar (a circle) and the workpart (a half-plane), as gaps and engine shapes.

A gap is the distance between the link's contact point and the obstacle; it is positive in flight. Engine shapes
of obstacles are larger than the obstacle by ``SHAPE_MARGIN``, and the engine's slop covers it, so that a sustained touch is
detected at every step while its position is left alone; only obstacles are enlarged, so that the lever of friction on
the link stays exact.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol

import pymunk

from bristle_sim.scene.contact.laws import ENERGETIC, ContactLaw
from bristle_sim.scene.mechanism import Pose, Vector

SHAPE_MARGIN = 0.02
"""Fraction of the link's length by which obstacle shapes are enlarged in the engine."""

SAME_GAP = 1e-9
"""Two pieces of a bent wire whose gaps differ by less than this fraction of its length both touch."""

LEAST_REACH = 1e-9
"""Least distance of the wire's centre line from the bar's centre, as a fraction of the link's length: a hundred times the
gap that counts as closed. Rounding of 1e-16 then turns the normal by 1e-7."""

HALF_PLANE = 1e3
"""Half width and depth of the workpart's shape, in link lengths: beyond any mechanism's reach."""


class ClosestApproach(NamedTuple):
    """Where and how a link is closest to an obstacle.

    Attributes:
        gap: distance, negative inside.
        arm: contact point seen from the link's joint, along world axes.
        normal: unit vector out of the obstacle.
        velocity: (normal, tangential) velocity of the link's contact point.
        kinks: the motion in sustained contact has a kink where one of these passes through 0: the contact leaves a straight
            piece of the centre line for a corner or the end, or comes back.
        piece: which straight piece of the centre line is closest, from 0 at the joint; of two wires, which of their four ends.
        partner_arm: contact point seen from the joint of the other wire's link; None on what is fixed.
    """

    gap: float
    arm: Vector
    normal: Vector
    velocity: Vector
    kinks: tuple[float, ...]
    piece: int = 0
    partner_arm: Vector | None = None

    @property
    def tangent(self) -> Vector:
        """The normal turned clockwise: +x on the workpart."""
        return (self.normal[1], -self.normal[0])


class Obstacle(Protocol):
    """A pair of a link and what it can touch, with what a scene needs of it."""

    @property
    def name(self) -> str:
        """What events and contact records call it."""

    @property
    def link(self) -> int:
        """Number of the link, from 0; the last one is also -1."""

    @property
    def partner(self) -> int | None:
        """Number of the other wire's link; None where it is fixed."""

    @property
    def friction(self) -> float:
        """Coulomb's mu, in compression and in sustained slip."""

    @property
    def restitution_friction(self) -> float:
        """Coulomb's mu in restitution."""

    @property
    def restitution(self) -> float:
        """Coefficient of restitution."""

    @property
    def law(self) -> ContactLaw:
        """Law of its impacts."""

    @property
    def first_touch(self) -> str:
        """Name of the event of a wire's first touch; later ones are named by the obstacle."""

    @property
    def dent(self) -> float:
        """Depth by which contacts resolved in time have moved its surface back."""

    @property
    def corner(self) -> int | None:
        """The corner of the link's centre line that touches, -1 for its tip; None where the contact slides along the link."""

    def closest(self, poses: Sequence[Pose], rates: Sequence[float], piece: int | None = None) -> ClosestApproach:
        """Return the closest approach of the links in given poses, or of one straight piece."""


class Held(NamedTuple):
    """A sustained contact: the pair, the straight piece of its link that touches, and the sense of slip, 0 in stick."""

    obstacle: Obstacle
    piece: int | None
    slip: int | None


_Closest = tuple[float, Vector, tuple[float, float]]


def _closest(centre: Vector, joint: Vector, start: Vector, end: Vector) -> _Closest:
    """Return a straight piece's squared distance from a point, closest point from the joint, and place past its ends."""
    along_x, along_y = end[0] - start[0], end[1] - start[1]
    to_x, to_y = centre[0] - start[0], centre[1] - start[1]
    along = (to_x * along_x + to_y * along_y) / (along_x**2 + along_y**2)
    within = min(max(along, 0.0), 1.0)
    x, y = start[0] + within * along_x, start[1] + within * along_y
    square = (x - centre[0]) ** 2 + (y - centre[1]) ** 2
    return square, (x - joint[0], y - joint[1]), (along, along - 1.0)


def _relative(pose: Pose, rate: float, arm: Vector, normal: Vector) -> Vector:
    x = pose.joint_velocity[0] - rate * arm[1]
    y = pose.joint_velocity[1] + rate * arm[0]
    return (x * normal[0] + y * normal[1], x * normal[1] - y * normal[0])


@dataclass(frozen=True, slots=True)
class BarObstacle:
    """Fixed circle that the wire touches: the wire's centre line keeps ``radius + wire_radius`` from ``centre``."""

    centre: Vector
    radius: float
    wire_radius: float
    friction: float
    restitution: float
    name: str = "bar"
    link: int = -1
    partner: None = None
    law: ContactLaw = ENERGETIC
    first_touch: str = "bar touch"
    dent: float = 0.0
    corner: None = None

    def __post_init__(self) -> None:
        """Refuse a bar so thin that rounding decides on which side of it the wire is."""
        reach = self.radius + self.wire_radius
        if not reach >= LEAST_REACH:
            raise ValueError(
                f"bar_radius + wire_diameter / 2 = {reach:.3g} of the bristle's length: must be at least"
                f" {LEAST_REACH:g} (dimensionless)"
            )

    @property
    def restitution_friction(self) -> float:
        """Friction in restitution is that in compression."""
        return self.friction

    def closest(self, poses: Sequence[Pose], rates: Sequence[float], piece: int | None = None) -> ClosestApproach:
        """Return the closest approach of the centre line (with a round end); the contact is on the wire's surface.

        Of two pieces that touch, the one that approaches faster counts, unless one is named.
        """
        pose, rate = poses[self.link], rates[self.link]
        if not pose.knees:
            found = _closest(self.centre, pose.joint, pose.joint, pose.tip)
            return self._approach(pose, rate, 0, found, found[2][1:])
        pieces = [_closest(self.centre, pose.joint, a, b) for a, b in itertools.pairwise(pose.corners)]
        kinks = tuple(kink for found in pieces for kink in found[2])[1:]
        touches = [self._approach(pose, rate, index, found, kinks) for index, found in enumerate(pieces)]
        if piece is not None:
            return touches[piece]
        least = min(touch.gap for touch in touches)
        return min((touch for touch in touches if touch.gap <= least + SAME_GAP), key=lambda touch: touch.velocity[0])

    def _approach(
        self, pose: Pose, rate: float, piece: int, found: _Closest, kinks: tuple[float, ...]
    ) -> ClosestApproach:
        square, arm, _ = found
        distance = math.sqrt(square)
        scale = distance or 1.0  # at the very centre no direction is the normal's
        x, y = pose.joint[0] + arm[0] - self.centre[0], pose.joint[1] + arm[1] - self.centre[1]
        normal = (x / scale, y / scale)
        arm = (arm[0] - self.wire_radius * normal[0], arm[1] - self.wire_radius * normal[1])
        gap = distance - self.radius - self.wire_radius + self.dent
        return ClosestApproach(gap, arm, normal, _relative(pose, rate, arm, normal), kinks, piece)

    def gap_beside(self, pose: Pose, piece: int) -> float:
        """Return the gap of the link's other pieces in whose elbow with this one the bar lies; infinite where there is none."""
        gaps = [math.inf]
        for index, (start, end) in enumerate(itertools.pairwise(pose.corners)):
            square, _, (past_start, past_end) = _closest(self.centre, pose.joint, start, end)
            at_shared_corner = past_end >= 0.0 if index < piece else past_start <= 0.0
            if index != piece and not at_shared_corner:
                gaps.append(math.sqrt(square) - self.radius - self.wire_radius + self.dent)
        return min(gaps)

    def foot(self, pose: Pose) -> tuple[float, float]:
        """Return the bar's centre along the first piece, past its start, and along the last, past its end, in their lengths."""
        corners = pose.corners
        first = _closest(self.centre, pose.joint, *corners[:2])[2][0]
        return first, _closest(self.centre, pose.joint, *corners[-2:])[2][1]

    def shapes(self, space: pymunk.Space, body: pymunk.Body, corners: Sequence[Vector]) -> list[pymunk.Shape]:
        """Return a circle, and the wire as segments with round ends."""
        bar = pymunk.Circle(space.static_body, self.radius + SHAPE_MARGIN, self.centre)
        pieces = itertools.pairwise(corners)
        return [bar, *(pymunk.Segment(body, start, end, self.wire_radius) for start, end in pieces)]


@dataclass(frozen=True, slots=True)
class WorkpartObstacle:
    """Half-plane y <= -depth that a corner of the link's centre line touches: its tip, or a knee by its number."""

    depth: float
    friction: float
    restitution_friction: float
    restitution: float
    name: str = "workpart"
    link: int = -1
    partner: None = None
    law: ContactLaw = ENERGETIC
    first_touch: str = "strike"
    dent: float = 0.0
    corner: int = -1

    def closest(self, poses: Sequence[Pose], rates: Sequence[float], piece: int | None = None) -> ClosestApproach:
        """Return the corner above the surface; normal +y, tangent +x."""
        del piece
        pose = poses[self.link]
        x, y = pose.tip if self.corner == -1 else pose.knees[self.corner]
        arm, normal = (x - pose.joint[0], y - pose.joint[1]), (0.0, 1.0)
        return ClosestApproach(
            y + self.depth + self.dent, arm, normal, _relative(pose, rates[self.link], arm, normal), ()
        )

    def shapes(self, space: pymunk.Space, body: pymunk.Body, corners: Sequence[Vector]) -> list[pymunk.Shape]:
        """Return a thick segment whose upper face is the surface, and the corner as a point."""
        middle = -self.depth - HALF_PLANE
        surface = pymunk.Segment(
            space.static_body, (-HALF_PLANE, middle), (HALF_PLANE, middle), HALF_PLANE + SHAPE_MARGIN
        )
        return [surface, pymunk.Circle(body, 0.0, corners[1:][self.corner])]


def dented(obstacle: Obstacle, depth: float) -> Obstacle:
    """Return a pair with its surface moved back by a depth."""
    moved: Obstacle = replace(obstacle, dent=depth)  # type: ignore[type-var]
    return moved
