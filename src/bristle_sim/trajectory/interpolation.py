"""A trajectory between its samples: one polynomial through positions and velocities of the samples around an instant."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.arrays import Array

if TYPE_CHECKING:
    from bristle_sim.trajectory.trajectory import Trajectory


SAMPLES = 8
"""Samples that a polynomial of free motion passes through, with its slope too: then it is of degree 15."""

UNEVEN = 20.0
"""Largest ratio of a sample interval to that of the instant: where an event falls next to a sample, a polynomial through
both would magnify their rounding."""


@dataclass(frozen=True, slots=True)
class Motion:
    """The motion at instants of any shape (...), in SI units and radians.

    Attributes:
        time, hub_angle: s and rad, shape (...).
        angles, rates: absolute angle and rate of each link, shape (..., links), rad and rad/s.
        centre_line, centre_line_velocity: corners of the centre line, shape (..., corners, 2), m and m/s.
    """

    time: Array
    hub_angle: Array
    angles: Array
    rates: Array
    centre_line: Array
    centre_line_velocity: Array

    @property
    def relative_angle(self) -> Array:
        """Angle of the first link relative to the radial direction, negative when it lags, shape (...), rad."""
        return np.asarray(self.angles[..., 0] - self.hub_angle)

    @property
    def tip(self) -> Array:
        """Position of the tip, shape (..., 2), m."""
        return self.centre_line[..., -1, :]

    @property
    def tip_velocity(self) -> Array:
        """Velocity of the tip, shape (..., 2), m/s."""
        return self.centre_line_velocity[..., -1, :]


def motion_at(run: Trajectory, time: ArrayLike, *, side: str = "after") -> Motion:
    """Return the motion at one instant or several, between samples too.

    In free motion a polynomial passes through angles and rates of up to eight samples around the instant, from one contact
    to the next; in sustained contact, whose motion may have kinks, through those of one interval and its inner samples.
    Tried at accuracy 1e-6 on 3,000 random instants of each of nine tools, compared with runs of accuracy 1e-9 that are sampled
    closely: angles are within 4e-8 rad and rates within 7e-7 of the largest rate.
    During a contact resolved in time, of which only first and last touch are samples, it is a cubic between the two, without
    that accuracy; the contact's ``history`` has what happens there.

    Args:
        time: s, of any shape.
        side: ``before`` or ``after``, which of the two states at the instant of an impact.

    Raises:
        ValueError: for an instant outside the run, or another side.
    """
    if side not in ("before", "after"):
        raise ValueError(f"side = {side!r}: must be before or after")
    instants = np.asarray(time, dtype=float)
    outside = ~((instants >= run.time[0]) & (instants <= run.time[-1]))
    if outside.any():
        raise ValueError(
            f"time = {instants[outside].flat[0]:g}: must be from {run.time[0]:g} to {run.time[-1]:g}, within the run (in s)"
        )
    links, corners = run.angles.shape[1], run.centre_line.shape[1]
    rows = run.time.size
    places = np.hstack([run.angles, run.centre_line.reshape(rows, -1)])
    slopes = np.hstack([run.rates, run.centre_line_velocity.reshape(rows, -1)])
    found, change = _interpolated(run, places, slopes, instants.ravel(), side)
    shape, lines = instants.shape, (*instants.shape, corners, 2)
    return Motion(
        time=instants,
        hub_angle=np.asarray(run.hub_angle[0] + run.hub_speed * (instants - run.time[0])),
        angles=found[:, :links].reshape(*shape, links),
        rates=change[:, :links].reshape(*shape, links),
        centre_line=found[:, links:].reshape(lines),
        centre_line_velocity=change[:, links:].reshape(lines),
    )


def _interpolated(run: Trajectory, places: Array, slopes: Array, instants: Array, side: str) -> tuple[Array, Array]:
    """Values and slopes at instants, each of shape (instants, columns)."""
    from scipy.interpolate import KroghInterpolator

    windows: dict[tuple[int, int], list[int]] = {}
    inner_time, inner_places, inner_slopes = _inner(run, places.shape[1])
    pieces = _smooth_pieces(run)
    starts, ends = run.time[np.array(pieces)].T
    after = np.searchsorted(starts, instants, side="right") - 1
    chosen = after if side == "after" else np.searchsorted(ends, instants, side="left")
    for number, (instant, piece) in enumerate(zip(instants.tolist(), chosen.tolist(), strict=True)):
        windows.setdefault(_window(run.time, pieces[piece], instant), []).append(number)
    found, change = np.empty((instants.size, places.shape[1])), np.empty((instants.size, places.shape[1]))
    for (first, last), numbers in windows.items():
        rows = slice(first, last + 1)
        inner = slice(*np.searchsorted(inner_time, run.time[[first, last]]))
        time = np.concatenate([run.time[rows], inner_time[inner]])
        # Every sample twice: the second time its row is the slope there.
        columns = (
            np.concatenate([places[rows], inner_places[inner]]),
            np.concatenate([slopes[rows], inner_slopes[inner]]),
        )
        order = np.argsort(time)
        both = np.stack(columns, axis=1)[order].reshape(2 * time.size, -1)
        curve = KroghInterpolator(np.repeat(time[order], 2), both)
        found[numbers], change[numbers] = curve(instants[numbers]), curve.derivative(instants[numbers])
    return found, change


def _inner(run: Trajectory, columns: int) -> tuple[Array, Array, Array]:
    """Time, values and slopes of the inner samples, of shapes (k,), (k, columns) and (k, columns)."""
    inner = run.inner_samples
    if inner is None:
        return np.empty(0), np.empty((0, columns)), np.empty((0, columns))
    count, corners = inner.time.size, columns - inner.angles.shape[1]
    places = np.hstack([inner.angles, inner.centre_line.reshape(count, corners)])
    return inner.time, places, np.hstack([inner.rates, inner.centre_line_velocity.reshape(count, corners)])


def _window(time: Array, piece: tuple[int, int], instant: float) -> tuple[int, int]:
    """First and last sample of the polynomial for an instant: outwards from its interval, as far as spacing is alike."""
    first, last = piece
    low = min(first + int(np.searchsorted(time[first : last + 1], instant, side="right")), last) - 1
    high, own = low + 1, time[low + 1] - time[low]

    def alike(start: int) -> bool:
        return first <= start < last and bool(own <= UNEVEN * (time[start + 1] - time[start]) <= UNEVEN**2 * own)

    while high - low + 1 < SAMPLES and (alike(low - 1) or alike(high)):
        low -= alike(low - 1)
        high += high - low + 1 < SAMPLES and alike(high)
    return low, high


def _smooth_pieces(run: Trajectory) -> list[tuple[int, int]]:
    """First and last sample of each piece in which no contact begins or ends.

    Before and after an impact are samples of their own; where a sustained contact begins or ends one sample belongs to both
    pieces. The first sample of a sustained contact still has the normal velocity that the impact left, which the second
    has not, so that the interval between them is a piece of its own.
    """
    time = run.time
    jumps = np.flatnonzero(np.diff(time) <= 0.0)
    edges = [0, *np.sort(np.concatenate([jumps, jumps + 1])).tolist(), time.size - 1]
    shared = set()
    for contact in run.contacts:
        if contact.duration:
            begin, end = (int(np.abs(time - each).argmin()) for each in (contact.time, contact.time + contact.duration))
            begin = int(np.searchsorted(time, time[begin], side="right")) - 1
            shared |= {begin, begin + 1, end}
            if run.inner_samples is not None and contact.law == "sustained":
                shared |= set(range(begin, end))
    found = []
    for start, end in zip(edges[::2], edges[1::2], strict=True):
        corners = [start, *sorted(each for each in shared if start < each < end), end]
        found += [(first, last) for first, last in pairwise(corners) if last > first]
    return found
