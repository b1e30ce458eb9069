"""The first event in an interval, found by a search that misses no touch.

A touch is a zero of the gap between a link and an obstacle. The zero is searched on the interval's
interpolating polynomial by conservative advancement (Mirtich 1996): a gap g cannot close before the
time g / (largest speed), so a step of the search of this length cannot pass a touch. A gap that is
larger than the path of all intervals since it was last computed is not computed again.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from bristle_sim.scene.events import Happening, Kind
from bristle_sim.scene.locate import Interval, first_change, locate, settle
from bristle_sim.scene.mechanism import Mechanism, State
from bristle_sim.scene.motion import SHORTEST_INTERVAL, Motion
from bristle_sim.scene.pairs import ClosestApproach, ContactPair
from bristle_sim.scene.system import GAP_ROUNDING, System

CUBIC_ERROR = 0.01
"""Error bound of a gap on the cubic polynomial, divided by h^4 with the interval h (engine units).
The quotient is 1/384 times a safety factor. For a vibration of angular frequency w, whose angular
velocity has the amplitude 1, the same number is the error bound divided by h^4 w^3."""

QUINTIC_ERROR = 1.3e-5
"""Error bound of a gap on the quintic polynomial, divided by h^6 with the interval h (engine
units). The quotient is 3.2e-6 times a safety factor."""

# Largest error of a polynomial near the interval's start, divided by the error bound of the whole
# interval and by the square of the fraction of the interval that has passed.
NEAR_START = 16.0
SHORTEST_ADVANCE = 1e-9
"""Shortest time, and shortest path, from the interval's start to a minimum of the gap, in engine
units. A closer minimum is not distinct from the start."""

# Least step of the search, as a fraction of the interval. Slopes reveal a minimum within a step.
LEAST_ADVANCE = 1.0 / 8.0
# Least tolerance of the gap at a located touch, engine units: rounding error of an extrapolated
# interval.
GAP_TOLERANCE = 1e-13
LOCATED_GAP = 1e-6
"""Tolerance of the gap at a located touch, as a fraction of the run's accuracy. The tolerance is
small because the error of the time is the gap divided by the approach speed, which may be small
too."""

# Time in which the gap of a released pair must open, as a fraction of the sampling interval.
OPENING = 1.0 / 16.0
MOST_FASTER = 1.5
"""Ratio of a gap's opening velocity at the end of the time ``OPENING`` to that at the beginning.
Above this ratio the gap may have closed in between; the end of such a rebound is searched for."""

EARLIER = 0.7
"""Ratio of a trial time to the next later trial time in the search for an open gap that closes. In
a rebound of constant acceleration the gap closes in the second half of its duration."""

LEAST_HOP = 1e-6  # duration of the shortest rebound that is followed, as a fraction of the interval
MOST_HALVINGS = 40  # largest number of bisections of an interval, down to rounding error

MOST_SPEED = 1.5  # largest speed in an interval, divided by the larger of those at its two ends

Found = tuple[Interval, Happening | None]
"""The interval up to an event, and the event; or the interval up to a minimum of a gap at which
link and obstacle do not touch, and None."""


def first_event(system: System, motion: Motion, interval: Interval) -> Found:
    """Search for the first event in an interval.

    During a contact the events of contacts are searched for first. Otherwise a contact that slides
    onto the neighbouring link would be taken for a touch of that link. In flight touches are
    searched for first: extremes of the motion after a touch then need not be located.

    Returns:
        One of three pairs:
            The interval up to the event, and the event.
            The interval up to a minimum of a gap, and None, if link and obstacle almost touch.
            The whole interval, and None.
    """
    sustained = [contact.pair for contact in motion.contacts]
    first = None
    changed = None
    if sustained:
        interval, changed = first_change(system, motion.events, interval)
    speeds = map(system.mechanism.speed_bound, (interval.start, interval.end.state))
    path = MOST_SPEED * max(speeds) * interval.length
    for pair in system.pairs:
        if pair in sustained or interval.length <= 0.0:
            continue
        clearance = system.clearances.get(pair, 0.0) - path
        if clearance <= 0.0:
            clearance = system.closest(pair).gap - path
        system.clearances[pair] = clearance
        found = None
        ends = (interval.start, interval.end.state)
        alone = pair.partner is None
        if clearance <= 0.0 and (alone or not system.coincide(pair, sustained, *ends)):
            found = _touch(system, motion, interval, pair)
        if found is not None:
            interval, first = found
            changed = None
    if not sustained:
        interval, changed = first_change(system, motion.events, interval)
    if changed is not None:
        first = Happening(changed.kind, changed.subject)
    for event in motion.events:
        if event is changed:
            event.sign = -(event.sign or 0.0)
        else:
            event.follow(interval.end)
    return interval, first


def _search_hop(
    system: System, interval: Interval, pair: ContactPair, longest: float
) -> Found | None:
    """Search for the end of a rebound so small that the link touches again within the interval.

    An interval longer than ``longest`` is first shortened to this length.

    Returns:
        One of three results:
            The interval up to the end of the rebound, and the touch. (The event is ``REST`` if the
            rebound is too low to follow.)
            The shortened interval and None, if the link is outside the obstacle at its end.
            None, if the interval is not shortened and the link is outside the obstacle at its end.
    """
    integrate_to = interval.integrate_to
    shortened = interval.length > longest
    if shortened:
        interval = interval.up_to(integrate_to(longest))
    length = interval.length
    instant = min(system.plan.instant, length)
    closest = partial(system.closest, pair)
    touch = closest(interval.end.state)
    closes = touch.velocity[0] < 0.0
    outside = touch.gap >= (GAP_ROUNDING if closes else -GAP_ROUNDING)
    at_start = closest(interval.start).gap
    if outside or (not closes and touch.gap >= at_start):
        return (interval, None) if shortened else None
    gap = closest(interval.at(instant)).gap
    if gap <= 0.0 and instant < length:
        gap = closest(integrate_to(instant).state).gap
    # A small rebound of a single rigid link has no effect. With several links, one link may rebound
    # while another is pressed on.
    low = (
        system.mechanism.single_link
        and system.law_of(pair).instantaneous
        and -system.plan.accuracy <= gap < 0.0
    )
    if low or at_start < -GAP_ROUNDING:
        end = interval.end if instant == length else integrate_to(instant)
        return interval.up_to(end), Happening(Kind.REST, pair)
    time = length
    shortest = LEAST_HOP * length
    while time > shortest and (above := closest(interval.at(time)).gap) < -GAP_ROUNDING:
        time = 0.5 * time
    if time < length and above > 0.0:
        ends = (time, 2.0 * time)
        closed = settle(system, lambda at: closest(at.state).gap, interval, *ends, GAP_TOLERANCE)
        # A zero at the interval's start is no touch.
        if closed is not None and closest(closed.state).velocity[0] < 0.0:
            return interval.up_to(closed), Happening(Kind.TOUCH, pair)
    end = integrate_to(time)
    while (gap := closest(end.state).gap) < -GAP_ROUNDING and time > shortest:
        time *= 0.5
        end = integrate_to(time)
    return interval.up_to(end), None if gap > GAP_ROUNDING else Happening(Kind.REST, pair)


def _touch(system: System, motion: Motion, interval: Interval, pair: ContactPair) -> Found | None:
    """Search for the first touch of a pair in an interval.

    Args:
        system: the run.
        motion: the motion. The gaps of its separating pairs must first open.
        interval: the interval.
        pair: the pair, which is not in sustained contact.

    Returns:
        One of three results:
            The interval up to the touch, and the touch.
            The interval up to a minimum of the gap, and None, if link and obstacle almost touch.
            None, if the gap stays open or stays closed.
    """
    length = interval.length
    closest = partial(system.closest, pair)
    sustained = [contact.pair for contact in motion.contacts]
    error = polynomial_error(system, interval)
    begin = 0.0
    if pair in motion.separating:
        begin = OPENING * min(system.plan.longest_interval, system.plan.time_scale)
        within = min(begin, length)
        opening = closest(interval.at(within))
        # The gap may have closed and opened again: at a corner of the link, its acceleration jumps.
        leaves = closest(interval.start).velocity[0]
        if leaves * within > GAP_ROUNDING and opening.velocity[0] > MOST_FASTER * leaves:
            following, time, touch = within, within, opening
            # After a contact with a spring the wire is still in its dent, which is not a tap.
            taps = system.law_of(pair).instantaneous
            while (
                taps
                and leaves * time > GAP_ROUNDING
                and (touch.gap < 0.0 or touch.velocity[0] > 0.0)
            ):
                following, time = time, EARLIER * time
                touch = closest(interval.at(time))
            ends = (time / length, following / length) if taps else (0.0, within / length)
            dip = first_touch(system.mechanism, closest, interval, error, *ends)
            if dip is not None:
                return _search_hop(system, interval, pair, dip * length)
        near_start = min(1.0, NEAR_START * (within / length) ** 2)
        opens = opening.gap > GAP_ROUNDING + near_start * error
        if length <= begin or not opens:
            return _search_hop(system, interval, pair, begin)
    else:
        times = (0.0, 0.5 * length, length)
        rests = sustained and all(
            abs(closest(interval.at(time)).gap) <= GAP_ROUNDING for time in times
        )
        active = [*motion.separating, *sustained]
        behind = system.behind_joint(pair, active, interval.end.state)
        straight = len(system.mechanism.links[pair.link].corners) == 2
        if rests or (behind is not None and straight):
            return None
        if behind is not None:
            # Only the segment on the other side of the link's knee can touch.
            closest = partial(_of_piece, system.mechanism, pair, 1 - behind)
    fraction = first_touch(system.mechanism, closest, interval, error, begin / length)
    if fraction is None:
        return None
    last = fraction * length
    tolerance = min(max(LOCATED_GAP * system.plan.accuracy, GAP_TOLERANCE), 0.1 * GAP_ROUNDING)
    closed = settle(system, lambda at: closest(at.state).gap, interval, begin, last, tolerance)
    if closed is not None and closest(closed.state).velocity[0] <= 0.0:
        # If the gap were opening at this zero, there would be an earlier zero.
        return interval.up_to(closed), Happening(Kind.TOUCH, pair)
    return _integrated_touch(interval, pair, closest, begin, last)


def _of_piece(mechanism: Mechanism, pair: ContactPair, piece: int, state: State) -> ClosestApproach:
    """Return the closest approach of one straight segment of a pair's link."""
    return pair.closest(mechanism.poses(state), state.rates, piece)


