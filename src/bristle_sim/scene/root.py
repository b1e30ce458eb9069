"""The root of a function of time between two instants at which its signs differ."""

from __future__ import annotations

from collections.abc import Callable

# time, and fraction of the searched interval, of an instant
SHORTEST_BRACKET = 1e-15
SHORTEST_BRACKET_FRACTION = 1e-12
MOST_TRIALS = 110
"""Most evaluations; a smooth function takes three to six, and a jump is halved down to the last digit of a double."""

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

    For a jump the method ends in bisection. The value is within ``tolerance`` at the result, or it is the first duration past the
    root. The first evaluation is at ``guess`` or, without one, at the root of a straight line.

    T. R. Chandrupatla, *A new hybrid quadratic/bisection algorithm*, Adv. Eng. Softw. 28 (1997) 145-149: the root of the
    inverse quadratic through the last three points if that is monotonic between them, else the middle.
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
        # Seen from the other end, the root's place in units of the point before.
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
