"""Positions between a trajectory's samples: cubic interpolation from impact to impact, and the wire's kinematics."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

from bristle_sim.parameters import Tool
from bristle_sim.trajectory import Trajectory

__all__ = ["Course", "Motion", "direction", "tip_speed", "wire_ends"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Course:
    """A run sampled closely enough to draw: arrays of one length, SI units and radians.

    Attributes:
        time: s; two samples share the instant of an impact.
        hub_angle: of the first link's root, rad.
        angles, rates: of each link, shape (n, links), rad and rad/s.
        relative_angle, relative_rate: of the first link relative to the hub, rad and rad/s.
    """

    time: Array
    hub_angle: Array
    angles: Array
    rates: Array
    relative_angle: Array
    relative_rate: Array


class Motion:
    """A trajectory at any instant: cubic in each stretch between impacts, continuous in angle and rate.

    Two samples that share an instant (before and after an impact) end one stretch and begin the next; at that very
    instant the later one holds. Instants outside the run are taken as its ends.

    Raises:
        ValueError: if the run has no two different instants.
    """

    def __init__(self, trajectory: Trajectory) -> None:
        self._trajectory = trajectory
        time = trajectory.time
        cuts = np.flatnonzero(np.diff(time) <= 0.0) + 1
        stretches = [part for part in np.split(np.arange(time.size), cuts) if part.size > 1]
        if not stretches:
            raise ValueError(f"trajectory: {time.size} sample(s) at one instant, two instants are needed to draw it")
        self._stretches = stretches
        self._starts = np.array([time[part[0]] for part in stretches])
        self._splines = [
            CubicHermiteSpline(time[part], trajectory.angles[part], trajectory.rates[part]) for part in stretches
        ]
        self.start, self.end = float(time[0]), float(time[-1])

    def angles(self, time: ArrayLike) -> Array:
        """Absolute angle of each link, rad, shape (*time.shape, links)."""
        return self._evaluate(time, 0)

    def rates(self, time: ArrayLike) -> Array:
        """Absolute rate of each link, rad/s, shape (*time.shape, links)."""
        return self._evaluate(time, 1)

    def hub_angle(self, time: ArrayLike) -> Array:
        """Angle of the first link's root, rad, shape of time."""
        return np.asarray(np.interp(np.asarray(time), self._trajectory.time, self._trajectory.hub_angle))

    def relative_angle(self, time: ArrayLike) -> Array:
        """Angle of the first link relative to the radial direction, rad, shape of time."""
        return np.asarray(self.angles(time)[..., 0] - self.hub_angle(time))

    def relative_rate(self, time: ArrayLike) -> Array:
        """Rate of the first link relative to the hub, rad/s, shape of time."""
        return np.asarray(self.rates(time)[..., 0] - self._trajectory.hub_speed)

    def course(self, until: float = math.inf, points: int = 1500) -> Course:
        """The run up to an instant at every sample and at ``points`` further instants, evenly spaced."""
        if not until > self.start:
            raise ValueError(f"until = {until:g}: an instant after the run's start at {self.start:g} is allowed (in s)")
        end = min(until, self.end)
        even = np.linspace(self.start, end, points)
        time, angles, rates = [], [], []
        for spline in self._splines:
            instants = np.union1d(spline.x, even[(even > spline.x[0]) & (even < spline.x[-1])])
            instants = instants[instants <= end]
            time.append(instants)
            angles.append(spline(instants))
            rates.append(spline(instants, 1))
        joined, angle, rate = np.concatenate(time), np.concatenate(angles), np.concatenate(rates)
        hub_angle = self.hub_angle(joined)
        speed = self._trajectory.hub_speed
        return Course(joined, hub_angle, angle, rate, angle[:, 0] - hub_angle, rate[:, 0] - speed)

    def along(self, course: Course, samples: Array) -> Array:
        """A quantity known at the samples, interpolated without overshoot at a course's instants, shape (n,)."""
        pieces = []
        for part in self._stretches:
            instants = self._trajectory.time[part]
            inside = course.time[(course.time >= instants[0]) & (course.time <= instants[-1])]
            pieces.append(PchipInterpolator(instants, samples[part])(np.unique(inside)))
        return np.concatenate(pieces)

    def _evaluate(self, time: ArrayLike, derivative: int) -> Array:
        instants = np.clip(np.asarray(time, dtype=float), self.start, self.end)
        stretch = np.searchsorted(self._starts, instants, side="right") - 1
        result = np.empty((*instants.shape, self._trajectory.angles.shape[1]))
        for number in np.unique(stretch):
            here = stretch == number
            result[here] = self._splines[number](instants[here], derivative)
        return result


def direction(angle: ArrayLike) -> Array:
    """Unit vector (sin, -cos) of an angle measured from the direction of the workpart, shape (*angle.shape, 2)."""
    return np.stack([np.sin(angle), -np.cos(angle)], axis=-1)


def wire_ends(tool: Tool, hub_angle: ArrayLike, angle: ArrayLike) -> tuple[Array, Array]:
    """Root and tip of the wire's centre line, m, each of shape (*angle.shape, 2)."""
    root = tool.hub.radius * direction(hub_angle)
    return root, root + tool.bristle.length * direction(angle)


def tip_speed(tool: Tool, hub_angle: ArrayLike, angle: ArrayLike, rate: ArrayLike) -> Array:
    """Speed of the tip over the workpart, |r_h omega e(hub) + L rate e(wire)| with e = (cos, sin), m/s."""
    rim_speed, swing_speed = tool.hub.radius * tool.hub.speed, tool.bristle.length * np.asarray(rate)
    along = rim_speed * np.cos(hub_angle) + swing_speed * np.cos(angle)
    across = rim_speed * np.sin(hub_angle) + swing_speed * np.sin(angle)
    return np.asarray(np.hypot(along, across))
