"""One step of every flight, up to the first touch within it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.passes.bar import closest
from bristle_sim.passes.crossing import Function, Sloped, newton_root, root
from bristle_sim.passes.motion import ORDER, Course, Pose, course_of, free_acceleration, step_length
from bristle_sim.passes.state import Chosen, Passes, Place

NOTHING, BAR, WORKPART, HUB = range(4)
"""Codes of touches at the end of a step; a wire that folds back by a quarter turn lies on the
hub."""

INTERVALS = 8
"""Number of equal parts of a step; a gap has at most one minimum in a part, by assumption."""

LEAST_BEND = 0.1
"""Least reach of the bar, over the bristle's length, that shortens the parts of a step."""

BEND = 0.5
"""Longest path of the wire's end in a part of a step near the bar, over the bar's reach."""

FASTER = 1.5
"""Bound of a gap's rate within a step, over the largest rate at the ends of the parts."""

EDGE = 1e-9  # largest distance of a hub angle outside the bar's window that is within it, rad
# Least depth at which a wire that has just left the bar is on it again, over the bristle's length.
HOP_ROUNDING = 1e-14

NEWTON_ROUNDS = 2
"""Rounds of Newton's method from the chord to the least angle.

The error of its place is then 1e-6, that of the angle the square of that."""

FRACTIONS = np.linspace(0.0, 1.0, INTERVALS + 1)

Gap = Callable[[Array], tuple[Array, Array]]
"""Function that returns the gaps at steps, and their rates."""

PLACE_OF_LEAST = 1e-8  # rad; the least gap depends on its place by the square


@dataclass(slots=True)
class Search:
    """The search of a step for the first closing of a gap.

    Attributes:
        place: step to the touch, or to the place where the search must continue, rad.
        touched: whether the gap closes at that place.
        margin: least gap at a located minimum, over the bristle's length; infinite without a
        minimum.
    """

    place: Array
    touched: Chosen
    margin: Array


def fly(passes: Passes, tolerance: float) -> tuple[Chosen, Array]:
    """Advance every flight by one step.

    Returns:
        Codes of the touches at the end of the step, and the least gap that each wire passed without
        a touch.
    """
    course = course_of(passes)
    step, near = _step(passes, course, tolerance)
    passes.error = (
        passes.error + np.abs(course.rate[-1]) * step ** (ORDER - 1.0) / passes.rate_scale
    )
    poses = course.sampled(step, FRACTIONS)
    bend = 0.125 * (step / INTERVALS) ** 2  # of the hub's cosine between two places
    highest = passes.radius * (poses.hub_cosine.max(axis=0) + bend)
    low = np.flatnonzero(highest >= passes.depth - 1.0)  # elsewhere no tip reaches the workpart
    place = step.copy()
    kind = np.full(passes.size, NOTHING)
    margin = np.full(passes.size, np.inf)
    for obstacle, chosen in ((WORKPART, low), (BAR, near)):
        if chosen.size:
            some = passes.take(chosen)
            part = course.take(chosen)
            gaps, openings = clearance(obstacle, some, Pose(*(each[:, chosen] for each in poses)))
            leaving = some.touching & (obstacle == BAR)
            search = first_closing(
                _gaps(obstacle, some, part), gaps, openings, step[chosen], leaving
            )
            sooner = (search.place < place[chosen]) | (
                search.touched & (search.place <= place[chosen])
            )
            margin[chosen] = np.minimum(margin[chosen], search.margin)
            kind[chosen] = np.where(
                sooner, np.where(search.touched, obstacle, NOTHING), kind[chosen]
            )
            place[chosen] = np.where(sooner, search.place, place[chosen])
    folded = poses.cosine * poses.hub_cosine + poses.sine * poses.hub_sine < 0.0  # cos alpha
    kind[(folded & (FRACTIONS[:, np.newaxis] * step <= place)).any(axis=0)] = HUB
    passes.angle = course.angle_at(place)
    passes.rate = course.rate_at(place)
    _note_retraction(passes, course, poses.rate, step, place)
    passes.hub_angle = passes.hub_angle + place
    passes.touching = passes.touching & (place <= 0.0)
    return kind, margin


def _step(passes: Passes, course: Course, tolerance: float) -> tuple[Array, Chosen]:
    """Return the steps, and the numbers of the passes near the bar.

    A step ends at the end of the pass, or where the wire begins to reach the bar. Near the bar it
    is so short that a gap has at most one minimum in each of its parts.
    """
    chi = np.remainder(passes.hub_angle - passes.bar_angle + np.pi, 2.0 * np.pi) - np.pi
    near = np.flatnonzero(np.abs(chi) <= passes.window + EDGE)
    ahead = np.remainder(-passes.window - chi, 2.0 * np.pi)
    ahead[near] = np.inf
    ahead[passes.window < 0.0] = np.inf
    step = np.minimum(step_length(passes, course, tolerance), passes.end - passes.hub_angle)
    np.minimum(step, ahead, out=step)
    gained = 0.25 * np.abs(course.rate[2, near]) * step[near]
    speed = passes.radius[near] + 1.0 + np.abs(passes.rate[near]) + gained
    longest = INTERVALS * BEND * np.maximum(passes.reach[near], LEAST_BEND) / speed
    step[near] = np.minimum(step[near], longest)
    return step, near


