"""Signs of event functions, and the first of their changes within an interval."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence

from bristle_sim.scene.build import Scene
from bristle_sim.scene.events.functions import EventFunction, at_state
from bristle_sim.scene.events.locate import Interval, guess, interpolate, locate, settle
from bristle_sim.scene.integrate.stepping import Advance, Stepper
from bristle_sim.scene.mechanism import State

LEAST_VALUE = 1e-10
"""Rates, accelerations and forces of a scene's units below this have no sign, however accurate the stepper is."""

LOCATED_VALUE = 1e-3
"""Fraction of the accuracy to which a change of sign is located, relative to the values at the interval's ends."""

DIFFERENCE = 1e-13
"""Rounding of the difference of two rates that an acceleration is made of."""

QUARTERS = (0.25, 0.5, 0.75)
"""Fractions of an interval at which a function of a vibrating motion is looked at for an extreme within."""

FAR_OFF = 0.1
"""Fraction of a function's range within an interval by which its extreme, estimated from five values, may be off; the cubic
between the states of an interval of 1.4 radians of the fastest motion is off by 1.4^4/384 = 1 % of its amplitude."""

NEAR_THE_ENDS = 0.01
"""Fraction of an interval from its ends within which no extreme is looked for: the function hardly moves there."""


class Signs:
    """Remembers the sign that each function's value had last.

    Args:
        scene, stepper: of the run.
        accuracy: to which changes are located, relative.
    """

    def __init__(self, scene: Scene, stepper: Stepper, accuracy: float) -> None:
        """Begin without any sign."""
        self.stepper = stepper
        self.accuracy = accuracy
        # A damped spring turns an error of the rate into one of the acceleration.
        damping = scene.effects.damping / scene.mechanism.links[0].inertia_about_joint
        self.noise = max(LEAST_VALUE, stepper.noise * (1.0 + damping))
        self.signs: dict[str, float] = {}

    def begin(self, state: State, functions: Sequence[EventFunction]) -> None:
        """Begin a smooth motion with the signs at its state: a change in its first interval is an event, too."""
        here = at_state(state)
        values = [(function, function.value(here)) for function in functions]
        known = {each.name: math.copysign(1.0, value) for each, value in values if abs(value) > self._noise(each)}
        self.signs = {each.name: 1.0 for each, _ in values if each.final is not None or each.positive} | known

    def return_to(
        self,
        known: Mapping[str, float],
        functions: Sequence[EventFunction],
        end: Advance,
        happens: EventFunction | None,
    ) -> None:
        """Restore the signs from before the interval, evaluated anew at its new end; keep that of the function that is zero there."""
        signs = dict(known)
        for function in functions:
            value = function.value(end)
            if function is happens:
                signs[function.name] = self.signs[function.name]
            elif abs(value) > self._noise(function):
                signs[function.name] = math.copysign(1.0, value)
        self.signs = signs

    def look_back(self, interval: Interval, functions: Sequence[EventFunction]) -> None:
        """Find signs at the very start exactly, if the first link's acceleration may have changed its sign since.

        By the cubic through the ends.
        """
        (start, *_), (rate_0, *_) = interval.start.angles, interval.start.rates
        (end, *_), (rate_1, *_) = interval.end.state.angles, interval.end.state.rates
        length, after = interval.length, interval.end.accelerations[0]
        before = 6.0 * (end - start) / length - 4.0 * rate_0 - 2.0 * rate_1
        if after * before >= 0.2 * length * after**2:
            return
        exact = {function.name: function.exact(interval.start) for function in functions if function.exact is not None}
        self.signs |= {name: math.copysign(1.0, value) for name, value in exact.items() if abs(value) > LEAST_VALUE}

    def find_first(
        self, functions: Sequence[EventFunction], interval: Interval, before: Advance | None, *, turns: bool = False
    ) -> tuple[Advance, EventFunction | None]:
        """Return the interval up to the first change of sign, and the function.

        ``before`` is the interval before it; in a motion that ``turns`` a function may change its sign twice.
        """
        first = None
        for function in functions:
            looked_at = _to_the_extreme(function, interval) if turns and function.turns else interval
            changed = self.find(function, looked_at, before)
            if changed is not None:
                interval, first = interval._replace(end=changed), function
        return interval.end, first

    def find(self, function: EventFunction, interval: Interval, before: Advance | None) -> Advance | None:
        """Return the interval up to where the function changes its sign, or None; ``before`` is the one before it."""
        length, instant = interval.length, 1e-15 * (1.0 + interval.end.state.time)
        if length <= instant:
            return None
        right, sign = function.value(interval.end), self.signs.get(function.name)
        noise = self._noise(function)
        if function.difference:
            noise = max(noise, DIFFERENCE / length)
        if abs(right) > noise:
            self.signs[function.name] = math.copysign(1.0, right)
        if sign is None or sign * right >= 0.0 or abs(right) <= noise:
            return None
        if function.falling is not None and function.falling != (sign > 0.0):
            return None
        left = function.value(before or at_state(interval.start))
        left = -right if math.isnan(left) else left
        if function.exact is not None:
            left, right = function.exact(interval.start), function.exact(interval.end.state)
            if sign * right > 0.0 or sign * left < -noise:
                # It does not change within this interval, looked at exactly: the differences have misled.
                self.signs[function.name] = math.copysign(1.0, right)
                return None
        interval = interval._replace(again=functools.cache(interval.again))
        least = LEAST_VALUE if function.tolerance is None else math.ulp(1.0)
        duration = self._locate(function, interval, sign * max(sign * left, least), right)
        return interval.again(max(duration, instant))

    def _locate(self, function: EventFunction, interval: Interval, left: float, right: float) -> float:
        """Return when a value that differs in sign at the two ends of an interval is zero."""

        def value(span: float) -> float:
            at = interval.again(span)
            return function.value(at) if function.exact is None else function.exact(at.state)

        tolerance = max(LOCATED_VALUE * min(self.accuracy, 1e-4) * max(abs(left), abs(right)), 0.1 * LEAST_VALUE)
        if function.tolerance is not None:
            tolerance = function.tolerance
        self.stepper.begin_afresh()
        near = None
        if function.exact is None:

            def of_state(state: State) -> float:
                return function.value(at_state(state))

            near = guess(of_state, interval.start, interval.end.state)
            if near is not None:
                found = settle(of_state, interval.start, interval.again, near, interval.length, tolerance)
                if found is not None:
                    return found
        return locate(value, 0.0, interval.length, left, right, tolerance, near)

    def _noise(self, function: EventFunction) -> float:
        return self.noise if function.tolerance is None else math.ulp(1.0)


