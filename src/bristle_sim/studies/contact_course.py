"""A bristle's contact resolved in time: force, motion, work, and the energy balance that its states imply."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicHermiteSpline, CubicSpline, PPoly

from bristle_sim.arrays import Array
from bristle_sim.parameters import Bristle, Surface
from bristle_sim.scene.strike import Chain
from bristle_sim.trajectory import ContactHistory, ContactRecord

NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)
"""Gauss's rule integrates a product of two cubics exactly."""


def cubics(time: Array, values: Array, slopes: Array | None = None) -> PPoly:
    """Return cubics through samples; they are smooth except at instants sampled more than once, where they jump.

    Times have the shape (n,), values and slopes (n, ...). Without slopes each piece is a spline.
    """
    coefficients = np.zeros((4, len(time) - 1, *values.shape[1:]))
    coefficients[3] = values[:-1]  # in an interval that is rounding
    for first, last in pieces(time):
        own = time[first:last], values[first:last]
        piece = CubicSpline(*own) if slopes is None else CubicHermiteSpline(*own, slopes[first:last])
        coefficients[:, first : last - 1] = piece.c
    return PPoly(coefficients, time)


def pieces(time: Array) -> list[tuple[int, int]]:
    """Return the first sample of each smooth piece and the one past its last; instants that differ by rounding are equal."""
    least = 1e-12 * float(time[-1] - time[0])
    edges = [0, *(np.flatnonzero(np.diff(time) <= least) + 1).tolist(), len(time)]
    return [(first, last) for first, last in pairwise(edges) if last - first > 1]


def trapezoidal_sums(time: Array, values: Array) -> Array:
    """Integrate samples from the first to each by the trapezoidal rule, shape (n,)."""
    return np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(time))])


def compression_end(history: ContactHistory) -> float:
    """Return the time from the first touch to the deepest penetration, s; it is a sample."""
    return float(history.time[int(np.argmax(history.penetration))] - history.time[0])


