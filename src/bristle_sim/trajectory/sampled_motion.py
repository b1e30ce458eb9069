"""Interpolate a trajectory between its samples: interpolation from impact to impact, of what the run itself recorded."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicHermiteSpline, CubicSpline

from bristle_sim.arrays import Array
from bristle_sim.trajectory.trajectory import Trajectory


@dataclass(frozen=True, slots=True)
class Course:
    """A run sampled closely enough to draw: arrays of one length n, SI units and radians.

    Attributes:
        time: s; two samples share the instant of an impact.
        retraction: of the first link, positive when it lags the radial direction, rad.
        relative_speed: of the first link, its rate relative to the hub, rad/s.
        centre_line: root, corners and tip from the hub's centre, shape (n, corners, 2), m.
    """

    time: Array
    retraction: Array
    relative_speed: Array
    centre_line: Array

    @property
    def tip(self) -> Array:
        """Return where the centre line ends, shape (n, 2), m."""
        return self.centre_line[:, -1]


class SampledMotion:
    """A trajectory at any instant, by cubics between samples that meet the recorded positions and velocities.

    Two samples that share an instant (before and after an impact) end one interval and begin the next; at that very
    instant the later one holds. Instants outside the run are taken as its ends.

    Raises:
        ValueError: if the run has no two different instants.
    """

    def __init__(self, trajectory: Trajectory) -> None:
        self._trajectory = trajectory
        time = trajectory.time
        cuts = np.flatnonzero(np.diff(time) <= 0.0) + 1
        intervals = [part for part in np.split(np.arange(time.size), cuts) if part.size > 1]
        if not intervals:
            raise ValueError(f"trajectory: {time.size} sample(s) at one instant, two instants are needed to draw it")
        self._intervals = intervals
        self._starts = np.array([time[part[0]] for part in intervals])
        retraction, relative_speed = trajectory.retraction, trajectory.relative_rate
        self._retractions = [CubicHermiteSpline(time[at], retraction[at], -relative_speed[at]) for at in intervals]
        self._lines = [
            CubicHermiteSpline(time[at], trajectory.centre_line[at], trajectory.centre_line_velocity[at])
            for at in intervals
        ]
        self.start, self.end = float(time[0]), float(time[-1])

    def hub_angle(self, time: ArrayLike) -> Array:
        """Return the angle of the first link's root, rad, shape of time."""
        return np.asarray(np.interp(np.asarray(time), self._trajectory.time, self._trajectory.hub_angle))

    def retraction(self, time: ArrayLike) -> Array:
        """Return the angle by which the first link lags the radial direction, rad, shape of time."""
        return self._evaluate(self._retractions, time)

    def centre_line(self, time: ArrayLike) -> Array:
        """Return root, corners and tip from the hub's centre, m, shape (*time.shape, corners, 2)."""
        return self._evaluate(self._lines, time)

    def tip_speed(self, time: ArrayLike) -> Array:
        """Return the speed of the tip over the workpart, m/s, shape of time."""
        velocity = self._evaluate(self._lines, time, 1)[..., -1, :]
        return np.asarray(np.hypot(velocity[..., 0], velocity[..., 1]))

    def course(self, until: float = math.inf, points: int = 1500) -> Course:
        """Return the run up to an instant at every sample and at ``points`` further instants, evenly spaced."""
        if not until > self.start:
            raise ValueError(f"until = {until:g}: must be an instant after the run's start at {self.start:g} (in s)")
        end = min(until, self.end)
        even = np.linspace(self.start, end, points)
        columns: list[tuple[Array, ...]] = []
        for retraction, line in zip(self._retractions, self._lines, strict=True):
            instants = np.union1d(line.x, even[(even > line.x[0]) & (even < line.x[-1])])
            instants = instants[instants <= end]
            columns.append((instants, retraction(instants), line(instants)))
        time, retractions, centre_line = (np.concatenate(each) for each in zip(*columns, strict=True))
        return Course(time, retractions, self.along(time, self._trajectory.relative_rate), centre_line)

    def along(self, time: Array, samples: Array) -> Array:
        """Interpolate a quantity known at the samples by cubic splines at a course's instants, shape (n,).

        Where a sustained contact begins or ends, forces jump, and speeds and energies have a kink: one spline ends and
        another begins.
        """
        contacts = self._trajectory.contacts
        kinks = np.array([each for one in contacts for each in (one.time, one.time + one.duration)])
        pieces = []
        for part in self._intervals:
            instants = self._trajectory.time[part]
            inside = np.unique(time[(time >= instants[0]) & (time <= instants[-1])])
            inner = kinks[(kinks > instants[0]) & (kinks < instants[-1])]
            nearest = np.abs(instants[:, np.newaxis] - inner).argmin(axis=0)  # contacts begin and end there
            knots = np.union1d([0, part.size - 1], nearest).astype(int)
            values = np.empty_like(inside)
            for first, last in pairwise(knots.tolist()):
                span = slice(first, last + 1)
                here = (inside >= instants[first]) & (inside <= instants[last])
                values[here] = CubicSpline(instants[span], samples[part][span])(inside[here])
            pieces.append(values)
        return np.concatenate(pieces)

    def _evaluate(self, splines: list[CubicHermiteSpline], time: ArrayLike, derivative: int = 0) -> Array:
        instants = np.clip(np.asarray(time, dtype=float), self.start, self.end)
        interval = np.searchsorted(self._starts, instants, side="right") - 1
        result = np.empty((*instants.shape, *splines[0].c.shape[2:]))
        for number in np.unique(interval):
            here = interval == number
            result[here] = splines[number](instants[here], derivative)
        return result
