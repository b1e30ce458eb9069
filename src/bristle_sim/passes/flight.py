"""One step of the hub for all bristles in flight; each bristle stops at its first touch within the
step.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.passes.bar import closest, half_turn
from bristle_sim.passes.crossing import Function, root
from bristle_sim.passes.motion import (
    FRACTIONS,
    INTERVALS,
    Course,
    Pose,
    course_of,
    pose_of,
    step_length,
)
from bristle_sim.passes.state import Chosen, Passes, Place

NOTHING, BAR, WORKPART, HUB = range(4)
"""Codes of the obstacle that a wire touches at the end of a step; HUB is a wire folded by a quarter
turn, which lies on the hub."""

LEAST_BEND = 0.1
"""Distance of the wire's centre line from the bar's centre at a touch, over the bristle's length,
below which a thinner bar does not shorten the segments of a step further. A wire that has just
left the bar has no such bound: its end may touch again within a turn of the size of this distance."""

BEND = 0.5
"""Longest path of the wire's end in a segment of a step near the bar, over the distance of the
wire's centre line from the bar's centre at a touch."""

FASTER = 1.5
"""Assumed upper bound of a gap's rate within a step, over its largest rate at the ends of the
segments."""

EDGE = 1e-9  # tolerance, rad, within which a hub angle counts as inside the bar's window
# Least overlap, over the bristle's length, at which a wire that has just left the bar touches again
HOP_ROUNDING = 1e-14

Gap = Callable[[Array], tuple[Array, Array]]
"""Function of the hub's turn since the start of the step, rad; it returns the gaps and their
rates."""


class Search(NamedTuple):
    """The instant in a step at which each gap first closes, and the closest near miss before it.

    Attributes:
        place: turn of the hub from the start of the step to the closing, rad; infinite if the gap
            stays open.
        margin: smallest minimum of the gap before the closing, over the bristle's length; infinite
            if the gap has no minimum.
    """

    place: Array
    margin: Array


def fly(passes: Passes, tolerance: float) -> tuple[Chosen, Array]:
    """Advance every bristle in flight by one step, or to its first touch within the step.

    Returns:
        The code of the touch at the end of the step, and the smallest gap at which each wire passed
        an obstacle without a touch, over the bristle's length.
    """
    course = course_of(passes)
    step, near = _step(passes, course, tolerance)
    last_terms = np.abs(course.rate[-1]) * step ** (len(course.rate) - 1.0)
    passes.error = passes.error + last_terms / passes.rate_scale
    turns = FRACTIONS * step
    angles, rates = course.sampled(step)
    poses = pose_of(passes.hub_angle + turns, angles, rates)
    place = step.copy()
    kind = np.full(passes.size, NOTHING)
    margin = np.full(passes.size, np.inf)
    for obstacle, chosen in ((WORKPART, np.arange(passes.size)), (BAR, near)):
        if chosen.size:
            own = passes.place(chosen)
            gaps, openings = clearance(obstacle, own, Pose(*(each[:, chosen] for each in poses)))
            search = first_closing(
                _gaps(obstacle, passes, course, chosen),
                gaps,
                openings,
                step[chosen],
                passes.touching[chosen] & (obstacle == BAR),
            )
            margin[chosen] = np.minimum(margin[chosen], search.margin)
            sooner = search.place <= place[chosen]
            kind[chosen[sooner]] = obstacle
            place[chosen[sooner]] = search.place[sooner]
    folded = np.abs(angles) > 0.5 * np.pi
    if folded.any():
        kind[(folded & (turns <= place)).any(axis=0)] = HUB
    passes.angle, passes.rate = course.at(place)
    _note_retraction(passes, course, rates, step, place)
    passes.hub_angle = passes.hub_angle + place
    passes.touching = passes.touching & (place <= 0.0)
    return kind, margin


def _step(passes: Passes, course: Course, tolerance: float) -> tuple[Array, Chosen]:
    """Return the length of each pass's step, rad, and the indices of the passes near the bar.

    A step ends at the latest with the pass, or where the wire begins to reach the bar. Near the bar
    a step is so short that the gap has at most one minimum in each segment of the step.
    """
    chi = half_turn(passes.hub_angle - passes.bar_angle)
    outside = np.abs(chi) > passes.window + EDGE
    near = np.flatnonzero(~outside)
    ahead = -passes.window - chi
    ahead += np.where(ahead < 0.0, 2.0 * np.pi, 0.0)
    step = np.minimum(step_length(passes, course, tolerance), passes.end - passes.hub_angle)
    np.minimum(step, ahead, out=step, where=outside & (passes.window >= 0.0))
    gained = 0.25 * np.abs(course.rate[1, near]) * step[near]
    speed = passes.radius[near] + 1.0 + np.abs(passes.rate[near]) + gained
    least = np.where(passes.touching[near], 0.0, LEAST_BEND)
    longest = INTERVALS * BEND * np.maximum(passes.reach[near], least) / speed
    step[near] = np.minimum(step[near], longest)
    return step, near


def _gaps(obstacle: int, passes: Passes, course: Course, chosen: Chosen) -> Callable[[Chosen], Gap]:
    """Return a function that selects some of the chosen passes by index, and returns their gap to
    an obstacle as a function of the hub's turn.
    """

    def gap_of(numbers: Chosen) -> Gap:
        """Return the gap of the selected passes as a function of the hub's turn."""
        place = passes.place(chosen[numbers])
        own = course.take(chosen[numbers])
        return lambda step: clearance(obstacle, place, own.pose_at(step))

    return gap_of


