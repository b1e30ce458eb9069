"""The integrator of intervals without events: engine steps, extrapolated to the step zero.

The engine moves positions by the old velocities and then changes the velocities, so its error over
an interval without events is smooth in the step h and of first order. The interval is repeated with
n = 4, 5, 6, 7 ... steps, and the results are extrapolated to h = 0 (Richardson; Bulirsch and Stoer
1966); each repetition removes one power of h from the error. The difference between the last two
extrapolated results estimates the error. The length of the next interval and the number of
repetitions follow from this estimate as in Hairer, Norsett and Wanner, *Solving Ordinary
Differential Equations I*, sec. II.9.
"""

from __future__ import annotations

import math
from bisect import bisect
from collections.abc import Callable, Mapping, Sequence
from operator import mul
from types import MappingProxyType
from typing import NamedTuple, Protocol

from bristle_sim.scene.build import Scene
from bristle_sim.scene.mechanism import State

PLACING_COST = 6.0
"""Cost of placing and reading the bodies once, in engine steps. The choice of the interval's length
weighs it against the cost of the steps."""

# rounding error of an angle of a few radians, rad; the weights of extrapolation amplify it
ANGLE_ROUNDING = 4e-16

# least ratio of the errors of two successive repetitions that is believed under damping, where a
# single estimate may be too small
LEAST_GAIN = 0.1


class Load(Protocol):
    """Interface between an integrator and the forces of all contacts in a smooth motion.

    Attributes:
        symmetric: whether the forces are the same forwards and backwards in time.
    """

    symmetric: bool

    def begin(self, step: float, *, symmetric: bool = False) -> Callable[[], None] | None:
        """Set impulses and work to zero; return the function to call before each step, or None if
        no call is needed.

        ``step`` is the length of a step; ``symmetric`` states whether steps are symmetric in time.
        """

    def totals(self) -> list[float]:
        """Return the values of :class:`bristle_sim.scene.contact.Sums` of all contacts in one list, after the last step."""

    def fails(self, totals: Sequence[float]) -> bool:
        """Return whether a contact would have to pull to stay closed."""


class IntervalResult(NamedTuple):
    """Result of integrating over an interval.

    Attributes:
        state: the state at the interval's end.
        accelerations: the links' angular accelerations at the interval's end.
        totals: the values of :class:`bristle_sim.scene.contact.Sums` of all contacts in one list;
            empty where the contact forces are unknown.
        error: estimated error, the larger one of the error of angles (rad) and the error of rates,
            rad per time unit; 0 without an estimate.
        failed: whether a contact would have had to pull; the rest of the result is then
            meaningless.
        errors: estimated error after each repetition of the interval, by the repetition's index.
        middle: the state at half the interval; None if the integrator does not compute it.
    """

    state: State
    accelerations: tuple[float, ...] = ()
    totals: tuple[float, ...] = ()
    error: float = 0.0
    failed: bool = False
    errors: Mapping[int, float] = MappingProxyType({})
    middle: State | None = None

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


class Repetitions:
    """Numbers of steps with which an interval is repeated, and the weights that extrapolate the
    results.

    ``costs``, ``weights``, ``first_order``, ``differences`` and ``noise`` have one entry for each
    repetition; the entry holds for the results of this and all earlier repetitions.

    Attributes:
        counts: number of steps of each repetition.
        power: power p of the step h; the error of a result is a polynomial in h^p.
        least_rows: number of repetitions at which the error is first estimated.
        costs: total cost, in engine steps.
        weights: weights for results whose error is a polynomial in h^p.
        first_order: weights for results whose error is a polynomial in h.
        differences: weights of the error estimate, which is the extrapolated result minus the
            result extrapolated without the first repetition.
        noise: rounding error of an extrapolated angle, rad; it grows with every repetition.
    """

    def __init__(self, *counts: int, power: int = 1) -> None:
        """Compute all weights from the numbers of steps, which must be ascending."""
        rows = range(1, len(counts) + 1)
        self.counts = counts
        self.power = power
        self.least_rows = 3 if power > 1 else 4
        self.costs = [PLACING_COST * row + sum(counts[:row]) for row in rows]
        self.first_order = [lagrange_weights(counts[:row]) for row in rows]
        self.weights = [lagrange_weights(counts[:row], power) for row in rows]
        without = [(0.0, *lagrange_weights(counts[1:row], power)) for row in rows]
        both = zip(self.weights, without, strict=True)
        self.differences = [tuple(a - b for a, b in zip(*each, strict=True)) for each in both]
        self.noise = [ANGLE_ROUNDING * sum(map(abs, weights)) for weights in self.weights]


def lagrange_weights(counts: tuple[int, ...], power: int = 1) -> tuple[float, ...]:
    """Return the weights that extrapolate the results of repetitions to the step zero.

    They are the values at h = 0 of Lagrange's polynomials in h^power, with the steps h = 1/n for
    the numbers of steps n in ``counts``.
    """
    return tuple(
        math.prod(n**power / (n**power - other**power) for other in counts if other != n)
        for n in counts
    )


HALVED = Repetitions(
    4, 6, 8, 10, 12, 14, 18, 22, 26, 30, 34, 40
)  # even numbers of steps, so that the state in the middle of the interval is computed too
CLOSE = Repetitions(4, 5, 6, 7, 8, 10, 12, 14, 16, 18, 20, 24)  # fewest steps for a given order
WIDE = Repetitions(
    4, 6, 8, 12, 16, 24, 32, 48
)  # small weights, for spring forces with the rounding error of a small penetration
EVEN = Repetitions(
    2, 4, 6, 8, 10, 12, 16, 20, 24, power=2
)  # for time-symmetric steps; the error of odd numbers of steps is a different polynomial
LEAST_NOISE = HALVED.noise[3]  # least error of an interval, limited by rounding
CUT_SHORT = 0.25
"""Least length, over the proposed length, of an interval that may shorten the next proposal. An
interval cut shorter, by an event for instance, leaves the proposal unchanged. The next interval is
at most four times as long, which leads back from this fraction to the proposed length."""


