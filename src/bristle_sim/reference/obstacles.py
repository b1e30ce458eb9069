"""What the bristle can touch: the bar (a circle) and the workpart (a half-plane), both at rest.

At a touch the normal n points out of the obstacle and the tangent is n turned clockwise by 90 degrees, t = -i n: for the
workpart n = +y and t = +x. Velocities at the contact point are linear in the relative rate,

    (v_n, v_t) = J alpha' + omega (drift), J = d(v_n, v_t)/d alpha',

and the contact-space inverse mass is K = J J^T / I, of rank one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from bristle_sim.parameters import Tool
from bristle_sim.reference.mechanics import Mechanics, Number, Vector, dot

__all__ = ["Circle", "HalfPlane", "Obstacle", "Touch", "obstacles_of"]


@dataclass(frozen=True, slots=True)
class Touch:
    """Kinematics of the contact point, at one instant or at many.

    Attributes:
        normal_lever, tangential_lever: J, m/rad.
        normal_drift, tangential_drift: velocity of a contact point that turns with the hub (alpha' = 0), m/s.
        bend: second derivative of the gap in time at alpha'' = 0, so that gap'' = J_n alpha'' + bend, m/s^2.
    """

    normal_lever: Number
    tangential_lever: Number
    normal_drift: Number
    tangential_drift: Number
    bend: Number

    def velocity(self, rate: Number) -> tuple[Number, Number]:
        """(v_n, v_t) of the bristle's contact point, m/s."""
        return (
            self.normal_lever * rate + self.normal_drift,
            self.tangential_lever * rate + self.tangential_drift,
        )

    def inverse_mass(self, inertia: float) -> NDArray[np.float64]:
        """K of a single touch, shape (2, 2), 1/kg."""
        lever = np.array([self.normal_lever, self.tangential_lever])
        return np.outer(lever, lever) / inertia


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

    def side(self, angle: float, hub_angle: float) -> float:
        """Which of the two bristle angles that touch at a hub angle this is, +1 or -1."""

    def held_angle(self, hub_angle: Number, side: float) -> Number:
        """Relative angle alpha that touches at a hub angle, rad."""

    def within_reach(self, hub_angle: Number) -> Number:
        """Positive where some bristle angle touches, m."""

    def seam(self, hub_angle: Number) -> Number:
        """Changes sign where held motion passes from one smooth stretch to another, m^2."""


@dataclass(frozen=True, slots=True)
class Circle:
    """The bar. The centre line keeps ``reach`` = r_b + d/2 from its centre; the wire's end is round."""

    mechanics: Mechanics
    centre: complex
    reach: float
    wire_radius: float
    friction: float
    friction_in_restitution: float
    restitution: float
    name: str = "bar"

    def gap(self, angle: Number, hub_angle: Number) -> Number:
        """Distance of the centre line from the bar's centre less the reach, m."""
        wire, root, along, _ = self._nearest(angle, hub_angle)
        return np.abs(root + along * wire - self.centre) - self.reach

    def touch(self, angle: Number, rate: Number, hub_angle: Number) -> Touch:
        """Kinematics where wire and bar touch: on the wire's surface, d/2 from its centre line."""
        wire, root, along, beyond = self._nearest(angle, hub_angle)
        outward = root + along * wire - self.centre
        normal = outward / np.abs(outward)
        arm = along * wire - self.wire_radius * normal
        flank = self._flank_bend(angle, rate, hub_angle)
        bend = np.where(beyond, self._end_bend(normal, root, wire, rate), flank)
        return _touch(self.mechanics, normal, arm, root, bend)

    def side(self, angle: float, hub_angle: float) -> float:
        """+1 where the bar's centre is ahead of the wire in the hub's sense of rotation."""
        return 1.0 if self._offset(angle, hub_angle) > 0.0 else -1.0

    def held_angle(self, hub_angle: Number, side: float) -> Number:
        """Direction of the bar's centre from the root, less the angle that the reach takes up there.

        With D the centre's distance from the root: sin = reach/D where the flank touches, the law of cosines in the
        triangle (D, L, reach) where the wire's end does.
        """
        radial = self.mechanics.direction(hub_angle)
        centre = (self.centre - self.mechanics.root(hub_angle)) / radial
        distance, length = np.abs(centre), self.mechanics.length
        cosine = (distance**2 + length**2 - self.reach**2) / (2.0 * length * distance)
        flank, end = np.arcsin(self.reach / distance), np.arccos(np.clip(cosine, -1.0, 1.0))
        taken = np.where(self.seam(hub_angle) > 0.0, end, flank)
        return np.angle(centre) - side * taken

    def within_reach(self, hub_angle: Number) -> Number:
        """Wire's length and reach less the distance of the bar's centre from the root, m."""
        return self.mechanics.length + self.reach - np.abs(self.centre - self.mechanics.root(hub_angle))

    def seam(self, hub_angle: Number) -> Number:
        """Square of the wire's length to where the bar would touch its line, less L^2: positive where its end touches."""
        distance = np.abs(self.centre - self.mechanics.root(hub_angle))
        return distance**2 - self.reach**2 - self.mechanics.length**2

    def ahead(self, hub_angle: float) -> bool:
        """Whether the root is within half a turn before the bar's direction."""
        return bool((self.centre / self.mechanics.direction(hub_angle)).imag > 0.0)

    def _nearest(self, angle: Number, hub_angle: Number) -> tuple[Vector, Vector, Number, Number]:
        """Wire's direction, root, nearest point's distance from the root, and whether that is the wire's end."""
        wire, root = self.mechanics.direction(hub_angle + angle), self.mechanics.root(hub_angle)
        along = dot(self.centre - root, wire)
        return wire, root, np.clip(along, 0.0, self.mechanics.length), along > self.mechanics.length

    def _offset(self, angle: Number, hub_angle: Number) -> Number:
        """Distance q of the bar's centre from the wire's line, positive ahead of it, m."""
        ahead = 1j * self.mechanics.direction(hub_angle + angle)
        return dot(self.centre - self.mechanics.root(hub_angle), ahead)

    def _flank_bend(self, angle: Number, rate: Number, hub_angle: Number) -> Number:
        """Second derivative of |q| = |S sin(beta - alpha) + r_h sin alpha|, beta' = -omega, S and beta fixing the bar."""
        offset = self._offset(angle, hub_angle)
        transverse = self.mechanics.hub_radius * np.sin(angle)
        absolute = self.mechanics.speed + rate
        return -np.sign(offset) * (absolute**2 * (offset - transverse) + rate**2 * transverse)

    def _end_bend(self, normal: Vector, root: Vector, wire: Vector, rate: Number) -> Number:
        """Second derivative of the end's distance: its acceleration outward plus v_t^2 over the distance."""
        absolute, arm = self.mechanics.speed + rate, self.mechanics.length * wire
        sliding = dot(-1j * normal, 1j * (self.mechanics.speed * root + absolute * arm))
        return _inward(self.mechanics, normal, root, arm, absolute) + sliding**2 / self.reach


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
        return self.mechanics.tip(hub_angle, angle).imag + self.depth

    def touch(self, angle: Number, rate: Number, hub_angle: Number) -> Touch:
        """Kinematics of the tip."""
        root, arm = self.mechanics.root(hub_angle), self.mechanics.length * self.mechanics.direction(hub_angle + angle)
        bend = _inward(self.mechanics, 1j, root, arm, self.mechanics.speed + rate)
        return _touch(self.mechanics, 1j, arm, root, bend)

    def side(self, angle: float, hub_angle: float) -> float:
        """Sign of the bristle's absolute angle: +1 where the tip is beyond the root."""
        return 1.0 if np.sin(hub_angle + angle) > 0.0 else -1.0

    def held_angle(self, hub_angle: Number, side: float) -> Number:
        """From r_h cos psi + L cos(psi + alpha) = depth; the branch within half a turn of radial."""
        cosine = (self.depth - self.mechanics.hub_radius * np.cos(hub_angle)) / self.mechanics.length
        angle = side * np.arccos(np.clip(cosine, -1.0, 1.0)) - hub_angle
        return angle - 2.0 * np.pi * np.round(angle / (2.0 * np.pi))

    def within_reach(self, hub_angle: Number) -> Number:
        """Depth of the lowest tip below the surface, m."""
        return self.mechanics.length + self.mechanics.hub_radius * np.cos(hub_angle) - self.depth

    def seam(self, hub_angle: Number) -> Number:
        """There is none."""
        return np.ones_like(hub_angle)


def obstacles_of(tool: Tool, mechanics: Mechanics) -> tuple[Obstacle, ...]:
    """The obstacles of a tool, bar first."""
    found: list[Obstacle] = []
    if (bar := tool.bar) is not None:
        wire_radius = tool.bristle.wire_diameter / 2.0
        surface = (bar.friction, bar.friction, bar.restitution)
        found.append(Circle(mechanics, complex(*bar.centre), tool.bar_reach, wire_radius, *surface))
    if (part := tool.workpart) is not None:
        surface = (part.friction, part.friction_in_restitution, part.restitution)
        found.append(HalfPlane(mechanics, tool.workpart_depth, *surface))
    return tuple(found)


def _touch(mechanics: Mechanics, normal: Vector, arm: Vector, root: Vector, bend: Number) -> Touch:
    tangent, lever, drift = -1j * normal, 1j * arm, 1j * mechanics.speed * (root + arm)
    return Touch(dot(normal, lever), dot(tangent, lever), dot(normal, drift), dot(tangent, drift), bend)


def _inward(mechanics: Mechanics, normal: Vector, root: Vector, arm: Vector, absolute: Number) -> Number:
    """Centripetal acceleration of the wire's end along the normal, m/s^2."""
    return dot(normal, -(mechanics.speed**2) * root - absolute**2 * arm)