def _integrated_touch(
    interval: Interval,
    pair: ContactPair,
    closest: Callable[[State], ClosestApproach],
    begin: float,
    last: float,
) -> Found:
    """Locate a touch by integration, where the polynomial is not accurate enough.

    Args:
        interval: the interval.
        pair: the pair.
        closest: function that returns the closest approach in a state.
        begin: time, from the interval's start, at which the gap is open.
        last: time at which the gap on the polynomial is closed or almost closed.

    Returns:
        One of two pairs:
            The interval up to the touch, and the touch.
            The interval up to an instant before a minimum of an open gap, and None.
    """
    integrate_to = interval.integrate_to
    touch = closest(integrate_to(last).state)
    while touch.gap > 0.0 and touch.velocity[0] > 0.0 and last - begin > SHORTEST_INTERVAL:
        # The gap is opening at ``last``, so its minimum or its zero is earlier.
        last = 0.5 * (begin + last)
        touch = closest(integrate_to(last).state)
    if touch.gap < 0.0:
        at_begin = max(closest(interval.at(begin)).gap, 1e-300)
        last = locate(
            lambda at: closest(at.state).gap,
            integrate_to,
            begin,
            last,
            at_begin,
            touch.gap,
            GAP_TOLERANCE,
        )
    reached = interval.up_to(integrate_to(last))
    return reached, None if touch.gap > 0.0 else Happening(Kind.TOUCH, pair)


