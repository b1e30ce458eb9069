"""Contacts of wires with bar, workpart and each other: gaps, and Jacobian rows of the contact
velocities.

The normal n points from the obstacle to the wire; the tangent is t = -i n. A piece is a straight
part of a link's centre line. A contact on the flank of a piece has a normal that turns with its
link. A contact on a corner (between two pieces, or at the wire's end) has a normal that turns as
the corner slides around the bar. The velocities of the wire's surface at the contact obey

  v_n = J_n theta' + drift,    gap'' = J_n theta'' + bias_n,    v_t = J_t theta' + drift,    v_t' =
  J_t theta'' + bias_t.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.parameters import Surface, Tool
from bristle_sim.reference.mechanics import Chain, Kinematics
from bristle_sim.theory.contact_spring import ContactSpring


class Point(NamedTuple):
    """The location of a contact on a wire: the flank of a straight piece, or the corner at its end.

    ``obstacle`` is the name of the obstacle, ``piece`` the index of the piece (or of the pair of
    wires), and ``corner`` tells whether the contact is at the corner.
    """

    obstacle: str
    piece: int
    corner: bool


class Touch(NamedTuple):
    """Kinematics of a contact at one instant, in SI units.

    Attributes:
        gap: gap between wire and obstacle, m.
        normal_row, tangential_row: derivatives of the contact velocity with respect to the rates of
            the links, m.
        velocity: (normal, tangential) velocity of the wire's surface at the contact, m/s.
        bias: (normal, tangential) acceleration of the contact while the rates of the links are
            constant, m/s^2.
        along: position of the contact along a flat surface, m.
    """

    gap: float
    normal_row: Array
    tangential_row: Array
    velocity: tuple[float, float]
    bias: tuple[float, float]
    along: float = 0.0


@dataclass(slots=True)
class Spring:
    """The normal and the tangential spring of a compliant contact, and their state.

    Attributes:
        law: stiffness, restitution and friction of the contact.
        surface: gap at which the contact began, from which the penetration is measured, m. It is
            negative in the dent of an earlier contact.
        anchor: position of the tangential spring's foot along the surface while it sticks, m.
        deepest: deepest penetration, m.
        loading: whether the normal spring is in loading.
    """

    law: ContactSpring
    surface: float = 0.0
    anchor: float = 0.0
    deepest: float = 0.0
    loading: bool = True

    @property
    def left(self) -> float:
        """Return the penetration at which the force reaches zero in unloading, m."""
        return self.law.residual(self.deepest)

    def force(self, gap: float) -> float:
        """Return the normal force, N, at a gap, m, measured from the undented surface."""
        return self.law.normal_force(self.surface - gap, None if self.loading else self.deepest)

    def rub(self, touch: Touch, slip: int) -> float | None:
        """Return the tangential force, N; None if the contact is rigid along the surface.

        ``slip`` is the sense in which the tangential spring's foot slides, 0 while it sticks.
        """
        if not self.law.compliance:
            return None
        if slip:
            return -self.law.coefficient(loading=self.loading) * slip * self.force(touch.gap)
        return self.law.tangential_force(touch.along, self.anchor)

    def foot(self, touch: Touch, slip: int) -> float:
        """Return the velocity of the tangential spring's foot in the sense of its slip, m/s.

        Without a tangential spring it is the velocity of the contact point in this sense.
        """
        return slip * self.law.foot_velocity(touch.velocity, slip, loading=self.loading)

    def stretch(self, touch: Touch, pull: float) -> None:
        """Set the tangential spring's foot so that the tangential force is ``pull``, N."""
        self.anchor = self.law.foot(touch.along, pull)


