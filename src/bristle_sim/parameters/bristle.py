"""The bristle: a slender wire, straight or with a knee, one rigid rod or a chain of links."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

from bristle_sim.quantity import Declared, count, quantity

Vector = tuple[float, float]

WIRE_KEYS = ("wire_links", "wire_modulus", "wire_damping_ratio")
"""Keys of a wire that bends."""


@dataclass(frozen=True, slots=True)
class Bristle(Declared):
    """Slender wire, straight or with one knee: one rigid rod, or a chain of equal rigid links that bends."""

    length: float = quantity(
        0.027,
        "bristle_length",
        "m",
        at_least=1e-9,
        at_most=1e3,
        source="Zhang 2020, eq. 2.2",
        meaning="length of the wire from root to tip, along its centre line",
    )
    mass: float = quantity(
        8.387e-5,
        "bristle_mass",
        "kg",
        at_least=1e-30,
        at_most=1e6,
        source="Zhang 2020, caption of fig. 2.7",
        meaning="mass of one bristle",
    )
    wire_diameter: float = quantity(
        7.1e-4,
        "wire_diameter",
        "m",
        at_least=0.0,
        at_most=1e2,
        source="Zhang 2020, sec. 4.1: tip ellipse",
        meaning="thickness of the wire, half of which touches the bar",
    )
    knee_position: float = quantity(
        0.75,
        "knee_position",
        "1",
        at_least=0.01,
        at_most=0.99,
        source="assumed: fraction of the length; Zhang 2020, fig. 1.3",
        meaning="distance of the knee from the root, as a fraction of the length",
        needs="knee_angle_deg != 0",
    )
    knee_angle_deg: float = quantity(
        0.0,
        "knee_angle_deg",
        "deg",
        at_least=-90.0,
        at_most=90.0,
        source="straight as in Zhang 2020, fig. 2.5",
        meaning="bend at the knee; positive bends the tip forward, in the hub's sense",
    )
    links: int = count(
        1,
        "wire_links",
        at_least=1,
        at_most=64,
        source="rigid as in Zhang 2020, sec. 2.3",
        meaning="number of equal rigid links of the wire; 1 is a rigid bristle",
    )
    modulus: float = quantity(
        2e11,
        "wire_modulus",
        "Pa",
        above=0.0,
        at_most=1e15,
        source="steel: E = 2e11 Pa",
        meaning="Young's modulus of the wire, which stiffens the hinges between its links",
        needs="wire_links != 1",
    )
    bending_damping_ratio: float = quantity(
        0.0,
        "wire_damping_ratio",
        "1",
        at_least=0.0,
        at_most=1e3,
        source="undamped as in Zhang 2020",
        meaning="damping ratio of the wire's first bending mode",
        needs="wire_links != 1",
    )

    @property
    def path(self) -> tuple[Vector, ...]:
        """Return the centre line's corners from root to tip, seen from the root with the shank along (0, -1), m."""
        if self.knee_angle_deg == 0.0:
            return ((0.0, -self.length),)
        shank, bend = self.knee_position * self.length, math.radians(self.knee_angle_deg)
        rest = self.length - shank
        return ((0.0, -shank), (rest * math.sin(bend), -shank - rest * math.cos(bend)))

    @property
    def tip(self) -> Vector:
        """Return the end of the centre line, seen from the root as in ``path``, m."""
        return self.path[-1]

    @property
    def centre(self) -> Vector:
        """Return the centre of mass, seen from the root as in ``path``, m."""
        x = y = 0.0
        for start, end, fraction in self._pieces():
            x += fraction * 0.5 * (start[0] + end[0])
            y += fraction * 0.5 * (start[1] + end[1])
        return (x, y)

    @property
    def inertia_about_centre(self) -> float:
        """Return the moment of inertia about the centre of mass, m L^2/12 (2.22) for a straight bristle, kg m^2."""
        if self.knee_angle_deg == 0.0:
            return self.mass * self.length**2 / 12.0
        centre, total = self.centre, 0.0
        for start, end, fraction in self._pieces():
            middle = (0.5 * (start[0] + end[0]) - centre[0], 0.5 * (start[1] + end[1]) - centre[1])
            own = ((end[0] - start[0]) ** 2 + (end[1] - start[1]) ** 2) / 12.0
            total += fraction * self.mass * (own + middle[0] ** 2 + middle[1] ** 2)
        return total

    @property
    def inertia_about_root(self) -> float:
        """Return the moment of inertia about the root, m L^2/3 for a straight bristle, kg m^2."""
        if self.knee_angle_deg == 0.0:
            return self.mass * self.length**2 / 3.0
        centre = self.centre
        return self.inertia_about_centre + self.mass * (centre[0] ** 2 + centre[1] ** 2)

    def _pieces(self) -> list[tuple[Vector, Vector, float]]:
        """Return the straight pieces of the centre line with their fractions of the length."""
        corners = ((0.0, 0.0), *self.path)
        return [
            (start, end, math.hypot(end[0] - start[0], end[1] - start[1]) / self.length)
            for start, end in itertools.pairwise(corners)
        ]
