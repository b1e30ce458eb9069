"""Where within an interval the link touches an obstacle."""

from __future__ import annotations

import functools
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from bristle_sim.scene.events import first_touch, guess, locate
from bristle_sim.scene.gaps import Gaps
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.obstacles import Obstacle
from bristle_sim.scene.stepping import Advance

__all__ = ["SHORTEST", "Interval", "find_touch"]

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
