"""The shape of one crater that a tip cuts into a plane, as a formula.

x runs along the slide and y across it, from the middle of the crater's outline. ``shape`` is the
height of the crater's surface above the crater's lowest point. After the cut the ground is at each
place the lower one of the old ground and the shape. The shape is defined beyond the outline too,
for a tip that meets higher ground. Lengths in m.

``SweptTip``: the tip's face, half an ellipse, moves along a straight path that descends at the
impact angle gamma. The edge of the face is z_e(y) = D (1 - sqrt(1 - (2 y/d)^2)) above the lowest
point of the face, with the wire's diameter d and the depth D at which the cut is as wide as the
wire. From the edge the face rises forward at phi = 28 deg to the surface (Zhang 2020, eqs.
4.9-4.14). Behind the tip's last position x_t the height of the floor is therefore
z_e(y) (1 + tan(gamma)/tan(phi)) - (x - x_t) tan(gamma). Ahead of x_t the crater ends in the imprint
of the face, whose height is (x - x_t) tan(phi). At a depth of 106 um the volume of this shape is
6 % larger than the chip volume V of ``crater_cutting``. With an upright wall instead of the imprint
the volume would be 42 % smaller than V.

``Paraboloid``: 4 depth (x^2/length^2 + y^2/width^2), a crater of given depth, length and width.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.arrays import Array, Number
from bristle_sim.theory.crater_kinematics import IMPACT_ANGLE, PRINTED_FACE, TipFace

# Distance by which rounding may put a point beside the wire, as a fraction of the wire's radius.
ROUNDING = 1e-9


@dataclass(frozen=True, slots=True)
class Paraboloid:
    """A crater whose sections along and across the tip's slide are parabolas.

    Attributes:
        depth: depth of the crater, m.
        length: length of its outline along the slide, m.
        width: width of its outline across the slide, m.

    >>> crater = Paraboloid(130e-6, 325e-6, 651e-6)
    >>> print(f"{1e6 * crater.area():.3f} mm^2, {1e9 * crater.volume():.5f} mm^3")
    0.166 mm^2, 0.01080 mm^3
    """

    depth: float
    length: float
    width: float

    @property
    def lowest(self) -> float:
        """Coordinate x of the lowest point, m: 0, the middle of the crater."""
        return 0.0

    def shape(self, x: Array, y: Array) -> Array:
        """Return the height of the crater's surface above its lowest point, m, shape (y, x).

        The grid consists of all pairs of the coordinates ``x`` along and ``y`` across the slide, m.
        """
        return 4.0 * self.depth * np.add.outer((y / self.width) ** 2, (x / self.length) ** 2)

    def reach(self, height: float) -> tuple[float, float, float]:
        """Return the crater's extent at a height (m) above its lowest point, m.

        Returns:
            The least x, the largest x and the largest y of the region below this height.
        """
        part = 0.5 * math.sqrt(height / self.depth)
        return -part * self.length, part * self.length, part * self.width

    def area(self) -> float:
        """Return the area of the crater's elliptic outline on a plane surface, m^2."""
        return math.pi / 4.0 * self.length * self.width

    def volume(self, depth: ArrayLike | None = None) -> Number:
        """Return the volume of the crater below the plane surface, m^3.

        If ``depth`` (m) is given, only the lowest layer of this thickness counts.
        """
        ratio = 1.0 if depth is None else np.asarray(depth) / self.depth
        return 0.5 * self.area() * self.depth * ratio**2


