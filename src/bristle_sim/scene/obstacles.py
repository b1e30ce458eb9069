"""What a link can touch: the bar (a circle) and the workpart (a half-plane), as gap functions and as engine shapes.

A gap is the distance between the last link's contact point and the obstacle; it is positive in flight. Engine shapes
of obstacles are larger than the obstacle by ``MARGIN``, and the engine's slop covers it, so that a sustained touch is
detected at every step while its position is left alone; only obstacles are enlarged, so that the lever of friction on
the link stays exact.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import pymunk

from bristle_sim.scene.mechanism import Pose, Vector

__all__ = ["MARGIN", "BarObstacle", "Obstacle", "Touch", "WorkpartObstacle"]

MARGIN = 0.02
"""Share of the link's length by which obstacle shapes are enlarged in the engine."""

HALF_PLANE = 1e3
"""Half width and depth of the workpart's shape, in link lengths: beyond any mechanism's reach."""


@dataclass(frozen=True, slots=True)
class Touch:
    """Where and how a link meets an obstacle.

    Attributes:
        gap: distance, negative inside.
        arm: contact point seen from the link's joint, along world axes.
        normal: unit vector out of the obstacle.
        velocity: (normal, tangential) velocity of the link's contact point.
        end: signed distance along the link by which the contact is past the link's end; a kink where it is 0.
    """

    gap: float
    arm: Vector
    normal: Vector
    velocity: Vector
    end: float

    @property
    def tangent(self) -> Vector:
        """The normal turned clockwise: +x on the workpart."""
        return (self.normal[1], -self.normal[0])


class Obstacle(Protocol):
    """What a scene needs of an obstacle."""

    @property
    def name(self) -> str:
        """What events and ledger call it."""

    @property
    def friction(self) -> float:
        """Coulomb's mu, in compression and in sustained slip."""

    @property
    def restitution_friction(self) -> float:
        """Coulomb's mu in restitution."""

    @property
    def restitution(self) -> float:
        """Coefficient of restitution."""

    def touch(self, pose: Pose, rate: float) -> Touch:
        """The closest approach of a link in the given pose."""

    def shapes(self, space: pymunk.Space, body: pymunk.Body, tip: Vector) -> tuple[pymunk.Shape, pymunk.Shape]:
        """Engine shapes: the obstacle's on the static body, the link's on the body whose tip is given."""


def _relative(pose: Pose, rate: float, arm: Vector, normal: Vector) -> Vector:
    x = pose.joint_velocity[0] - rate * arm[1]
    y = pose.joint_velocity[1] + rate * arm[0]
    return (x * normal[0] + y * normal[1], x * normal[1] - y * normal[0])


@dataclass(frozen=True, slots=True)
class BarObstacle:
    """Fixed circle that holds the wire: the wire's centre line keeps ``radius + wire_radius`` from ``centre``."""

    centre: Vector
    radius: float
    wire_radius: float
    friction: float
    restitution: float
    name: str = "bar"

    @property
    def restitution_friction(self) -> float:
        """The same friction in both phases."""
        return self.friction

    def touch(self, pose: Pose, rate: float) -> Touch:
        """The closest approach; the contact is on the wire's surface."""
        share, end, x, y = self._closest(pose)
        distance = math.hypot(x, y) or 1.0
        normal = (x / distance, y / distance)
        wire = (pose.tip[0] - pose.joint[0], pose.tip[1] - pose.joint[1])
        arm = (share * wire[0] - self.wire_radius * normal[0], share * wire[1] - self.wire_radius * normal[1])
        gap = distance - self.radius - self.wire_radius
        return Touch(gap, arm, normal, _relative(pose, rate, arm, normal), end)

    def _closest(self, pose: Pose) -> tuple[float, float, float, float]:
        """Share of the wire at the closest point, distance past its end, and the vector from the bar's centre."""
        wire_x, wire_y = pose.tip[0] - pose.joint[0], pose.tip[1] - pose.joint[1]
        to_x, to_y = self.centre[0] - pose.joint[0], self.centre[1] - pose.joint[1]
        square = wire_x**2 + wire_y**2
        share = (to_x * wire_x + to_y * wire_y) / square
        held = min(max(share, 0.0), 1.0)
        return held, (share - 1.0) * math.sqrt(square), held * wire_x - to_x, held * wire_y - to_y

    def shapes(self, space: pymunk.Space, body: pymunk.Body, tip: Vector) -> tuple[pymunk.Shape, pymunk.Shape]:
        """A circle, and the wire as a segment with round ends."""
        bar = pymunk.Circle(space.static_body, self.radius + MARGIN, self.centre)
        root = (-tip[0], -tip[1])
        return bar, pymunk.Segment(body, root, tip, self.wire_radius)


@dataclass(frozen=True, slots=True)
class WorkpartObstacle:
    """Half-plane y <= -depth that the link's tip strikes."""

    depth: float
    friction: float
    restitution_friction: float
    restitution: float
    name: str = "workpart"

    def touch(self, pose: Pose, rate: float) -> Touch:
        """The tip above the surface; normal +y, tangent +x."""
        arm = (pose.tip[0] - pose.joint[0], pose.tip[1] - pose.joint[1])
        normal = (0.0, 1.0)
        return Touch(pose.tip[1] + self.depth, arm, normal, _relative(pose, rate, arm, normal), 1.0)

    def shapes(self, space: pymunk.Space, body: pymunk.Body, tip: Vector) -> tuple[pymunk.Shape, pymunk.Shape]:
        """A thick segment whose upper face is the surface, and the tip as a point."""
        middle = -self.depth - HALF_PLANE
        surface = pymunk.Segment(space.static_body, (-HALF_PLANE, middle), (HALF_PLANE, middle), HALF_PLANE + MARGIN)
        return surface, pymunk.Circle(body, 0.0, tip)
