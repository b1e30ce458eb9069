"""Where within an interval a link touches an obstacle, for the first time or again."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

from bristle_sim.scene.event_functions import Touch
from bristle_sim.scene.events import first_touch, guess, locate
from bristle_sim.scene.gaps import GAP_ROUNDING, Gaps
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.obstacles import Obstacle
from bristle_sim.scene.stepping import Advance
from bristle_sim.scene.wire_joints import behind_joint

if TYPE_CHECKING:
    from bristle_sim.scene.progress import Progress


GAP_TOLERANCE = 1e-13
"""To which a touch is located: rounding of an extrapolated interval is of this size, and a closer search would not end."""

SHORTEST = 1e-13
"""An interval shorter than this fraction of the scene's time unit means that no interval is short enough. A motion of that
fraction of the scene's length, too, is an instant."""


class Interval(NamedTuple):
    """An interval that has been carried, and what carries the scene over less of it.

    Attributes:
        start: state that it begins with.
        end: result at its end.
        again: the result after a shorter time from the start.
    """

    start: State
    end: Advance
    again: Callable[[float], Advance]

    @property
    def length(self) -> float:
        """Duration of the interval."""
        return self.end.state.time - self.start.time


LEAST_HOP = 1e-6
"""Fraction of an interval within which a rebound that is shorter is taken for none."""


def search_touch(
    progress: Progress,
    interval: Interval,
    obstacle: Obstacle,
    sustained: Sequence[Obstacle],
    separating: Sequence[Obstacle],
) -> tuple[Advance, Touch | None] | None:
    """Return the interval cut short where it comes nearest to an obstacle, and the touch if it does touch; None if it is clear.

    ``sustained`` and ``separating`` are the pairs that are in contact and those that leave each other.
    """
    end = interval.end
    if obstacle in separating:
        return _search_return(progress, interval, obstacle)
    if sustained and progress.gaps.rests(obstacle, interval.start, end.state):
        return None
    error = progress.stepper.interpolation_error(interval.start, end.state)
    if progress.mechanism.wire_links > 1:
        if behind_joint(progress, obstacle, [*separating, *sustained], end.state):
            return None
        error += progress.cubic_error(interval.length)
    found = find_touch(interval, progress.gaps, obstacle, error)
    return None if found is None else (found[0], Touch(obstacle) if found[1] else None)


def _search_return(progress: Progress, interval: Interval, obstacle: Obstacle) -> tuple[Advance, Touch | None] | None:
    """Search a touch of what a link has left: it touches it again only by coming back within the interval."""
    gaps, result = progress.gaps, interval.end
    gap, rate = gaps.gap_and_rate(obstacle, result.state)
    if gap >= -GAP_ROUNDING or rate >= 0.0:
        return None
    entered = gaps.gap(obstacle, interval.start) >= -GAP_ROUNDING
    # Whether a single link hops is of no consequence; of several, one may hop while another is pressed on.
    if entered and (gap < -progress.plan.accuracy or len(progress.mechanism.links) > 1):
        result = _rise(interval, gaps, obstacle)
        if gaps.gap(obstacle, result.state) > GAP_ROUNDING:
            return result, None
    # It is back within the shortest interval: too low a rebound to follow.
    return result, Touch(obstacle, True)


def _rise(interval: Interval, gaps: Gaps, obstacle: Obstacle) -> Advance:
    """Return the part of an interval that ends deep inside an obstacle in which the rebound is still above it."""
    result, span = interval.end, interval.length
    while span > LEAST_HOP * interval.length and gaps.gap(obstacle, result.state) < -GAP_ROUNDING:
        span *= 0.5
        result = interval.again(span)
    return result


def find_touch(
    interval: Interval, gaps: Gaps, obstacle: Obstacle, interpolation_error: float
) -> tuple[Advance, bool] | None:
    """Return the interval up to its first touch and True, or up to where it nearly touched and False; else None.

    ``interpolation_error`` is how far the motion may be off the cubic through the ends besides the cubic's own error.
    """
    start, end = interval.start, interval.end
    fraction = first_touch(
        gaps.mechanism, lambda state: gaps.gap_and_rate(obstacle, state), start, end.state, interpolation_error
    )
    if fraction is None:
        return None
    again = functools.cache(interval.again)
    reached, closed = end if fraction == 1.0 else again(fraction * interval.length), fraction * interval.length
    at_end, rate = gaps.gap_and_rate(obstacle, reached.state)
    if at_end > 0.0 and rate > 0.0:
        closed, at_end = least_gap(interval._replace(again=again), gaps, obstacle, closed, at_end)
    if at_end > 0.0:
        return reached, False
    if at_end < 0.0:
        at_start = max(gaps.gap(obstacle, start), 1e-300)
        near = guess(partial(gaps.gap, obstacle), start, end.state, fraction)
        closed = locate(
            lambda span: gaps.gap(obstacle, again(span).state), 0.0, closed, at_start, at_end, GAP_TOLERANCE, near
        )
    return again(closed), True


def least_gap(interval: Interval, gaps: Gaps, obstacle: Obstacle, span: float, gap: float) -> tuple[float, float]:
    """Return where the gap is closed, or else least, in a motion after which it opens: the duration, and the gap."""
    fastest = 1.5 * gaps.mechanism.speed_bound(interval.start)
    left, right = 0.0, span
    while gap <= fastest * (right - left) and max(1.0, fastest) * (right - left) > SHORTEST:
        middle = 0.5 * (left + right)
        gap, rate = gaps.gap_and_rate(obstacle, interval.again(middle).state)
        if gap < 0.0:
            return middle, gap
        left, right = (middle, right) if rate < 0.0 else (left, middle)
    return right, gap
