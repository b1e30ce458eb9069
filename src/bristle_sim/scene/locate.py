"""An interval of smooth motion, and the instant within it at which an event's value is zero.

The instant is first estimated on the polynomial through the interval's states. The integrator then
repeats the interval up to the estimated instant, and improves the estimate, until the interval ends
at the zero.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from bristle_sim.scene.contact import forces_within
from bristle_sim.scene.events import BEGINS_POSITIVE, DIFFERENCES, ROUNDED_TOLERANCES, TURNS, Event
from bristle_sim.scene.extrapolation import IntervalResult
from bristle_sim.scene.mechanism import Curve, State
from bristle_sim.scene.system import LEAST_VALUE, System

LOCATED_VALUE = 1e-3
"""Tolerance of an event's value at its located zero, divided by the run's accuracy and by the
larger of the values at the interval's two ends."""

# Rounding error of the difference of two angular velocities, engine units. Divided by the
# interval's length it is the rounding error of an acceleration or a force.
RATE_ROUNDING = 1e-13

EXTREME_ERROR = 0.1
"""Largest error of an extreme that is estimated from five values, as a fraction of the function's
range in the interval. The cubic polynomial through the states at the ends of an interval of 1.4
radians of the fastest motion deviates by 1.4^4/384 = 1 % of the motion's amplitude."""

LONGEST_OF_A_FORCE = 0.025
"""Longest interval, in time scales of the fastest motion, in which a zero of a force is located.
Extrapolation from the steps h/4, h/5, h/6 and h/7 leaves an error of h^4/840 times the force's
fourth derivative, which no error estimate includes."""

# A force's zero is located in a shorter interval, which begins at this fraction of the zero's time.
BEFORE_ZERO = 0.95
LEAST_BEFORE = 2.5e-5  # its least beginning, in time scales; a zero at the start is passed

# Least time of an extreme, as a fraction of the interval; an earlier extreme is ignored.
EARLIEST_EXTREME = 0.01

# Rounding error of the time, divided by (1 + time at the interval's end)
ONE_INSTANT = 1e-15


class Interval:
    """An interval of smooth motion that has been integrated.

    Attributes:
        first: result at the start.
        end: result at the end.
        integrate_to: function that returns the result at a time after the start.
        start: state at the start.
        length: duration of the interval.
        instant: time after the start within which an event counts as happening at the start.
    """

    __slots__ = ("_curve", "_known", "end", "first", "instant", "integrate_to", "length", "start")

    def __init__(
        self,
        first: IntervalResult,
        end: IntervalResult,
        integrate_to: Callable[[float], IntervalResult],
    ) -> None:
        self.first = first
        self.end = end
        self.integrate_to = integrate_to
        self.start = first.state
        self.length = end.state.time - first.state.time
        self.instant = ONE_INSTANT * (1.0 + end.state.time)
        self._curve: Curve | None = None
        self._known = {self.length: end.state, 0.0: self.start}

    def at(self, time: float) -> State:
        """Return the interpolated state at a time that is measured from the interval's start."""
        if time not in self._known:
            self._curve = self._curve or Curve(self.start, self.end.middle, self.end.state)
            self._known[time] = self._curve.at(time)
        return self._known[time]

    def up_to(self, end: IntervalResult) -> Interval:
        """Return the interval shortened to an earlier end.

        If the end is no later than ``instant`` after the start, the interval has zero length.
        """
        if end is self.end:
            return self
        at_start = end.state.time - self.start.time <= self.instant
        return Interval(self.first, self.first if at_start else end, self.integrate_to)


def first_change(
    system: System, events: Sequence[Event], interval: Interval
) -> tuple[Interval, Event | None]:
    """Return the interval shortened to the first event in it, and this event.

    Without an event return the whole interval and None.
    """
    first = None
    least, longest = (system.plan.time_scale * each for each in (LEAST_BEFORE, LONGEST_OF_A_FORCE))
    for event in events:
        if interval.length <= interval.instant:
            break
        part = _to_the_extreme(event, interval) if event.kind in TURNS else interval
        ends = _change(event, part) if part.length > part.instant else None
        while ends is not None and event.kind in DIFFERENCES and part.length > longest:
            # A force's zero is located in a short interval that begins before it.
            left, right = ends
            zero = part.length * left / (left - right)
            part = part.up_to(part.integrate_to(max(BEFORE_ZERO * zero, least)))
            ends = _change(event, part)
            if ends is None:
                interval = part
                first = None
        if ends is not None:
            interval = part.up_to(_zero(system, event, part, *ends))
            first = event
    return interval, first


