"""The root of a function of time between two instants at which the function has opposite signs."""

from __future__ import annotations

from collections.abc import Callable

# shortest bracket, in time and over the searched interval: the smaller one counts
SHORTEST_BRACKET = 1e-15
SHORTEST_BRACKET_FRACTION = 1e-12
MOST_TRIALS = 110
"""Most evaluations. A smooth function takes three to six; a jump is halved down to the last digit
of a double."""

# least distance of a trial from the ends of the bracket, over the bracket's length
LEAST_PART = 1e-10


def locate(
    value: Callable[[float], float],
    left: float,
    right: float,
    at_left: float,
    at_right: float,
    tolerance: float,
    guess: float | None = None,
) -> float:
    """Return the root of a function between two times at which it has opposite signs, by
    Chandrupatla's method.

    The value at the result is within ``tolerance``, or the result is the first time past the root.
    The first evaluation is at ``guess`` or, without one, at the root of a straight line. For a jump
    the method becomes bisection.

    T. R. Chandrupatla, *A new hybrid quadratic/bisection algorithm*, Adv. Eng. Softw. 28 (1997)
    145-149: the next trial is the root of the inverse quadratic through the last three points if
    that is monotonic between them, else the middle.
    """
    last = right
    at_last = at_right
    other = left
    at_other = at_left
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
        before = last
        at_before = at_last
        if (found < 0.0) != (at_last < 0.0):
            before = other
            at_before = at_other
            other = last
            at_other = at_last
        last = trial
        at_last = found
        # Position and value of the last point from the other end, in units of those of the point
        # before it.
        place = (last - other) / (before - other)
        height = (at_last - at_other) / (at_before - at_other)
        if height * height < place and (1.0 - height) ** 2 < 1.0 - place:
            part = at_last / (at_other - at_last) * at_before / (at_other - at_before)
            slope = (before - last) / (other - last)
            part += slope * at_last / (at_before - at_last) * at_other / (at_before - at_other)
            part = min(max(part, LEAST_PART), 1.0 - LEAST_PART)
        else:
            part = 0.5
    return max(last, other)
