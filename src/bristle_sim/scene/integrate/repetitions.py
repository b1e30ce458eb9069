"""Numbers of steps in which an interval is repeated, and the weights that extrapolate the results to zero step."""

from __future__ import annotations

import math

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