def _change(event: Event, interval: Interval) -> tuple[float, float] | None:
    """Return an event's values at an interval's ends; None if it does not happen there."""
    sign = event.sign
    right = event.at(interval.end)
    noise = event.noise
    if event.kind in DIFFERENCES:
        noise = max(noise, RATE_ROUNDING / interval.length)
    if sign is None or not sign * right < -noise or event.direction == sign:
        return None
    left = event.value(interval.first)
    left = -right if math.isnan(left) else left
    return sign * max(sign * left, LEAST_VALUE if event.tolerance is None else math.ulp(1.0)), right


def _zero(
    system: System, event: Event, interval: Interval, left: float, right: float
) -> IntervalResult:
    """Return the result of integrating from the interval's start to the zero of an event's value.

    ``left`` and ``right`` are the values at the interval's ends, which have opposite signs.
    """
    integrate_to = interval.integrate_to
    value = event.value
    tolerance = event.tolerance
    if tolerance is None:
        located = LOCATED_VALUE * min(system.plan.accuracy, 1e-4) * max(abs(left), abs(right))
        rounding = 0.1 * LEAST_VALUE
        if event.kind in DIFFERENCES:
            rounding = 100.0 * RATE_ROUNDING / interval.length
        tolerance = max(located, rounding)
    begin = 0.0
    if event.kind in BEGINS_POSITIVE and value(interval.first) <= tolerance:
        # The value rises from zero before it falls: the search begins where it is positive.
        time = interval.length
        while begin == 0.0 and time > interval.instant:
            time *= 0.5
            at_time = value(IntervalResult(interval.at(time)))
            if math.isnan(at_time):
                at_time = value(integrate_to(time))
            if at_time > tolerance:
                begin = time
    found = settle(system, value, interval, begin, interval.length, tolerance)
    if found is not None:
        return found
    ends = (begin, interval.length, left, right)
    time = max(locate(value, integrate_to, *ends, tolerance), interval.instant)
    back = 1e-12
    while (result := integrate_to(time)).failed and back < 1.0:
        # Beyond the release the contact would have to pull; the result just before it is accurate.
        time = time * (1.0 - back)
        back = 10.0 * back
    return result


def _to_the_extreme(event: Event, interval: Interval) -> Interval:
    """Return the interval shortened so that it ends at an extreme of the event's value.

    If the value changes sign twice, the shortened interval contains the first change only. The
    extreme is that of a parabola through the least (or greatest) of five values and its neighbours.
    The interval is shortened only if the extreme is beyond zero or close to zero.
    """
    sense = -float(event.direction)
    length = interval.length
    last = sense * event.at(interval.end)
    if not last >= 0.0:  # also where it is NaN
        return interval
    values = []
    for part in (0.0, 0.25, 0.5, 0.75):
        result = IntervalResult(interval.at(part * length))
        if event.kind in DIFFERENCES:
            forces = forces_within(interval.first.totals, interval.end.totals, length, part)
            result = result._replace(totals=forces)
        values.append(sense * event.value(result))
    if math.isnan(sum(values)):
        return interval
    values.append(last)
    least = min(max(values.index(min(values)), 1), 3)
    before, middle, after = values[least - 1 : least + 2]
    bend = before + after - 2.0 * middle
    slope = 0.5 * (after - before)
    at = 0.25 * (least - slope / bend) if bend > abs(slope) else 0.0
    if at < EARLIEST_EXTREME or middle - 0.5 * slope**2 / bend > EXTREME_ERROR * max(values):
        return interval  # the sign does not change twice
    return interval.up_to(interval.integrate_to(at * length))


MOST_GUESSES = 4  # largest number of guesses of the time of an event; one or two usually suffice

MOST_SECANTS = 3  # largest number of secant steps from one guess
# Time difference for the slope of the first secant step, as a fraction of the interval.
SLOPE_SPAN = 1e-4
# Tolerance of a root of the interpolating polynomial, as a fraction of the larger of the values at
# the two ends. The polynomial is hardly more accurate.
GUESS_TOLERANCE = 1e-7

MOST_MOVED = 0.1
"""Longest time by which a result is advanced at constant accelerations, divided by T sqrt(error),
with the time scale T of the fastest motion and the error permitted in an interval. If the relative
error of the accelerations is sqrt(error), the error of the angular velocities is then a tenth of
the permitted error."""


