"""One step of all bristles in flight; a bristle's step ends at its first touch."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.passes.bar import closest, half_turn
from bristle_sim.passes.crossing import root
from bristle_sim.passes.motion import (
    FRACTIONS,
    ORDER,
    SEGMENT,
    Course,
    Function,
    course_of,
    direction,
    step_length,
)
from bristle_sim.passes.state import (
    BAR,
    FLIES,
    FOLDS,
    MISSED,
    QUARTER_TURN,
    WORKPART,
    Chosen,
    Passes,
)

LOCAL_FRACTION = 1e-3
"""Ratio of the error permitted in one step to the requested accuracy, because the errors of a
thousand steps may add up.

The length of a step depends only weakly on the permitted error."""

MOST_TOLERANCE = 1e-9
"""Largest error permitted in one step: repeated impacts on the bar magnify errors a thousandfold.

At the high order of the series a larger permitted error saves little time."""

LEAST_TOLERANCE = 1e-14  # smallest error permitted in one step, the size of rounding error

LEAST_BEND = 0.1
"""Lower bound of ``reach`` in the choice of a step near the bar, divided by the bristle's length.

``reach`` is the distance of the wire's centre line from the bar's centre when they touch. The
longest step is proportional to ``reach``, or to this bound if ``reach`` is smaller. The bound
does not apply to a wire that has just left the bar: its end may touch the bar again after the hub
has rotated by an angle of the order of ``reach``."""

BEND = 0.5
"""Longest path of the wire's end in a segment of a step near the bar, divided by ``reach``, the
distance of the wire's centre line from the bar's centre when they touch."""

HOPS = 2.0
"""Longest step after a rebound from the bar, divided by ``hop`` (an attribute of ``Passes``).

When the hub has rotated by t since the rebound, the gap is v t - a t^2/2 + j t^3/6, and ``hop`` is
2 v/a. If this gap closes, its maximum is before 2/3 ``hop``, and its minimum is after 2 ``hop``.
The step therefore does not contain both."""

FASTER = 2.0
"""Assumed largest magnitude of a gap's derivative within a segment that contains a minimum of the
gap, divided by the larger of the magnitudes at the segment's two ends."""

EDGE = 1e-9  # tolerance, rad, of the hub angles between which the wire can reach the bar
MINIMUM_ERROR = 1e-8  # largest error of a minimum's place, relative to the length of its segment
BOTH_ENDS = np.array([[0], [1]])  # plus a segment's index: the indices of the segment's two ends


Samples = Array
"""Motion of passes at the ends of the segments into which a step is divided.

The shape is (3, segments + 1, passes). The three rows are the rotation of the hub since the step
began (rad), the angle of the wire from the radial direction (rad), and the derivative of this angle
with respect to the hub angle."""


def fly(passes: Passes, accuracy: float) -> Chosen:
    """Advance bristles in flight by one step, or to the first touch within the step.

    Returns:
        The code of each pass's new state.
    """
    tolerance = max(min(LOCAL_FRACTION * accuracy, MOST_TOLERANCE), LEAST_TOLERANCE)
    course = course_of(passes)
    step, near = _step(passes, course, tolerance)
    passes.error += np.abs(course.series[1, ORDER - 1]) * step ** (ORDER - 1.0) / passes.rate_scale
    samples = np.array([FRACTIONS * step, *course.sampled(step)])
    code = np.full(passes.size, FLIES)
    advance(passes, course.at, samples, near, step, code, accuracy)
    code[(code == FLIES) & (passes.hub_angle >= passes.end)] = MISSED
    return code


def advance(
    passes: Passes,
    motion: Function,
    samples: Samples,
    near: Chosen,
    place: Array,
    code: Chosen,
    accuracy: float,
) -> None:
    """Advance each pass by a rotation of the hub, or to its first touch within the rotation.

    A wire has folded if its angle from the radial direction has exceeded 90 degrees.

    Args:
        passes: passes to advance.
        motion: function that returns the wires' angles from the radial direction, and the
            derivatives of these angles, after a rotation of the hub.
        samples: motion at the ends of the segments into which the rotation is divided.
        near: indices of the wires that may touch the bar.
        place: rotation of the hub if there is no touch, rad.
        code: code of each pass's state after the rotation ``place``. The function replaces the code
            of a pass in which the wire touches an obstacle or folds.
        accuracy: requested accuracy. If a wire passes an obstacle at a distance smaller than this
            fraction of the bristle's length, the number of touches is uncertain.
    """
    turns, angles, _ = samples
    for obstacle, chosen in ((WORKPART, low(passes, turns[-1])), (BAR, near)):
        closing = first_closing(obstacle, passes, motion, samples, chosen, accuracy)
        code[closing <= place] = obstacle
        place = np.minimum(place, closing)
    folded = ((np.abs(angles) > QUARTER_TURN) & (turns <= place)).any(axis=0)
    _note_lowest(passes, motion, samples, place)
    passes.angle[:], passes.rate[:] = motion(place, np.arange(passes.size))[:2]
    np.minimum(passes.lowest, passes.angle, out=passes.lowest)
    passes.hub_angle += place
    code[folded | (np.maximum(passes.angle, -passes.lowest) > QUARTER_TURN)] = FOLDS


