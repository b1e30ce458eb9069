"""Equations of motion of straight rigid bristles in one plane of one hub.

Bristle k obeys the lone bristle's equation with its own hub angle, psi_k = psi_0 - k beta + omega t: no term couples two of
them, and the mass matrix is diagonal. Only contacts couple them.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bristle_sim.arrays import Array
from bristle_sim.parameters import Tool
from bristle_sim.reference.mechanics import Chain, Kinematics


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

    def mass_matrix(self, turn: NDArray[np.complex128]) -> Array:
        """Return the mass matrix, kg m^2."""
        return np.diag(self._all.mass_matrix(turn[:, None])[:, 0, 0])

    def forces(self, time: float, angles: Array, rates: Array, turn: NDArray[np.complex128]) -> Array:
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
