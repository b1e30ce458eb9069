"""One step of every flight, up to the first touch within it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.passes.bar import closest
from bristle_sim.passes.crossing import Function, root
from bristle_sim.passes.motion import ORDER, Course, Pose, course_of, free_acceleration, step_length
from bristle_sim.passes.state import Passes, Place

NOTHING, BAR, WORKPART = range(3)  # what a bristle touches at the end of its step

INTERVALS = 8
"""Equal parts of a step; a gap is taken to have at most one minimum in each."""

LEAST_BEND = 0.1
"""Least radius of the bar, over the bristle's length, for which the parts of a step are shortened."""

BEND = 0.5
"""Path of the wire's end in a part of a step near the bar, over the radius at which it touches."""

EDGE = 1e-9  # rad; a hub angle this close to the window of the bar is within it

HOP_ROUNDING = 1e-14  # depth, over the bristle's length, below which a wire that has just left the bar is not back on it

NEWTON_ROUNDS = 2
"""Rounds of Newton's method from the chord to the least angle: its place is then known to 1e-6, the angle to its square."""

FRACTIONS = np.linspace(0.0, 1.0, INTERVALS + 1)


@dataclass(slots=True)
class Search:
    """The search of a step for the first closing of a gap.

    Attributes:
        place: step to the touch, or to where the search must go on, rad.
        touched: whether the gap closes there.
        margin: least gap at a minimum that was located, over the bristle's length; infinite where there was none.
    """

    place: Array
    touched: Array
    margin: Array


def fly(passes: Passes, tolerance: float) -> tuple[Array, Array]:
    """Advance every flight by a step; return what each touches then, and the least gap that it passed without a touch."""
    course = course_of(passes)
    chi = np.remainder(passes.hub_angle - passes.bar_angle + np.pi, 2.0 * np.pi) - np.pi
    near = np.flatnonzero(np.abs(chi) <= passes.window + EDGE)
    step = np.minimum(step_length(passes, course, tolerance), passes.end - passes.hub_angle)
    ahead = np.remainder(-passes.window - chi, 2.0 * np.pi)
    ahead[near] = np.inf
    ahead[passes.window < 0.0] = np.inf
    np.minimum(step, ahead, out=step)
    pull = np.abs(course.rate[2, near])
    speed = passes.radius[near] + 1.0 + np.abs(passes.rate[near]) + pull * step[near] * 0.25
    step[near] = np.minimum(step[near], INTERVALS * BEND * np.maximum(passes.reach[near], LEAST_BEND) / speed)
    passes.error += np.abs(course.rate[-1]) * step ** (ORDER - 1.0) / passes.rate_scale

    angles, poses = course.sampled(step, FRACTIONS)
    place = step.copy()
    kind = np.full(passes.size, NOTHING)
    margin = np.full(passes.size, np.inf)
    for obstacle, chosen in ((WORKPART, slice(None)), (BAR, near)):
        some = passes if obstacle == WORKPART else passes.take(near)
        part = course if obstacle == WORKPART else course.take(near)

        def gap_of(number: Array, obstacle: int = obstacle, some: Passes = some, part: Course = part) -> Gap:
            place = some.place(number)
            own = part.take(number)

            def gap(offset: Array, opens: bool = False) -> Array:
                pose = own.pose_at(offset)
                if opens:
                    return clearance(obstacle, place, pose._replace(rate=own.rate_at(offset)))[1]
                return clearance(obstacle, place, pose)[0]

            return gap

        gaps, openings = clearance(obstacle, some, Pose(*(each[:, chosen] for each in poses)))
        leaving = some.touching if obstacle == BAR else np.zeros(some.size, dtype=bool)
        search = first_closing(gap_of, gaps, openings, step[chosen], leaving)
        sooner = search.place < place[chosen]
        sooner |= search.touched & (search.place <= place[chosen])
        margin[chosen] = np.minimum(margin[chosen], search.margin)
        kind[chosen] = np.where(sooner, np.where(search.touched, obstacle, NOTHING), kind[chosen])
        place[chosen] = np.where(sooner, search.place, place[chosen])

    passes.angle = course.angle_at(place)
    passes.rate = course.rate_at(place)
    _note_retraction(passes, course, poses.rate, step, place)
    passes.hub_angle = passes.hub_angle + place
    passes.touching = passes.touching & (place <= 0.0)
    return kind, margin


def clearance(obstacle: int, passes: Passes | Place, pose: Pose) -> tuple[Array, Array]:
    """Return the gap to an obstacle and its rate, over the bristle's length and per radian of the hub."""
    if obstacle == BAR:
        found = closest(passes, pose)
        return found.gap, found.rate
    gap = passes.depth - passes.radius * pose.hub_cosine - pose.cosine
    return gap, passes.radius * pose.hub_sine + pose.sine * (1.0 + pose.rate)