def clearance(obstacle: int, passes: Passes | Place, pose: Pose) -> tuple[Array, Array]:
    """Return the gap between wire and obstacle, over the bristle's length, and the derivative of
    the gap with respect to the hub angle.
    """
    if obstacle == BAR:
        found = closest(passes, pose)
        return found.gap, found.rate
    gap = passes.depth - passes.radius * pose.hub_cosine - pose.cosine
    return gap, passes.radius * pose.hub_sine + pose.sine * (1.0 + pose.rate)


def first_closing(
    gap_of: Callable[[Chosen], Gap], gaps: Array, rates: Array, step: Array, leaving: Chosen
) -> Search:
    """Find the instant in a step at which each gap first closes.

    A gap closes in a segment of the step if it is closed at the segment's end, or if its minimum
    within the segment is negative.

    Args:
        gap_of: function that takes the indices of some passes, and returns their gap as a function
            of the hub's turn.
        gaps, rates: gaps and their rates at the ends of the segments, shape (segments + 1, passes).
        step: lengths of the steps, rad.
        leaving: whether the wire has just left the obstacle, so that the gap begins at zero.
    """
    width = step / INTERVALS
    with np.errstate(invalid="ignore"):  # without a workpart the gap is infinite
        fastest = np.abs(rates).max(axis=0) * (FASTER * width)
        candidate = (rates[:-1] < 0.0) & (rates[1:] > 0.0) & (gaps[:-1] + gaps[1:] < fastest)
    candidate[0, leaving] = False
    candidate |= gaps[1:] <= 0.0
    hop = np.full(len(step), np.nan)
    first = np.flatnonzero(leaving)
    hop[first] = _hops(gaps[:2, first], rates[:2, first], width[first])
    candidate[0] |= np.isfinite(hop)
    place = np.full(len(step), np.inf)
    margin = place.copy()
    while (number := np.flatnonzero(candidate.any(axis=0))).size:
        part = candidate[:, number].argmax(axis=0)
        candidate[part, number] = False
        low = part * width[number]
        high = low + width[number]
        leaves = leaving[number] & (part == 0)
        slopes = (rates[part, number], rates[part + 1, number])
        low_gap = gaps[part, number]
        high_gap = gaps[part + 1, number]
        dips = np.flatnonzero(high_gap > 0.0)
        if dips.size:
            some = number[dips]
            ends = (low[dips], high[dips])
            own = (slopes[0][dips], slopes[1][dips])
            hops = np.where(leaves[dips], hop[some], np.nan)
            bottom = _lowest(gap_of, some, ends, (low_gap[dips], high_gap[dips]), own, hops)
            least, _ = gap_of(some)(bottom)
            closes = least < np.where(leaves[dips], -HOP_ROUNDING, 0.0)
            passed = some[~(closes | leaves[dips])]
            margin[passed] = np.minimum(margin[passed], least[~(closes | leaves[dips])])
            high[dips] = np.where(closes, bottom, high[dips])
            high_gap[dips] = np.where(closes, least, high_gap[dips])
        closed = np.flatnonzero(high_gap <= 0.0)
        if closed.size:
            some = number[closed]
            candidate[:, some] = False
            place[some] = _closing(
                gap_of,
                some,
                (low[closed], high[closed]),
                (low_gap[closed], high_gap[closed]),
                (slopes[0][closed], slopes[1][closed]),
                leaves[closed],
            )
    return Search(place, margin)


