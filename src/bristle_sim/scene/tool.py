"""Building the scene of a bristle-blasting tool, in engine units, from parameters in SI units.

The engine's tolerances are absolute, so results in SI units would depend on the size of the tool.
The units of a scene are therefore chosen so that the quantities of an impact are of the order of 1.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from bristle_sim.declared import Declared
from bristle_sim.fields import count, quantity
from bristle_sim.parameters import START, Bristle, Contact, Tool
from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.compliant import CompliantLaw
from bristle_sim.scene.impacts import ContactLaw, EnergeticLaw, EngineLaw
from bristle_sim.scene.mechanism import Link, Mechanism
from bristle_sim.scene.pairs import BarPair, ContactPair, WirePair, WorkpartPair
from bristle_sim.theory.wire import hinge_damping, hinge_stiffness

SLOWEST_MOTION = 1e-100
"""Smallest angular velocity or angular frequency (rad/s) from which the unit of time is derived.
With a smaller one the unit of energy would be too small for a floating-point number."""

SHORTEST_PIECE = 1e-12
"""Shortest straight segment of a link, as a fraction of the wire's length. A knee that is closer to
a joint is moved to the joint."""


class Units:
    """The units of a scene ("engine units") in SI units.

    Attributes:
        length: unit of length, m.
        mass: unit of mass, kg.
        time: unit of time, s.
        rate: unit of angular velocity, rad/s.
        velocity: unit of velocity, m/s.
        impulse: unit of impulse, N s.
        force: unit of force, N.
        energy: unit of energy, J.
        angular_damping: unit of the damping of a torsion spring, N m s.
    """

    def __init__(self, length: float, mass: float, time: float) -> None:
        """Derive all units from the units of length (m), mass (kg) and time (s)."""
        self.length = length
        self.mass = mass
        self.time = time
        self.rate = 1.0 / time
        self.velocity = length / time
        self.impulse = mass * self.velocity
        self.force = self.impulse / time
        self.energy = mass * self.velocity**2
        self.angular_damping = self.energy * time


@dataclass(frozen=True, slots=True)
class Row(Declared):
    """Several bristles in one plane on one hub, and the friction and restitution between them.

    Each bristle lags the bristle in front of it by the angle ``pitch``.
    """

    bristles: int = count(1, "1 <= bristles <= 100: number of bristles [requested]")
    pitch: float = quantity(
        0.0,
        f"0 <= pitch <= {2.0 * math.pi} rad: angle about the hub from one bristle to the next [requested]",
    )
    friction: float = quantity(
        0.0,
        "0 <= neighbour_friction <= 1e6: coefficient of friction between two wires [requested]",
    )
    restitution: float = quantity(
        0.0,
        "0 <= neighbour_restitution <= 1: energetic coefficient of restitution between two wires [requested]",
    )


ONE_BRISTLE = Row()  # no row: a single bristle


def tool_units(tool: Tool) -> Units:
    """Return the units of a tool's scene.

    The units of length and mass are those of the bristle. The unit of time is the reciprocal of the
    hub's angular velocity, or of the bristle's natural angular frequency under belt, centrifugal
    force and gravity if that frequency is larger.
    """
    bristle = tool.bristle
    field = tool.hub.radius * tool.hub.speed**2 + tool.gravity
    stiffness = tool.belt.stiffness + bristle.mass * math.hypot(*bristle.centre) * field
    rate = max(math.sqrt(stiffness / bristle.inertia_about_root), tool.hub.speed)
    return Units(bristle.length, bristle.mass, 1.0 / rate if rate > SLOWEST_MOTION else 1.0)


def build_tool(
    tool: Tool, *, hub_start: float = START, row: Row = ONE_BRISTLE
) -> tuple[Scene, Units]:
    """Build the scene of a tool, with only those effects that its parameters request.

    Args:
        tool: parameters of the tool.
        hub_start: angle of the first root at time 0, rad.
        row: number and arrangement of the bristles.

    Returns:
        The scene and its units.
    """
    units = tool_units(tool)
    bristle = tool.bristle
    hub = tool.hub
    links = wire_links(bristle) * row.bristles
    mechanism = Mechanism(
        links, hub.radius / units.length, hub.speed * units.time, hub_start, row.bristles, row.pitch
    )
    pairs = [
        each for first in range(0, len(links), bristle.links) for each in _pairs(tool, units, first)
    ]
    if row.bristles > 1:
        pairs += wire_pairs(
            mechanism, bristle.wire_diameter / 2.0 / units.length, row.friction, row.restitution
        )
    effects = Effects(
        stiffness=tool.belt.stiffness / units.energy,
        damping=tool.belt_damping / units.angular_damping,
        gravity=tool.gravity * units.time / units.velocity,
        pairs=tuple(pairs),
        hinge=wire_hinge(bristle, tool.belt.stiffness, units) if bristle.links > 1 else (0.0, 0.0),
    )
    return Scene(mechanism, effects), units


def _pairs(tool: Tool, units: Units, first: int) -> Iterator[ContactPair]:
    """Yield the pairs of a wire: each link with the bar; the tip and the knee with the workpart.

    ``first`` is the index of the wire's first link.
    """
    bristle = tool.bristle
    size = units.length
    bar = tool.bar
    part = tool.workpart
    if bar is not None:
        centre = complex(*bar.centre) / size
        radii = (bar.radius / size, bristle.wire_diameter / 2.0 / size)
        for link in range(first, first + bristle.links):
            yield BarPair(centre, *radii, bar.friction, bar.restitution, link=link)
    if part is not None:
        surface = (
            tool.workpart_depth / size,
            part.friction,
            part.friction_in_restitution,
            part.restitution,
        )
        # Link and corner of the wire's tip and knee; corner -1 is a link's tip, 1 its knee.
        corners = [(first + bristle.links - 1, -1)]
        joint = bristle.knee_position * bristle.links
        if len(bristle.path) > 1:
            at_joint = (
                bristle.links > 1 and abs(joint - round(joint)) < bristle.links * SHORTEST_PIECE
            )
            corners.append((first + round(joint) - 1, -1) if at_joint else (first + int(joint), 1))
        for link, corner in corners:
            yield WorkpartPair(*surface, link=link, corner=corner)


def wire_links(bristle: Bristle) -> tuple[Link, ...]:
    """Return the links of a wire, in units of the bristle's length and mass.

    The links divide the centre line into parts of equal length; the link that contains the knee is
    bent. In these units a link's mass equals its length. In the unstressed wire all links have the
    same angle. At angle 0 the shank, from root to knee, points along (0, -1).
    """
    corners = np.array([0j, *(complex(*place) for place in bristle.path)]) / bristle.length
    distances = np.cumsum([0.0, *abs(np.diff(corners))])  # of the corners, along the wire
    borders = [number / bristle.links for number in range(bristle.links + 1)]
    links = []
    for low, high in itertools.pairwise(borders):
        inner = (distances > low + SHORTEST_PIECE) & (distances < high - SHORTEST_PIECE)
        places = np.interp([low, *distances[inner], high], distances, corners)
        places -= places[0]
        masses = abs(np.diff(places))
        middles = 0.5 * (places[:-1] + places[1:])
        mass = float(masses.sum())
        centre = complex(masses @ middles) / mass
        inertia = float(masses @ (masses**2 / 12.0 + abs(middles - centre) ** 2))
        links.append(Link(mass, inertia, centre, tuple(places.tolist())))
    return tuple(links)


def wire_hinge(bristle: Bristle, root_stiffness: float, units: Units) -> tuple[float, float]:
    """Return stiffness and damping of the torsion spring in each joint between two links.

    Args:
        bristle: parameters of the bristle.
        root_stiffness: stiffness of the belt, N m/rad.
        units: units of the scene, in which the results are returned.
    """
    diameter = bristle.wire_diameter
    length = bristle.length
    modulus = bristle.modulus
    stiffness = hinge_stiffness(diameter, length, modulus, bristle.links)
    shape = (bristle.mass, length, diameter, modulus, root_stiffness)
    damping = hinge_damping(*shape, bristle.bending_damping_ratio, bristle.links)
    return stiffness / units.energy, damping / units.angular_damping


def wire_pairs(
    mechanism: Mechanism, wire_radius: float, friction: float, restitution: float
) -> Iterator[WirePair]:
    """Yield a pair for each corner of a wire and each straight segment of another wire.

    The radius of the wires (engine units), their friction and their restitution are the same in all
    pairs.

    Raises:
        ValueError: if the wires have no thickness, so that no gap between them can close.
    """
    if not wire_radius:
        raise ValueError("wire_diameter = 0: must be above 0, or no wires touch each other (in m)")
    size = mechanism.wire_links
    for (link, own), (partner, other) in itertools.permutations(enumerate(mechanism.links), 2):
        if link // size != partner // size:
            corners = range(0 if link % size == 0 else 1, len(own.corners))
            for corner, segment in itertools.product(corners, range(len(other.corners) - 1)):
                yield WirePair(link, corner, partner, segment, wire_radius, friction, restitution)


def contact_law(contact: Contact, accuracy: float, time_unit: float) -> ContactLaw:
    """Return the contact law that ``contact.law`` names.

    Args:
        contact: parameters of the contact.
        accuracy: requested relative accuracy.
        time_unit: unit of time of the scene, s.
    """
    squared = contact.tangential_compliance
    if contact.law == "compliant":
        duration = None if contact.duration is None else contact.duration / time_unit
        return CompliantLaw(duration, accuracy, tangential_compliance=squared, time_unit=time_unit)
    return EngineLaw() if contact.law == "engine" else EnergeticLaw(accuracy, squared)