def touch_of(
    chain: Chain,
    motion: Kinematics,
    link: int,
    gap: float,
    normal: complex,
    point: complex,
    spin: float,
    moving: complex,
) -> Touch:
    """Return the kinematics of a contact.

    Args:
        chain: the links.
        motion: kinematics of the links.
        link: index of the link in contact.
        gap: gap between wire and obstacle, m.
        normal: unit normal, from the obstacle to the wire.
        point: position of the contact point on the wire's surface, m.
        spin: angular velocity of the normal, rad/s.
        moving: velocity of the contact point, which slides along the wire's material, m/s.
    """
    velocity = motion.velocity[link]
    rate = motion.rates[link]
    tangent = -1j * normal
    arm = point - motion.joint[link]
    material = velocity + 1j * rate * arm
    # d/dt of n.v and t.v, with n' = i spin n and arm' = moving - velocity, at theta'' = 0.
    change = motion.acceleration[link] + 1j * rate * (moving - velocity)
    normal_row = chain.jacobian(motion, link, arm, normal)
    tangential_row = chain.jacobian(motion, link, arm, tangent)
    velocities = dot(normal, material), dot(tangent, material)
    biases = [dot(1j * spin * each, material) + dot(each, change) for each in (normal, tangent)]
    return Touch(gap, normal_row, tangential_row, velocities, (biases[0], biases[1]))


@dataclass(frozen=True, slots=True)
class Bar:
    """The accelerator bar as an obstacle: a circle that a wire can touch on any side.

    ``reach`` is the sum of the radii of bar and wire, m. ``compliance`` is the ratio of the normal
    to the tangential contact stiffness; 0 is rigid along the surface.
    """

    centre: complex
    reach: float
    wire_radius: float
    surface: Surface
    compliance: float = 0.0

    def feet(self, chain: Chain, motion: Kinematics) -> tuple[Array, Array]:
        """Return where the perpendicular from the bar's centre meets each piece, and the gap.

        Returns:
            The distance of the perpendicular's foot from the start of the piece, m, which may be
            beyond the piece; and the gap at the nearest point of the piece, m. The shapes are
            (..., pieces).
        """
        links, starts, directions, lengths = chain.pieces
        turn = motion.turn[..., links]
        joint = motion.joint[..., links]
        origin = joint + starts * turn
        along = directions * turn
        foot = (np.conj(along) * (self.centre - origin)).real
        nearest = origin + np.minimum(np.maximum(foot, 0.0), lengths) * along
        return foot, np.abs(nearest - self.centre) - self.reach

    def gaps(self, chain: Chain, motion: Kinematics) -> Array:
        """Return the gap between the bar and every straight piece, m, shape (..., pieces)."""
        return self.feet(chain, motion)[1]

    def touch(self, chain: Chain, motion: Kinematics, point: Point) -> Touch:
        """Return the kinematics of a contact of the bar with a flank or a corner of a wire."""
        link, start, direction, length = (column[point.piece] for column in chain.pieces)
        origin, _ = chain.points(motion, link, start)
        along = direction * motion.turn[link]
        away = length if point.corner else dot(along, self.centre - origin)
        place, carried = chain.points(motion, link, start + away * direction)
        distance = abs(place - self.centre)
        normal = (place - self.centre) / distance
        spin = dot(1j * normal, carried) / distance if point.corner else motion.rates[link]
        surface = self.centre + (distance - self.wire_radius) * normal
        # The place of contact stays on the bar, whose normal turns at ``spin``.
        moving = 1j * spin * normal * (distance - self.wire_radius)
        return touch_of(chain, motion, link, distance - self.reach, normal, surface, spin, moving)


@dataclass(frozen=True, slots=True)
class Workpart:
    """The workpart as an obstacle: the half-plane y < -depth, m.

    The tip and the knees of a wire can touch it.
    """

    depth: float
    surface: Surface
    compliance: float = 0.0  # ratio of the normal to the tangential contact stiffness

    def gaps(self, chain: Chain, motion: Kinematics) -> Array:
        """Return the height of tips and knees above the surface, m, shape (..., corners).

        They are in the order of ``chain.corners``.
        """
        corners = list(chain.corners)
        links = chain.pieces.links[corners]
        places, _ = chain.points(motion, links, chain.pieces.ends[corners])
        return np.asarray(places.imag + self.depth)

    def touch(self, chain: Chain, motion: Kinematics, point: Point) -> Touch:
        """Return the kinematics of the contact of a tip or knee with the surface."""
        link = int(chain.pieces.links[point.piece])
        corner, moving = chain.points(motion, link, chain.pieces.ends[point.piece])
        gap = corner.imag + self.depth
        touch = touch_of(chain, motion, link, gap, 1j, corner, 0.0, moving)
        return touch._replace(along=float(corner.real))


