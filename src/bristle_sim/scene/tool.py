"""The bristle-blasting tool as a scene: from SI parameters to engine units.

The engine's tolerances are absolute and its biases are per time unit, so results would depend on a
scene's units. A scene therefore runs in units of its own size; every number of an impact is then
near 1.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from bristle_sim.declared import Declared, count, quantity
from bristle_sim.parameters import START, Bristle, Tool
from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.mechanism import Link, Mechanism, Vector
from bristle_sim.scene.pairs import BarPair, ContactPair, WorkpartPair, wire_pairs
from bristle_sim.theory.wire import hinge_damping, hinge_stiffness

SLOWEST_MOTION = 1e-100
"""Slowest rate that counts as motion, rad/s; the unit of energy that follows from a slower rate
would be too small a number."""

SHORTEST_PIECE = 1e-12
"""Shortest piece of a link, over the wire's length: a knee closer to a joint is at the joint."""


class Units:
    """SI size of one engine unit: length in m, mass in kg, time in s, and the units that follow
    from these.
    """

    def __init__(self, length: float, mass: float, time: float) -> None:
        """Compute the units of a scene."""
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
    """Bristles in one plane on one hub, each one pitch behind the one before it, and their mutual
    friction and restitution.
    """

    bristles: int = count(1, "1 <= bristles <= 100: number of bristles [requested]")
    pitch: float = quantity(0.0, f"0 <= pitch <= {2.0 * math.pi} rad [requested]")
    friction: float = quantity(0.0, "0 <= neighbour_friction <= 1e6 [requested]")
    restitution: float = quantity(0.0, "0 <= neighbour_restitution <= 1 [requested]")


ONE_BRISTLE = Row()  # no row: a single bristle


def tool_units(tool: Tool) -> Units:
    """Return the units of the tool's scene: length and mass of the bristle, and the time of the
    fastest of belt, hub and gravity.
    """
    stiffness = tool.belt.stiffness + tool.bristle.mass * (
        tool.hub.radius * tool.bristle.length / 2.0 * tool.hub.speed**2
        + tool.gravity * tool.bristle.length
    )
    rate = max(math.sqrt(stiffness / tool.bristle.inertia_about_root), tool.hub.speed)
    return Units(
        tool.bristle.length, tool.bristle.mass, 1.0 / rate if rate > SLOWEST_MOTION else 1.0
    )


def build_tool(
    tool: Tool, *, hub_start: float = START, row: Row = ONE_BRISTLE
) -> tuple[Scene, Units]:
    """Return the tool's scene, with exactly the effects that its parameters ask for, and the
    scene's units.
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
        stiffness=tool.belt.stiffness / units.energy
        if tool.belt.stiffness or tool.belt.damping_ratio
        else None,
        damping=tool.belt_damping / units.angular_damping,
        gravity=tool.gravity * units.time / units.velocity,
        pairs=tuple(pairs),
        hinges=wire_hinges(bristle, tool.belt.stiffness, units) * row.bristles,
    )
    return Scene(mechanism, effects), units


def _pairs(tool: Tool, units: Units, first: int) -> Iterator[ContactPair]:
    """Yield the pairs of a wire's links: every link with the bar, and tip and knee with the
    workpart.

    ``first`` is the number of the wire's first link.
    """
    bristle = tool.bristle
    size = units.length
    bar = tool.bar
    part = tool.workpart
    if bar is not None:
        centre = (bar.centre[0] / size, bar.centre[1] / size)
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
        # Link and corner of the wire's tip and knee; corner -1 is the tip of a link.
        corners = [(first + bristle.links - 1, -1)]
        joint = bristle.knee_position * bristle.links
        if len(bristle.path) > 1:
            at_joint = (
                bristle.links > 1 and abs(joint - round(joint)) < bristle.links * SHORTEST_PIECE
            )
            corners.append((first + round(joint) - 1, -1) if at_joint else (first + int(joint), 0))
        for link, corner in corners:
            yield WorkpartPair(*surface, link=link, corner=corner)


def wire_links(bristle: Bristle) -> tuple[Link, ...]:
    """Return the links of a wire, of equal length along it, in units of the bristle's length and
    mass.

    In the unstressed wire, whose shank is along (0, -1), all links have the same angle. The link
    that contains the knee is bent.
    """
    size = bristle.length
    corners = [(0.0, 0.0), *((x / size, y / size) for x, y in bristle.path)]
    borders = [number / bristle.links for number in range(bristle.links + 1)]
    return tuple(_link(_between(corners, *ends)) for ends in itertools.pairwise(borders))


def wire_hinges(
    bristle: Bristle, root_stiffness: float, units: Units
) -> tuple[tuple[float, float], ...]:
    """Return (stiffness, damping) of the torsion spring in each joint between two links, in engine
    units.

    ``root_stiffness`` is the belt's stiffness, N m/rad.
    """
    if bristle.links == 1:
        return ()
    diameter = bristle.wire_diameter
    length = bristle.length
    modulus = bristle.modulus
    stiffness = hinge_stiffness(diameter, length, modulus, bristle.links)
    damping = 0.0
    if bristle.bending_damping_ratio:
        shape = (bristle.mass, length, diameter, modulus, root_stiffness)
        damping = hinge_damping(*shape, bristle.bending_damping_ratio, bristle.links)
    return ((stiffness / units.energy, damping / units.angular_damping),) * (bristle.links - 1)


def _between(corners: list[Vector], low: float, high: float) -> list[Vector]:
    """Return the corners of the centre line between two distances along it from the root."""
    ends = [0.0, *itertools.accumulate(itertools.starmap(math.dist, itertools.pairwise(corners)))]
    inner = [each for each in ends if low + SHORTEST_PIECE < each < high - SHORTEST_PIECE]
    places = [low, *inner, high]
    x, y = (np.interp(places, ends, each).tolist() for each in zip(*corners, strict=True))
    return list(zip(x, y, strict=True))


def _link(corners: list[Vector]) -> Link:
    """Return a uniform wire along corners as a link whose mass is its length."""
    joint = corners[0]
    places = [(x - joint[0], y - joint[1]) for x, y in corners]
    pieces = [
        (math.dist(a, b), 0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]))
        for a, b in itertools.pairwise(places)
    ]
    mass = sum(length for length, _, _ in pieces)
    centre = (sum(m * x for m, x, _ in pieces) / mass, sum(m * y for m, _, y in pieces) / mass)
    inertia = sum(m * (m**2 / 12.0 + math.dist((x, y), centre) ** 2) for m, x, y in pieces)
    return Link(mass, inertia, centre, places[-1], tuple(places[1:-1]))
