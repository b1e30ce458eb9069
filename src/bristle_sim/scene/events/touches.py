"""Where within an interval a link touches an obstacle, for the first time or again, without missing it.

Gaps are searched on the cubic by conservative advancement (Mirtich 1996): from a gap g no contact can happen before
g / (largest speed), so nothing is jumped over.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING

from bristle_sim.scene.contact.gaps import GAP_ROUNDING, Gaps, behind_joint
from bristle_sim.scene.contact.obstacles import Obstacle
from bristle_sim.scene.events.functions import Touch
from bristle_sim.scene.events.locate import Interval, guess, interpolate, locate, settle
from bristle_sim.scene.integrate.stepping import Advance
from bristle_sim.scene.mechanism import Mechanism, State

if TYPE_CHECKING:
    from bristle_sim.scene.progress import Progress

CUBIC_ERROR = 0.01
"""Gap by which the cubic may be off, per fourth power of the interval, in a scene's units: h^4/384 times some safety."""

SHORTEST_ADVANCE = 1e-9
"""A least gap sooner than this, in a scene's time units and lengths, is the one at which the interval begins."""

RESOLUTION = 1.0 / 8.0
"""Least advance in a search, as a fraction of the interval; least values of the gap in between show in its slopes."""

GAP_TOLERANCE = 1e-13
"""Least gap to which a touch is located: rounding of an extrapolated interval is of this size, and a closer search would not end."""

TOUCH_LOCATED = 1e-6
"""Gap to which a touch is located, as a fraction of the accuracy: a slow approach makes more of it in time."""

SHORTEST_INTERVAL = 1e-13
"""An interval shorter than this fraction of the scene's time unit means that no interval is short enough. A motion of that
fraction of the scene's length, too, is an instant."""


MUCH_SHORTER = 0.25
"""Fraction of an interval below which many repetitions give no more accuracy, but their weights more rounding."""

LEAST_HOP = 1e-6
"""Fraction of an interval within which a rebound that is shorter is taken for none."""


VIBRATION = 0.01
"""Error of the cubic in the scene's unit, per fourth power of the interval and third power of the fastest rate: of a rate of
1 at that frequency, h^4 w^3/384 times some safety."""


def first_touch_of_all(
    progress: Progress, interval: Interval, sustained: Sequence[Obstacle], separating: Sequence[Obstacle]
) -> tuple[Advance, Touch | None]:
    """Return the interval up to its first touch, and the touch; or up to where a link comes nearest to what it does not touch.

    ``sustained`` and ``separating`` are the pairs that are in contact and those that leave each other.
    """
    first: Touch | None = None
    for obstacle in progress.obstacles:
        if obstacle not in sustained and interval.length > 0.0:
            found = _search_touch(progress, interval, obstacle, sustained, separating)
            if found is not None:
                end, first = found
                interval = interval._replace(end=end)
    return interval.end, first


def _search_touch(
    progress: Progress,
    interval: Interval,
    obstacle: Obstacle,
    sustained: Sequence[Obstacle],
    separating: Sequence[Obstacle],
) -> tuple[Advance, Touch | None] | None:
    """Return the interval cut short where it comes nearest to an obstacle, and the touch if it does touch; None if it is clear."""
    end = interval.end
    if obstacle in separating:
        return _search_return(progress, interval, obstacle)
    if sustained and progress.gaps.rests(obstacle, interval.start, end.state):
        return None
    error = progress.stepper.interpolation_error(interval.start, end.state)
    if progress.mechanism.wire_links > 1:
        if behind_joint(progress, obstacle, [*separating, *sustained], end.state):
            return None
        error += VIBRATION * interval.length * (interval.length / progress.plan.time_scale) ** 3
    found = find_touch(progress, interval, obstacle, error)
    return None if found is None else (found[0], Touch(obstacle) if found[1] else None)


def _search_return(progress: Progress, interval: Interval, obstacle: Obstacle) -> tuple[Advance, Touch | None] | None:
    """Search a touch of what a link has left: it touches it again only by coming back within the interval."""
    gaps, result = progress.gaps, interval.end
    gap, rate = gaps.gap_and_rate(obstacle, result.state)
    if gap >= -GAP_ROUNDING or rate >= 0.0:
        return None
    progress.stepper.begin_afresh()
    interval = interval._replace(again=functools.cache(interval.again))
    share = progress.instant / interval.length
    if share < 1.0:
        gap = gaps.gap(obstacle, interpolate(interval.start, result.state, share))
        if gap <= 0.0:
            result = interval.again(progress.instant)
            gap = gaps.gap(obstacle, result.state)
    # Whether a single link hops is of no consequence; of several, one may hop while another is pressed on.
    low = len(progress.mechanism.links) == 1 and -progress.plan.accuracy <= gap < 0.0
    if gaps.gap(obstacle, interval.start) >= -GAP_ROUNDING and not low:
        return _hop(interval, gaps, obstacle)
    return (result if share >= 1.0 else interval.again(progress.instant)), Touch(obstacle, True)


