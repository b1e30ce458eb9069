"""Contacts of two straight wires of one row: capsules, of which an end touches the other's flank or end.

The normal n points from the second wire to the first one, the tangent is t = -i n, and velocities are those of the first
wire's surface relative to the second's:

    v_n = (J_1 - J_2) theta' + drift,    K = J M^-1 J^T from both wires' rows J = J_1 - J_2.
"""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bristle_sim.arrays import Array
from bristle_sim.reference.contacts import Point, Surface, Touch, dot, touch_of
from bristle_sim.reference.mechanics import Chain, Kinematics
from bristle_sim.reference.row import Row

Complexes = NDArray[np.complex128]


class _Place(NamedTuple):
    """Nearest points of two centre lines: an end of one wire (0 the first one) and its foot on the other.

    ``along`` are their distances from the wires' roots, m.
    """

    distance: float
    end: int
    along: tuple[float, float]


class Wires:
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
        apart = roots[own] - roots[other]
        return float((np.conj(arms[other]) * apart).imag * (np.conj(arms[other]) * (apart + arms[own])).imag)

    return sides(first, second) < 0.0 and sides(second, first) < 0.0