def _step(passes: Passes, course: Course, tolerance: float) -> tuple[Array, Chosen]:
    """Return the hub's rotation in the next step of each pass (rad), and the indices of passes near
    the bar.

    A step ends no later than the pass, and no later than the hub angle from which the wire can
    reach the bar. Near the bar, a step is so short that the gap has at most one minimum in each of
    its segments. ``course`` is the Taylor series of the motion; ``tolerance`` bounds its error in a
    step.
    """
    chi = half_turn(passes.hub_angle - passes.bar_angle)
    outside = np.abs(chi) > passes.window + EDGE
    near = np.flatnonzero(~outside)
    ahead = -passes.window - chi
    ahead += 2.0 * np.pi * (ahead < 0.0)
    step = np.minimum(step_length(passes, course, tolerance), passes.end - passes.hub_angle)
    np.minimum(step, ahead, out=step, where=outside & (passes.window >= 0.0))
    if near.size:
        gained = 0.25 * np.abs(course.series[1, 1, near]) * step[near]
        speed = passes.radius[near] + 1.0 + np.abs(passes.rate[near]) + gained
        least = LEAST_BEND * ~passes.parting[near]
        longest = BEND / SEGMENT * np.maximum(passes.reach[near], least) / speed
        step[near] = np.minimum(step[near], longest)
        np.minimum(step, HOPS * passes.hop, out=step, where=passes.parting)
    return step, near


def low(passes: Passes, turn: Array) -> Chosen:
    """Return the indices of the passes whose wire can reach the workpart while the hub rotates by
    ``turn`` (rad).

    In these passes the tip would touch the workpart if the wire were vertical at the lowest
    position that the root has during the rotation.
    """
    half = 0.5 * turn
    aside = np.abs(half_turn(passes.hub_angle + half)) - half
    lowest = passes.radius * np.cos(np.maximum(aside, 0.0)) + 1.0
    return np.flatnonzero(lowest >= passes.depth)


def height(passes: Passes, hub_angle: Array, angle: Array, rate: Array) -> tuple[Array, Array]:
    """Return the height of each tip above the workpart, and its derivative with respect to the hub
    angle.

    The height is divided by the bristle's length. ``hub_angle`` is psi (rad), ``angle`` the wire's
    angle alpha from the radial direction (rad), and ``rate`` the derivative d(alpha)/d(psi).
    """
    root = passes.radius * direction(hub_angle)
    wire = direction(hub_angle + angle)
    return passes.depth - (root + wire).real, (root + (1.0 + rate) * wire).imag


GAPS: dict[int, Callable[..., Any]] = {BAR: closest, WORKPART: height}
"""Functions that return first the gap between wire and obstacle, divided by the bristle's length,
and then its derivative with respect to the hub angle."""


def first_closing(
    obstacle: int,
    passes: Passes,
    motion: Function,
    samples: Samples,
    chosen: Chosen,
    accuracy: float,
) -> Array:
    """Return the rotation of the hub from the start of a step to the first touch of an obstacle by
    each wire (rad), infinite without a touch.

    A gap closes in a segment of the step if it is negative or zero at the segment's end, or if its
    minimum within the segment is negative. If the minimum is between zero and the accuracy, the
    number of touches is uncertain, and the pass's error is set to 1.

    Args:
        obstacle: code of the obstacle.
        passes: passes of the wires, at the start of the step.
        motion: function that returns the wires' angles from the radial direction, and the
            derivatives of these angles, after a rotation of the hub.
        samples: motion at the ends of the segments into which the step is divided.
        chosen: indices of the wires that may touch the obstacle.
        accuracy: requested accuracy.
    """
    place = np.full(passes.size, np.inf)
    if not chosen.size:
        return place
    gap = GAPS[obstacle]

    def gap_at(turn: Array, numbers: Chosen) -> Any:
        """Return the gaps of the wires ``chosen[numbers]``, and the derivatives of these gaps, at
        the end of the hub's rotation ``turn``.
        """
        some = passes.take(chosen[numbers])
        gaps, rates = gap(some, some.hub_angle + turn, *motion(turn, chosen[numbers])[:2])[:2]
        return gaps - rounding[numbers], rates

    some = passes.take(chosen)
    turns, angles, rates = samples.take(chosen, axis=-1)
    gaps, rates = gap(some, some.hub_angle + turns, angles, rates)[:2]
    leaves = some.parting & (obstacle == BAR)
    rounding = leaves * gaps[0]  # a gap of 1e-15 before or behind zero would be a touch
    gaps -= rounding
    way = FASTER * np.maximum(-rates[:-1], rates[1:]) * (turns[1:] - turns[:-1])
    dips = (rates[:-1] < 0.0) & (rates[1:] > 0.0) & (gaps[1:] > 0.0) & (gaps[:-1] + gaps[1:] < way)
    dips[0, leaves] = False
    ends = np.array([turns, gaps, rates])
    part, number = np.nonzero(dips)
    if number.size:
        bottom = _lowest(gap_at, number, ends[:, part + BOTH_ENDS, number])
        least = gap_at(bottom, number)[0]
        below = least < 0.0
        # the segment ends at its minimum
        ends[:2, part[below] + 1, number[below]] = bottom[below], least[below]
        closings = np.cumsum(ends[1, 1:] <= 0.0, axis=0)[part, number]
        passes.error[chosen[number[(closings == 0) & (least < accuracy)]]] = 1.0
    closes = ends[1, 1:] <= 0.0
    number = np.flatnonzero(closes.any(axis=0))
    if number.size:
        part = closes[:, number].argmax(axis=0)
        segment = ends[:, part + BOTH_ENDS, number]
        place[chosen[number]] = _closing(gap_at, number, segment, leaves[number] & (part == 0))
    return place


