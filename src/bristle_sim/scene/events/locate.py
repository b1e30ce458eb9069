"""Event functions and the one locator: where within an interval of motion a function is zero.

The zero is first estimated on the cubic through the states at the interval's two ends. Then the engine is run again from the
restored start over a shorter time, until the zero is at the end.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from bristle_sim.scene.integrate.extrapolation import Advance
from bristle_sim.scene.mechanism import State, interpolate
from bristle_sim.stop_reason import StopReason

if TYPE_CHECKING:
    from bristle_sim.scene.events.table import Change
    from bristle_sim.scene.progress import Progress

SHORTEST_BRACKET, SHORTEST_BRACKET_FRACTION = 1e-15, 1e-12  # time, and fraction of the searched interval, of an instant
LEAST_VALUE = 1e-10  # rates, accelerations and forces of a scene's units below this have no sign
LOCATED_VALUE = 1e-3  # fraction of the accuracy to which a sign change is located, relative to the ends' values
RATE_ROUNDING = 1e-13  # of the difference of two rates of which an acceleration is made

EXTREME_ERROR = 0.1
"""Fraction of a function's range within an interval by which its extreme, estimated from five values, may be off; the cubic
between the states of an interval of 1.4 radians of the fastest motion is off by 1.4^4/384 = 1 % of its amplitude."""

ENDS_WITHOUT_EXTREME = 0.01  # fraction of an interval from its ends in which a function hardly moves


class Interval(NamedTuple):
    """An interval that has been integrated: its first state, the result at its end, and the result after a shorter time."""

    start: State
    end: Advance
    again: Callable[[float], Advance]

    @property
    def length(self) -> float:
        """Duration of the interval."""
        return self.end.state.time - self.start.time


@dataclass(slots=True, eq=False)
class EventFunction:
    """A function whose change of sign is an event.

    Attributes:
        value: function of the result of an interval.
        falling: True if only falling through zero counts, False if only rising, None for both.
        event, wire: name under which it is recorded (if it is), and number of its wire.
        final: why the run stops there; None if the run continues.
        act: returns the change of the contacts; None if there is none.
        exact: ``value`` as a function of the state, where ``value`` has the error of a difference over the interval.
        difference: whether the value is made of a difference of rates over a step, and carries its rounding.
        tolerance: replaces the run's own for its location; values then have a sign down to rounding.
        turns: whether it may change its sign twice within an interval.
        positive: whether the value is known to be positive where the motion begins.
        noise, sign: values below this have no sign; the last sign, None while it is unknown.
    """

    value: Callable[[Advance], float]
    falling: bool | None = None
    event: str | None = None
    wire: int = 0
    final: StopReason | None = None
    act: Callable[[], Change | None] | None = None
    exact: Callable[[State], float] | None = None
    difference: bool = False
    tolerance: float | None = None
    turns: bool = False
    positive: bool = False
    noise: float = LEAST_VALUE
    sign: float | None = None

    def begin(self, state: State, noise: float) -> None:
        """Take the sign at the start of a smooth motion: a change in its first interval is then an event, too."""
        self.noise = noise if self.tolerance is None else math.ulp(1.0)
        value = self.value(at_state(state))
        self.sign = math.copysign(1.0, value) if abs(value) > self.noise else 1.0 if self.positive else None


def at_state(state: State) -> Advance:
    """Return a state as the end of an interval of no length."""
    return Advance(state, (math.nan,) * len(state.angles), (), 0.0)


def look_back(interval: Interval, functions: Sequence[EventFunction]) -> None:
    """Determine signs at the start exactly if, on the cubic, the first link's acceleration may have changed sign since."""
    start, end, length = interval.start, interval.end.state, interval.length
    after = interval.end.accelerations[0]
    before = 6.0 * (end.angles[0] - start.angles[0]) / length - 4.0 * start.rates[0] - 2.0 * end.rates[0]
    for each in functions:
        if after * before < 0.2 * length * after**2 and each.exact is not None:
            value = each.exact(start)
            each.sign = math.copysign(1.0, value) if abs(value) > LEAST_VALUE else each.sign


