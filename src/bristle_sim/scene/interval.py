"""An interval of smooth motion: forces and sums of its contacts, the result at its end, and the load that an integrator sees."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple, Protocol

from bristle_sim.scene.build import Scene
from bristle_sim.scene.mechanism import Curve, State

ONE_INSTANT = 1e-15  # of the time at an interval's end plus 1: an event sooner after the start is at the start


class Sums(NamedTuple):
    """Forces of one contact on its link at the end of an interval, and their sums over it; engine units.

    Attributes:
        normal, tangential: the forces. In stick the tangential one is the force that friction would have to supply.
        impulse_normal, impulse_tangential: their integrals over the time.
        work_normal, work_tangential: their integrals over the path.
        tangential_at_start: the tangential force of a spring in stick at the beginning of the interval.
    """

    normal: float = 0.0
    tangential: float = 0.0
    impulse_normal: float = 0.0
    impulse_tangential: float = 0.0
    work_normal: float = 0.0
    work_tangential: float = 0.0
    tangential_at_start: float = 0.0


NUMBERS = len(Sums._fields)  # of a contact in the flat list that an integrator extrapolates


def sums_of(totals: Sequence[float], index: int) -> Sums:
    """Return the sums of one contact from the flat list of all."""
    return Sums(*totals[NUMBERS * index : NUMBERS * (index + 1)])


class Load(Protocol):
    """The forces of all contacts of a smooth motion, as an integrator sees them.

    Attributes:
        symmetric: whether they act alike forwards and backwards in time.
    """

    symmetric: bool

    def begin(self, step: float) -> Callable[[], None]:
        """Reset the sums; return a callback to run before each step of this length."""

    def totals(self) -> list[float]:
        """Return the numbers of :class:`Sums` of each contact, with the last step."""

    def fails(self, totals: Sequence[float]) -> bool:
        """Return whether a contact would have to pull."""


class IntervalResult(NamedTuple):
    """Result of integrating over an interval: the state at its end, the links' accelerations there, the sums of a load.

    Attributes:
        error: estimated error of angles in rad and of rates per time unit; 0 where there is no estimate.
        failed: whether the load could not act as it should; the rest of the result is then meaningless.
        errors: estimated error by number of the repetition, if the stepper repeats the interval.
        middle: the state halfway; None if the integrator does not know it.
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
        """Return the angles, rates, accelerations and totals that a scene had at a time."""
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

    def sums(self, index: int) -> Sums:
        """Return the forces and sums of one contact of the load."""
        return sums_of(self.totals, index)

    def moved(self, time: float) -> IntervalResult:
        """Return the result a short time later, by the accelerations."""
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
    """Return the state with the angles and rates that a scene's bodies had at a time."""
    size = len(scene.links)
    turned = scene.turned
    return State(
        time, tuple([angle + turned for angle in values[:size]]), tuple(values[size : 2 * size])
    )


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
