"""An interval of smooth motion: the results at its ends, and the function that integrates a shorter time."""

from __future__ import annotations

import math
from collections.abc import Callable

from bristle_sim.scene.extrapolation import IntervalResult
from bristle_sim.scene.mechanism import Curve, State

ONE_INSTANT = 1e-15  # of the time at an interval's end plus 1: an event sooner after the start is at the start


class Interval:
    """An interval that has been integrated: the results at its ends, and the function that integrates a shorter time."""

    __slots__ = ("_curve", "end", "first", "integrate_to", "length", "start")

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
        self._curve: Curve | None = None

    def at(self, time: float) -> State:
        """Return the state a time after the start, on the polynomial through start, end and, where it is known, middle."""
        if self._curve is None:
            middle = () if self.end.middle is None else (self.end.middle,)
            self._curve = Curve(self.start, *middle, self.end.state)
        return self._curve(self.start.time + time)

    @property
    def instant(self) -> float:
        """The time within which the end is the start."""
        return ONE_INSTANT * (1.0 + self.end.state.time)

    def up_to(self, end: IntervalResult) -> Interval:
        """Return the interval with an earlier end; within an instant that is the start, where nothing is integrated."""
        if end is self.end:
            return self
        at_start = end.state.time - self.start.time <= self.instant
        return Interval(self.first, self.first if at_start else end, self.integrate_to)


def at_state(state: State) -> IntervalResult:
    """Return a state as the end of an interval of no length."""
    return IntervalResult(state, (math.nan,) * len(state.angles), (), 0.0)
