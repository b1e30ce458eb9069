"""The times in an integration step at which a function changes its sign: events and extremes.

Short excursions beyond zero are not missed. On a short interval a smooth function equals its
Chebyshev series up to rounding error, and a companion matrix gives all roots of the series at once.
The roots only separate intervals of one sign; the crossing itself is bracketed and located on the
function. If 17 samples do not resolve the function (a kink, a jump), the interval is halved.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from operator import itemgetter
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from scipy.optimize import brentq

from bristle_sim.arrays import Array
from bristle_sim.reference.contacts import Bar
from bristle_sim.reference.events import Event, Follow, Value
from bristle_sim.reference.log import LARGEST_RETRACTION, PEAK, STRIKE, Log, Record
from bristle_sim.reference.system import Instant, State, System

IDLE = 10.0  # least relative rate that counts as a highest one, over the rounding error of a rate

Function = Callable[[Array], Array]  # times of shape (n,) -> values of shape (n,)

DEGREE = 16
NODES = chebyshev.chebpts1(DEGREE + 1)
WEIGHTS = np.linalg.inv(chebyshev.chebvander(NODES, DEGREE))
# Largest number of intervals: fifty halvings confine a kink or a jump to rounding error.
MOST_PIECES = 100
# Size of the last coefficients of a series, as a fraction of the function's size, below which they
# are rounding error.
SERIES_ROUNDING = 1e-13


def nodes(start: float, end: float) -> Array:
    """Return the 17 ascending times of an interval at which a series samples a function."""
    return np.asarray(0.5 * (start + end) + 0.5 * (end - start) * NODES)


def crossings(
    function: Function,
    start: float,
    end: float,
    resolution: float,
    before: int = 0,
    values: Array | None = None,
) -> list[tuple[float, int]]:
    """Return every change of sign of a function in [start, end], in order of time.

    Values within ``resolution`` of zero have no sign of their own; the last sign before them holds.

    Args:
        function: the function of time.
        start, end: ends of the interval, s.
        resolution: magnitude below which the function is rounding error.
        before: sign of the function before the interval. With 0 the first sign in the interval does
            not count as a change.
        values: values at the times of ``nodes``, if they are known already.

    Returns:
        Pairs of the time, s, and +1 for a change to positive or -1 for a change to negative.
    """
    edges = {start, end}
    pieces = [(start, end)]
    for left, right in pieces:  # the list grows
        values = function(nodes(left, right)) if values is None else values
        series = WEIGHTS @ values
        sizes = np.abs(series)
        size = np.abs(values).max()
        constant = sizes[0] > sizes[1:].sum()
        resolved = sizes[-3:].max() <= max(resolution, SERIES_ROUNDING * size)
        if len(pieces) == 1 and (
            size <= resolution or (resolved and constant and series[0] * before >= 0.0)
        ):
            return []
        middle = 0.5 * (left + right)
        if not resolved and len(pieces) < MOST_PIECES:
            pieces += [(left, middle), (middle, right)]
        elif not constant:
            roots = chebyshev.chebroots(chebyshev.chebtrim(series, np.finfo(float).eps * size))
            # A double root splits into a pair that is off the real axis by the root of rounding.
            inner = roots.real[(np.abs(roots.imag) < 1e-6) & (np.abs(roots.real) < 1.0)]
            edges.update((middle + 0.5 * (right - left) * inner).tolist())
        edges.add(left)
        values = None
    ordered = np.array(sorted(edges))
    probes = np.array([start, *(0.5 * (ordered[1:] + ordered[:-1])), end])
    return list(_sign_changes(function, probes, function(probes), resolution, before))


def _sign_changes(
    function: Function, probes: Array, values: Array, resolution: float, before: int
) -> Iterator[tuple[float, int]]:
    """Yield the time of each change of sign between the probes, s, and the sign after the change.

    ``probes`` are times and ``values`` the function at these times. Values within ``resolution`` of
    zero are left out.
    """
    signed = np.flatnonzero(np.abs(values) > resolution).tolist()
    sign = before
    last = 0
    for probe in signed:
        new = int(np.sign(values[probe]))
        if sign * new < 0:
            yield _root(function, probes[last], probes[probe], values[last] * new), new
        sign = new
        last = probe


def _root(function: Function, left: float, right: float, already: float) -> float:
    """Return the root of a function between two times, s.

    ``already`` is the function's value at ``left`` times the sign of its value at ``right``. If the
    product is not negative, rounding error has moved the root to ``left``.
    """
    if already >= 0.0:  # by rounding, at the start of the search
        return float(left)
    return float(
        brentq(
            lambda time: float(function(np.array([time]))[0]), left, right, xtol=1e-300, maxiter=400
        )
    )


class Step(NamedTuple):
    """A step of the integrator.

    Attributes:
        system: the links and their contacts.
        motion: function that returns the states at given times.
        instants: states with kinematics and forces at the times of ``nodes``.
        start, end: start and end of the step, s.
    """

    system: System
    motion: Callable[[Array], list[State]]
    instants: list[Instant]
    start: float
    end: float

    def crossings(
        self, value: Value, resolution: float, before: int = 0
    ) -> list[tuple[float, int]]:
        """Return every change of sign, in the step, of a function of the state.

        Arguments and result are those of the function ``crossings``.
        """

        def along(times: Array) -> Array:
            return np.array([value(self.system.at(each)) for each in self.motion(times)])

        values = np.array([value(each) for each in self.instants])
        return crossings(along, self.start, self.end, resolution, before, values)


def first_event(events: list[Event], step: Step) -> tuple[float, Follow | None]:
    """Return the first event in a step of the integrator.

    An event function that begins within rounding error of zero counts as being before its event.

    Returns:
        The time of the event, s, and the function that applies its consequence. Without an event
        they are the end of the step and None.
    """
    near = _near(step.system, step.instants[-1], step.end - step.start)
    found = [
        (time, event.follow)
        for event in events
        if event.place is None or event.place in near
        for time, _ in step.crossings(event.value, event.resolution, -event.direction)[:1]
    ]
    return min(found, key=itemgetter(0), default=(step.end, None))


def _near(system: System, instant: Instant, duration: float) -> set[tuple[str, int]]:
    """Return the pairs of an obstacle and a straight piece of a wire that can touch in a step.

    A gap cannot close faster than the points of the links can move.
    """
    chain = system.chain
    top_speed = chain.speed * chain.hub_radius + float(
        np.abs(chain.ends) @ np.abs(instant.state.rates)
    )
    return {
        (name, int(piece))
        for name in system.obstacles
        for piece in np.flatnonzero(instant.gaps(name) < 2.0 * top_speed * duration)
    }


def note_extremes(log: Log, own: Record, step: Step, until: float) -> float | None:
    """Record a wire's largest retraction and highest relative rate in a step, up to a time.

    For a wire of several links the highest rate is not recorded: its hinges vibrate, so that the
    rate of its first link has several maxima.

    Returns:
        The time at which one of the extremes ends the run, s, or None.
    """
    system = step.system
    chain = own.chain
    link = own.links.start
    rounding = system.rate_rounding(step.instants[-1].state)

    def rate(at: Instant) -> float:
        return float(at.state.rates[link] - chain.speed)

    def acceleration(at: Instant) -> float:
        return float(at.balance.accelerations[link])

    def zeros(value: Value, resolution: float, sense: int) -> list[float]:
        """Return the times at which a quantity passes zero, rising (+1) or falling (-1)."""
        found = step.crossings(value, resolution)
        return [time for time, direction in found if direction == sense and time <= until]

    for time in zeros(rate, rounding, 1):
        own.turned.append(step.motion(np.array([time]))[0])
        log.marks.append(time)
        if log.stop_after == LARGEST_RETRACTION:
            return time
    touched = any(each.touch.normal_row[link] for each in step.instants[0].contacts)
    if chain.links > 1 or touched or own.seen(PEAK) or own.seen(STRIKE):
        return None
    bar = system.obstacles.get("bar")
    ahead = (
        isinstance(bar, Bar)
        and chain.speed
        and (bar.centre / chain.roots(step.start)[0]).imag > 0.0
    )
    if ahead and not own.seen(
        "bar touch"
    ):  # the bar is within half a turn ahead of the root: the bristle has not been thrown yet
        return None
    for time in zeros(acceleration, rounding * system.fastest, -1):
        if rate(system.at(step.motion(np.array([time]))[0])) > IDLE * rounding:
            own.event(PEAK, time)
            log.marks.append(time)
            return time if log.stop_after == PEAK else None
    return None