@dataclass(frozen=True, slots=True)
class SweptTip:
    """The crater that the elliptic face of the tip sweeps on a straight descending path.

    Attributes:
        depth: depth of the crater, m.
        impact_angle: angle gamma of the path to the surface, rad.
        face: cutting face of the tip.

    At the printed depth of 130 um and 23.4 deg the width is the printed one (Zhang 2020, fig. 4.6):

    >>> print(f"{1e6 * SweptTip(130e-6).width:.0f} um")
    651 um
    """

    depth: float
    impact_angle: float = IMPACT_ANGLE
    face: TipFace = PRINTED_FACE

    @property
    def length_ratio(self) -> float:
        """Ratio of the crater's length to its depth, cot(gamma) + cot(phi).

        gamma is the impact angle, phi the angle of the tip's face to the surface.
        """
        return 1.0 / math.tan(self.impact_angle) + 1.0 / math.tan(self.face.face_angle)

    @property
    def length(self) -> float:
        """Length of the crater's outline along the slide, m."""
        return self.depth * self.length_ratio

    @property
    def width(self) -> float:
        """Largest width of the crater's outline, m (Zhang 2020, eq. 4.14).

        The outline is widest at the tip's last position.
        """
        return float(self.face.width(self.depth))

    @property
    def lowest(self) -> float:
        """Coordinate x of the lowest point, m: the tip's last position."""
        return 0.5 * self.length - self.depth / math.tan(self.face.face_angle)

    def shape(self, x: Array, y: Array) -> Array:
        """Return the height of the crater's surface above its lowest point, m, shape (y, x).

        The grid consists of all pairs of the coordinates ``x`` along and ``y`` across the slide, m.
        Where |y| exceeds the wire's radius, the height is infinite.
        """
        sine = 2.0 * np.abs(y) / self.face.short_axis
        edge = self.face.full_depth * (1.0 - np.sqrt(np.maximum(1.0 - sine**2, 0.0)))
        edge = np.where(sine <= 1.0 + ROUNDING, edge, math.inf)
        ahead = x - self.lowest
        slope = math.tan(self.impact_angle)
        floor = np.add.outer(edge * slope * self.length_ratio, -ahead * slope)
        return np.maximum(floor, ahead * math.tan(self.face.face_angle))

    def reach(self, height: float) -> tuple[float, float, float]:
        """Return the crater's extent at a height (m) above its lowest point, m.

        Returns:
            The least x, the largest x and the largest y of the region below this height.
        """
        start = self.lowest - height / math.tan(self.impact_angle)
        return start, start + height * self.length_ratio, 0.5 * float(self.face.width(height))

    def area(self) -> float:
        """Return the area of the crater's outline on a plane surface, m^2.

        The area is (cot(gamma) + cot(phi)) times the integral of depth - z_e(y) over y. gamma is
        the impact angle, phi the angle of the face to the surface, z_e(y) the height of the face's
        edge above the edge's lowest point.
        """
        last, sine, above = self._edge(self.depth)
        section = 2.0 * above * sine + self.face.full_depth * (last + sine * np.cos(last))
        return float(0.5 * self.face.short_axis * section * self.length_ratio)

    def volume(self, depth: ArrayLike | None = None) -> Number:
        """Return the volume of the crater below the plane surface, m^3.

        The volume is (cot(gamma) + cot(phi))/2 times the integral of (depth - z_e(y))^2 over y.
        gamma is the impact angle, phi the angle of the face to the surface, z_e(y) the height of
        the face's edge above the edge's lowest point. If ``depth`` (m) is given, only the lowest
        layer of this thickness counts.
        """
        last, sine, above = self._edge(self.depth if depth is None else depth)
        full = self.face.full_depth
        squares = 2.0 * above**2 * sine + 2.0 * above * full * (last + sine * np.cos(last))
        cubes = full**2 * (2.0 * sine - 2.0 / 3.0 * sine**3)
        return 0.25 * self.face.short_axis * (squares + cubes) * self.length_ratio

    def _edge(self, depth: ArrayLike) -> tuple[Number, Number, Number]:
        """Return where the edge of the elliptic face meets the surface, for a depth of the tip (m).

        A point of the edge has the angle theta, y = (d/2) sin(theta) and z_e = D (1 - cos(theta)),
        with the wire's diameter d and the depth D at which half the ellipse is below the surface.

        Returns:
            The angle theta at the surface (rad), its sine, and the depth minus D (m).
        """
        full = self.face.full_depth
        below = np.asarray(depth, dtype=float)
        last = np.arccos(np.maximum(1.0 - below / full, 0.0))
        return last, np.sin(last), below - full


CraterBody = Paraboloid | SweptTip
