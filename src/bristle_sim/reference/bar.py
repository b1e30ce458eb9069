"""The bar, a circle, and which point of the wire is on it."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from bristle_sim.reference.mechanics import Mechanics, Number, Vector, dot
from bristle_sim.reference.touch import Touch, centripetal, contact

__all__ = ["Circle"]


class Nearest(NamedTuple):
    """The centre line's point nearest to the bar, seen from the root along world axes, and how far away it is.

    ``cornered`` where it is a knee or an end, not on a straight piece.
    """

    distance: Number
    arm: Vector
    cornered: Number


@dataclass(frozen=True, slots=True)
class Circle:
    """The bar. The centre line keeps ``reach`` = r_b + d/2 from its centre; the wire's knee and end are round.

    ``corners`` are those of the centre line, or of a part of it, from the root outwards. With knees of at most 90 degrees
    they get ever farther from the root, so that a bar at the distance D from the root meets one point of each side.
    """

    mechanics: Mechanics
    corners: tuple[complex, ...]
    centre: complex
    reach: float
    wire_radius: float
    friction: float
    friction_in_restitution: float
    restitution: float
    name: str = "bar"

    def gap(self, angle: Number, hub_angle: Number) -> Number:
        """Distance of the centre line from the bar's centre less the reach, m."""
        return self._nearest(self.mechanics.root(hub_angle), hub_angle + angle).distance - self.reach

    def touch(self, angle: Number, rate: Number, hub_angle: Number) -> Touch:
        """Kinematics where wire and bar touch: on the wire's surface, d/2 from its centre line."""
        root = self.mechanics.root(hub_angle)
        nearest = self._nearest(root, hub_angle + angle)
        outward = root + nearest.arm - self.centre
        normal = outward / np.abs(outward)
        corner = self._corner_bend(normal, root, nearest.arm, rate)
        bend = np.where(nearest.cornered, corner, self._flank_bend(normal, root, rate))
        return contact(self.mechanics, normal, nearest.arm - self.wire_radius * normal, root, bend)

    def parts(self, side: float) -> tuple[Circle, ...]:
        """The wire; shank and rest apart where the knee opens towards the bar, which strikes one when held by the other."""
        first, last = self.corners[1] - self.corners[0], self.corners[-1] - self.corners[-2]
        if side * (last / first).imag >= 0.0:
            return (self,)
        return tuple(replace(self, corners=piece) for piece in itertools.pairwise(self.corners))

    def held_angle(self, hub_angle: Number, side: float) -> Number:
        """Direction of the bar's centre from the root, less where the wire has it at that distance.

        With D the distance, sin = q/D where a piece touches whose flank on that side, ``reach`` off its centre line,
        passes the root at q; where a corner p does, the law of cosines in the triangle (D, |p|, reach).
        """
        centre = (self.centre - self.mechanics.root(hub_angle)) / self.mechanics.direction(hub_angle)
        distance, passed = np.abs(centre), sum(seam(hub_angle) > 0.0 for seam in self.seams(side))
        return np.angle(centre) - np.choose(passed, self._directions(distance, side))

    def within_reach(self, hub_angle: Number) -> Number:
        """Distance of the wire's end from the root and reach less the distance of the bar's centre from the root, m."""
        return np.abs(self.corners[-1]) + self.reach - self._distance(hub_angle)

    def seams(self, side: float) -> list[Callable[[Number], Number]]:
        """D^2 less its values where the touch passes between corners and flanks, from the root outwards."""
        levels = []
        for start, end in itertools.pairwise(self.corners):
            along, offset = self._flank(start, end, side)
            levels += [offset**2 + dot(along, corner) ** 2 for corner in (start, end)]
        return [partial(self._past, level) for level in levels]

    def ahead(self, hub_angle: float) -> bool:
        """Whether the root is within half a turn before the bar's direction."""
        return bool((self.centre / self.mechanics.direction(hub_angle)).imag > 0.0)

    def _distance(self, hub_angle: Number) -> Number:
        """Distance D of the bar's centre from the root, m."""
        return np.abs(self.centre - self.mechanics.root(hub_angle))

    def _past(self, level: float, hub_angle: Number) -> Number:
        return self._distance(hub_angle) ** 2 - level

    def _nearest(self, root: Vector, absolute_angle: Number) -> Nearest:
        turn = np.exp(1j * absolute_angle)
        found = [self._on_piece(root, turn, *piece) for piece in itertools.pairwise(self.corners)]
        best = found[0]
        for each in found[1:]:
            closer = each.distance < best.distance
            best = Nearest(*(np.where(closer, new, old) for new, old in zip(each, best, strict=True)))
        return best

    def _on_piece(self, root: Vector, turn: Vector, start: complex, end: complex) -> Nearest:
        """The nearest point of one straight piece."""
        length = abs(end - start)
        along, origin = (end - start) / length * turn, start * turn
        foot = dot(self.centre - root - origin, along)
        held = np.clip(foot, 0.0, length)
        arm = origin + held * along
        return Nearest(np.abs(root + arm - self.centre), arm, foot != held)

    def _flank(self, start: complex, end: complex, side: float) -> tuple[complex, float]:
        """Direction of a piece, and the lever q of its flank on one side about the root, positive ahead of it, m."""
        along = (end - start) / abs(end - start)
        return along, float(dot(1j * along, start)) - side * self.reach

    def _directions(self, distance: Number, side: float) -> list[Number]:
        """Angles ahead of the shank at which corners and flanks in turn, from the root outwards, have the bar's centre."""
        found = []
        for start, end in itertools.pairwise(self.corners):
            along, offset = self._flank(start, end, side)
            leaning = np.angle(1j * along) + np.arcsin(np.clip(offset / distance, -1.0, 1.0))
            found += [self._around(start, distance, side), leaning]
        return [*found, self._around(self.corners[-1], distance, side)]

    def _around(self, corner: complex, distance: Number, side: float) -> Number:
        """The angle at which the bar touches a corner."""
        length = abs(corner)
        if not length:
            return np.zeros_like(distance)
        cosine = (distance**2 + length**2 - self.reach**2) / (2.0 * length * distance)
        return np.angle(1j * corner) - side * np.arccos(np.clip(cosine, -1.0, 1.0))

    def _flank_bend(self, normal: Vector, root: Vector, rate: Number) -> Number:
        """Second derivative of the centre's distance from a line of the wire.

        Seen from the wire, which turns at phi', the bar's centre turns at -phi' and the root at -alpha', both about the
        hub's centre.
        """
        absolute = self.mechanics.speed + rate
        return dot(normal, absolute**2 * self.centre - rate**2 * root)

    def _corner_bend(self, normal: Vector, root: Vector, arm: Vector, rate: Number) -> Number:
        """Second derivative of a corner's distance: its acceleration outward plus v_t^2 over the distance."""
        absolute = self.mechanics.speed + rate
        sliding = dot(-1j * normal, 1j * (self.mechanics.speed * root + absolute * arm))
        return centripetal(self.mechanics, normal, root, arm, absolute) + sliding**2 / self.reach
