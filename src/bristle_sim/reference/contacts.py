"""Contacts of wires with bar, workpart and each other: gaps, and Jacobian rows of the contact
velocities.

The normal n points from the obstacle to the wire; the tangent is t = -i n. A piece is a straight
part of a link's centre line. On the flank of a piece the normal turns with the link. On a corner
(between two pieces, or at the wire's end) the normal turns as the corner slides around the bar.
With the angles theta of the links, the normal velocity v_n and the tangential velocity v_t of the
wire's surface at the contact obey

  v_n = J_n theta' + drift_n,    gap'' = J_n theta'' + bias_n,
  v_t = J_t theta' + drift_t,    v_t' = J_t theta'' + bias_t.

The drifts are the velocities if theta' = 0, the biases the accelerations if theta'' = 0.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.parameters import Surface, Tool
from bristle_sim.reference.mechanics import Chain, Kinematics


class Point(NamedTuple):
    """The point of a wire at which a contact acts.

    Attributes:
        obstacle: name of the obstacle; ``wire`` for a contact between two wires.
        piece: index of the straight piece of the wire. For a contact between two wires it is an
            index of ``WirePairs.pairs``.
        corner: whether the contact is at the end of the piece instead of on its flank.
    """

    obstacle: str
    piece: int
    corner: bool


class Touch(NamedTuple):
    """Kinematics of a contact at one instant, or at n instants along a first axis, in SI units.

    The two components of a vector are normal and tangential to the obstacle's surface.

    Attributes:
        gap: gap between wire and obstacle, m.
        rows: Jacobian of the contact velocity: its derivatives with respect to the angular
            velocities of the links (m), shape (..., 2, links).
        velocity: velocity of the wire's surface at the contact (m/s), shape (..., 2).
        bias: acceleration of the contact if the links' angular accelerations are zero (m/s^2),
            shape (..., 2).
        along: coordinate x of the contact, along a flat surface, m.
    """

    gap: Any
    rows: Array
    velocity: Array
    bias: Array
    along: Any = 0.0


def touch_of(
    chain: Chain,
    motion: Kinematics,
    link: int,
    gap: Any,
    normal: Any,
    point: Any,
    spin: Any,
    moving: Any,
) -> Touch:
    """Return the kinematics of a contact between a link and an obstacle.

    Vectors of the plane are complex numbers x + iy. Each argument after ``link`` is a number, or an
    array for n instants.

    Args:
        chain: the links.
        motion: positions and velocities of the links.
        link: index of the link in contact.
        gap: gap between wire and obstacle, m.
        normal: unit normal, from the obstacle to the wire.
        point: position of the contact point, m.
        spin: angular velocity of the normal, rad/s.
        moving: velocity of the contact point, m/s. It differs from the velocity of the wire's
            material at this point, because the contact point moves along the wire.
    """
    axes = np.conj([normal, -1j * normal]).T
    arm = point - motion.joint[..., link]
    turning = 1j * motion.rates[..., link]
    material = motion.velocity[..., link] + turning * arm
    # d/dt of n.v and t.v, with n' = i spin n and arm' = moving - velocity, at theta'' = 0.
    change = motion.acceleration[..., link] + turning * (moving - motion.velocity[..., link])
    change = change - 1j * spin * material
    rows = axes[..., None] * chain.jacobian(motion, link, arm)[..., None, :]
    velocity, bias = (axes * each[..., None] for each in (material, change))
    return Touch(gap, rows.real, velocity.real, bias.real, point.real)


@dataclass(frozen=True, slots=True)
class Bar:
    """The accelerator bar as an obstacle: a circle that a wire can touch on any side.

    Attributes:
        centre: position x + iy of the bar's centre, m.
        reach: sum of the radii of bar and wire, m.
        wire_radius: radius of the wire, m.
        surface: friction and restitution of the bar.
        compliance: ratio of the normal to the tangential contact stiffness. With 0 the contact is
            rigid in the tangential direction.
    """

    centre: complex
    reach: float
    wire_radius: float
    surface: Surface
    compliance: float = 0.0

    def feet(self, chain: Chain, motion: Kinematics) -> Array:
        """Return the coordinate of the bar's centre along each piece (m), shape (..., pieces).

        The coordinate is the distance from the start of the piece to the foot of the perpendicular
        from the bar's centre. The foot may lie outside the piece.
        """
        pieces = chain.pieces
        origins, _ = chain.points(motion, pieces.links, pieces.starts)
        along = pieces.directions * motion.turn[..., pieces.links]
        return np.asarray((np.conj(along) * (self.centre - origins)).real)

    def gaps(self, chain: Chain, motion: Kinematics) -> Array:
        """Return the gap between the bar and every straight piece (m), shape (..., pieces)."""
        links, starts, directions, lengths = chain.pieces
        feet = np.minimum(np.maximum(self.feet(chain, motion), 0.0), lengths)
        nearest, _ = chain.points(motion, links, starts + feet * directions)
        return np.asarray(np.abs(nearest - self.centre) - self.reach)

    def touch(self, chain: Chain, motion: Kinematics, point: Point) -> Touch:
        """Return the kinematics of a contact between the bar and a wire.

        ``point`` is the flank or the corner of the wire at which the contact acts.
        """
        link, start, direction, length = (column[point.piece] for column in chain.pieces)
        away = length if point.corner else self.feet(chain, motion)[..., point.piece]
        place, carried = chain.points(motion, link, start + away * direction)
        distance = np.abs(place - self.centre)
        normal = (place - self.centre) / distance
        spin = dot(1j * normal, carried) / distance if point.corner else motion.rates[..., link]
        # The place of contact stays on the bar, whose normal turns at ``spin``.
        outwards = (distance - self.wire_radius) * normal
        gap = distance - self.reach
        surface = self.centre + outwards
        return touch_of(chain, motion, link, gap, normal, surface, spin, 1j * spin * outwards)


@dataclass(frozen=True, slots=True)
class Workpart:
    """The workpart as an obstacle: the half-plane y < -depth, m.

    Only the tip and the knees of a wire can touch it.
    """

    depth: float
    surface: Surface
    compliance: float = 0.0  # ratio of the normal to the tangential contact stiffness

    def gaps(self, chain: Chain, motion: Kinematics) -> Array:
        """Return the gap between the workpart and each piece's end (m), shape (..., pieces).

        The gap is infinite for an end that is neither a tip nor a knee.
        """
        places, _ = chain.points(motion, chain.pieces.links, chain.pieces.ends)
        return np.where(chain.corners, places.imag + self.depth, np.inf)

    def touch(self, chain: Chain, motion: Kinematics, point: Point) -> Touch:
        """Return the kinematics of a contact between the workpart and a tip or knee."""
        link = int(chain.pieces.links[point.piece])
        corner, moving = chain.points(motion, link, chain.pieces.ends[point.piece])
        return touch_of(chain, motion, link, corner.imag + self.depth, 1j, corner, 0.0, moving)


class WirePairs:
    """The wires of a row as obstacles of each other: corners and straight pieces of different wires.

    A corner is a root, a knee, a joint between links or a tip. At least one of the two points at
    which wires touch is a corner. A contact's ``Point.piece`` is here the index of a pair of corner
    and piece. ``pairs`` holds two pieces for each pair: the corner is an end of the first one.
    """

    compliance = 0.0

    def __init__(self, chain: Chain, diameter: float, surface: Surface) -> None:
        self.diameter = diameter
        self.surface = surface
        wires = np.cumsum(chain.tips) - chain.tips  # index of each piece's wire
        pieces = np.arange(len(wires))
        roots = np.flatnonzero(np.diff(wires, prepend=-1))
        corners = np.concatenate([chain.pieces.starts[roots], chain.pieces.ends])
        carriers = np.concatenate([roots, pieces])
        own, self._other = np.nonzero(np.not_equal.outer(wires[carriers], wires))
        self._links = chain.pieces.links[carriers[own]]
        self._arms = corners[own]
        self.pairs = np.column_stack([carriers[own], self._other]).tolist()

    def gaps(self, chain: Chain, motion: Kinematics) -> Array:
        """Return the gap between corner and piece of every pair (m), shape (..., pairs)."""
        (front, _), (back, _), _ = self._nearest(chain, motion, slice(None))
        return np.asarray(np.abs(front - back) - self.diameter)

    def touch(self, chain: Chain, motion: Kinematics, point: Point) -> Touch:
        """Return the kinematics of the contact between the corner and the piece of a pair.

        The velocity is that of the corner's wire minus that of the piece's wire.
        """
        nearest = self._nearest(chain, motion, point.piece)
        (front, front_velocity), (back, back_velocity), on_flank = nearest
        other = int(chain.pieces.links[self._other[point.piece]])
        distance = np.abs(front - back)
        normal = (front - back) / distance
        # The normal turns with the piece's flank, or with the line between two corners.
        between = dot(1j * normal, front_velocity - back_velocity) / distance
        spin = np.where(on_flank, motion.rates[..., other], between)
        reach = 0.5 * self.diameter * normal
        moving = front_velocity - 1j * spin * reach
        gap = distance - self.diameter
        wire, obstacle = (
            touch_of(chain, motion, int(link), gap, normal, front - reach, spin, moving)
            for link in (self._links[point.piece], other)
        )
        return Touch(
            gap,
            wire.rows - obstacle.rows,
            wire.velocity - obstacle.velocity,
            wire.bias - obstacle.bias,
        )

    def _nearest(self, chain: Chain, motion: Kinematics, pair: Any) -> tuple[Any, Any, Any]:
        """Return the corner and the nearest point of the piece, for one pair or for several.

        Returns:
            Position (m) and velocity (m/s) of the corner.
            Position and velocity of the nearest point of the piece.
            Whether this point is between the ends of the piece.
        """
        links, starts, directions, lengths = (column[self._other[pair]] for column in chain.pieces)
        corner = chain.points(motion, self._links[pair], self._arms[pair])
        origin, _ = chain.points(motion, links, starts)
        foot = dot(directions * motion.turn[..., links], corner[0] - origin)
        arms = starts + np.clip(foot, 0.0, lengths) * directions
        return corner, chain.points(motion, links, arms), (foot > 0.0) & (foot < lengths)


Obstacles = Mapping[str, Bar | Workpart | WirePairs]


def obstacles_of(tool: Tool) -> dict[str, Bar | Workpart]:
    """Return the obstacles that a tool has, its bar and its workpart, by name."""
    found: dict[str, Bar | Workpart] = {}
    if (bar := tool.bar) is not None:
        surface = Surface(friction=bar.friction, restitution=bar.restitution)
        radius = 0.5 * tool.bristle.wire_diameter
        found["bar"] = Bar(complex(*bar.centre), tool.bar_reach, radius, surface)
    if tool.workpart is not None:
        compliance = tool.contact.tangential_compliance
        found["workpart"] = Workpart(tool.workpart_depth, tool.workpart, compliance)
    return found


def follows(chain: Chain, piece: int) -> bool:
    """Return whether a straight piece starts at the end of another piece, not at a wire's root."""
    return piece > 0 and not chain.tips[piece - 1]


def dot(first: Any, second: Any) -> Any:
    """Return the scalar product of two vectors of the plane, given as complex numbers."""
    return (np.conj(first) * second).real