@dataclass(frozen=True)
class TimedContact:
    """A radial bristle's contact resolved in time, the scene's record of it, and the cost of the last strike.

    Series have one entry a sample. The rate follows from the tip's velocity along the workpart.
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

    @property
    def compression_time(self) -> float:
        """From first touch to the deepest penetration, s."""
        return compression_end(self.history)

    @property
    def tip_speed(self) -> float:
        """v_C (2.24), m/s."""
        return self.chain.lengths[0] * self.chain.rates[0] + self.chain.hub_radius * self.chain.hub_speed

    @cached_property
    def force(self) -> Array:
        """Resultant force, N."""
        return np.asarray(np.hypot(1.0, self._ratio_and_slope[0]) * self.history.normal_force)

    @cached_property
    def resultant(self) -> PPoly:
        """Resultant force as a function of time, N."""
        ratio, slope = self._ratio_and_slope
        return cubics(self.time, self.force, np.hypot(1.0, ratio) * slope)

    @property
    def peak_force(self) -> float:
        """Largest resultant force, N; it is reached at the deepest penetration, which is a sample."""
        return float(self.force.max())

    @property
    def compressive_impulse(self) -> float:
        """Integral of the resultant force over the compression, p_c (Zhang 2020, eq. 3.1), N s."""
        return float(self.resultant.integrate(0.0, self.compression_time))

    @property
    def path(self) -> Array:
        """Length of the tip's path since first touch, m."""
        return self._sums(np.hypot(self.history.normal_velocity, self.history.tangential_velocity))

    @cached_property
    def hub_angle(self) -> Array:
        """Angle of the root, rad."""
        return np.asarray(self.chain.hub_angle + self.chain.hub_speed * self.time)

    @cached_property
    def tip(self) -> tuple[Array, Array]:
        """Position of the tip from the hub's centre, along and above the workpart, m."""
        radius, length = self.chain.hub_radius, self.chain.lengths[0]
        start, angle = self.chain.hub_angle, self.chain.angles[0]
        along = radius * math.sin(start) + length * math.sin(angle) + self._sums(self.history.tangential_velocity)
        return along, -radius * math.cos(start) - length * math.cos(angle) - self.history.penetration

    @cached_property
    def angle(self) -> Array:
        """Angle of the bristle from its root on the hub to its tip, rad."""
        (along, above), radius = self.tip, self.chain.hub_radius
        return np.arctan2(along - radius * np.sin(self.hub_angle), -radius * np.cos(self.hub_angle) - above)

    @cached_property
    def rate(self) -> Array:
        """Rate of the bristle, rad/s."""
        along = self.history.tangential_velocity - self.chain.hub_radius * self.chain.hub_speed * np.cos(self.hub_angle)
        return np.asarray(along / (self.chain.lengths[0] * np.cos(self.angle)))

    @property
    def centre_speed(self) -> Array:
        """v_G, m/s."""
        rim, half = self.chain.hub_radius * self.chain.hub_speed, 0.5 * self.chain.lengths[0] * self.rate
        return np.sqrt(rim**2 + half**2 + 2.0 * rim * half * np.cos(self.angle - self.hub_angle))

    @property
    def work(self) -> float:
        """Work of the force on the tip from first to last touch, J, from the recorded samples; negative."""
        # Force and speed are cubics each: of the force the slopes are known, which few samples of their product lack.
        h, (ratio, slope) = self.history, self._ratio_and_slope
        speed = cubics(self.time, h.normal_velocity + ratio * h.tangential_velocity)
        force, half = cubics(self.time, h.normal_force, slope), 0.5 * np.diff(self.time)
        at = self.time[:-1, None] + half[:, None] * (1.0 + NODES)
        return float(half @ (force(at) * speed(at)) @ WEIGHTS)

    @property
    def energy_given_up(self) -> float:
        """Energy that bristle and hub give up during the contact, J; the hub's drive works on the moment of its rim.

        It is computed from states alone: the decrease of Jacobi's integral (the energy in the hub's frame), which only the
        contact changes, less the work omega M of the contact's moment about the hub's centre.
        """
        omega, field = self.chain.hub_speed, self.bristle.mass * self.chain.hub_radius * self.chain.lengths[0]
        turning = 0.5 * self.bristle.inertia_about_root * (self.rate - omega) ** 2
        jacobi = turning - 0.5 * field * omega**2 * np.cos(self.angle - self.hub_angle)
        h, end, (ratio, slope), (along, above) = self.history, self.time[-1], self._ratio_and_slope, self.tip
        lever, turning = along - ratio * above, h.tangential_velocity + ratio * h.normal_velocity
        slopes = lever * slope + turning * h.normal_force
        moment = float(cubics(self.time, lever * h.normal_force, slopes).integrate(0.0, end))
        # In stick the samples leave out the force that keeps the tip in place; the record's impulse includes it.
        rubbed = float(cubics(self.time, ratio * h.normal_force, ratio * slope).integrate(0.0, end))
        moment -= float(above[-1]) * (self.record.impulse[1] - rubbed)
        return float(jacobi[0] - jacobi[-1]) - omega * moment

    def _sums(self, values: Array) -> Array:
        return np.asarray(cubics(self.time, values).antiderivative()(self.time))

    @cached_property
    def _ratio_and_slope(self) -> tuple[Array, Array]:
        """Tangential over normal force, and the slope of the normal force, N/s, by a stiffness; constant in each piece."""
        h, (ratio, slope) = self.history, np.zeros((2, len(self.time)))
        for first, last in pieces(self.time):
            force, depth = h.normal_force[first:last], h.penetration[first:last]
            top = int(np.argmax(force))
            if force[top] > 0.0:
                ratio[first:last] = h.tangential_force[first + top] / force[top]
            deeper = depth[-1] - depth[0]
            stiffness = (force[-1] - force[0]) / deeper if deeper else 0.0
            slope[first:last] = -stiffness * h.normal_velocity[first:last]
        return ratio, slope