def _closing(gap_at: Function, number: Chosen, segment: Array, leaves: Chosen) -> Array:
    """Return the rotation of the hub (rad) at which each gap closes within its segment.

    Newton's method starts from inverse cubic interpolation of the gap and its derivative at both
    ends. If the wire leaves the obstacle at the segment's start, the gap is zero there too.
    Newton's method then seeks the root of the quotient gap/rotation, which is not zero there.

    Args:
        gap_at: function that returns the gaps and their derivatives after a rotation of the hub.
        number: indices of the passes.
        segment: rotation, gap and derivative at both ends, shape (3, 2, passes).
        leaves: whether the gap is zero at the segment's start.
    """
    (low, high), gaps, rates = segment
    with np.errstate(divide="ignore", invalid="ignore"):
        rise = gaps[1] - gaps[0]
        part = -gaps[0] / rise
        bend = rise * ((1.0 - part) / rates[0] - part / rates[1])
        start = low + part * part * (3.0 - 2.0 * part) * (high - low) + part * (1.0 - part) * bend

    def value_at(place: Array, chosen: Chosen) -> tuple[Array, Array]:
        gap, rate = gap_at(place, number[chosen])
        return gap, rate - leaves[chosen] * gap / place

    return root(value_at, (low, high), gaps[1], np.where(leaves, high, start))


def _lowest(values_at: Function, number: Chosen, segment: Array) -> Array:
    """Return the rotation of the hub (rad) at which each gap or angle is smallest within its
    segment.

    The minimum is a zero of the derivative. The search starts at the minimum of the cubic through
    the values and derivatives at the ends.

    Args:
        values_at: function that returns the gaps or angles, and their derivatives, after a rotation
            of the hub.
        number: indices of the passes.
        segment: rotation, value and derivative at both ends, shape (3, 2, passes).
    """
    (low, high), gaps, rates = segment
    width = high - low
    rise = 3.0 * (gaps[1] - gaps[0]) / width
    bend = rise - 2.0 * rates[0] - rates[1]
    twist = 3.0 * (rates[0] + rates[1]) - 2.0 * rise
    with np.errstate(divide="ignore", invalid="ignore"):
        least = -rates[0] / (bend + np.sqrt(bend * bend - twist * rates[0]))

    def rate_at(place: Array, chosen: Chosen) -> tuple[Array, None]:
        return values_at(place, number[chosen])[1], None

    return root(rate_at, (low, high), rates[1], low + least * width, MINIMUM_ERROR)


def _note_lowest(passes: Passes, motion: Function, samples: Samples, place: Array) -> None:
    """Update ``passes.lowest``, the smallest angle so far, by a minimum of the angle within the
    hub's rotation ``place`` (rad).

    Only the first minimum that may be smaller than all earlier angles is located. A minimum is
    assumed to be larger than a + 2 a' h, where h is the length of its segment, and a and a' are the
    angle and its derivative at the segment's start.
    """
    turn, angle, rate = samples
    turning = (rate[:-1] < 0.0) & (rate[1:] > 0.0) & (turn[:-1] < place)
    turning &= angle[:-1] + 2.0 * rate[:-1] * (turn[1:] - turn[:-1]) < passes.lowest
    number = np.flatnonzero(turning.any(axis=0))
    if number.size:
        part = turning[:, number].argmax(axis=0)
        segment = samples[:, part + BOTH_ENDS, number]
        at = np.minimum(_lowest(motion, number, segment), place[number])
        passes.lowest[number] = np.minimum(passes.lowest[number], motion(at, number)[0])
