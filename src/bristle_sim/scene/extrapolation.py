"""The integrator of an interval without events, by engine steps extrapolated to zero step.

The engine moves positions by the old velocities and then changes the velocities, so its error over an interval without
events is smooth in the step h, of first order. Repeating the interval with n = 4, 5, 6, 7 ... steps and extrapolating the
results to h = 0 (Richardson; Bulirsch and Stoer 1966) removes one power of h per repetition. The difference between
the last two extrapolates estimates the error; step and number of repetitions follow from it as in Hairer, Norsett and
Wanner, *Solving Ordinary Differential Equations I*, sec. II.9.
"""

from __future__ import annotations

import math
from operator import mul

from bristle_sim.scene.build import Scene
from bristle_sim.scene.interval import IntervalResult, Load, state_of
from bristle_sim.scene.mechanism import State

PLACING_COST = 6.0
"""Cost of placing and reading the bodies once, in engine steps; the choice of the interval uses
it."""

# rounding of an angle of some radians, rad, which the weights of extrapolation amplify
ANGLE_ROUNDING = 4e-16
LEAST_GAIN = 0.1  # least ratio of two repetitions' errors under damping, where a single estimate may be too small


class Repetitions:
    """Numbers of steps in which an interval is repeated, and the weights that extrapolate the
    results.

    Every attribute but ``least_rows`` has one entry for each repetition, for the results up to it.

    Attributes:
        least_rows: number of repetitions before the first error estimate.
        costs: cost of the repetitions, in engine steps.
        weights: weights for results whose error is a polynomial in the step to the given ``power``.
        first_order: weights for results whose error is a polynomial in the step itself.
        differences: weights of the extrapolate less the extrapolate without the first result; they
            give the error estimate.
        noise: rounding of the extrapolate that the rounding of an angle causes, rad.
    """

    def __init__(self, *counts: int, power: int = 1) -> None:
        """Compute all weights from ascending numbers of steps."""
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
    """Return the weights that extrapolate results with these numbers of steps to zero step.

    They are the values at h = 0 of Lagrange's polynomials in h^power, h = 1/n.
    """
    return tuple(
        math.prod(n**power / (n**power - other**power) for other in counts if other != n)
        for n in counts
    )


HALVED = Repetitions(
    4, 6, 8, 10, 12, 14, 18, 22, 26, 30, 34, 40
)  # even, so that the motion is known in the middle too
CLOSE = Repetitions(4, 5, 6, 7, 8, 10, 12, 14, 16, 18, 20, 24)  # few steps for an order
WIDE = Repetitions(
    4, 6, 8, 12, 16, 24, 32, 48
)  # small weights, for forces with the rounding of a small penetration
EVEN = Repetitions(
    2, 4, 6, 8, 10, 12, 16, 20, 24, power=2
)  # symmetric in time; odd numbers have an error of their own
LEAST_NOISE = HALVED.noise[3]  # least error of an interval that rounding permits
CUT_SHORT = 0.25
"""Least fraction of the proposed interval that a shorter one must reach to shorten the next
proposal: an interval grows by a factor of four at most, which leads back from here."""


class Extrapolation:
    """Integrate an interval by engine steps extrapolated to zero step, to ``tolerance * scale``.

    Args:
        tolerance: error permitted in an interval, relative.
        scale: scale of the motion.
        repetitions: numbers of steps, for loads and steps that need no others.
        longest: bound of proposed intervals. The first interval, and one extended by a tenth to
            avoid a short remainder, may be longer.
        damped_step: coarsest step whose error estimate is trusted under damping.

    Attributes:
        noise: error that an interval may have.
    """

    def __init__(
        self,
        tolerance: float,
        scale: float = 1.0,
        repetitions: Repetitions = CLOSE,
        longest: float = math.inf,
        damped_step: float = math.inf,
    ) -> None:
        """Start with an interval of about a radian of the scene's motion."""
        self._given = repetitions
        self.longest = longest
        self.damped_step = damped_step
        self.length = 1.5
        self.noise = max(tolerance * scale, repetitions.noise[3])
        self._use(repetitions)

    def _use(self, repetitions: Repetitions) -> None:
        """Repeat intervals with these numbers of steps from now on, as far as their rounding is
        below the tolerance.
        """
        self.repetitions = repetitions
        self.most_rows = sum(1 for noise in repetitions.noise if noise <= self.noise)

    def propose(self, remaining: float) -> float:
        """Return the interval of least cost per time, shortened so that it divides the remaining
        time evenly.
        """
        return remaining / max(1, math.ceil(remaining / self.length - 0.1))

    def advance(
        self, scene: Scene, state: State, duration: float, load: Load | None = None
    ) -> IntervalResult:
        """Integrate over an interval by finer and finer steps until the error estimate is within
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
        """Return whether the estimate is within the tolerance; in either case it determines the
        next interval.

        An accepted interval cut far short of the proposed one does not shorten the next proposal.
        """
        proposed = self.length
        self.length = self.next_length(result, duration)
        accurate = result.error <= self.noise
        if accurate and duration < CUT_SHORT * proposed:
            self.length = max(self.length, proposed)
        return accurate

    def next_length(self, result: IntervalResult, duration: float) -> float:
        """Return the length of the next interval: that of least cost per time by the error
        estimates so far.
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
        """Return whether the state in the middle of an interval is computed too."""
        return scene.engine.take_symmetric is None and load is None