def obstacles_of(tool: Tool) -> dict[str, Bar | Workpart]:
    """Return the obstacles of a tool by name."""
    found: dict[str, Bar | Workpart] = {}
    if (bar := tool.bar) is not None:
        surface = Surface(friction=bar.friction, restitution=bar.restitution)
        found["bar"] = Bar(
            complex(*bar.centre), tool.bar_reach, tool.bristle.wire_diameter / 2.0, surface
        )
    if tool.workpart is not None:
        compliance = tool.contact.tangential_compliance
        found["workpart"] = Workpart(tool.workpart_depth, tool.workpart, compliance)
    return found


def follows(chain: Chain, piece: int) -> bool:
    """Return whether a straight piece begins at the end of another piece, not at a wire's root."""
    return piece > 0 and piece - 1 not in chain.tips


def dot(first: complex, second: complex) -> float:
    """Return the scalar product of two vectors."""
    return float((np.conj(first) * second).real)


class WirePairs:
    """All pairs of wires of a row, as one obstacle.

    The ``piece`` of a contact's ``Point`` is here the index of the pair.
    """

    name = "wire"
    compliance = 0.0

    def __init__(self, wires: int, diameter: float, surface: Surface) -> None:
        self.diameter = diameter
        self.surface = surface
        self.pairs = list(itertools.combinations(range(wires), 2))

    def gaps(self, chain: Chain, motion: Kinematics) -> Array:
        """Return the gap between the two wires of every pair, m."""
        return np.array(
            [self._nearest(chain, motion, *pair)[0] - self.diameter for pair in self.pairs]
        )

    def touch(self, chain: Chain, motion: Kinematics, point: Point) -> Touch:
        """Return the kinematics of the contact between the two wires of a pair.

        The velocity is that of the first wire relative to the second wire.
        """
        first, second = wires = self.pairs[point.piece]
        distance, end, places = self._nearest(chain, motion, first, second)
        arms = np.array(places) * chain.ends[[first, second]] / chain.length
        ends, carried = chain.points(motion, [first, second], arms)
        normal = complex(ends[0] - ends[1]) / distance
        # An end moves with its wire; the normal turns with the flank, or with the line from end to end.
        if 0.0 < places[1 - end] < chain.length:
            spin = float(motion.rates[wires[1 - end]])
        else:
            spin = dot(1j * normal, complex(carried[0] - carried[1])) / distance
        reach = (0.5 - end) * self.diameter * normal
        contact = complex(ends[end] - reach)
        moving = complex(carried[end] - 1j * spin * reach)
        gap = distance - self.diameter
        front, back = (
            touch_of(chain, motion, link, gap, normal, contact, spin, moving) for link in wires
        )
        return Touch(
            gap,
            front.normal_row - back.normal_row,
            front.tangential_row - back.tangential_row,
            (front.velocity[0] - back.velocity[0], front.velocity[1] - back.velocity[1]),
            (front.bias[0] - back.bias[0], front.bias[1] - back.bias[1]),
        )

    @staticmethod
    def _nearest(
        chain: Chain, motion: Kinematics, first: int, second: int
    ) -> tuple[float, int, tuple[float, float]]:
        """Return the nearest points of the centre lines of two wires.

        Returns:
            The distance between the points, m; the index (0 or 1) of the wire whose end is one of
            the points; and the distances of the points from the roots of their wires, m.
        """
        length = chain.length
        along = chain.ends * motion.turn / chain.length
        found = []
        for end, (own, other) in enumerate(((first, second), (second, first))):
            for at in (0.0, length):
                apart = motion.joint[own] + at * along[own] - motion.joint[other]
                foot = min(max(dot(along[other], apart), 0.0), length)
                found.append(
                    (abs(apart - foot * along[other]), end, (foot, at) if end else (at, foot))
                )
        return min(found)
