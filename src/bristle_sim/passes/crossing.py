"""Roots of many functions at once, each within a bracket, by Newton's method, or by the secant
method where derivatives are unknown.
"""

from __future__ import annotations

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.passes.motion import Function

MOST_EVALUATIONS = 120  # largest number of evaluations of the function for one root

MOST_STEPS = 10  # number of evaluations after which every second evaluation halves the bracket

ROOT_ERROR = 1e-13
"""Largest error of a root, relative to the width of its bracket.

The estimate of this relative error is the product of the last two steps towards the root, divided
by the square of the bracket's width. Newton's method takes the square of the last step instead."""

LAST_MOVE = 1e-3
"""Largest length of either of the last two steps, relative to the bracket's width.

After a longer step of the secant method the value at the step's start may be so large that the next
step is tiny although the root is far."""

ROOT_ROUNDING = 5e-16
"""Half-width of the narrowest bracket of a root, rad: the rounding error of hub angles of some
radians."""


def root(
    function: Function,
    ends: tuple[Array, Array],
    high_value: Array,
    start: Array,
    error: float = ROOT_ERROR,
) -> Array:
    """Return a root in each bracket.

    An estimate that leaves its bracket is replaced by the bracket's midpoint. If some roots are not
    found after a few evaluations, every second evaluation halves their brackets. The number of
    evaluations is therefore bounded.

    Args:
        function: function whose roots are sought. Its first argument holds one place in each of
            several brackets, its second argument the indices of these brackets. The function
            returns its values at the places, and its derivatives there, or None if the derivatives
            are unknown.
        ends: lower and upper ends of the brackets.
        high_value: values of the function at the upper ends. The values at the lower ends must have
            the opposite sign.
        start: estimates of the roots.
        error: largest error of a root, relative to the width of its bracket.
    """
    numbers = np.arange(start.size)
    going = np.ones(start.size, dtype=bool)
    found = start.copy()
    low, high = ends
    width = high - low
    rises = high_value > 0.0
    place, last, last_value = start, high, high_value
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for count in range(MOST_EVALUATIONS):
            inside = (place > low) & (place < high)
            if count > MOST_STEPS and count % 2:
                inside[:] = False
            place = np.where(inside, place, 0.5 * (low + high))
            value, slope = function(place, numbers)
            secant = place - last
            step = value / ((value - last_value) / secant if slope is None else slope)
            if slope is not None:
                secant = step
            last, last_value = place, value
            above = (value > 0.0) == rises
            low = np.where(above, low, place)
            high = np.where(above, place, high)
            place = place - step
            found[numbers[going]] = np.minimum(np.maximum(place, low), high)[going]
            close = np.abs(step * secant) < error * width**2
            close &= np.maximum(np.abs(step), np.abs(secant)) < LAST_MOVE * width
            going &= ~close & (high - low > 2.0 * ROOT_ROUNDING) & (value != 0.0)
            left = np.count_nonzero(going)
            if not left:
                break
            if 2 * left < numbers.size:
                numbers, rises = numbers[going], rises[going]
                place, low, high, last, last_value, width = (
                    each[going] for each in (place, low, high, last, last_value, width)
                )
                going = going[going]
    return found
