"""Find the first event within an interval, without missing the touch of a link and an obstacle.

Gaps are searched on the interval's interpolating polynomial by conservative advancement (Mirtich
1996): a gap g cannot close before the time g / (largest speed), so the search never steps over a
touch.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from bristle_sim.scene.events import Happening, Kind
from bristle_sim.scene.extrapolation import IntervalResult
from bristle_sim.scene.gaps import GAP_ROUNDING
from bristle_sim.scene.locate import Interval, first_change, locate, settle
from bristle_sim.scene.mechanism import Mechanism, State
from bristle_sim.scene.motion import SHORTEST_INTERVAL, Motion
from bristle_sim.scene.pairs import ClosestApproach, ContactPair
from bristle_sim.scene.system import System

CUBIC_ERROR = 0.01
"""Error bound of a gap on the cubic polynomial, over the fourth power of the interval h (engine
units): h^4/384 with a safety factor. For an angular velocity of amplitude 1 that vibrates with the
fastest frequency w, h^4 w^3/384 is bounded by the same factor."""

QUINTIC_ERROR = 1.3e-5
"""Error bound of a gap on the quintic polynomial, over the sixth power of the interval h (engine
units): 3.2e-6 h^6 with a safety factor."""

# largest error of a polynomial near the start of the interval: over the error bound, and over the
# square of the fraction of the interval that has passed
NEAR_START = 16.0
SHORTEST_ADVANCE = 1e-9
"""Shortest time, and shortest path, from the interval's start to a minimum of the gap that is
distinct from the start, in engine units."""

LEAST_ADVANCE = (
    1.0 / 8.0
)  # least step of the search, as a fraction of the interval; slopes reveal a minimum within a step
# least tolerance of the gap at a located touch: rounding error of an extrapolated interval
GAP_TOLERANCE = 1e-13
LOCATED_GAP = 1e-6
"""Tolerance of the gap at a located touch, over the run's accuracy. It is small, because the error
of the time is the gap over the speed of approach."""

OPENING = (
    1.0 / 16.0
)  # time in which the gap of a released pair must open, over the interval between samples
LEAST_HOP = 1e-6  # duration of the shortest rebound that is followed, over the interval
MOST_HALVINGS = 40  # largest number of bisections of an interval, down to rounding error

Found = tuple[Interval, Happening | None]
"""The interval up to an event, and the event; or the interval up to a minimum of a gap without a
touch, and None."""


def first_event(system: System, motion: Motion, interval: Interval) -> Found:
    """Return the interval shortened to its first event, and this event; or shortened to a near
    miss, or the whole interval, and None.

    Events of contacts come before touches: a contact that slides onto the neighbouring link is not
    a new touch of that link.
    """
    interval, changed = first_change(system, motion.events, interval)
    first = None if changed is None else Happening(changed.kind, changed.subject)
    sustained = [contact.pair for contact in motion.contacts]
    for pair in system.pairs:
        if pair not in sustained and interval.length > 0.0:
            found = _touch(system, interval, pair, sustained, motion.separating)
            if found is not None:
                interval, first = found
                changed = None
    for event in motion.events:
        if event is changed:
            event.sign = -(event.sign or 0.0)
        else:
            event.follow(interval.end)
    return interval, first


def _touch(
    system: System,
    interval: Interval,
    pair: ContactPair,
    sustained: Sequence[ContactPair],
    separating: Sequence[ContactPair],
) -> Found | None:
    """Return the interval shortened to a pair's first touch, and the touch; or shortened to a near
    miss, and None. If the gap stays open, or stays closed, a single None is returned.

    Args:
        system: the run.
        interval: the interval.
        pair: the pair.
        sustained: pairs in sustained contact.
        separating: released pairs, whose gaps must first open.
    """
    gaps = system.gaps
    if pair in separating:
        soon = OPENING * min(system.plan.longest_interval, system.plan.time_scale)
        if interval.length > soon:
            touch = gaps.closest(pair, interval.at(soon))
            if touch.velocity[0] > 0.0 and touch.gap > GAP_ROUNDING + polynomial_error(
                system, interval
            ):
                return find_touch(system, interval, pair, soon / interval.length)
        return _search_hop(system, interval, pair, soon)
    times = (0.0, 0.5 * interval.length, interval.length)
    rests = sustained and all(
        abs(gaps.gap(pair, interval.at(time))) <= GAP_ROUNDING for time in times
    )
    behind = system.mechanism.wire_links > 1 and system.behind_joint(
        pair, [*separating, *sustained], interval.end.state
    )
    return None if rests or behind else find_touch(system, interval, pair)


def _search_hop(
    system: System, interval: Interval, pair: ContactPair, longest: float
) -> Found | None:
    """Search for the end of a small rebound, from which the link comes back within the interval.

    An interval longer than ``longest`` is shortened to this length. If it then ends inside the
    obstacle, it is shortened to the end of the rebound, or to an instant at which the link is still
    outside. A rebound shorter than the shortest interval is too low to follow.
    """
    gaps = system.gaps
    integrate_to = interval.integrate_to
    shortened = interval.length > longest
    if shortened:
        interval = interval.up_to(integrate_to(longest))
    length = interval.length
    instant = min(system.plan.instant, length)
    touch = gaps.closest(pair, interval.end.state)
    if touch.gap >= -GAP_ROUNDING or touch.velocity[0] >= 0.0:
        return (interval, None) if shortened else None

    def gap_at(at: IntervalResult) -> float:
        return gaps.gap(pair, at.state)

    gap = gaps.gap(pair, interval.at(instant))
    if gap <= 0.0 and instant < length:
        gap = gap_at(integrate_to(instant))
    # A small rebound of a single rigid link has no effect. Of several links, one may rebound while
    # another is pressed on.
    low = (
        system.mechanism.single_link
        and system.law_of(pair).instantaneous
        and -system.plan.accuracy <= gap < 0.0
    )
    if low or gap_at(interval.first) < -GAP_ROUNDING:
        end = interval.end if instant == length else integrate_to(instant)
        return interval.up_to(end), Happening(Kind.REST, pair)
    time = length
    shortest = LEAST_HOP * length
    while time > shortest and (above := gaps.gap(pair, interval.at(time))) < -GAP_ROUNDING:
        time = 0.5 * time
    if time < length and above > 0.0:
        closed = settle(system, gap_at, interval, time, 2.0 * time, GAP_TOLERANCE)
        # A zero at the interval's start is no touch.
        if closed is not None and gaps.closest(pair, closed.state).velocity[0] < 0.0:
            return interval.up_to(closed), Happening(Kind.TOUCH, pair)
    while (gap := gap_at(integrate_to(time))) < -GAP_ROUNDING and time > shortest:
        time *= 0.5
    rest = None if gap > GAP_ROUNDING else Happening(Kind.REST, pair)
    return interval.up_to(integrate_to(time)), rest


def find_touch(
    system: System, interval: Interval, pair: ContactPair, begin: float = 0.0
) -> Found | None:
    """Return the interval shortened to its first touch, and the touch; or shortened to a near miss,
    and None.

    If the gap stays open, a single None is returned. The search begins at the fraction ``begin`` of
    the interval, where the gap is open.
    """
    gaps = system.gaps
    integrate_to = interval.integrate_to
    length = interval.length
    closest = partial(gaps.closest, pair)
    fraction = first_touch(
        gaps.mechanism, closest, interval, polynomial_error(system, interval), begin
    )
    if fraction is None:
        return None
    first = begin * length
    last = fraction * length
    tolerance = min(max(LOCATED_GAP * system.plan.accuracy, GAP_TOLERANCE), 0.1 * GAP_ROUNDING)
    closed = settle(system, lambda at: closest(at.state).gap, interval, first, last, tolerance)
    if closed is not None and closest(closed.state).velocity[0] <= 0.0:
        # If the gap were opening at this zero, there would be an earlier zero.
        return interval.up_to(closed), Happening(Kind.TOUCH, pair)
    reached = interval.end if fraction == 1.0 else integrate_to(last)
    touch = closest(reached.state)
    at_end = touch.gap
    if at_end > 0.0 and touch.velocity[0] > 0.0:
        # The gap opens again, so it is closed or least before.
        fastest = 1.5 * gaps.mechanism.speed_bound(interval.start)

        def at_instant(span: float, gap: float) -> bool:
            return gap > fastest * span or max(1.0, fastest) * span <= SHORTEST_INTERVAL

        last, at_end = _least(
            lambda time: closest(integrate_to(time).state), first, last, at_end, at_instant
        )
    if at_end > 0.0:
        return interval.up_to(reached), None
    if at_end < 0.0:
        at_start = max(gaps.gap(pair, interval.at(first)), 1e-300)
        last = locate(
            lambda time: closest(integrate_to(time).state).gap,
            first,
            last,
            at_start,
            at_end,
            GAP_TOLERANCE,
        )
    return interval.up_to(integrate_to(last)), Happening(Kind.TOUCH, pair)


def polynomial_error(system: System, interval: Interval) -> float:
    """Return an upper bound of a gap's error on the interval's interpolating polynomial, in engine
    units.
    """
    length = interval.length
    middle = interval.end.middle
    error = CUBIC_ERROR * length**4 if middle is None else QUINTIC_ERROR * length**6
    if system.mechanism.wire_links > 1:
        error += CUBIC_ERROR * length * (length / system.plan.time_scale) ** 3
    return error


def first_touch(
    mechanism: Mechanism,
    closest: Callable[[State], ClosestApproach],
    interval: Interval,
    interpolation_error: float = 0.0,
    begin: float = 0.0,
) -> float | None:
    """Return the fraction of the interval at which the gap on the polynomial is closed or nearly
    closed; None if the gap stays open.

    The returned fraction may be later than the first touch, but is never later than a second touch.
    The gap's error at a fraction f is at most 16 f^2 (1 - f)^2 times ``interpolation_error``,
    because angles and rates at the interval's ends are exact.

    Args:
        mechanism: the mechanism, for its largest speed.
        closest: function that returns the closest approach in a state.
        interval: the interval.
        interpolation_error: upper bound of the gap's error on the polynomial.
        begin: fraction of the interval at which the search begins.
    """
    length = interval.length
    margin = interpolation_error
    ends = (interval.start, interval.end.state)
    bound = 1.5 * max(map(mechanism.speed_bound, ends)) * length
    fraction = begin
    touch = closest(interval.at(begin * length))
    while fraction < 1.0 and touch.gap <= bound * (1.0 - fraction) + margin:
        ahead = min(1.0, fraction + max(touch.gap / bound if bound else 1.0, LEAST_ADVANCE))
        following = closest(interval.at(ahead * length))
        if following.gap < 0.0:
            return ahead
        if touch.velocity[0] < 0.0 < following.velocity[0]:
            dip, least = _least(
                lambda part: closest(interval.at(part * length)),
                fraction,
                ahead,
                following.gap,
                lambda span, _: span < 2.0**-MOST_HALVINGS,
            )
            near = least < margin * min(1.0, NEAR_START * dip**2)
            if least < 0.0 or (near and dip * max(length, bound) > SHORTEST_ADVANCE):
                return dip
        fraction = ahead
        touch = following
    return None


def _least(
    closest: Callable[[float], ClosestApproach],
    left: float,
    right: float,
    at_right: float,
    enough: Callable[[float, float], bool],
) -> tuple[float, float]:
    """Return the position of the gap's minimum and the gap there, by bisection on the gap's rate.

    The gap falls at the left end and rises at the right end. A closed gap ends the search at once.
    The search also ends when the function ``enough`` of the bracket's length and the gap is true.
    """
    value = at_right
    while not enough(right - left, value):
        middle = 0.5 * (left + right)
        touch = closest(middle)
        value = touch.gap
        if value < 0.0:
            return middle, value
        left, right = (middle, right) if touch.velocity[0] < 0.0 else (left, middle)
    return right, closest(right).gap
