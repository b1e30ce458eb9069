"""Extrapolation of engine steps to zero step, with an estimate of the error.

The engine moves positions by the old velocities and then changes the velocities, so its error over an interval without
events is smooth in the step h, of first order. Repeating the interval with n = 4, 5, 6, 7 ... steps and extrapolating the
results to h = 0 (Richardson; Bulirsch and Stoer 1966) removes one power of h per repetition. The difference between
the last two extrapolates estimates the error; step and number of repetitions follow from it as in Hairer, Norsett and
Wanner, *Solving Ordinary Differential Equations I*, sec. II.9.
"""

from __future__ import annotations

import math
from collections import deque
from operator import mul

from bristle_sim.scene.build import Scene
from bristle_sim.scene.integrate.stepping import Advance, Load, unpack
from bristle_sim.scene.mechanism import State

RUN_OVERHEAD = 6.0
"""Cost of placing and reading the bodies once, in engine steps; it only steers the choice of the step."""

ROUNDING = 4e-16
"""Rounding of an angle of some radians; extrapolation weights amplify it."""


class Repetitions:
    """Numbers of steps in which an interval is repeated, with what extrapolating their results takes.

    Attributes:
        counts: steps in each repetition.
        costs: of the repetitions up to each one, in engine steps.
        weights: that extrapolate the results up to each one to zero step.
        first_order: such weights for results whose error has all powers of the step.
        differences: the last extrapolate less the one without the first result, an estimate of the latter's error.
        power: of the step in which the error is a polynomial.
        noise: rounding that the weights make of that of an angle.
    """

    def __init__(self, *counts: int, power: int = 1) -> None:
        """Compute all from ascending numbers of steps."""
        rows = range(len(counts))
        self.counts, self.power = counts, power
        self.costs = [RUN_OVERHEAD * (row + 1) + sum(counts[: row + 1]) for row in rows]
        self.first_order = [lagrange_weights(counts[: row + 1]) for row in rows]
        self.weights = self.first_order if power == 1 else [lagrange_weights(counts[: row + 1], power) for row in rows]
        self.differences = [
            tuple(
                a - b
                for a, b in zip(self.weights[row], (0.0, *lagrange_weights(counts[1 : row + 1], power)), strict=True)
            )
            for row in rows
        ]
        self.noise = [ROUNDING * sum(map(abs, weights)) for weights in self.weights]


def lagrange_weights(counts: tuple[int, ...], power: int = 1) -> tuple[float, ...]:
    """Return the weights that extrapolate ``counts`` steps to zero step: Lagrange's polynomial in h^power, h = 1/n, at 0."""
    return tuple(math.prod(n**power / (n**power - other**power) for other in counts if other != n) for n in counts)


CLOSE = Repetitions(4, 5, 6, 7, 8, 10, 12, 14, 16, 18, 20, 24)
"""Few steps for an order, for motion that is computed to rounding."""

WIDE = Repetitions(4, 6, 8, 12, 16, 24, 32, 48)
"""Small weights, for stiff contacts whose forces carry the rounding of a small penetration."""

EVEN = Repetitions(2, 4, 6, 8, 10, 12, 16, 20, 24, power=2)
"""Steps symmetric in time; an odd number of them has an error of its own."""

LEAST_ROWS = 4
"""Repetitions to begin with."""

LEAST_NOISE = CLOSE.noise[LEAST_ROWS - 1]
"""Rounding of an interval, of angles in rad and rates per time unit; no interval is known to be more accurate."""


CUT_SHORT = 0.25
"""Fraction of a proposed interval; growth by a factor of four at most leads back from here."""


