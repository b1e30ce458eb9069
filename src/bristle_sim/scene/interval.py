"""An interval of smooth motion between two events: its end state and its contact forces, impulses
and work.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple, Protocol

from bristle_sim.scene.build import Scene
from bristle_sim.scene.mechanism import Curve, State

# largest time after an interval's start, over (1 + time at its end), at which an event counts as at
# the start; rounding error of the time
ONE_INSTANT = 1e-15


class Sums(NamedTuple):
    """Forces of one contact on its link at the end of an interval, and the forces' impulse and work
    in the interval; engine units.

    Attributes:
        normal: normal force.
        tangential: tangential force; in stick, the force that friction would have to supply.
        impulse_normal: impulse of the normal force.
        impulse_tangential: impulse of the tangential force.
        work_normal: work of the normal force.
        work_tangential: work of the tangential force.
        tangential_at_start: tangential force of a contact with a spring in stick, at the beginning
            of the interval; otherwise 0.
    """

    normal: float = 0.0
    tangential: float = 0.0
    impulse_normal: float = 0.0
    impulse_tangential: float = 0.0
    work_normal: float = 0.0
    work_tangential: float = 0.0
    tangential_at_start: float = 0.0


# count of values of one contact in the flat list that an integrator extrapolates
NUMBERS = len(Sums._fields)


def sums_of(totals: Sequence[float], index: int) -> Sums:
    """Return one contact's forces, impulses and work from the flat list of all contacts' values."""
    return Sums(*totals[NUMBERS * index : NUMBERS * (index + 1)])


class Load(Protocol):
    """Interface between an integrator and the forces of all contacts in a smooth motion.

    Attributes:
        symmetric: whether the forces are the same forwards and backwards in time.
    """

    symmetric: bool

    def begin(self, step: float) -> Callable[[], None] | None:
        """Reset impulses and work; return the callback to run before each step of the length
        ``step``, or None if no callback is needed.
        """

    def totals(self) -> list[float]:
        """Return the values of :class:`Sums` of all contacts in one list, after the last step."""

    def fails(self, totals: Sequence[float]) -> bool:
        """Return whether a contact would have to pull to stay closed."""


class IntervalResult(NamedTuple):
    """Result of integrating over an interval.

    Attributes:
        state: the state at the interval's end.
        accelerations: the links' angular accelerations at the interval's end.
        totals: the values of :class:`Sums` of all contacts in one list.
        error: estimated error, the larger one of the error of angles, rad, and the error of rates,
            rad per time unit; 0 without an estimate.
        failed: whether a contact would have had to pull; the rest of the result is then
            meaningless.
        errors: estimated error after each repetition of the interval, by the repetition's index.
        middle: the state at half the interval; None if the integrator does not compute it.
    """

    state: State
    accelerations: tuple[float, ...]
    totals: tuple[float, ...]
    error: float
    failed: bool = False
    errors: Mapping[int, float] = MappingProxyType({})
    middle: State | None = None

    @classmethod
    def of(
        cls,
        scene: Scene,
        time: float,
        values: list[float],
        error: float,
        failed: bool,
        errors: Mapping[int, float],
    ) -> IntervalResult:
        """Return the result from the flat list of angles, rates, accelerations and totals."""
        size = len(scene.links)
        state = state_of(scene, time, values)
        return cls(
            state,
            tuple(values[2 * size : 3 * size]),
            tuple(values[3 * size :]),
            error,
            failed,
            errors,
        )

    def moved(self, time: float) -> IntervalResult:
        """Return the result with its state advanced by a short time at constant acceleration."""
        when, angles, rates = self.state
        angles = tuple(
            [
                a + time * (u + 0.5 * time * b)
                for a, u, b in zip(angles, rates, self.accelerations, strict=True)
            ]
        )
        rates = tuple([u + time * b for u, b in zip(rates, self.accelerations, strict=True)])
        return self._replace(state=State(when + time, angles, rates))


def state_of(scene: Scene, time: float, values: Sequence[float]) -> State:
    """Return the state from a list that begins with the angles and rates of a scene's links."""
    size = len(scene.links)
    turned = scene.turned
    return State(
        time, tuple([angle + turned for angle in values[:size]]), tuple(values[size : 2 * size])
    )


class Interval:
    """An interval that has been integrated.

    Attributes:
        first: result at the start.
        end: result at the end.
        integrate_to: function that integrates from the start over a shorter time.
        start: state at the start.
        length: duration of the interval.
        instant: longest time after the start that counts as at the start.
    """

    __slots__ = ("_curve", "end", "first", "instant", "integrate_to", "length", "start")

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

    def at(self, time: float) -> State:
        """Return the state at a time after the start, by polynomial interpolation.

        The polynomial passes through the states at the start, at the end and, if the integrator has
        computed it, in the middle.
        """
        if self._curve is None:
            middle = () if self.end.middle is None else (self.end.middle,)
            self._curve = Curve(self.start, *middle, self.end.state)
        return self._curve(self.start.time + time)

    def up_to(self, end: IntervalResult) -> Interval:
        """Return the interval shortened to an earlier end; an end closer than ``instant`` to the
        start becomes the start.
        """
        if end is self.end:
            return self
        at_start = end.state.time - self.start.time <= self.instant
        return Interval(self.first, self.first if at_start else end, self.integrate_to)


def at_state(state: State) -> IntervalResult:
    """Return a state as the result of an interval of zero length."""
    return IntervalResult(state, (math.nan,) * len(state.angles), (), 0.0)
