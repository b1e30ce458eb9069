"""Finding the instant at which something happens within a stretch of motion, without missing it.

A stretch is first searched on the cubic through the states at its two ends, then the engine is run again with the
stretch shortened, from the restored state, until the event is at its end. Gaps are searched by conservative
advancement (Mirtich 1996): from a gap g no contact can happen before g / (largest speed), so nothing is jumped over.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bristle_sim.scene.mechanism import Mechanism, State

__all__ = ["extrapolated_root", "first_touch", "interpolate", "locate"]

CUBIC_ERROR = 0.01
"""Gap by which the cubic may be off, per fourth power of the stretch, in a scene's units: h^4/384 times some safety."""

SHORTEST = 1e-15
"""Stretches of a scene's time unit shorter than this are an instant."""

SHORTEST_ADVANCE = 1e-9
"""A least gap sooner than this, in a scene's time units, is the one at which the stretch begins."""

RESOLUTION = 1.0 / 8.0
"""Least advance in a search, as a share of the stretch; least values of the gap in between show in its slopes."""


def interpolate(start: State, end: State, share: float) -> State:
    """The cubic through angles and rates at both ends, at a share of the stretch between them."""
    length = end.time - start.time
    rest = 1.0 - share
    h_00, h_01 = (1.0 + 2.0 * share) * rest * rest, share * share * (3.0 - 2.0 * share)
    h_10, h_11 = length * share * rest * rest, -length * share * share * rest
    d_0, d_1 = 6.0 * share * rest / length, rest * rest - 2.0 * share * rest
    d_2 = share * share - 2.0 * share * rest
    rows = list(zip(start.angles, start.rates, end.angles, end.rates, strict=True))
    angles = tuple(h_00 * a + h_10 * u + h_01 * b + h_11 * v for a, u, b, v in rows)
    rates = tuple(d_0 * (b - a) + d_1 * u + d_2 * v for a, u, b, v in rows)
    return State(start.time + share * length, angles, rates)


Gap = Callable[[State], tuple[float, float]]
"""The gap of a state, and its rate."""


def first_touch(mechanism: Mechanism, gap: Gap, start: State, end: State, stray: float = 0.0) -> float | None:
    """Share of the stretch at which the gap is closed, or nearly so at its least, on the cubic; None if it stays open.

    The share may be later than the touch but never past a second one. ``stray`` is how far the motion may be off the
    cubic besides its own error.
    """
    length = end.time - start.time
    bound = 1.5 * max(mechanism.speed_bound(start), mechanism.speed_bound(end)) * length
    margin = CUBIC_ERROR * length**4 + stray
    share, (value, rate) = 0.0, gap(start)
    while share < 1.0 and value <= bound * (1.0 - share) + margin:
        ahead = min(1.0, share + max(value / bound if bound else 1.0, RESOLUTION))
        following, next_rate = gap(interpolate(start, end, ahead)) if ahead < 1.0 else gap(end)
        if following < 0.0:
            return ahead
        if rate < 0.0 < next_rate:
            dip, least = _dip(lambda at: gap(interpolate(start, end, at)), share, ahead)
            if least < 0.0 or (least < margin and dip * length > SHORTEST_ADVANCE):
                return dip
        share, value, rate = ahead, following, next_rate
    return None


def _dip(gap: Callable[[float], tuple[float, float]], left: float, right: float) -> tuple[float, float]:
    """Where a gap that falls at its left and rises at its right end is closed, or else least: the share, and the gap."""
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
    """Root of a function between two durations at which its signs differ: false position, Illinois variant.

    The function runs the engine, so evaluations are dear and a library's root finder not worth its import. The result
    is where the value is within ``tolerance``, or the first duration past the root.
    """
    side = 0
    for _ in range(100):
        if right - left <= 4e-16 * right + SHORTEST:
            break
        middle = left + (right - left) * min(max(at_left / (at_left - at_right), 1e-4), 1.0 - 1e-4)
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


def extrapolated_root(value: Callable[[float], float], reach: float, guess: float) -> float:
    """Root near a guess of the cubic through a function's values at four places up to ``reach``.

    A value that rests on differences over the stretch itself is of no use where the stretch is next to nothing, so an
    event at its very beginning is extrapolated from behind it. Returns the guess if the cubic has no root there.
    """
    places = [reach * quarter for quarter in (0.25, 0.5, 0.75, 1.0)]
    cubic = np.polynomial.Polynomial.fit(places, [value(place) for place in places], 3)
    roots = cubic.roots()
    real = roots.real[np.abs(roots.imag) <= 1e-9 * reach]
    nearest = min(real.tolist(), key=lambda root: abs(root - guess), default=guess)
    return nearest if abs(nearest - guess) < reach else guess
