"""Roots of many functions at once, within brackets: Newton's method, or the secant method where no
slopes are known.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.passes.state import Chosen

MOST_EVALUATIONS = 120  # largest number of evaluations for a root

HALVING = 8
"""Number of evaluations after which a bracket is halved, against steps that creep along it."""

LAST_STEP = 1e-7
"""Step of Newton's method, rad, after which the error is its square: rounding."""

LAST_SECANT = 1e-4
"""Longest secant, rad, that is a tangent.

The value at the end of a longer one may be so large that the step is nothing."""

ROOT_ROUNDING = 5e-16
"""Half-width of the last bracket of a root, rad: rounding of hub angles of some radians."""

Function = Callable[[Array], tuple[Array, Array | None]]
"""Function that returns values at places, and its slopes there where they are known."""


def root(
    function_of: Callable[[Chosen], Function],
    ends: tuple[Array, Array],
    high_value: Array,
    start: Array,
) -> Array:
    """Return a root in each bracket, halving the bracket where a step leaves it.

    Args:
        function_of: function that returns, for the numbers of some brackets, the function whose
            roots are in them.
        ends: lower and upper ends of the brackets.
        high_value: values of the function at the upper ends; those at the lower ends have the
            opposite sign.
        start: estimates of the roots.
    """
    found = start.copy()
    going = np.ones(start.size, dtype=bool)
    numbers = np.arange(found.size)
    low, high = ends
    last, last_value = high, high_value
    rises = last_value > 0.0
    place = start
    function = function_of(numbers)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for count in range(1, MOST_EVALUATIONS):
            outside = ~((place > low) & (place < high))
            if count % HALVING == 0:
                outside[:] = True
            place = np.where(outside, 0.5 * (low + high), place)
            value, slope = function(place)
            secant = np.full(place.size, LAST_STEP)
            if slope is None:
                secant = np.abs(place - last)
                slope = (value - last_value) / (place - last)
                last, last_value = place, value
            above = (value > 0.0) == rises
            low = np.where(above, low, place)
            high = np.where(above, place, high)
            step = value / slope
            place = place - step
            found[numbers[going]] = np.clip(place, low, high)[going]
            # the error of a secant's step is the product of step and secant
            close = (np.abs(step) * secant < LAST_STEP**2) & (secant < LAST_SECANT)
            going &= ~close & (high - low > 2.0 * ROOT_ROUNDING) & (value != 0.0)
            left = np.count_nonzero(going)
            if not left:
                break
            if 2 * left < numbers.size:
                numbers, rises = numbers[going], rises[going]
                place, low, high, last, last_value = (
                    each[going] for each in (place, low, high, last, last_value)
                )
                going = going[going]
                function = function_of(numbers)
    return found