def _to_the_extreme(function: EventFunction, interval: Interval) -> Interval:
    """Return an interval up to where a function has changed its sign, if it changes it twice; else all of it.

    Its least value is that of the parabola through the least of five values and the two beside it.
    """
    sense = 1.0 if function.falling else -1.0
    middle_state = interpolate(interval.start, interval.end.state, 0.5)
    first, middle, last = (
        sense * function.value(each) for each in (at_state(interval.start), at_state(middle_state), interval.end)
    )
    bend, slope = first + last - 2.0 * middle, 0.5 * (last - first)
    # Without an extreme within, or far above zero there, nothing is missed.
    if not (last >= 0.0 and bend > abs(slope) and middle - 0.5 * slope**2 / bend < FAR_OFF * max(first, last)):
        return interval
    states = [interpolate(interval.start, interval.end.state, part) for part in QUARTERS]
    ends = [at_state(interval.start), *map(at_state, states), interval.end]
    margins = [sense * function.value(each) for each in ends]
    if math.isnan(sum(margins)) or margins[-1] < 0.0:
        return interval
    least = min(max(margins.index(min(margins)), 1), 3)
    before, middle, after = margins[least - 1 : least + 2]
    bend, slope = before + after - 2.0 * middle, 0.5 * (after - before)
    at = 0.25 * (least - slope / bend) if bend > 0.0 else 0.0
    inside = NEAR_THE_ENDS < at < 1.0 - NEAR_THE_ENDS
    if not inside or middle - 0.5 * slope**2 / bend > FAR_OFF * (max(margins) - min(margins)):
        return interval
    part = interval.again(at * interval.length)
    return interval._replace(end=part) if sense * function.value(part) < 0.0 else interval
