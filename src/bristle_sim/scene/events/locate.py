"""The locator: where within an interval of motion a function of the state or of the interval is zero.

The zero is guessed on the cubic through the states at the interval's two ends. Then the engine is run again over less of the
interval, from the restored state, until the zero is at its end.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from bristle_sim.scene.integrate.stepping import Advance
from bristle_sim.scene.mechanism import Mechanism, State

SHORTEST_BRACKET = 1e-15
"""Intervals of a scene's time unit shorter than this are an instant."""

SHORTEST_FRACTION = 1e-12
"""So is this fraction of an interval that is searched: a fast motion needs short ones."""


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


def interpolate(start: State, end: State, fraction: float) -> State:
    """Return the cubic through angles and rates at both ends, at a fraction of the interval between them."""
    length = end.time - start.time
    rest = 1.0 - fraction
    h_00, h_01 = (1.0 + 2.0 * fraction) * rest * rest, fraction * fraction * (3.0 - 2.0 * fraction)
    h_10, h_11 = length * fraction * rest * rest, -length * fraction * fraction * rest
    d_0, d_1 = 6.0 * fraction * rest / length, rest * rest - 2.0 * fraction * rest
    d_2 = fraction * fraction - 2.0 * fraction * rest
    rows = list(zip(start.angles, start.rates, end.angles, end.rates, strict=True))
    angles = [h_00 * a + h_10 * u + h_01 * b + h_11 * v for a, u, b, v in rows]
    rates = [d_0 * (b - a) + d_1 * u + d_2 * v for a, u, b, v in rows]
    return State(start.time + fraction * length, tuple(angles), tuple(rates))


def turns(mechanism: Mechanism, start: State, end: State, link: int = 0) -> list[State]:
    """Return where, on the cubic, a wire's first link turns back relative to the hub within the interval."""
    length, speed = end.time - start.time, mechanism.hub_speed
    rate_0, rate_1 = ((state.rates[link] - speed) * length for state in (start, end))
    way = end.angles[link] - start.angles[link] - speed * length
    # Of the derivative in the fraction s of the interval: half the slope at s = 0, and the curvature.
    half, curve = 3.0 * way - 2.0 * rate_0 - rate_1, 3.0 * (rate_0 + rate_1) - 6.0 * way
    square = half * half - curve * rate_0
    if square <= 0.0:
        return []
    large = -half - math.copysign(math.sqrt(square), half)
    roots = [large / curve] if curve else []
    roots += [rate_0 / large] if large else []
    return [interpolate(start, end, root) for root in roots if 0.0 < root < 1.0]


MOST_TRIALS = 110
"""A smooth function takes three with a guess and six without; a jump is halved for the last digit of a double."""

LEAST_PART = 1e-10
"""Closest to the ends of what is left that the root is looked for, as a fraction of it."""

GUESSED = 1e-9
"""To which a guess is located, relative; the cubic is not that good."""


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

    The function runs the engine, so evaluations are dear and a library's root finder not worth its import. One that
    jumps is halved in the end. The result is where the value is within ``tolerance``, or the first duration past the root.
    The first evaluation is at ``guess`` if there is one, else where a straight line would have its root.

    T. R. Chandrupatla, *A new hybrid quadratic/bisection algorithm*, Adv. Eng. Softw. 28 (1997) 145-149: the root of the
    inverse quadratic through the last three points if that is monotonic between them, else the middle.
    """
    last, at_last, other, at_other = right, at_right, left, at_left
    instant = min(SHORTEST_BRACKET, SHORTEST_FRACTION * (right - left))
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
        part = _part(last - other, before - other, at_last, at_other, at_before)
    return max(last, other)


def _part(last: float, before: float, at_last: float, at_other: float, at_before: float) -> float:
    """Return how far the root is on the way from the last point back to the other one of another sign, both seen from that."""
    place, value = last / before, (at_last - at_other) / (at_before - at_other)
    if not (value * value < place and (1.0 - value) ** 2 < 1.0 - place):
        return 0.5
    part = at_last / (at_other - at_last) * at_before / (at_other - at_before)
    part += (last - before) / last * at_last / (at_before - at_last) * at_other / (at_before - at_other)
    return min(max(part, LEAST_PART), 1.0 - LEAST_PART)


MOST_GUESSES = 4
"""Two or three bring a touch that is found on the cubic of a whole interval to rounding."""

ROUNDED = 10.0
"""Tolerances within which the last guess must be, where rounding of many repetitions lets none come nearer."""

NEARBY = 1e-3
"""Fraction of an interval over which a slope is taken on its cubic; a secant step makes up for its error."""


def settle(
    value: Callable[[State], float],
    start: State,
    again: Callable[[float], Advance],
    near: float,
    last: float,
    tolerance: float,
) -> float | None:
    """Return the duration, near a guess and at most ``last``, after which a function of the state is zero; None if in doubt.

    The next guess is the zero on the cubic through the start and the state last reached, where that is exact; then those of
    straight lines.
    """
    before, at_before = 0.0, math.nan
    for trial in range(MOST_GUESSES):
        reached = again(near).state
        found = value(reached)
        if abs(found) <= (tolerance if trial < MOST_GUESSES - 1 else ROUNDED * tolerance):
            return near
        following = _following(value, start, reached, found) if trial == 0 else _secant(near, before, found, at_before)
        before, at_before, near = near, found, following * near
        if not 0.0 < near <= last:
            return None
    return None


def _following(value: Callable[[State], float], start: State, reached: State, found: float) -> float:
    """Return the fraction of an interval at which a function is zero on its cubic, near its end; 0 if the function is flat."""
    slope = (found - value(interpolate(start, reached, 1.0 - NEARBY))) / NEARBY
    if not slope:
        return 0.0
    change = -found / slope
    left = value(interpolate(start, reached, 1.0 + change))
    return 1.0 + (change * found / (found - left) if left != found else 0.0)


def _secant(near: float, before: float, found: float, at_before: float) -> float:
    """Return the fraction of an interval at which the straight line through two values is zero; 0 if they are one."""
    return 1.0 - found * (near - before) / ((found - at_before) * near) if found != at_before else 0.0


def guess(value: Callable[[State], float], start: State, end: State, fraction: float = 1.0) -> float | None:
    """Return the time since the start at which a function of the state is zero on the cubic; None without a change of sign.

    Args:
        value: the function; not a number where the state alone does not tell it.
        start, end: ends of the cubic.
        fraction: of the interval that is searched.
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
    return length * locate(at, 0.0, fraction, left, right, GUESSED * max(abs(left), abs(right)))
