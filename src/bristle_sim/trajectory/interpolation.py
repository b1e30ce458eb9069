"""A trajectory between its samples: one polynomial through positions and velocities of the samples around an instant."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.arrays import Array
from bristle_sim.trajectory.records import InnerSamples, Motion

if TYPE_CHECKING:
    from bristle_sim.trajectory.trajectory import Trajectory


SAMPLES = 8  # samples that a polynomial of free motion passes through, with its slope too: then it is of degree 15

UNEVEN = 20.0  # largest ratio of neighbouring intervals; next to an event a polynomial would magnify their rounding
SAME = 1e-6  # rounding of a contact's end, as a fraction of its duration


def motion_at(run: Trajectory, time: ArrayLike, *, side: str = "after") -> Motion:
    """Return the motion at one instant or several, between samples too.

    In free motion a polynomial passes through angles and rates of up to eight samples around the instant, from one contact
    to the next; in sustained contact, whose motion may have kinks, through those of one interval and its inner samples; in a
    contact resolved in time through inner samples of one phase.
    Tried at accuracy 1e-6 on 3,000 random instants of each of nine tools, compared with runs of accuracy 1e-9 that are sampled
    closely: angles are within 4e-8 rad and rates within 7e-7 of the largest rate.
    Of the reference, which keeps no inner samples, it is a cubic between first and last touch of a contact resolved in time.

    Args:
        time: s, of any shape.
        side: ``before`` or ``after``, which of the two states at the instant of an impact.

    Raises ValueError for an instant outside the run, another side, or a run of one instant.
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
    found = _interpolated(run, instants.ravel(), side)
    angles, lines = (*instants.shape, links), (*instants.shape, corners, 2)
    return Motion(
        time=instants,
        hub_angle=np.asarray(run.hub_angle[0] + run.hub_speed * (instants - run.time[0])),
        angles=found[0, :, :links].reshape(angles),
        rates=found[1, :, :links].reshape(angles),
        centre_line=found[0, :, links:].reshape(lines),
        centre_line_velocity=found[1, :, links:].reshape(lines),
    )


def _interpolated(run: Trajectory, instants: Array, side: str) -> Array:
    """Values and slopes of angles and corners at instants, shape (2, instants, columns)."""
    from scipy.interpolate import KroghInterpolator

    rows, inner, kinks = _samples(run)
    pieces = _smooth_pieces(rows.time, kinks)
    if not pieces:
        raise ValueError("trajectory: must have samples of two different instants to be interpolated")
    starts, ends = rows.time[np.array(pieces)].T
    after = np.searchsorted(starts, instants, side="right") - 1
    chosen = after if side == "after" else np.searchsorted(ends, instants, side="left")
    windows: dict[tuple[int, int], list[int]] = {}
    for number, (instant, piece) in enumerate(zip(instants.tolist(), chosen.tolist(), strict=True)):
        windows.setdefault(_window(rows.time, pieces[piece], instant), []).append(number)
    found = np.empty((2, instants.size, rows.states.shape[2]))
    for (first, last), numbers in windows.items():
        within = slice(*np.searchsorted(inner.time, rows.time[[first, last]]))
        time, states = (
            np.concatenate([own[first : last + 1], more[within]]) for own, more in zip(rows, inner, strict=True)
        )
        order = np.argsort(time)
        # Every sample twice: the second time its row is the slope there.
        curve = KroghInterpolator(np.repeat(time[order], 2), states[order].reshape(2 * order.size, -1))
        found[:, numbers] = curve(instants[numbers]), curve.derivative(instants[numbers])
    return found


class _Samples(NamedTuple):
    """Instants, shape (k,), and there angles and corners with their slopes, shape (k, 2, columns)."""

    time: Array
    states: Array

    @classmethod
    def of(cls, samples: Trajectory | InnerSamples) -> _Samples:
        """Return those of a run, or of the instants between them."""
        rows = samples.time.size
        places = np.hstack([samples.angles, samples.centre_line.reshape(rows, -1)])
        slopes = np.hstack([samples.rates, samples.centre_line_velocity.reshape(rows, -1)])
        return cls(samples.time, np.stack([places, slopes], axis=1))


def _samples(run: Trajectory) -> tuple[_Samples, _Samples, set[int]]:
    """Return the samples, the inner ones of sustained contacts, and the samples at which polynomials end.

    The first sample of a sustained contact still has the normal velocity that the impact left, which the second has not, so
    that the interval between them is a piece of its own. Inner samples of a contact resolved in time become samples: where a
    phase ends two share its instant.
    """
    rows = _Samples.of(run)
    inner = _Samples(*(each[:0] for each in rows)) if run.inner_samples is None else _Samples.of(run.inner_samples)
    kinks: set[int] = set()
    for contact in run.contacts:
        if not contact.duration:
            continue
        end = contact.time + contact.duration
        inside = (inner.time >= contact.time) & (inner.time <= end + SAME * contact.duration)
        begin, last = (int(np.abs(rows.time - each).argmin()) for each in (contact.time, end))
        begin = int(np.searchsorted(rows.time, rows.time[begin], side="right")) - 1
        if contact.history is not None and inside.any():
            both = zip(rows, inner, strict=True)
            rows = _Samples(*(np.insert(own, begin + 1, more[inside], axis=0) for own, more in both))
            inner = _Samples(*(each[~inside] for each in inner))
            continue
        kinks |= {begin, begin + 1, last}
        if contact.history is None and run.inner_samples is not None:
            kinks |= set(range(begin, last))
    return rows, inner, kinks


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


def _smooth_pieces(time: Array, kinks: set[int]) -> list[tuple[int, int]]:
    """First and last sample of each piece in which no contact begins or ends; it shares that of a sustained contact's end."""
    jumps = np.flatnonzero(np.diff(time) <= 0.0)
    edges = [0, *np.sort(np.concatenate([jumps, jumps + 1])).tolist(), time.size - 1]
    found = []
    for start, end in zip(edges[::2], edges[1::2], strict=True):
        corners = [start, *sorted(each for each in kinks if start < each < end), end]
        found += [(first, last) for first, last in pairwise(corners) if last > first]
    return found