class Extrapolation:
    """Engine steps extrapolated to zero step, to a tolerance for each interval.

    Args:
        tolerance: of the error of an interval, relative to ``scale``.
        scale: size of the motion: angles in rad and rates per time unit.
        repetitions: in how many steps an interval is repeated.
        longest: bounds the intervals that follow from an error estimate, so that more accuracy than they need is not paid for;
            the first one, and one that is stretched by a tenth to save a stub, may be longer.
    """

    def __init__(
        self, tolerance: float, scale: float = 1.0, repetitions: Repetitions = CLOSE, longest: float = math.inf
    ) -> None:
        """Start with an interval of about a radian of the scene's motion."""
        self._given = repetitions
        self.longest = longest
        self.limit = max(tolerance * scale, repetitions.noise[LEAST_ROWS - 1])
        self._use(repetitions)
        self.length = 1.5

    def _use(self, repetitions: Repetitions) -> None:
        """Repeat intervals with these numbers of steps from now on."""
        self.repetitions = repetitions
        # More repetitions amplify rounding beyond the tolerance.
        self.most_rows = sum(1 for noise in repetitions.noise if noise <= self.limit)
        self.rows = LEAST_ROWS

    @property
    def noise(self) -> float:
        """The error that an interval may have."""
        return self.limit

    def propose(self, remaining: float) -> float:
        """Return the interval that costs least per time; what is left is cut evenly rather than into a stub."""
        return remaining / max(1, math.ceil(remaining / self.length - 0.1))

    def advance(self, scene: Scene, state: State, duration: float, load: Load | None = None) -> Advance:
        """Repeat the interval with finer steps until the estimate is within the tolerance."""
        symmetric = scene.step_symmetrically if load is None or load.symmetric else None
        take = symmetric or scene.step
        if (table := EVEN if symmetric else self._given) is not self.repetitions:
            self._use(table)
        known: dict[int, float] = {}
        size, rows = len(scene.links), self.rows
        columns: list[list[float]] = []
        error = math.inf
        for row, count in enumerate(table.counts[: self.most_rows]):
            step = duration / count
            scene.place(state, -0.5 * step if symmetric else 0.0)
            values = take(step, count) if load is None else take(step, count, load.begin(step)) + load.totals()
            if load is not None and load.fails(values[3 * size :]):
                return unpack(scene, state, duration, values, math.inf, failed=True, errors=known)
            if row == 0:
                columns = [[] for _ in values]
                motion = columns[: 2 * size]
            deque(map(list.append, columns, values), 0)
            if row + 2 >= rows and row:
                differences = table.differences[row]
                errors = [abs(sum(map(mul, differences, column))) for column in motion]
                # The largest of numbers one of which is NaN depends on their order.
                error = known[row] = max(errors) if sum(errors) < math.inf else math.inf
                if row + 1 >= rows and error <= self.limit:
                    break
        weights, others = table.weights[len(columns[0]) - 1], table.first_order[len(columns[0]) - 1]
        best = [sum(map(mul, weights, column)) for column in motion]
        best += [sum(map(mul, others, column)) for column in columns[2 * size :]]
        return unpack(scene, state, duration, best, error, errors=known)

    def accepts(self, result: Advance, duration: float) -> bool:
        """Whether the estimate is within the tolerance; the next interval follows what was learnt either way.

        An interval that was cut far short of the proposed one tells nothing against that.
        """
        proposed = self.length
        self.length, self.rows = self.learnt(result, duration)
        accurate = result.error <= self.limit
        if accurate and duration < CUT_SHORT * proposed:
            self.length = max(self.length, proposed)
        return accurate

    def learnt(self, result: Advance, duration: float) -> tuple[float, int]:
        """Return the length and the repetitions of the next interval that cost least per time, by the estimates so far."""
        costs, limit, longest = self.repetitions.costs, self.limit, self.longest
        power, lengths, prices = self.repetitions.power, {}, {}
        least = 1e-3 * limit
        for row, error in result.errors.items():
            change = 0.9 * (0.5 * limit / (error if error > least else least)) ** (1.0 / (power * row + 1))
            length = duration * (4.0 if change > 4.0 else 0.1 if change < 0.1 else change)
            lengths[row] = length = length if length < longest else longest
            prices[row] = costs[row] / length
        last = max(prices)
        best = min((row for row in prices if row > 1), key=prices.__getitem__, default=last)
        length, rows = lengths[best], best + 1
        if best == last < self.most_rows - 1 and prices[best] < 0.9 * prices.get(best - 1, math.inf):
            # Still getting cheaper: one more repetition, with the interval that would keep the price.
            length *= costs[best + 1] / costs[best]
            rows += 1
        return (length if result.error <= limit else min(length, 0.5 * duration)), rows

    def begin_afresh(self) -> None:
        """Begin with few repetitions again, whose weights amplify rounding least."""
        self.rows = LEAST_ROWS

    def interpolation_error(self, start: State, end: State) -> float:
        """Return 0: an extrapolated interval is off the cubic by the cubic's own error alone."""
        del start, end
        return 0.0
