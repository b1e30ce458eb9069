"""Straight rigid bristles in one plane of one hub: their equations of motion, and their contacts with each other.

Bristle k obeys the lone bristle's equation with its own hub angle, psi_k = psi_0 - k beta + omega t: no term couples two of
them, and the mass matrix is diagonal. Only contacts couple them: of capsules, of which an end touches the other's flank or
end. The normal n points from the second wire to the first one, the tangent is t = -i n, and velocities are those of the
first wire's surface relative to the second's:

    v_n = (J_1 - J_2) theta' + drift,    K = J M^-1 J^T from both wires' rows J = J_1 - J_2.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.parameters import Surface, Tool
from bristle_sim.reference.contacts import Point, Touch, dot, touch_of
from bristle_sim.reference.mechanics import Chain, Complexes, Kinematics


class Row:
    """Bristles that start at given hub angles, rad, as one system whose link k is bristle k.

    It answers what a chain of links answers, see :class:`bristle_sim.reference.mechanics.Chain`.
    """

    def __init__(self, tool: Tool, start_hub_angles: Sequence[float]) -> None:
        count = len(start_hub_angles)
        self.bristles = tuple(Chain.of(tool, each) for each in start_hub_angles)
        one = self.bristles[0]
        # The chain's formulas broadcast: here over bristles of one link each.
        self._all = dataclasses.replace(one, start_hub_angle=np.array(start_hub_angles))
        self.speed, self.hub_radius, self.length = one.speed, one.hub_radius, one.length
        self.fastest_rate = one.fastest_rate
        self.masses, self.ends = np.tile(one.masses, count), np.tile(one.ends, count)
        self.pieces = tuple(one.pieces[0]._replace(link=link) for link in range(count))

    @property
    def links(self) -> int:
        """How many bristles."""
        return len(self.bristles)

    @property
    def tips(self) -> tuple[int, ...]:
        """Return the pieces that end at a bristle's tip: all."""
        return tuple(range(self.links))

    @property
    def corners(self) -> tuple[int, ...]:
        """Return the pieces whose end can touch a flat surface: all."""
        return self.tips

    def mass_matrix(self, turn: Complexes) -> Array:
        """Return the mass matrix, kg m^2."""
        return np.diag(self._all.mass_matrix(turn[:, None])[:, 0, 0])

    def forces(self, time: float, angles: Array, rates: Array, turn: Complexes) -> Array:
        """Return the generalized forces of inertia, belt and gravity, N m."""
        return self._all.forces(time, angles[:, None], rates[:, None], turn[:, None])[:, 0]

    def kinematics(self, time: Any, angles: Array, rates: Array) -> Kinematics:
        """Return directions, rates, positions, velocities and accelerations of the bristles."""
        turn, rate, *points = self._all.kinematics(time, angles[:, None], rates[:, None])
        return Kinematics(turn[:, 0], rate[:, 0], *(each[:, 0] for each in points))

    def jacobian(self, motion: Kinematics, link: int, arm: complex, direction: complex) -> Array:
        """Return d(velocity along a direction)/d(theta') of the point at ``arm`` from a bristle's root."""
        del motion
        row = np.zeros(self.links)
        row[link] = (np.conj(direction) * 1j * arm).real
        return row


class _Place(NamedTuple):
    """Nearest points of two centre lines: an end of one wire, its foot on the other, and both distances from the roots, m."""

    distance: float
    end: int
    along: tuple[float, float]


class WirePairs:
    """All pairs of wires of a row, as one obstacle; a contact's piece is the number of its pair."""

    name = "wire"

    def __init__(self, row: Row, diameter: float, surface: Surface) -> None:
        self.diameter = diameter
        self.surface = surface
        self.pairs = list(itertools.combinations(range(row.links), 2))

    def gaps(self, row: Chain | Row, motion: Kinematics) -> Array:
        """Return the gap of every pair, m; minus a diameter where centre lines cross."""
        gaps = []
        for first, second in self.pairs:
            crossed = _crossed(motion.joint, row.ends * motion.turn, first, second)
            gaps.append((0.0 if crossed else self._nearest(row, motion, first, second).distance) - self.diameter)
        return np.array(gaps)

    def touch(self, row: Chain | Row, motion: Kinematics, point: Point) -> Touch:
        """Return the kinematics of a pair's contact."""
        first, second = self.pairs[point.piece]
        place = self._nearest(row, motion, first, second)
        along = row.ends * motion.turn / row.length
        wires = [first, second]
        arms = np.array(place.along) * along[wires]
        ends, carried = motion.joint[wires] + arms, motion.velocity[wires] + 1j * motion.rates[wires] * arms
        normal = complex(ends[0] - ends[1]) / place.distance
        # An end moves with its wire; the normal turns with the flank, or with the line from end to end.
        end, other = place.end, 1 - place.end
        if 0.0 < place.along[other] < row.length:
            spin = float(motion.rates[wires[other]])
        else:
            spin = dot(1j * normal, complex(carried[0] - carried[1])) / place.distance
        reach = (0.5 - end) * self.diameter * normal
        contact, moving = complex(ends[end] - reach), complex(carried[end] - 1j * spin * reach)
        gap = place.distance - self.diameter
        front, back = (touch_of(row, motion, link, gap, normal, contact, spin, moving) for link in wires)
        return Touch(
            gap,
            front.normal_row - back.normal_row,
            front.tangential_row - back.tangential_row,
            (front.velocity[0] - back.velocity[0], front.velocity[1] - back.velocity[1]),
            (front.bias[0] - back.bias[0], front.bias[1] - back.bias[1]),
        )

    @staticmethod
    def _nearest(row: Chain | Row, motion: Kinematics, first: int, second: int) -> _Place:
        """Return the nearest points of two wires: an end of one of them, and its foot on the other."""
        length, along = row.length, row.ends * motion.turn / row.length
        found = []
        for end, (own, other) in enumerate(((first, second), (second, first))):
            for at in (0.0, length):
                apart = motion.joint[own] + at * along[own] - motion.joint[other]
                foot = min(max(dot(along[other], apart), 0.0), length)
                found.append(_Place(abs(apart - foot * along[other]), end, (foot, at) if end else (at, foot)))
        return min(found)


def _crossed(roots: Complexes, arms: Complexes, first: int, second: int) -> bool:
    """Whether two centre lines cross."""

    def sides(own: int, other: int) -> float:
        """Return a number that is negative if one wire's ends lie on different sides of the other's line."""
        apart = roots[own] - roots[other]
        return float((np.conj(arms[other]) * apart).imag * (np.conj(arms[other]) * (apart + arms[own])).imag)

    return sides(first, second) < 0.0 and sides(second, first) < 0.0