def first_change(
    progress: Progress, functions: Sequence[EventFunction], interval: Interval, before: Advance | None
) -> tuple[Advance, EventFunction | None]:
    """Return the interval up to the first change of sign, and the function; ``before`` is the interval before it."""
    first = None
    for function in functions:
        instant = 1e-15 * (1.0 + interval.end.state.time)
        part = _to_the_extreme(function, interval) if function.turns else interval
        ends = _change(function, part, before) if part.length > instant else None
        if ends is not None:
            span, back = max(_zero(progress, function, part, *ends), instant), SHORTEST_BRACKET_FRACTION
            while interval.again(span).failed and back < 1.0:
                # A step beyond the release would pull: the last one before it is accurate.
                span, back = span * (1.0 - back), 10.0 * back
            interval, first = interval._replace(end=interval.again(span)), function
    return interval.end, first


def _change(function: EventFunction, interval: Interval, before: Advance | None) -> tuple[float, float] | None:
    """Return the values at the ends of an interval in which the function changes its sign, or None."""
    right, sign, noise = function.value(interval.end), function.sign, function.noise
    if function.difference:
        noise = max(noise, RATE_ROUNDING / interval.length)
    if abs(right) > noise:
        function.sign = math.copysign(1.0, right)
    if sign is None or sign * right >= 0.0 or abs(right) <= noise or function.falling == (sign < 0.0):
        return None
    left = function.value(before or at_state(interval.start))
    left = -right if math.isnan(left) else left
    if function.exact is not None:
        left, right = function.exact(interval.start), function.exact(interval.end.state)
        if sign * right > 0.0 or sign * left < -noise:
            # It does not change within this interval, looked at exactly: the differences have misled.
            function.sign = math.copysign(1.0, right)
            return None
    return sign * max(sign * left, LEAST_VALUE if function.tolerance is None else math.ulp(1.0)), right


def _zero(progress: Progress, function: EventFunction, interval: Interval, left: float, right: float) -> float:
    """Return the time of the zero of a value that has opposite signs at the ends of an interval."""
    again, exact, tolerance, near = interval.again, function.exact, function.tolerance, None
    if tolerance is None:
        located = LOCATED_VALUE * min(progress.plan.accuracy, 1e-4) * max(abs(left), abs(right))
        tolerance = max(located, 0.1 * LEAST_VALUE)
    progress.stepper.begin_afresh()
    if exact is not None:
        return locate(lambda span: exact(again(span).state), 0.0, interval.length, left, right, tolerance)

    def of_state(state: State) -> float:
        return function.value(at_state(state))

    near = guess(of_state, interval.start, interval.end.state)
    if near is not None:
        found = settle(of_state, interval, near, interval.length, tolerance)
        if found is not None:
            return found
    return locate(lambda span: function.value(again(span)), 0.0, interval.length, left, right, tolerance, near)


def _to_the_extreme(function: EventFunction, interval: Interval) -> Interval:
    """Shorten the interval to between two sign changes of the function, if it has two; otherwise return all of it.

    The function's least value is estimated by the parabola through the least of five values and its two neighbours.
    """
    sense, start, end = 1.0 if function.falling else -1.0, interval.start, interval.end
    states = [start, *(interpolate(start, end.state, part) for part in (0.25, 0.5, 0.75)), end.state]
    ends = at_state(start), at_state(states[2]), end
    first, middle, last = (sense * function.value(each) for each in ends)
    bend, slope = first + last - 2.0 * middle, 0.5 * (last - first)
    if not (bend > abs(slope) and middle - 0.5 * slope**2 / bend < EXTREME_ERROR * max(first, last)):
        # Without an extreme within, or far above zero there, nothing is missed.
        return interval
    margins = [sense * function.value(at_state(each)) for each in states[:4]] + [sense * function.value(end)]
    if math.isnan(sum(margins)) or margins[-1] < 0.0:
        return interval
    least = min(max(margins.index(min(margins)), 1), 3)
    before, middle, after = margins[least - 1 : least + 2]
    bend, slope = before + after - 2.0 * middle, 0.5 * (after - before)
    at = 0.25 * (least - slope / bend) if bend > 0.0 else 0.0
    inside = ENDS_WITHOUT_EXTREME < at < 1.0 - ENDS_WITHOUT_EXTREME
    if not inside or middle - 0.5 * slope**2 / bend > EXTREME_ERROR * (max(margins) - min(margins)):
        return interval
    part = interval.again(at * interval.length)
    return interval._replace(end=part) if sense * function.value(part) < 0.0 else interval


