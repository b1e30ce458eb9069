"""Roots of many functions at once, each within a bracket, by Newton's method, or by the secant
method where derivatives are unknown.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.passes.state import Chosen

MOST_EVALUATIONS = 120  # upper bound of the evaluations for a root

HALVING = 8
"""Every eighth evaluation is at the middle of the bracket, as steps may creep along the bracket."""

LAST_STEP = 1e-7
"""Length of the last Newton step, rad: the remaining error is about its square, which is below
rounding error."""

LAST_SECANT = 1e-4
"""Longest secant, rad, that may give the last step.

The value at the end of a longer secant may be so large that the step is tiny far from the root."""

ROOT_ROUNDING = 5e-16
"""Half-width of the narrowest bracket of a root, rad: the rounding error of hub angles of some
radians."""

Function = Callable[[Array], tuple[Array, Array | None]]
"""Function that returns its values at given arguments, and its derivatives there, or None if it has
no derivatives."""


def root(
    function_of: Callable[[Chosen], Function],
    ends: tuple[Array, Array],
    high_value: Array,
    start: Array,
) -> Array:
    """Return a root in each bracket.

    A step that would leave its bracket is replaced by a halving of the bracket.

    Args:
        function_of: function that takes the indices of some brackets, and returns the function
            whose roots lie in these brackets.
        ends: lower and upper ends of the brackets.
        high_value: values of the function at the upper ends. The values at the lower ends must have
            the opposite sign.
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