Gap = Callable[..., Array]


def first_closing(gap_of: Callable[[Array], Gap], gaps: Array, rates: Array, step: Array, leaving: Array) -> Search:
    """Find the first closing of each gap within a step.

    Args:
        gap_of: returns the function that returns gaps and their rates at steps, of the passes with these numbers.
        gaps, rates: at FRACTIONS of the step.
        step: rad.
        leaving: whether the gap begins at zero.
    """
    width = step / INTERVALS
    with np.errstate(invalid="ignore"):  # without a workpart its gap is infinite
        fastest = np.abs(rates).max(axis=0) * 1.5
        dips = (rates[:-1] < 0.0) & (rates[1:] > 0.0) & (gaps[:-1] + gaps[1:] < fastest * width)
    candidate = (gaps[1:] <= 0.0) | dips
    hop = _hops(gaps, rates, width)
    candidate[0] |= leaving & np.isfinite(hop)
    search = Search(step.copy(), np.zeros(len(step), dtype=bool), np.full(len(step), np.inf))
    number = np.flatnonzero(candidate.any(axis=0))
    if not number.size:
        return search
    part = candidate[:, number].argmax(axis=0)
    low = part * width[number]
    high = (part + 1) * width[number]
    leaves = leaving[number] & (part == 0)
    low_gap = np.where(leaves, np.where(rates[0, number] > 0.0, rates[0, number], np.inf), gaps[part, number])
    high_gap = gaps[part + 1, number]

    # Where the gap is open at both ends its minimum decides; a hop's is where its cubic says.
    open_end = np.flatnonzero(high_gap > 0.0)
    if open_end.size:
        some = number[open_end]
        ends = (low[open_end], high[open_end])
        slopes = (rates[part[open_end], some], rates[part[open_end] + 1, some])
        dipping = (slopes[0] < 0.0) & (slopes[1] > 0.0)
        bottom = np.where(dipping, 0.5 * (ends[0] + ends[1]), hop[some])
        if dipping.any():
            turning = np.flatnonzero(dipping)

            def opening_of(numbers: Array) -> Function:
                gap = gap_of(some[turning[numbers]])
                return lambda offset: gap(offset, opens=True)

            brackets = (ends[0][turning], ends[1][turning])
            bottom[turning] = root(opening_of, brackets, (slopes[0][turning], slopes[1][turning]))
        least = gap_of(some)(bottom)
        closes = least < np.where(leaves[open_end], -HOP_ROUNDING, 0.0)
        search.margin[some] = np.where(closes | leaves[open_end], np.inf, least)
        high[open_end] = np.where(closes, bottom, high[open_end])
        high_gap[open_end] = np.where(closes, least, high_gap[open_end])
    search.place[number] = high
    closed = np.flatnonzero(high_gap <= 0.0)
    chosen = number[closed]
    deflated = leaves[closed]

    def value_of(numbers: Array) -> Function:
        gap = gap_of(chosen[numbers])
        from_zero = deflated[numbers]
        return lambda offset: gap(offset) / np.where(from_zero, offset, 1.0)

    ends = (low[closed], high[closed])
    at_end = np.where(deflated, high_gap[closed] / ends[1], high_gap[closed])
    search.place[chosen] = root(value_of, ends, (low_gap[closed], at_end))
    search.touched[chosen] = True
    return search


def _hops(gaps: Array, rates: Array, width: Array) -> Array:
    """Return where a gap that begins at zero would be least in the first part of a step, by its cubic; NaN where it opens."""
    bend = 3.0 * gaps[1] / width**2 - (2.0 * rates[0] + rates[1]) / width
    twist = (rates[0] + rates[1]) / width**2 - 2.0 * gaps[1] / width**3
    with np.errstate(divide="ignore", invalid="ignore"):
        place = -0.5 * bend / twist
        return np.where((bend * bend > 4.0 * rates[0] * twist) & (place > 0.0) & (place < width), place, np.nan)


def _note_retraction(passes: Passes, course: Course, rates: Array, step: Array, place: Array) -> None:
    """Note the least angle up to the end of the step: at a minimum within it, or at its end."""
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
            at -= rate / free_acceleration(some, some.hub_angle + at, own.angle_at(at), rate)
        least = own.angle_at(np.minimum(at, place[number]))
        passes.lowest[number] = np.minimum(passes.lowest[number], least)
    passes.lowest = np.minimum(passes.lowest, passes.angle)
