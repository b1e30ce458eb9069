"""One step of every flight, up to the first touch within it."""

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
"""Codes of touches at the end of a step; a wire that folds back by a quarter turn lies on the
hub."""

LEAST_BEND = 0.1
"""Least reach of the bar, over the bristle's length, that shortens the parts of a step."""

BEND = 0.5
"""Longest path of the wire's end in a part of a step near the bar, over the bar's reach."""

FASTER = 1.5
"""Bound of a gap's rate within a step, over the largest rate at the ends of the parts."""

EDGE = 1e-9  # largest distance of a hub angle outside the bar's window that is within it, rad
# Least depth at which a wire that has just left the bar is on it again, over the bristle's length.
HOP_ROUNDING = 1e-14

Gap = Callable[[Array], tuple[Array, Array]]
"""Function that returns the gaps at steps, and their rates."""


class Search(NamedTuple):
    """The first closings of gaps within a step.

    Attributes:
        place: hub's turn up to the closing, rad; infinite where the gap stays open.
        margin: least gap at a minimum before, over the bristle's length; infinite without a
            minimum.
    """

    place: Array
    margin: Array


def fly(passes: Passes, tolerance: float) -> tuple[Chosen, Array]:
    """Advance every flight by one step.

    Returns:
        Codes of the touches at the end of the step, and the least gap that each wire passed without
        a touch.
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
    """Return the steps, and the numbers of the passes near the bar.

    A step ends at the end of the pass, or where the wire begins to reach the bar. Near the bar it
    is so short that a gap has at most one minimum in each of its parts.
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
    longest = INTERVALS * BEND * np.maximum(passes.reach[near], LEAST_BEND) / speed
    step[near] = np.minimum(step[near], longest)
    return step, near


def _gaps(obstacle: int, passes: Passes, course: Course, chosen: Chosen) -> Callable[[Chosen], Gap]:
    """Return the function that returns, for the numbers of some of the chosen passes, their gap to
    an obstacle over the step.
    """

    def gap_of(numbers: Chosen) -> Gap:
        """Return the gap of the passes with some numbers over the step."""
        place = passes.place(chosen[numbers])
        own = course.take(chosen[numbers])
        return lambda step: clearance(obstacle, place, own.pose_at(step))

    return gap_of


def clearance(obstacle: int, passes: Passes | Place, pose: Pose) -> tuple[Array, Array]:
    """Return the gap to an obstacle, over the bristle's length, and its rate, per radian of the
    hub.
    """
    if obstacle == BAR:
        found = closest(passes, pose)
        return found.gap, found.rate
    gap = passes.depth - passes.radius * pose.hub_cosine - pose.cosine
    return gap, passes.radius * pose.hub_sine + pose.sine * (1.0 + pose.rate)


def first_closing(
    gap_of: Callable[[Chosen], Gap], gaps: Array, rates: Array, step: Array, leaving: Chosen
) -> Search:
    """Find the first closing of each gap within a step.

    A part of the step has a closing if the gap is closed at its end, or if a minimum located in it
    is not positive.

    Args:
        gap_of: function that returns, for the numbers of some passes, their gap over the step.
        gaps, rates: gaps and their rates at FRACTIONS of the step.
        step: steps, rad.
        leaving: whether the gap begins at zero.
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
    """Return the places where gaps close between two ends.

    Newton's method begins at the root of the cubic through the inverse function's values and slopes
    at the ends. A gap that begins at zero is divided by the step, so that only its next zero
    remains.
    """

    def value_of(numbers: Chosen) -> Function:
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
    """Return the places where gaps are least between two ends.

    The place is where the rate changes its sign, or the minimum of a hop's cubic.
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
    """Return the place of the minimum of a gap that begins at zero, in the first part of a step;
    NaN if it opens.

    The cubic through the part's ends gives it.
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
    """Record the least angle up to the end of the step: at a minimum within it, or at its end."""
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
