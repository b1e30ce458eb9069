"""What the bristle can touch: the bar (a circle) and the workpart (a half-plane), both at rest."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from bristle_sim.parameters import Tool
from bristle_sim.reference.bar import Circle
from bristle_sim.reference.mechanics import Mechanics, Number
from bristle_sim.reference.touch import Touch, centripetal, contact

__all__ = ["HalfPlane", "Obstacle", "obstacles_of"]


class Obstacle(Protocol):
    """An obstacle's geometry, in (alpha, psi), and its surface."""

    @property
    def name(self) -> str:
        """``bar`` or ``workpart``."""

    @property
    def friction(self) -> float:
        """Coulomb's mu, in compression and in sustained touch."""

    @property
    def friction_in_restitution(self) -> float:
        """Coulomb's mu in restitution."""

    @property
    def restitution(self) -> float:
        """Energetic coefficient e*."""

    def gap(self, angle: Number, hub_angle: Number) -> Number:
        """Distance of the wire's centre line from touching, m; negative inside."""

    def touch(self, angle: Number, rate: Number, hub_angle: Number) -> Touch:
        """Kinematics of the point nearest to the obstacle."""

    def parts(self, side: float) -> tuple[Obstacle, ...]:
        """What can be touched on one side, apart where the motion from one to the other is a blow."""

    def held_angle(self, hub_angle: Number, side: float) -> Number:
        """Relative angle alpha that touches at a hub angle, rad; ``side`` is the sign of J_n there."""

    def within_reach(self, hub_angle: Number) -> Number:
        """Positive where some bristle angle touches, m."""

    def seams(self, side: float) -> list[Callable[[Number], Number]]:
        """Functions of the hub's angle, in m^2, that change sign where held motion passes between smooth stretches."""


@dataclass(frozen=True, slots=True)
class HalfPlane:
    """The workpart, y < -depth; the centre line's end touches it."""

    mechanics: Mechanics
    depth: float
    friction: float
    friction_in_restitution: float
    restitution: float
    name: str = "workpart"

    def gap(self, angle: Number, hub_angle: Number) -> Number:
        """Height of the tip above the surface, m."""
        return self.mechanics.tip_position(hub_angle, angle).imag + self.depth

    def touch(self, angle: Number, rate: Number, hub_angle: Number) -> Touch:
        """Kinematics of the tip."""
        root, arm = self.mechanics.root(hub_angle), self.mechanics.tip * np.exp(1j * (hub_angle + angle))
        bend = centripetal(self.mechanics, 1j, root, arm, self.mechanics.speed + rate)
        return contact(self.mechanics, 1j, arm, root, bend)

    def parts(self, side: float) -> tuple[HalfPlane, ...]:  # noqa: ARG002
        """Only the tip touches."""
        return (self,)

    def held_angle(self, hub_angle: Number, side: float) -> Number:
        """From r_h cos psi + t cos(psi + alpha + lead) = depth, the tip being at the distance t from the root.

        The branch within half a turn of radial.
        """
        tip = self.mechanics.tip
        cosine = (self.depth - self.mechanics.hub_radius * np.cos(hub_angle)) / abs(tip)
        angle = side * np.arccos(np.clip(cosine, -1.0, 1.0)) - hub_angle - np.angle(1j * tip)
        return angle - 2.0 * np.pi * np.round(angle / (2.0 * np.pi))

    def within_reach(self, hub_angle: Number) -> Number:
        """Depth of the lowest tip below the surface, m."""
        return abs(self.mechanics.tip) + self.mechanics.hub_radius * np.cos(hub_angle) - self.depth

    def seams(self, side: float) -> list[Callable[[Number], Number]]:  # noqa: ARG002
        """There is none."""
        return []


def obstacles_of(tool: Tool, mechanics: Mechanics) -> tuple[Obstacle, ...]:
    """The obstacles of a tool, bar first."""
    found: list[Obstacle] = []
    if (bar := tool.bar) is not None:
        wire_radius = tool.bristle.wire_diameter / 2.0
        corners = (0j, *(complex(*corner) for corner in tool.bristle.path))
        surface = (bar.friction, bar.friction, bar.restitution)
        found.append(Circle(mechanics, corners, complex(*bar.centre), tool.bar_reach, wire_radius, *surface))
    if (part := tool.workpart) is not None:
        surface = (part.friction, part.friction_in_restitution, part.restitution)
        found.append(HalfPlane(mechanics, tool.workpart_depth, *surface))
    return tuple(found)