def _hop(interval: Interval, gaps: Gaps, obstacle: Obstacle) -> tuple[Advance, Touch | None]:
    """Return an interval that ends deep inside an obstacle up to the end of the hop before, or up to where it is above still.

    Where it is back within the shortest interval it is too low a rebound to follow.
    """
    start, end, share = interval.start, interval.end.state, 1.0

    def gap_at(fraction: float) -> float:
        return gaps.gap(obstacle, interpolate(start, end, fraction))

    while share > LEAST_HOP and (above := gap_at(share)) < -GAP_ROUNDING:
        share, below = 0.5 * share, above
    if share < 1.0 and above > 0.0:
        near = interval.length * locate(gap_at, share, 2.0 * share, above, below, GAP_TOLERANCE)
        closed = settle(partial(gaps.gap, obstacle), start, interval.again, near, interval.length, GAP_TOLERANCE)
        # The zero at its beginning is none.
        if closed is not None and gaps.gap_and_rate(obstacle, interval.again(closed).state)[1] < 0.0:
            return interval.again(closed), Touch(obstacle)
    result, span = interval.again(share * interval.length), share * interval.length
    while span > LEAST_HOP * interval.length and gaps.gap(obstacle, result.state) < -GAP_ROUNDING:
        span *= 0.5
        result = interval.again(span)
    return result, None if gaps.gap(obstacle, result.state) > GAP_ROUNDING else Touch(obstacle, True)


def find_touch(
    progress: Progress, interval: Interval, obstacle: Obstacle, interpolation_error: float
) -> tuple[Advance, bool] | None:
    """Return the interval up to its first touch and True, or up to where it nearly touched and False; else None.

    ``interpolation_error`` is how far the motion may be off the cubic through the ends besides the cubic's own error.
    """
    start, end, gaps = interval.start, interval.end, progress.gaps
    fraction = first_touch(
        gaps.mechanism, lambda state: gaps.gap_and_rate(obstacle, state), start, end.state, interpolation_error
    )
    if fraction is None:
        return None
    again = functools.cache(interval.again)
    gap_of, last = partial(gaps.gap, obstacle), fraction * interval.length
    near = guess(gap_of, start, end.state, fraction)
    if (near or last) < MUCH_SHORTER * interval.length:
        progress.stepper.begin_afresh()
    tolerance = min(max(TOUCH_LOCATED * progress.plan.accuracy, GAP_TOLERANCE), 0.1 * GAP_ROUNDING)
    if near is not None and (closed := settle(gap_of, start, again, near, last, tolerance)) is not None:
        return again(closed), True
    reached, closed = end if fraction == 1.0 else again(last), last
    at_end, rate = gaps.gap_and_rate(obstacle, reached.state)
    if at_end > 0.0 and rate > 0.0:
        closed, at_end = least_gap(interval._replace(again=again), gaps, obstacle, closed, at_end)
    if at_end > 0.0:
        return reached, False
    if at_end < 0.0:
        at_start = max(gaps.gap(obstacle, start), 1e-300)
        closed = locate(lambda span: gap_of(again(span).state), 0.0, closed, at_start, at_end, GAP_TOLERANCE, near)
    return again(closed), True


def least_gap(interval: Interval, gaps: Gaps, obstacle: Obstacle, span: float, gap: float) -> tuple[float, float]:
    """Return where the gap is closed, or else least, in a motion after which it opens: the duration, and the gap."""
    fastest = 1.5 * gaps.mechanism.speed_bound(interval.start)
    left, right = 0.0, span
    while gap <= fastest * (right - left) and max(1.0, fastest) * (right - left) > SHORTEST_INTERVAL:
        middle = 0.5 * (left + right)
        gap, rate = gaps.gap_and_rate(obstacle, interval.again(middle).state)
        if gap < 0.0:
            return middle, gap
        left, right = (middle, right) if rate < 0.0 else (left, middle)
    return right, gap


Gap = Callable[[State], tuple[float, float]]
"""The gap of a state, and its rate."""


def first_touch(
    mechanism: Mechanism, gap: Gap, start: State, end: State, interpolation_error: float = 0.0
) -> float | None:
    """Return the fraction of the interval at which the gap is closed or nearly so, on the cubic; None if it stays open.

    The fraction may be later than the touch but never past a second one. ``interpolation_error`` is how far the motion may be off the
    cubic besides its own error.
    """
    length = end.time - start.time
    bound = 1.5 * max(mechanism.speed_bound(start), mechanism.speed_bound(end)) * length
    margin = CUBIC_ERROR * length**4 + interpolation_error
    fraction, (value, rate) = 0.0, gap(start)
    while fraction < 1.0 and value <= bound * (1.0 - fraction) + margin:
        ahead = min(1.0, fraction + max(value / bound if bound else 1.0, RESOLUTION))
        following, next_rate = gap(interpolate(start, end, ahead)) if ahead < 1.0 else gap(end)
        if following < 0.0:
            return ahead
        if rate < 0.0 < next_rate:
            dip, least = _dip(lambda at: gap(interpolate(start, end, at)), fraction, ahead)
            if least < 0.0 or (least < margin and dip * max(length, bound) > SHORTEST_ADVANCE):
                return dip
        fraction, value, rate = ahead, following, next_rate
    return None


def _dip(gap: Callable[[float], tuple[float, float]], left: float, right: float) -> tuple[float, float]:
    """Return where a gap that falls at its left and rises at its right end is closed, or least: fraction, and gap."""
    for _ in range(40):
        middle = 0.5 * (left + right)
        value, rate = gap(middle)
        if value < 0.0:
            return middle, value
        left, right = (middle, right) if rate < 0.0 else (left, middle)
    return right, gap(right)[0]