def _closing(
    gap_of: Callable[[Chosen], Gap],
    number: Chosen,
    ends: tuple[Array, Array],
    gaps: tuple[Array, Array],
    slopes: tuple[Array, Array],
    leaves: Chosen,
) -> Array:
    """Return the hub angle, rad, within each bracket at which the gap closes.

    Newton's method starts from inverse cubic interpolation of the gaps and their rates at the ends.
    A gap that begins at zero is divided by the turn, so that only its next zero remains.
    """

    def value_of(numbers: Chosen) -> Function:
        """Return the gaps of some passes, with their rates, as a function of the turn."""
        gap = gap_of(number[numbers])
        divided = leaves[numbers]

        def value(place: Array) -> tuple[Array, Array]:
            height, rate = gap(place)
            return height, np.where(divided, rate - height / place, rate)

        return value

    low, high = ends
    with np.errstate(divide="ignore", invalid="ignore"):
        rise = gaps[1] - gaps[0]
        part = -gaps[0] / rise
        bend = rise * ((1.0 - part) / slopes[0] - part / slopes[1])
        start = low + part * part * (3.0 - 2.0 * part) * (high - low) + part * (1.0 - part) * bend
    start = np.where(leaves, high, start)
    return root(value_of, ends, gaps[1], start)


def _lowest(
    gap_of: Callable[[Chosen], Gap],
    number: Chosen,
    ends: tuple[Array, Array],
    gaps: tuple[Array, Array],
    slopes: tuple[Array, Array],
    hop: Array,
) -> Array:
    """Return the hub angle, rad, within each bracket at which the gap is smallest.

    The minimum is located as a zero of the gap's rate. For a gap that begins at zero, ``hop`` is
    already that angle; it is NaN for all other gaps.
    """
    turning = np.flatnonzero(np.isnan(hop))
    bottom = hop.copy()
    if turning.size:

        def opening_of(numbers: Chosen) -> Function:
            gap = gap_of(number[turning[numbers]])
            return lambda place: (gap(place)[1], None)

        low, high, low_gap, high_gap, low_slope, high_slope = (
            each[turning] for each in (*ends, *gaps, *slopes)
        )
        with np.errstate(divide="ignore", invalid="ignore"):
            width = high - low
            rise = 3.0 * (high_gap - low_gap) / width
            bend = rise - 2.0 * low_slope - high_slope
            twist = 3.0 * (low_slope + high_slope) - 2.0 * rise
            least = -low_slope / (bend + np.sqrt(bend * bend - twist * low_slope))
        bottom[turning] = root(opening_of, (low, high), high_slope, low + least * width)
    return bottom


def _hops(gaps: Array, rates: Array, width: Array) -> Array:
    """Return the turn of the hub, rad, at which a gap that begins at zero is smallest in the first
    segment of a step.

    It is the minimum of the cubic through the gap and its rates at the segment's ends. The value is
    NaN if this cubic has no minimum in the segment.
    """
    bend = 3.0 * gaps[1] / width**2 - (2.0 * rates[0] + rates[1]) / width
    twist = (rates[0] + rates[1]) / width**2 - 2.0 * gaps[1] / width**3
    with np.errstate(divide="ignore", invalid="ignore"):
        place = -0.5 * bend / twist
        returns = (bend * bend > 4.0 * rates[0] * twist) & (place > 0.0) & (place < width)
    return np.asarray(np.where(returns, place, np.nan))


def _note_retraction(
    passes: Passes, course: Course, rates: Array, step: Array, place: Array
) -> None:
    """Update the least relative angle of each pass, which lies at a minimum within the step or at
    the end of the step.
    """
    turning = (rates[:-1] < 0.0) & (rates[1:] > 0.0)
    number = np.flatnonzero(turning.any(axis=0))
    if number.size:
        part = turning[:, number].argmax(axis=0)
        before, after = rates[part, number], rates[part + 1, number]
        width = step[number] / INTERVALS
        low = part * width
        at = root(
            lambda numbers: course.take(number[numbers]).turning_at,
            (low, low + width),
            after,
            low + width * before / (before - after),
        )
        least, _ = course.take(number).at(np.minimum(at, place[number]))
        passes.lowest[number] = np.minimum(passes.lowest[number], least)
    passes.lowest = np.minimum(passes.lowest, passes.angle)
