"""A bristle's contact resolved in time: force, motion, work, and the energy balance that its states imply."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from bristle_sim.parameters import Bristle, Surface
from bristle_sim.scene.strike import Chain
from bristle_sim.trajectory import ContactHistory, ContactRecord

__all__ = ["Course", "TimedContact"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Course:
    """Values over time, smooth but at instants that are sampled more than once; both of shape (n,)."""

    time: Array
    values: Array

    def integral(self, start: float, end: float) -> float:
        """From start to end, s, by a cubic spline through each smooth piece."""
        total = 0.0
        for first, last in self._pieces():
            low, high = max(start, self.time[first]), min(end, self.time[last - 1])
            if high > low:
                piece = CubicSpline(self.time[first:last], self.values[first:last])
                total += float(piece.integrate(low, high))
        return total

    def fine(self, points: int) -> tuple[Array, Array]:
        """Time and values on the same splines, with so many points for each sample."""
        parts = []
        for first, last in self._pieces():
            piece = CubicSpline(self.time[first:last], self.values[first:last])
            time = np.linspace(self.time[first], self.time[last - 1], points * (last - first))
            parts.append((time, np.asarray(piece(time))))
        return np.concatenate([time for time, _ in parts]), np.concatenate([values for _, values in parts])

    def _pieces(self) -> list[tuple[int, int]]:
        breaks = np.flatnonzero(np.diff(self.time) <= 0.0) + 1
        edges = [0, *breaks.tolist(), len(self.time)]
        return [(first, last) for first, last in pairwise(edges) if last - first > 1]


@dataclass(frozen=True)
class TimedContact:
    """A radial bristle's contact resolved in time.

    Attributes:
        bristle, surface, chain: what struck what, and how fast.
        record: the scene's, with its history.
        steps, wall_s: what the last strike cost.
    """

    bristle: Bristle
    surface: Surface
    chain: Chain
    record: ContactRecord
    steps: int
    wall_s: float

    @property
    def history(self) -> ContactHistory:
        """The contact in time."""
        assert self.record.history is not None
        return self.record.history

    @cached_property
    def time(self) -> Array:
        """s since the first touch."""
        return np.asarray(self.history.time - self.history.time[0])

    @cached_property
    def deepest(self) -> int:
        """Sample at which compression ends."""
        return int(np.argmax(self.history.penetration))

    @property
    def compression_time(self) -> float:
        """From first touch to the deepest penetration, s."""
        return float(self.time[self.deepest])

    @cached_property
    def resultant(self) -> Course:
        """Resultant force, N."""
        return Course(self.time, np.hypot(self.history.normal_force, self.history.tangential_force))

    def smooth_resultant(self, points: int = 24) -> tuple[Array, Array]:
        """The resultant between its samples too, on the splines that are integrated: time in s, force in N."""
        return self.resultant.fine(points)

    @property
    def peak_force(self) -> float:
        """Largest resultant force, N; it is reached where the penetration is, which is a sample."""
        return float(self.resultant.values.max())

    @cached_property
    def compressive_impulse(self) -> float:
        """Integral of the resultant force over the compression, p_c (Zhang 2020, eq. 3.1), N s."""
        return self.resultant.integral(0.0, self.compression_time)

    @property
    def tip_speed(self) -> float:
        """v_C (2.24), m/s."""
        return self.chain.lengths[0] * self.chain.rates[0] + self.chain.hub_radius * self.chain.hub_speed

    @cached_property
    def hub_angle(self) -> Array:
        """Of the root, rad."""
        return np.asarray(self.chain.hub_angle + self.chain.hub_speed * self.time)

    @cached_property
    def angle(self) -> Array:
        """Of the bristle, rad: its tip is as deep as recorded, its root where the hub carries it."""
        radius, length = self.chain.hub_radius, self.chain.lengths[0]
        height = -radius * math.cos(self.chain.hub_angle) - length * math.cos(self.chain.angles[0])
        cosine = (-radius * np.cos(self.hub_angle) - height + self.history.penetration) / length
        return np.asarray(-np.arccos(np.clip(cosine, -1.0, 1.0)))

    @cached_property
    def rate(self) -> Array:
        """Of the bristle, rad/s, from the tip's velocity along the workpart."""
        along = self.history.tangential_velocity - self.chain.hub_radius * self.chain.hub_speed * np.cos(self.hub_angle)
        return np.asarray(along / (self.chain.lengths[0] * np.cos(self.angle)))

    @cached_property
    def centre_speed(self) -> Array:
        """v_G, m/s."""
        return np.asarray(np.hypot(*self._centre_velocity()))

    @cached_property
    def path(self) -> Array:
        """Length of the tip's way since first touch, m."""
        speed = Course(self.time, np.hypot(self.history.normal_velocity, self.history.tangential_velocity))
        return np.array([speed.integral(0.0, end) for end in self.time])

    @property
    def work(self) -> float:
        """Work of the force on the tip over its path, first touch to last, J; negative.

        Splines through the recorded samples, where the ledger's works are added up in the engine step by step.
        """
        h = self.history
        power = h.normal_force * h.normal_velocity + h.tangential_force * h.tangential_velocity
        return Course(self.time, power).integral(0.0, float(self.time[-1]))

    @property
    def energy_given_up(self) -> float:
        """Energy that bristle and hub give up during the contact, J.

        The hub keeps its speed omega, so its drive does work omega M with the moment M that its rim exerts. The bristle's
        angular momentum about the hub's centre changes by the sum of M and the contact's moment C x F.
        """
        return self.energy_given_up_in_hub_frame - self.chain.hub_speed * self._contact_moment()

    @property
    def work_in_hub_frame(self) -> float:
        """Work of the force on the tip in the frame that turns with the hub, J: from the force's record alone."""
        return self.work - self.chain.hub_speed * self._contact_moment()

    @property
    def energy_given_up_in_hub_frame(self) -> float:
        """What T - omega L falls by, J: Jacobi's integral, which nothing but the contact changes; from states alone."""
        jacobi = self._kinetic_energy() - self.chain.hub_speed * self._angular_momentum()
        return float(jacobi[0] - jacobi[-1])

    def _contact_moment(self) -> float:
        """Integral of the contact's moment about the hub's centre, N m s."""
        h, end = self.history, float(self.time[-1])
        x = self.chain.hub_radius * np.sin(self.hub_angle) + self.chain.lengths[0] * np.sin(self.angle)
        y = -self.chain.hub_radius * np.cos(self.hub_angle) - self.chain.lengths[0] * np.cos(self.angle)
        recorded = Course(self.time, x * h.normal_force - y * h.tangential_force).integral(0.0, end)
        # In stick the record leaves out the force that holds the tip while the hub turns on; the ledger's impulse has it.
        held = self.record.impulse[1] - Course(self.time, h.tangential_force).integral(0.0, end)
        return recorded - float(y[-1]) * held

    def _centre_velocity(self) -> tuple[Array, Array]:
        rim, half = self.chain.hub_radius * self.chain.hub_speed, 0.5 * self.chain.lengths[0] * self.rate
        return (
            rim * np.cos(self.hub_angle) + half * np.cos(self.angle),
            rim * np.sin(self.hub_angle) + half * np.sin(self.angle),
        )

    def _kinetic_energy(self) -> Array:
        return np.asarray(
            0.5 * self.bristle.mass * self.centre_speed**2 + 0.5 * self.bristle.inertia_about_centre * self.rate**2
        )

    def _angular_momentum(self) -> Array:
        """About the hub's centre, kg m^2/s."""
        half = 0.5 * self.chain.lengths[0]
        x = self.chain.hub_radius * np.sin(self.hub_angle) + half * np.sin(self.angle)
        y = -self.chain.hub_radius * np.cos(self.hub_angle) - half * np.cos(self.angle)
        along, away = self._centre_velocity()
        return np.asarray(self.bristle.mass * (x * away - y * along) + self.bristle.inertia_about_centre * self.rate)
