"""Find the first touch of a link and a pair within an interval, without missing one.

Gaps are searched on the interval's polynomial by conservative advancement (Mirtich 1996): from a
gap g no contact can happen before g / (largest speed), so no touch is stepped over.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from bristle_sim.scene.events import Happening, Kind
from bristle_sim.scene.gaps import GAP_ROUNDING
from bristle_sim.scene.interval import Interval
from bristle_sim.scene.locate import guess, locate, settle
from bristle_sim.scene.mechanism import Mechanism, State
from bristle_sim.scene.pairs import ContactPair
from bristle_sim.scene.system import System

CUBIC_ERROR = 0.01
"""Bound of the cubic's error of the gap, over the fourth power of the interval h (scene units):
h^4/384 with a safety factor. For a rate of amplitude 1 that vibrates with the fastest frequency w,
h^4 w^3/384 is bounded by the same factor."""

QUINTIC_ERROR = 1.3e-5
"""Bound of the quintic's error of the gap, over the sixth power of the interval: 3.2e-6 h^6 with a
safety factor."""

# largest error of a polynomial near the start, over the error's bound times the square of the
# fraction of the interval
NEAR_START = 16.0
SHORTEST_ADVANCE = 1e-9
"""Least distance in time, and least length of the way, between the interval's start and a least gap
that is not the one at the start."""

LEAST_ADVANCE = (
    1.0 / 8.0
)  # fraction of the interval; least values of the gap in between show in its slopes
# least tolerance of the gap at a located touch: rounding of an extrapolated interval
GAP_TOLERANCE = 1e-13
LOCATED_GAP = 1e-6
"""Tolerance of the gap at a located touch, over the accuracy; the slower the approach, the larger
the error of the time."""

# shortest interval, in the scene's time units: no shorter one is accurate, and a motion of this
# length is an instant
SHORTEST_INTERVAL = 1e-13
OPENING = (
    1.0 / 16.0
)  # fraction of an interval between samples in which the gap of a released pair opens, or it hops
LEAST_HOP = 1e-6  # shortest rebound that is followed, over the interval
MOST_HALVINGS = 40  # most halvings of a fraction of an interval, down to rounding

Found = tuple[Interval, Happening | None]
"""The interval up to a touch, and the touch; or the interval up to a least gap without a touch, and
None."""


def first_touch_of_all(
    system: System,
    interval: Interval,
    sustained: Sequence[ContactPair],
    separating: Sequence[ContactPair],
) -> Found:
    """Return the interval up to its first touch or least gap, and the touch or None.

    Pairs in ``sustained`` contact are left out; a pair in ``separating`` must first open its gap.
    """
    first: Happening | None = None
    several = system.mechanism.wire_links > 1
    for pair in system.pairs:
        if pair in sustained or interval.length <= 0.0:
            continue
        end = interval.end.state
        if pair in separating:
            found = _search_return(system, interval, pair)
        elif (sustained and _rests(system, interval, pair)) or (
            several and system.behind_joint(pair, [*separating, *sustained], end)
        ):
            continue
        else:
            found = find_touch(system, interval, pair)
        if found is not None:
            interval, first = found
    return interval, first


def _rests(system: System, interval: Interval, pair: ContactPair) -> bool:
    """Return whether a gap is closed and stays closed."""
    start = interval.start
    end = interval.end.state
    gap = system.gaps.gap
    return abs(gap(pair, start)) <= GAP_ROUNDING and all(
        abs(gap(pair, state)) <= GAP_ROUNDING for state in (interval.at(0.5 * interval.length), end)
    )


def _search_return(system: System, interval: Interval, pair: ContactPair) -> Found | None:
    """Search for a touch of a pair that the link has just left: either the gap opens first, or the
    link comes back at once.
    """
    soon = OPENING * min(system.plan.longest_interval, system.plan.time_scale)
    if interval.length > soon:
        gap, rate = system.gaps.gap_and_rate(pair, interval.at(soon))
        if gap > GAP_ROUNDING + _error(system, interval) and rate > 0.0:
            return find_touch(system, interval, pair, soon / interval.length)
        interval = interval.up_to(interval.integrate_to(soon))
        return _search_hop(system, interval, pair) or (interval, None)
    return _search_hop(system, interval, pair)


def _search_hop(system: System, interval: Interval, pair: ContactPair) -> Found | None:
    """Search for the end of a hop, a rebound from which the link comes back within a short
    interval.

    An interval that ends deep inside a pair is cut at the end of the hop, or where the link is
    still above. A rebound that is over within the shortest interval is too low to follow.
    """
    gaps = system.gaps
    integrate_to = interval.integrate_to
    length = interval.length
    instant = system.plan.instant
    gap, rate = gaps.gap_and_rate(pair, interval.end.state)
    if gap >= -GAP_ROUNDING or rate >= 0.0:
        return None

    def gap_at(time: float) -> float:
        return gaps.gap(pair, interval.at(time))

    if instant < length and (gap := gap_at(instant)) <= 0.0:
        gap = gaps.gap(pair, integrate_to(instant).state)
    # A hop of a single rigid link has no effect. Of several links, one may hop while another is
    # pressed on.
    low = (
        system.mechanism.single_link
        and system.law_of(pair).instantaneous
        and -system.plan.accuracy <= gap < 0.0
    )
    if low or gaps.gap(pair, interval.start) < -GAP_ROUNDING:
        return (
            interval if instant >= length else interval.up_to(integrate_to(instant))
        ), Happening(Kind.REST, pair)
    time = length
    shortest = LEAST_HOP * length
    while time > shortest and (above := gap_at(time)) < -GAP_ROUNDING:
        time = 0.5 * time
        below = above
    if time < length and above > 0.0:
        near = locate(gap_at, time, 2.0 * time, above, below, GAP_TOLERANCE)
        closed = settle(system, partial(gaps.gap, pair), interval, near, GAP_TOLERANCE)
        # A zero at the interval's start is no touch.
        if closed is not None and gaps.gap_and_rate(pair, closed.state)[1] < 0.0:
            return interval.up_to(closed), Happening(Kind.TOUCH, pair)
    while (gap := gaps.gap(pair, integrate_to(time).state)) < -GAP_ROUNDING and time > shortest:
        time *= 0.5
    return interval.up_to(integrate_to(time)), None if gap > GAP_ROUNDING else Happening(
        Kind.REST, pair
    )


def find_touch(
    system: System, interval: Interval, pair: ContactPair, begin: float = 0.0
) -> Found | None:
    """Return the interval up to its first touch, or up to a least gap where the link nearly
    touches; None without either.

    The search begins at the fraction ``begin`` of the interval, where the gap is open.
    """
    gaps = system.gaps
    integrate_to = interval.integrate_to
    length = interval.length
    gap_of = partial(gaps.gap, pair)
    gap_and_rate = partial(gaps.gap_and_rate, pair)
    fraction = first_touch(gaps.mechanism, gap_and_rate, interval, _error(system, interval), begin)
    if fraction is None:
        return None
    last = fraction * length
    near = guess(gap_of, interval, last, begin * length)
    tolerance = min(max(LOCATED_GAP * system.plan.accuracy, GAP_TOLERANCE), 0.1 * GAP_ROUNDING)
    closed = None if near is None else settle(system, gap_of, interval, near, tolerance)
    if closed is not None and gap_and_rate(closed.state)[1] <= 0.0:
        # If the gap opened there, there would be another zero before.
        return interval.up_to(closed), Happening(Kind.TOUCH, pair)
    reached = interval.end if fraction == 1.0 else integrate_to(last)
    begin = begin * length
    at_end, rate = gap_and_rate(reached.state)
    if at_end > 0.0 and rate > 0.0:
        # The gap opens again, so it is closed or least before.
        fastest = 1.5 * gaps.mechanism.speed_bound(interval.start)

        def at_instant(span: float, gap: float) -> bool:
            return gap > fastest * span or max(1.0, fastest) * span <= SHORTEST_INTERVAL

        last, at_end = _least(
            lambda span: gap_and_rate(integrate_to(span).state), begin, last, at_end, at_instant
        )
    if at_end > 0.0:
        return interval.up_to(reached), None
    if at_end < 0.0:
        at_start = max(gap_of(interval.at(begin) if begin else interval.start), 1e-300)
        last = locate(
            lambda span: gap_of(integrate_to(span).state),
            begin,
            last,
            at_start,
            at_end,
            GAP_TOLERANCE,
            near,
        )
    return interval.up_to(integrate_to(last)), Happening(Kind.TOUCH, pair)


def _error(system: System, interval: Interval) -> float:
    """Return a bound of the gap's deviation from its value on the interval's polynomial."""
    length = interval.length
    middle = interval.end.middle
    error = CUBIC_ERROR * length**4 if middle is None else QUINTIC_ERROR * length**6
    if system.mechanism.wire_links > 1:
        error += CUBIC_ERROR * length * (length / system.plan.time_scale) ** 3
    return error


Gap = Callable[[State], tuple[float, float]]
"""The gap of a state, and its rate."""


def first_touch(
    mechanism: Mechanism,
    gap: Gap,
    interval: Interval,
    interpolation_error: float = 0.0,
    begin: float = 0.0,
) -> float | None:
    """Return the fraction of the interval at which the gap is closed or nearly so, on the
    polynomial; None if it stays open.

    The fraction may be later than the touch, but never later than a second touch.
    ``interpolation_error`` bounds the gap's deviation from its value on the polynomial. At a
    fraction f the deviation is at most 16 f^2 (1 - f)^2 times this bound, because angles and rates
    at the ends are exact.
    """
    length = interval.length
    end = interval.end
    margin = interpolation_error
    bound = (
        1.5 * max(mechanism.speed_bound(interval.start), mechanism.speed_bound(end.state)) * length
    )
    fraction, (value, rate) = begin, gap(interval.at(begin * length) if begin else interval.start)
    while fraction < 1.0 and value <= bound * (1.0 - fraction) + margin:
        ahead = min(1.0, fraction + max(value / bound if bound else 1.0, LEAST_ADVANCE))
        following, next_rate = gap(interval.at(ahead * length)) if ahead < 1.0 else gap(end.state)
        if following < 0.0:
            return ahead
        if rate < 0.0 < next_rate:

            def at(part: float) -> tuple[float, float]:
                return gap(interval.at(part * length))

            dip, least = _least(
                at, fraction, ahead, following, lambda span, _: span < 2.0**-MOST_HALVINGS
            )
            near = least < margin * min(1.0, NEAR_START * dip**2)
            if least < 0.0 or (near and dip * max(length, bound) > SHORTEST_ADVANCE):
                return dip
        fraction = ahead
        value = following
        rate = next_rate
    return None


def _least(
    gap: Callable[[float], tuple[float, float]],
    left: float,
    right: float,
    at_right: float,
    enough: Callable[[float, float], bool],
) -> tuple[float, float]:
    """Return the place of a least gap, and the gap there, by bisection on the rate; a closed gap
    ends the search at once.

    The gap falls at the left end and rises at the right end. ``enough`` takes the length of the
    bracket and the gap, and ends the search.
    """
    value = at_right
    while not enough(right - left, value):
        middle = 0.5 * (left + right)
        value, rate = gap(middle)
        if value < 0.0:
            return middle, value
        left, right = (middle, right) if rate < 0.0 else (left, middle)
    return right, gap(right)[0]
