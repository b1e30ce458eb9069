"""Changes of sign of event functions, and where within an interval they are."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence

from bristle_sim.scene.build import Scene
from bristle_sim.scene.events.functions import EventFunction
from bristle_sim.scene.events.search import guess, locate, settle
from bristle_sim.scene.events.touch_search import Interval
from bristle_sim.scene.integrate.stepping import Advance, Stepper
from bristle_sim.scene.mechanism import State

NOISE = 1e-10
"""Rates, accelerations and forces of a scene's units below this have no sign, however accurate the stepper is."""

LOCATED = 1e-3
"""Fraction of the accuracy to which a change of sign is located, relative to the values at the interval's ends."""

DIFFERENCE = 1e-13
"""Rounding of the difference of two rates that an acceleration is made of."""


class Changes:
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
        self.noise = max(NOISE, stepper.noise * (1.0 + damping))
        self.signs: dict[str, float] = {}

    def begin(self, state: State, functions: Sequence[EventFunction]) -> None:
        """Begin a smooth motion with the signs that the state alone tells: a change in its first interval is an event, too."""
        here = _no_interval(state)
        values = [(function, function.value(here)) for function in functions]
        known = {function.name: math.copysign(1.0, value) for function, value in values if abs(value) > self.noise}
        self.signs = {function.name: 1.0 for function, _ in values if function.final is not None} | known

    def return_to(
        self,
        known: Mapping[str, float],
        functions: Sequence[EventFunction],
        end: Advance,
        happens: EventFunction | None,
    ) -> None:
        """Forget signs beyond an interval's new end for those known before it, except of the function that is zero there."""
        signs = dict(known)
        for function in functions:
            value = function.value(end)
            if function is happens:
                signs[function.name] = self.signs[function.name]
            elif abs(value) > self.noise:
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
        self.signs |= {name: math.copysign(1.0, value) for name, value in exact.items() if abs(value) > NOISE}

    def find_first(
        self, functions: Sequence[EventFunction], interval: Interval, before: Advance | None
    ) -> tuple[Advance, EventFunction | None]:
        """Return the interval up to the first change of sign, and the function; ``before`` is the interval before it."""
        first = None
        for function in functions:
            changed = self.find(function, interval, before)
            if changed is not None:
                interval, first = interval._replace(end=changed), function
        return interval.end, first

    def find(self, function: EventFunction, interval: Interval, before: Advance | None) -> Advance | None:
        """Return the interval up to where the function changes its sign, or None; ``before`` is the one before it."""
        length, instant = interval.length, 1e-15 * (1.0 + interval.end.state.time)
        if length <= instant:
            return None
        right, sign = function.value(interval.end), self.signs.get(function.name)
        noise = max(self.noise, DIFFERENCE / length) if function.difference else self.noise
        if abs(right) > noise:
            self.signs[function.name] = math.copysign(1.0, right)
        if sign is None or sign * right >= 0.0 or abs(right) <= noise:
            return None
        if function.falling is not None and function.falling != (sign > 0.0):
            return None
        left = function.value(before or _no_interval(interval.start))
        if function.exact is not None:
            left, right = function.exact(interval.start), function.exact(interval.end.state)
            if sign * right > 0.0 or sign * left < -noise:
                # It does not change within this interval, looked at exactly: the differences have misled.
                self.signs[function.name] = math.copysign(1.0, right)
                return None
        interval = interval._replace(again=functools.cache(interval.again))
        duration = self._locate(function, interval, sign * max(sign * left, NOISE), right)
        return interval.again(max(duration, instant))

    def _locate(self, function: EventFunction, interval: Interval, left: float, right: float) -> float:
        """Return when a value that differs in sign at the two ends of an interval is zero."""

        def value(span: float) -> float:
            at = interval.again(span)
            return function.value(at) if function.exact is None else function.exact(at.state)

        tolerance = max(LOCATED * min(self.accuracy, 1e-4) * max(abs(left), abs(right)), 0.1 * NOISE)
        self.stepper.begin_afresh()
        near = None
        if function.exact is None:

            def of_state(state: State) -> float:
                return function.value(_no_interval(state))

            near = guess(of_state, interval.start, interval.end.state)
            if near is not None:
                found = settle(of_state, interval.start, interval.again, near, interval.length, tolerance)
                if found is not None:
                    return found
        return locate(value, 0.0, interval.length, left, right, tolerance, near)


def _no_interval(state: State) -> Advance:
    """Return a state as the end of an interval of no length."""
    return Advance(state, (math.nan,) * len(state.angles), (), 0.0)
