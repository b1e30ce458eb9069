"""Interpolate a trajectory between its samples: interpolation from impact to impact, of what the run itself recorded."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicHermiteSpline, CubicSpline, PPoly

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

    Raises ValueError if the run has no two different instants.
    """

    def __init__(self, trajectory: Trajectory) -> None:
        self._run, time = trajectory, trajectory.time
        cuts = np.flatnonzero(np.diff(time) <= 0.0) + 1
        self._intervals = [part for part in np.split(np.arange(time.size), cuts) if part.size > 1]
        if not self._intervals:
            raise ValueError(f"trajectory: {time.size} sample(s) at one instant, two instants are needed to draw it")
        self._retraction = self._cubics(trajectory.retraction, -trajectory.relative_rate)
        self._line = self._cubics(trajectory.centre_line, trajectory.centre_line_velocity)
        self.start, self.end = float(time[0]), float(time[-1])

    def hub_angle(self, time: ArrayLike) -> Array:
        """Return the angle of the first link's root, rad, shape of time."""
        return np.asarray(np.interp(np.asarray(time), self._run.time, self._run.hub_angle))

    def retraction(self, time: ArrayLike) -> Array:
        """Return the angle by which the first link lags the radial direction, rad, shape of time."""
        return np.asarray(self._retraction(np.clip(time, self.start, self.end)))

    def centre_line(self, time: ArrayLike) -> Array:
        """Return root, corners and tip from the hub's centre, m, shape (*time.shape, corners, 2)."""
        return np.asarray(self._line(np.clip(time, self.start, self.end)))

    def tip_speed(self, time: ArrayLike) -> Array:
        """Return the speed of the tip over the workpart, m/s, shape of time."""
        velocity = self._line(np.clip(time, self.start, self.end), 1)[..., -1, :]
        return np.asarray(np.hypot(velocity[..., 0], velocity[..., 1]))

    def course(self, until: float = math.inf, points: int = 1500) -> Course:
        """Return the run up to an instant at every sample and at ``points`` further instants, evenly spaced."""
        if not until > self.start:
            raise ValueError(f"until = {until:g}: must be an instant after the run's start at {self.start:g} (in s)")
        run, end = self._run, min(until, self.end)
        samples = run.time <= end
        between = np.setdiff1d(np.linspace(self.start, end, points), run.time)
        time = np.sort(np.concatenate([run.time[samples], between]))
        retraction, line = (
            self._both(self._retraction, run.retraction, time),
            self._both(self._line, run.centre_line, time),
        )
        return Course(time, retraction, self.along(time, run.relative_rate), line)

    def along(self, time: Array, samples: Array) -> Array:
        """Interpolate a quantity known at the samples by cubic splines at a course's instants, shape (n,).

        Where a sustained contact begins or ends, forces jump, and speeds and energies have a kink: one spline ends and
        another begins.
        """
        sampled, pieces = self._run.time, []
        kinks = np.array([each for one in self._run.contacts for each in (one.time, one.time + one.duration)])
        for part in self._intervals:
            instants = sampled[part]
            inner = kinks[(kinks > instants[0]) & (kinks < instants[-1])]
            nearest = np.abs(instants[:, np.newaxis] - inner).argmin(axis=0)  # contacts begin and end there
            for first, last in pairwise(np.union1d([0, part.size - 1], nearest).astype(int).tolist()):
                span = part[first : last + 1]
                pieces.append(CubicSpline(sampled[span], samples[span]))
        return self._both(_joined(pieces), samples, time)

    def _both(self, curve: PPoly, samples: Array, time: Array) -> Array:
        """Evaluate at a course's instants; of two that are one, before and after an impact, the first has the sample before."""
        found = np.asarray(curve(time))
        before = np.flatnonzero(np.diff(time) <= 0.0)
        found[before] = samples[np.searchsorted(self._run.time, time[before])]
        return found

    def _cubics(self, values: Array, slopes: Array) -> PPoly:
        time = self._run.time
        return _joined([CubicHermiteSpline(time[at], values[at], slopes[at]) for at in self._intervals])


def _joined(pieces: list[PPoly]) -> PPoly:
    """Join splines of which each begins where the one before ends; at that instant the later one holds."""
    places = np.concatenate([pieces[0].x[:1], *(each.x[1:] for each in pieces)])
    return PPoly(np.concatenate([each.c for each in pieces], axis=1), places)