def _gaps(obstacle: int, passes: Passes, course: Course) -> Callable[[Chosen], Gap]:
    """Return the function that returns, for the numbers of some passes, their gap to an obstacle
    over the step.
    """

    def gap_of(numbers: Chosen) -> Gap:
        """Return the gap of the passes with some numbers over the step."""
        place = passes.place(numbers)
        own = course.take(numbers)

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

    A part of the step has a touch if the gap is closed at its end, or if a minimum located in it is
    not positive. If the minimum is positive, the search ends with that part, and the next step
    begins there.

    Args:
        gap_of: function that returns, for the numbers of some passes, their gap over the step.
        gaps, rates: gaps and their rates at FRACTIONS of the step.
        step: steps, rad.
        leaving: whether the gap begins at zero.
    """
    width = step / INTERVALS
    with np.errstate(invalid="ignore"):  # without a workpart the gap is infinite
        fastest = np.abs(rates).max(axis=0) * FASTER
        dips = (rates[:-1] < 0.0) & (rates[1:] > 0.0) & (gaps[:-1] + gaps[1:] < fastest * width)
        hop = np.where(leaving, _hops(gaps, rates, width), np.nan)
    candidate = (gaps[1:] <= 0.0) | dips
    candidate[0] |= np.isfinite(hop)
    search = Search(step.copy(), np.zeros(len(step), dtype=bool), np.full(len(step), np.inf))
    number = np.flatnonzero(candidate.any(axis=0))
    if not number.size:
        return search
    part = candidate[:, number].argmax(axis=0)
    low = part * width[number]
    high = (part + 1) * width[number]
    leaves = leaving[number] & (part == 0)
    slopes = (rates[part, number], rates[part + 1, number])
    high_gap = gaps[part + 1, number]

    open_end = np.flatnonzero(high_gap > 0.0)
    if open_end.size:
        some = number[open_end]
        bottom = _lowest(
            gap_of,
            some,
            (low[open_end], high[open_end]),
            (slopes[0][open_end], slopes[1][open_end]),
            hop[some],
        )
        least, _ = gap_of(some)(bottom)
        closes = least < np.where(leaves[open_end], -HOP_ROUNDING, 0.0)
        search.margin[some] = np.where(closes | leaves[open_end], np.inf, least)
        high[open_end] = np.where(closes, bottom, high[open_end])
        high_gap[open_end] = np.where(closes, least, high_gap[open_end])
    search.place[number] = high

    # A gap that begins at zero is divided by the step, so that only its next zero remains.
    closed = np.flatnonzero(high_gap <= 0.0)
    chosen = number[closed]
    from_zero = leaves[closed]
    ends = (low[closed], high[closed])
    values = (np.where(from_zero, np.inf, gaps[part[closed], chosen]), high_gap[closed])

    def value_of(numbers: Chosen) -> Sloped:
        gap = gap_of(chosen[numbers])
        divided = from_zero[numbers]

        def value(place: Array) -> tuple[Array, Array]:
            height, rate = gap(place)
            return height, np.where(divided, rate - height / place, rate)

        return value

    search.place[chosen] = newton_root(
        value_of, ends, values, (slopes[0][closed], slopes[1][closed])
    )
    search.touched[chosen] = True
    return search


def _lowest(
    gap_of: Callable[[Chosen], Gap],
    number: Chosen,
    ends: tuple[Array, Array],
    slopes: tuple[Array, Array],
    hop: Array,
) -> Array:
    """Return the places where gaps are least between two ends.

    The place is where the rate changes its sign, or the minimum of a hop's cubic.
    """
    dipping = (slopes[0] < 0.0) & (slopes[1] > 0.0)
    turning = np.flatnonzero(dipping)
    bottom = hop.copy()

    def opening_of(numbers: Chosen) -> Function:
        gap = gap_of(number[turning[numbers]])
        return lambda place: gap(place)[1]

    brackets = (ends[0][turning], ends[1][turning])
    bottom[turning] = root(
        opening_of, brackets, (slopes[0][turning], slopes[1][turning]), PLACE_OF_LEAST
    )
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
    return np.where(returns, place, np.nan)


def _note_retraction(
    passes: Passes, course: Course, rates: Array, step: Array, place: Array
) -> None:
    """Record the least angle up to the end of the step: at a minimum within it, or at its end."""
    turning = (rates[:-1] < 0.0) & (rates[1:] > 0.0)
    number = np.flatnonzero(turning.any(axis=0))
    if number.size:
        part = turning[:, number].argmax(axis=0)
        before = rates[part, number]
        at = (part - before / (rates[part + 1, number] - before)) * step[number] / INTERVALS
        own = course.take(number)
        some = passes.take(number)
        for _ in range(NEWTON_ROUNDS):
            rate = own.rate_at(at)
            at = at - rate / free_acceleration(some, some.hub_angle + at, own.angle_at(at), rate)
        least = own.angle_at(np.minimum(at, place[number]))
        passes.lowest[number] = np.minimum(passes.lowest[number], least)
    passes.lowest = np.minimum(passes.lowest, passes.angle)