def settle(
    system: System,
    value: Callable[[IntervalResult], float],
    interval: Interval,
    first: float,
    last: float,
    tolerance: float,
) -> IntervalResult | None:
    """Locate a zero of a function of the state, and return the integrator's result there.

    The first estimate of the time is the zero on the interval's interpolating polynomial. The
    interval is integrated up to the estimate. From the state reached, the motion is extrapolated at
    constant accelerations. Secant steps on the extrapolated motion give the next estimate. Return
    None if the function does not change sign between ``first`` and ``last``, if it depends on the
    contact forces, or if the estimates do not converge.

    Args:
        system: the run.
        value: the function.
        interval: the interval.
        first, last: times between which the zero is sought, measured from the interval's start.
        tolerance: largest magnitude of the function that counts as zero.
    """
    left = value(IntervalResult(interval.at(first)))
    right = value(IntervalResult(interval.at(last)))
    if not left * right < 0.0:  # NaN where the state does not determine the function
        return None
    rounding = GUESS_TOLERANCE * max(abs(left), abs(right))
    ends = (first, last, left, right)
    near = locate(value, lambda time: IntervalResult(interval.at(time)), *ends, rounding)
    longest = MOST_MOVED * system.plan.time_scale * math.sqrt(system.stepper.noise)
    span = SLOPE_SPAN * interval.length
    for trial in range(MOST_GUESSES):
        reached = interval.integrate_to(near)
        found = value(reached)
        allowed = ROUNDED_TOLERANCES if trial == MOST_GUESSES - 1 else 1.0
        if abs(found) <= allowed * tolerance:
            return reached
        moved = span
        before = 0.0
        at_before = found
        at_moved = value(reached.moved(span))
        for _ in range(MOST_SECANTS):
            if at_moved == at_before or not abs(at_moved) > tolerance:
                break
            secant = moved - at_moved * (moved - before) / (at_moved - at_before)
            before = moved
            at_before = at_moved
            moved = secant
            at_moved = value(reached.moved(moved))
        near += moved
        if not (0.0 < near <= interval.length and abs(at_moved) < abs(found)):
            return None
        if abs(moved) <= longest and abs(at_moved) <= tolerance and not reached.totals:
            return reached.moved(moved)
    return None


# Shortest bracket of a root, as a time in engine units and as a fraction of the searched interval.
SHORTEST_BRACKET = 1e-15
SHORTEST_BRACKET_FRACTION = 1e-12  # the smaller of the two applies
MOST_TRIALS = 110  # largest number of evaluations; a jump needs bisections to the last digit

# Least distance of a trial from the ends of the bracket, as a fraction of the bracket's length, in
# the first trial and in later trials. It is needed where the value at an end is rounding error.
LEAST_PART_AT_FIRST = 1e-4
LEAST_PART = 1e-10

# Largest number of evaluations by false position, before bisection. A smooth function needs fewer.
MOST_LINES = 30


def locate(
    value: Callable[[Any], float],
    motion: Callable[[float], Any],
    left: float,
    right: float,
    at_left: float,
    at_right: float,
    tolerance: float,
) -> float:
    """Return the time at which a function of the motion is zero.

    The time lies between two times at which the function has opposite signs. The method is false
    position with the weights of Anderson and Bjorck. A jump of the function may take more than
    ``MOST_LINES`` evaluations; bisection then follows. At the returned time the magnitude of the
    function is at most ``tolerance``, or the bracket of the root is the shortest possible and the
    returned time is its later end.

    Args:
        value: the function.
        motion: function that returns the motion at a time, which is the argument of ``value``.
        left, right: the earlier and the later time.
        at_left, at_right: values of the function at these times.
        tolerance: largest magnitude of the function that counts as zero.

    N. Anderson, A. Bjorck, *A new high order method of regula falsi type*, BIT 13 (1973) 253-264.
    Where two successive values have the same sign, the stored value at the other end of the bracket
    is multiplied by 1 minus the ratio of the second value to the first, or by 1/2 if this factor is
    not positive.
    """
    last, other = right, left
    at_last, at_other = at_right, at_left
    instant = min(SHORTEST_BRACKET, SHORTEST_BRACKET_FRACTION * (right - left))
    least = LEAST_PART_AT_FIRST
    for count in range(MOST_TRIALS):
        if abs(other - last) <= 4e-16 * max(other, last) + instant:
            break
        part = min(max(at_last / (at_last - at_other), least), 1.0 - least)
        trial = last + part * (other - last)
        least = LEAST_PART
        if count >= MOST_LINES or not min(last, other) < trial < max(last, other):
            trial = 0.5 * (last + other)
        found = value(motion(trial))
        if abs(found) <= tolerance:
            return trial
        if (found < 0.0) == (at_last < 0.0):
            at_other *= max(1.0 - found / at_last, 0.0) or 0.5
        else:
            other = last
            at_other = at_last
        last = trial
        at_last = found
    return max(last, other)