MOST_TRIALS = 110  # a smooth function takes three to six; a jump is halved for the last digit of a double
LEAST_PART = 1e-10  # fraction of the bracket: closest to its ends that the root is looked for


def locate(
    value: Callable[[float], float],
    left: float,
    right: float,
    at_left: float,
    at_right: float,
    tolerance: float,
    guess: float | None = None,
) -> float:
    """Return the root of a function between two durations at which its signs differ: Chandrupatla's method.

    The function runs the engine, so evaluations are expensive; a library's root finder is not worth its import. For a jump the
    method ends in bisection. The result is where the value is within ``tolerance``, or the first duration past the root. The
    first evaluation is at ``guess`` or, without one, at the root of a straight line.

    T. R. Chandrupatla, *A new hybrid quadratic/bisection algorithm*, Adv. Eng. Softw. 28 (1997) 145-149: the root of the
    inverse quadratic through the last three points if that is monotonic between them, else the middle.
    """
    last, at_last, other, at_other = right, at_right, left, at_left
    instant = min(SHORTEST_BRACKET, SHORTEST_BRACKET_FRACTION * (right - left))
    part = min(max(at_right / (at_right - at_left), 1e-4), 1.0 - 1e-4)
    if guess is not None and left < guess < right:
        part = (guess - right) / (left - right)
    for _ in range(MOST_TRIALS):
        if abs(other - last) <= 4e-16 * max(other, last) + instant:
            break
        trial = last + part * (other - last)
        found = value(trial)
        if abs(found) <= tolerance:
            return trial
        before, at_before = last, at_last
        if (found < 0.0) != (at_last < 0.0):
            before, at_before, other, at_other = other, at_other, last, at_last
        last, at_last = trial, found
        # Seen from the other end, the root's place in units of the point before.
        place, height = (last - other) / (before - other), (at_last - at_other) / (at_before - at_other)
        if height * height < place and (1.0 - height) ** 2 < 1.0 - place:
            part = at_last / (at_other - at_last) * at_before / (at_other - at_before)
            slope = (before - last) / (other - last)
            part += slope * at_last / (at_before - at_last) * at_other / (at_before - at_other)
            part = min(max(part, LEAST_PART), 1.0 - LEAST_PART)
        else:
            part = 0.5
    return max(last, other)


MOST_GUESSES = 4  # two or three bring a touch that is found on the cubic of a whole interval to rounding
ROUNDED_TOLERANCES = 10.0  # within which the last guess must be, where rounding lets none come nearer
SLOPE_SPAN = 1e-3  # fraction of an interval over which its cubic's slope is taken, before a secant step
GUESS_TOLERANCE = 1e-9  # to which a guess is located, relative; the cubic is not that good


def settle(
    value: Callable[[State], float], interval: Interval, near: float, last: float, tolerance: float
) -> float | None:
    """Return the duration, near a guess and at most ``last``, after which a function of the state is zero; None if in doubt.

    The second guess is the zero on the cubic up to the first one; later guesses are those of the secant method.
    """
    before, at_before = 0.0, math.nan
    for trial in range(MOST_GUESSES):
        reached = interval.again(near).state
        found = value(reached)
        if abs(found) <= (tolerance if trial < MOST_GUESSES - 1 else ROUNDED_TOLERANCES * tolerance):
            return near
        if trial == 0:
            slope = (found - value(interpolate(interval.start, reached, 1.0 - SLOPE_SPAN))) / SLOPE_SPAN
            part = 1.0 - found / slope if slope else 0.0
            before, at_before = part * near, value(interpolate(interval.start, reached, part))
        following = near - found * (near - before) / (found - at_before) if found != at_before else 0.0
        before, at_before, near = near, found, following
        if not 0.0 < near <= last:
            return None
    return None


def guess(value: Callable[[State], float], start: State, end: State, fraction: float = 1.0) -> float | None:
    """Return the time since the start at which a function of the state is zero on the cubic; None without a change of sign.

    Only the first ``fraction`` of the interval is searched. The value may be NaN where the state does not determine it.
    """

    def at(part: float) -> float:
        return value(interpolate(start, end, part))

    length = end.time - start.time
    if length <= 0.0:
        # Less than the rounding of the time.
        return None
    left, right = value(start), at(fraction)
    if not left * right < 0.0:
        return None
    return length * locate(at, 0.0, fraction, left, right, GUESS_TOLERANCE * max(abs(left), abs(right)))
