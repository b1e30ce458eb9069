"""The links that a bristle is cut into, and the torsion springs between them, for a scene."""

from __future__ import annotations

import itertools
import math

from bristle_sim.parameters import Bristle
from bristle_sim.scene.mechanism import Link, Vector
from bristle_sim.scene.units import Units
from bristle_sim.theory.wire import hinge_damping, hinge_stiffness

SHORTEST_PIECE = 1e-12
"""Fraction of the wire's length below which a straight piece of a link is rounding: the knee is at the joint."""


def wire_links(bristle: Bristle) -> tuple[Link, ...]:
    """Return the links of a wire, equally long along it, in units of the bristle's length and mass.

    They are seen from their joints as in the unstressed wire whose shank is along (0, -1), so that all have the same angle
    then. The link that holds the wire's knee is bent; a knee at a joint makes the next link point the other way.
    """
    size = bristle.length
    if bristle.links == 1:
        *knees, tip = ((x / size, y / size) for x, y in bristle.path)
        centre = (bristle.centre[0] / size, bristle.centre[1] / size)
        return (Link(1.0, bristle.inertia_about_centre / (bristle.mass * size**2), centre, tip, tuple(knees)),)
    corners = [(0.0, 0.0), *((x / size, y / size) for x, y in bristle.path)]
    borders = [number / bristle.links for number in range(bristle.links + 1)]
    return tuple(_link(_between(corners, *ends)) for ends in itertools.pairwise(borders))


def wire_hinges(bristle: Bristle, root_stiffness: float, units: Units) -> tuple[tuple[float, float], ...]:
    """Return stiffness and damping of the torsion spring in each joint between two links, in a scene's units.

    Args:
        bristle: whose links they join.
        root_stiffness: of the belt, N m/rad, which the first bending mode depends on.
        units: of the scene.
    """
    if bristle.links == 1:
        return ()
    wire = (bristle.wire_diameter, bristle.length, bristle.modulus)
    stiffness, damping = hinge_stiffness(*wire, bristle.links), 0.0
    if bristle.bending_damping_ratio:
        shape = (bristle.mass, bristle.length, bristle.wire_diameter, bristle.modulus, root_stiffness)
        damping = hinge_damping(*shape, bristle.bending_damping_ratio, bristle.links)
    return ((stiffness / units.energy, damping / units.angular_damping),) * (bristle.links - 1)


def _between(corners: list[Vector], low: float, high: float) -> list[Vector]:
    """Return the corners of the centre line between two distances along it from the root."""
    found: list[Vector] = []
    passed = 0.0
    for start, end in itertools.pairwise(corners):
        length = math.dist(start, end)
        for place in (max(low - passed, 0.0), min(high - passed, length)):
            if (
                -SHORTEST_PIECE < place < length + SHORTEST_PIECE
                and low - SHORTEST_PIECE < passed + place < high + SHORTEST_PIECE
            ):
                fraction = place / length
                point = (start[0] + fraction * (end[0] - start[0]), start[1] + fraction * (end[1] - start[1]))
                if not found or math.dist(found[-1], point) > SHORTEST_PIECE:
                    found.append(point)
        passed += length
    return found


def _link(corners: list[Vector]) -> Link:
    """Return a uniform wire along corners as a link whose mass is its length."""
    joint = corners[0]
    places = [(x - joint[0], y - joint[1]) for x, y in corners]
    pieces = [(math.dist(a, b), 0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])) for a, b in itertools.pairwise(places)]
    mass = sum(length for length, _, _ in pieces)
    centre = (sum(m * x for m, x, _ in pieces) / mass, sum(m * y for m, _, y in pieces) / mass)
    inertia = sum(m * (m**2 / 12.0 + math.dist((x, y), centre) ** 2) for m, x, y in pieces)
    return Link(mass, inertia, centre, places[-1], tuple(places[1:-1]))
