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
from operator import mul

from bristle_sim.scene.build import Scene
from bristle_sim.scene.interval import IntervalResult, Load, state_of
from bristle_sim.scene.mechanism import State

PLACING_COST = 6.0
"""Cost of placing and reading the bodies once, in engine steps. The choice of the interval's length
weighs it against the cost of the steps."""

# rounding error of an angle of a few radians, rad; the weights of extrapolation amplify it
ANGLE_ROUNDING = 4e-16

# least ratio of the errors of two successive repetitions that is believed under damping, where a
# single estimate may be too small
LEAST_GAIN = 0.1


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
        noise: rounding error of an extrapolated angle, rad.
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
        tolerance: largest relative error of an interval.
        scale: scale of the motion, in scene units; the largest absolute error is ``tolerance *
            scale``.
        repetitions: numbers of steps of the repetitions, except for time-symmetric steps and for
            plain steps without contacts, which have their own.
        longest: longest interval that is proposed. The first interval may be longer, and so may an
            interval that is extended by a tenth to avoid a short remainder.
        damped_step: longest step whose error estimate is trusted under damping.

    Attributes:
        noise: largest absolute error of an interval.
    """

    def __init__(
        self,
        tolerance: float,
        scale: float = 1.0,
        repetitions: Repetitions = CLOSE,
        longest: float = math.inf,
        damped_step: float = math.inf,
    ) -> None:
        """Propose a first interval in which the links turn by about one radian."""
        self._given = repetitions
        self.longest = longest
        self.damped_step = damped_step
        self.length = 1.5
        self.noise = max(tolerance * scale, repetitions.noise[3])
        self._use(repetitions)

    def _use(self, repetitions: Repetitions) -> None:
        """Repeat intervals with the given numbers of steps from now on.

        A repetition is left out if its rounding error would exceed the tolerance.
        """
        self.repetitions = repetitions
        self.most_rows = sum(1 for noise in repetitions.noise if noise <= self.noise)

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
        """
        symmetric = scene.engine.take_symmetric if load is None or load.symmetric else None
        take = symmetric or scene.step
        if (
            table := EVEN if symmetric else HALVED if self.halves(scene, load) else self._given
        ) is not self.repetitions:
            self._use(table)
        known: dict[int, float] = {}
        size = len(scene.links)
        end = state.time + duration
        halved = table is HALVED
        results: list[list[float]] = []
        halves: list[list[float]] = []
        error = math.inf
        for row, count in enumerate(table.counts[: self.most_rows]):
            step = duration / count
            scene.place(state, -0.5 * step if symmetric else 0.0)
            act = None if load is None else load.begin(step)
            if halved:
                halves.append(take(step, count // 2, act)[: 2 * size])
            values = take(step, count // 2 if halved else count, act)
            if load is not None:
                values += load.totals()
                if load.fails(values[3 * size :]):
                    return IntervalResult.of(scene, end, values, math.inf, True, known)
            results.append(values)
            if row + 1 >= table.least_rows:
                columns = [*zip(*results, strict=True)]
                differences = table.differences[row]
                errors = [abs(sum(map(mul, differences, column))) for column in columns[: 2 * size]]
                # With a NaN among them, the largest of numbers depends on their order.
                error = known[row] = max(errors) if sum(errors) < math.inf else math.inf
                if error <= self.noise and step <= self.damped_step:
                    if self.damped_step < math.inf:
                        error = min(max(error, LEAST_GAIN * known.get(row - 1, 0.0)), self.noise)
                    break
        if error == math.inf:
            # The engine turns a body at its old angle to the place that is set; a second placing is free of NaN.
            scene.engine.place(None)
        weights = table.weights[len(results) - 1]
        others = table.first_order[len(results) - 1]
        best = [sum(map(mul, weights, column)) for column in columns[: 2 * size]]
        best += [sum(map(mul, others, column)) for column in columns[2 * size :]]
        found = IntervalResult.of(scene, end, best, error, False, known)
        if not halved:
            return found
        middle = [sum(map(mul, weights, column)) for column in zip(*halves, strict=True)]
        return found._replace(middle=state_of(scene, state.time + 0.5 * duration, middle))

    def accepts(self, result: IntervalResult, duration: float) -> bool:
        """Return whether a result's estimated error is within the tolerance, and set the length of
        the next interval from the error.

        An accepted interval that was much shorter than proposed does not shorten the next proposal.
        """
        proposed = self.length
        self.length = self.next_length(result, duration)
        accurate = result.error <= self.noise
        if accurate and duration < CUT_SHORT * proposed:
            self.length = max(self.length, proposed)
        return accurate

    def next_length(self, result: IntervalResult, duration: float) -> float:
        """Return the length of the next interval, chosen for the least cost per simulated time.

        The cost of each number of repetitions follows from its error estimate in ``result``.
        """
        costs = self.repetitions.costs
        limit = self.noise
        lengths = {}
        prices = {}
        for row, error in result.errors.items():
            least = error if error > 1e-3 * limit else 1e-3 * limit
            change = 0.9 * (0.5 * limit / least) ** (1.0 / (self.repetitions.power * row + 1))
            length = duration * (4.0 if change > 4.0 else 0.1 if change < 0.1 else change)
            lengths[row] = length = length if length < self.longest else self.longest
            prices[row] = costs[row] / length
        last = max(prices)
        best = min(prices, key=prices.__getitem__)
        length = lengths[best]
        if best == last < self.most_rows - 1 and prices[best] < 0.9 * prices.get(
            best - 1, math.inf
        ):
            # Still getting cheaper: one more repetition, with the interval that would keep the price.
            length *= costs[best + 1] / costs[best]
        return length if result.error <= limit else min(length, 0.5 * duration)

    def halves(self, scene: Scene, load: Load | None) -> bool:
        """Return whether the integration of an interval also computes the state in its middle."""
        return scene.engine.take_symmetric is None and load is None