def polynomial_error(system: System, interval: Interval) -> float:
    """Return an upper bound (engine units) of a gap's error on an interval's polynomial."""
    length = interval.length
    middle = interval.end.middle
    error = CUBIC_ERROR * length**4 if middle is None else QUINTIC_ERROR * length**6
    if system.mechanism.jointed:
        error += CUBIC_ERROR * length * (length / system.plan.time_scale) ** 3
    return error


def first_touch(
    mechanism: Mechanism,
    closest: Callable[[State], ClosestApproach],
    interval: Interval,
    interpolation_error: float = 0.0,
    begin: float = 0.0,
    last: float = 1.0,
) -> float | None:
    """Return a fraction of the interval at which a gap is closed, or almost closed.

    The gap is computed on the interpolating polynomial. Return None if the gap stays open. The
    returned fraction may be later than the first touch, but is never later than a second touch. The
    gap's error at a fraction f is at most 16 f^2 (1 - f)^2 times ``interpolation_error``, because
    angles and angular velocities at the interval's ends are exact.

    Args:
        mechanism: the mechanism, for its largest speed.
        closest: function that returns the closest approach in a state.
        interval: the interval.
        interpolation_error: upper bound of the gap's error on the polynomial.
        begin: fraction of the interval at which the search begins.
        last: fraction of the interval at which the search ends.
    """
    length = interval.length
    margin = interpolation_error
    speeds = map(mechanism.speed_bound, (interval.start, interval.end.state))
    bound = MOST_SPEED * max(speeds) * length
    fraction = begin
    touch = closest(interval.at(begin * length))
    while fraction < last and touch.gap <= bound * (last - fraction) + margin:
        advance = max(touch.gap / bound if bound else 1.0, LEAST_ADVANCE * last)
        ahead = min(last, fraction + advance)
        following = closest(interval.at(ahead * length))
        if following.gap < 0.0:
            return ahead
        if touch.velocity[0] < 0.0 < following.velocity[0]:
            left, right, inside = fraction, ahead, following
            # The gap cannot close if it is larger than the path in the time that is left.
            while 2.0**-MOST_HALVINGS <= right - left >= (inside.gap - margin) / (bound or 1.0):
                middle = 0.5 * (left + right)
                inside = closest(interval.at(middle * length))
                if inside.gap < 0.0:
                    return middle
                left, right = (middle, right) if inside.velocity[0] < 0.0 else (left, middle)
            error = margin * min(1.0, NEAR_START * right**2)
            near = closest(interval.at(right * length)).gap < error
            if near and right * max(length, bound) > SHORTEST_ADVANCE:
                return right
        fraction = ahead
        touch = following
    return None