class Extrapolation:
    """Integrates intervals without events by engine steps, extrapolated to the step zero.

    Args:
        tolerance: largest absolute error of an interval, in scene units.
        repetitions: numbers of steps of the repetitions, except for time-symmetric steps and for
            plain steps without contacts, which have their own.
        longest: longest interval that is proposed. The first interval may be longer, and so may an
            interval that is extended by a tenth to avoid a short remainder.
        damped_step: longest step whose error estimate is trusted under damping.

    Attributes:
        noise: largest absolute error of an interval, at least its rounding error.
        length: length proposed for the next interval.
        table: numbers of steps of the last interval.
    """

    def __init__(
        self,
        tolerance: float,
        repetitions: Repetitions = CLOSE,
        longest: float = math.inf,
        damped_step: float = math.inf,
    ) -> None:
        """Propose a first interval in which the links turn by about one radian."""
        self._given = repetitions
        self.table = repetitions
        self.longest = longest
        self.damped_step = damped_step
        self.length = 1.5
        self.noise = max(tolerance, repetitions.noise[3])

    def propose(self, remaining: float) -> float:
        """Return the length of the next interval, shortened so that it divides the remaining time
        evenly.
        """
        return remaining / max(1, math.ceil(remaining / self.length - 0.1))

    def advance(
        self, scene: Scene, state: State, duration: float, load: Load | None = None
    ) -> IntervalResult:
        """Integrate over an interval; repeat it with finer steps until the error estimate is within
        the tolerance.

        A repetition is left out if its rounding error would exceed the tolerance.
        """
        symmetric = scene.mechanism.jointed and (load is None or load.symmetric)
        halved = load is None and not symmetric
        table = self.table = EVEN if symmetric else HALVED if halved else self._given
        known: dict[int, float] = {}
        links = len(scene.links)
        results: list[list[float]] = []
        halves: list[list[float]] = []
        error = math.inf
        failed = False
        for row, count in enumerate(table.counts[: bisect(table.noise, self.noise)]):
            step = duration / count
            scene.place(state, -0.5 * step if symmetric else 0.0)
            act = None if load is None else load.begin(step, symmetric=symmetric)
            values = scene.step(
                step, count, act, symmetric=symmetric, middle=halves if halved else None
            )
            results.append(values)
            if load is not None:
                values += load.totals()
                failed = load.fails(values[3 * links :])
                if failed:
                    break
            if row + 1 >= table.least_rows:
                columns = [*zip(*results, strict=True)]
                differences = table.differences[row]
                errors = [abs(sum(map(mul, differences, each))) for each in columns[: 2 * links]]
                # With a NaN among them, the largest of numbers depends on their order.
                error = known[row] = max(errors) if sum(errors) < math.inf else math.inf
                if error <= self.noise and step <= self.damped_step:
                    if self.damped_step < math.inf:
                        error = min(max(error, LEAST_GAIN * known.get(row - 1, 0.0)), self.noise)
                    break
        middle = None
        if failed:
            error = math.inf
        else:
            weights = table.weights[len(results) - 1]
            others = table.first_order[len(results) - 1]
            values = [sum(map(mul, weights, each)) for each in columns[: 2 * links]]
            values += [sum(map(mul, others, each)) for each in columns[2 * links :]]
            if error == math.inf:
                # The engine turns a body at its old angle to the place that is set; a second
                # placing is free of NaN.
                scene.put(None)
            if halved:
                best = [sum(map(mul, weights, each)) for each in zip(*halves, strict=True)]
                middle = scene.state_at(state.time + 0.5 * duration, best)
        return IntervalResult(
            state=scene.state_at(state.time + duration, values),
            accelerations=tuple(values[2 * links : 3 * links]),
            totals=tuple(values[3 * links :]),
            error=error,
            failed=failed,
            errors=known,
            middle=middle,
        )

    def accepts(self, result: IntervalResult, duration: float) -> bool:
        """Return whether a result's estimated error is within the tolerance, and set the length of
        the next interval from the error.

        The length is chosen for the least cost per simulated time. The cost of each number of
        repetitions follows from its error estimate in ``result``. An accepted interval that was
        much shorter than proposed does not shorten the next proposal.
        """
        table = self.table
        limit = self.noise
        lengths = {}
        prices = {}
        for row, error in result.errors.items():
            least = error if error > 1e-3 * limit else 1e-3 * limit
            change = 0.9 * (0.5 * limit / least) ** (1.0 / (table.power * row + 1))
            length = duration * (4.0 if change > 4.0 else 0.1 if change < 0.1 else change)
            lengths[row] = length = length if length < self.longest else self.longest
            prices[row] = table.costs[row] / length
        best = min(prices, key=prices.__getitem__)
        length = lengths[best]
        more = best == max(prices) and best + 1 < bisect(table.noise, limit)
        if more and prices[best] < 0.9 * prices.get(best - 1, math.inf):
            # Still getting cheaper: one more repetition, with the interval that would keep the price.
            length *= table.costs[best + 1] / table.costs[best]
        accurate = result.error <= limit
        if not accurate:
            length = min(length, 0.5 * duration)
        elif duration < CUT_SHORT * self.length:
            length = max(length, self.length)
        self.length = length
        return accurate
