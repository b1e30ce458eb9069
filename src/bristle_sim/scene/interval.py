"""An interval of smooth motion: its result, the forces and sums of its contacts, and the load on an
integrator.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple, Protocol

from bristle_sim.scene.build import Scene
from bristle_sim.scene.mechanism import Curve, State

# time over (1 + time at an interval's end) within which an event counts as at the interval's start
ONE_INSTANT = 1e-15


class Sums(NamedTuple):
    """Forces of one contact on its link at the end of an interval, and their integrals; engine
    units.

    Attributes:
        normal: normal force.
        tangential: tangential force; in stick, the force that friction would have to supply.
        impulse_normal: integral of the normal force over the time.
        impulse_tangential: integral of the tangential force over the time.
        work_normal: integral of the normal force over the path.
        work_tangential: integral of the tangential force over the path.
        tangential_at_start: tangential force of a spring in stick at the beginning of the interval.
    """

    normal: float = 0.0
    tangential: float = 0.0
    impulse_normal: float = 0.0
    impulse_tangential: float = 0.0
    work_normal: float = 0.0
    work_tangential: float = 0.0
    tangential_at_start: float = 0.0


# numbers of one contact in the flat list that an integrator extrapolates
NUMBERS = len(Sums._fields)


def sums_of(totals: Sequence[float], index: int) -> Sums:
    """Return the sums of one contact from the flat list of all contacts' sums."""
    return Sums(*totals[NUMBERS * index : NUMBERS * (index + 1)])


class Load(Protocol):
    """The forces of all contacts in a smooth motion, as an integrator calls them.

    Attributes:
        symmetric: whether the forces act alike forwards and backwards in time.
    """

    symmetric: bool

    def begin(self, step: float) -> Callable[[], None] | None:
        """Reset the sums; return the callback to run before each step of this length, if any."""

    def totals(self) -> list[float]:
        """Return the numbers of :class:`Sums` of each contact, in one list, after the last step."""

    def fails(self, totals: Sequence[float]) -> bool:
        """Return whether a contact would have to pull."""


class IntervalResult(NamedTuple):
    """Result of integrating over an interval.

    Attributes:
        state: the state at the interval's end.
        accelerations: the links' accelerations there.
        totals: the flat list of the contacts' sums.
        error: estimated error of angles in rad and of rates per time unit; 0 without an estimate.
        failed: whether a contact would have had to pull; the rest of the result is then
            meaningless.
        errors: estimated error after each repetition, by its number.
        middle: the state halfway; None if the integrator does not compute it.
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

    def sums(self, index: int) -> Sums:
        """Return the forces and sums of one contact."""
        return sums_of(self.totals, index)

    def moved(self, time: float) -> IntervalResult:
        """Return the result moved on by a short time with its accelerations."""
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
    """Return the state from a list that begins with the angles and rates of a scene's bodies."""
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
        """Return the state at a time after the start, by the polynomial through the known states.

        These are the start, the end and, if the integrator computed it, the middle.
        """
        if self._curve is None:
            middle = () if self.end.middle is None else (self.end.middle,)
            self._curve = Curve(self.start, *middle, self.end.state)
        return self._curve(self.start.time + time)

    @property
    def instant(self) -> float:
        """The longest time after the start that counts as the start."""
        return ONE_INSTANT * (1.0 + self.end.state.time)

    def up_to(self, end: IntervalResult) -> Interval:
        """Return the interval with an earlier end; an end within an instant of the start is the
        start.
        """
        if end is self.end:
            return self
        at_start = end.state.time - self.start.time <= self.instant
        return Interval(self.first, self.first if at_start else end, self.integrate_to)


def at_state(state: State) -> IntervalResult:
    """Return a state as the result of an interval of no length."""
    return IntervalResult(state, (math.nan,) * len(state.angles), (), 0.0)
