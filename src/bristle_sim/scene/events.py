"""Finding the instant at which something happens within an interval of motion, without missing it.

An interval is first searched on the cubic through the states at its two ends, then the engine is run again with the
interval shortened, from the restored state, until the event is at its end. Gaps are searched by conservative
advancement (Mirtich 1996): from a gap g no contact can happen before g / (largest speed), so nothing is jumped over.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from bristle_sim.scene.mechanism import Mechanism, State

__all__ = ["first_touch", "interpolate", "locate", "turns"]

CUBIC_ERROR = 0.01
"""Gap by which the cubic may be off, per fourth power of the interval, in a scene's units: h^4/384 times some safety."""

SHORTEST = 1e-15
"""Intervals of a scene's time unit shorter than this are an instant."""

SHORTEST_FRACTION = 1e-12
"""So is this fraction of an interval that is searched: a fast motion needs short ones."""

SHORTEST_ADVANCE = 1e-9
"""A least gap sooner than this, in a scene's time units and lengths, is the one at which the interval begins."""

RESOLUTION = 1.0 / 8.0
"""Least advance in a search, as a fraction of the interval; least values of the gap in between show in its slopes."""


def interpolate(start: State, end: State, fraction: float) -> State:
    """Return the cubic through angles and rates at both ends, at a fraction of the interval between them."""
    length = end.time - start.time
    rest = 1.0 - fraction
    h_00, h_01 = (1.0 + 2.0 * fraction) * rest * rest, fraction * fraction * (3.0 - 2.0 * fraction)
    h_10, h_11 = length * fraction * rest * rest, -length * fraction * fraction * rest
    d_0, d_1 = 6.0 * fraction * rest / length, rest * rest - 2.0 * fraction * rest
    d_2 = fraction * fraction - 2.0 * fraction * rest
    rows = list(zip(start.angles, start.rates, end.angles, end.rates, strict=True))
    angles = tuple(h_00 * a + h_10 * u + h_01 * b + h_11 * v for a, u, b, v in rows)
    rates = tuple(d_0 * (b - a) + d_1 * u + d_2 * v for a, u, b, v in rows)
    return State(start.time + fraction * length, angles, rates)


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


MOST_SECANTS, MOST_HALVINGS = 50, 60
"""A smooth function takes some ten of the first; the others suffice for the last digit of a double."""

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


def locate(
    value: Callable[[float], float], left: float, right: float, at_left: float, at_right: float, tolerance: float
) -> float:
    """Return the root of a function between two durations at which its signs differ: false position, Illinois variant.

    The function runs the engine, so evaluations are dear and a library's root finder not worth its import. One that
    jumps is halved in the end. The result is where the value is within ``tolerance``, or the first duration past the root.
    """
    side = 0
    instant = min(SHORTEST, SHORTEST_FRACTION * (right - left))
    for trial in range(MOST_SECANTS + MOST_HALVINGS):
        if right - left <= 4e-16 * right + instant:
            break
        fraction = at_left / (at_left - at_right) if trial < MOST_SECANTS else 0.5
        middle = left + (right - left) * min(max(fraction, 1e-4), 1.0 - 1e-4)
        found = value(middle)
        if abs(found) <= tolerance:
            return middle
        if (found < 0.0) == (at_right < 0.0):
            right, at_right = middle, found
            at_left *= 0.5 if side == 1 else 1.0
            side = 1
        else:
            left, at_left = middle, found
            at_right *= 0.5 if side == -1 else 1.0
            side = -1
    return right
