"""Roots of many functions at once, within brackets, with derivatives or without.

T. R. Chandrupatla, *A new hybrid quadratic/bisection algorithm for finding the zero of a nonlinear
function without using derivatives*, Advances in Engineering Software 28 (1997) 145-149.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.passes.state import Chosen

MOST_EVALUATIONS = 120
"""Largest number of evaluations for a root: twice that of bisection from a bracket of 1 rad to
rounding."""

ROOT_ROUNDING = 5e-16
"""Half-width of the last bracket of a root, rad: rounding of hub angles of some radians."""

Function = Callable[[Array], Array]


def root(
    function_of: Callable[[Chosen], Function],
    ends: tuple[Array, Array],
    values: tuple[Array, Array],
    rounding: float = ROOT_ROUNDING,
) -> Array:
    """Return a root in each bracket, without derivatives.

    Args:
        function_of: function that returns, for the numbers of some brackets, the function whose
            roots are in them.
        ends: lower and upper ends of the brackets.
        values: values of the function at the ends, of opposite signs.
        rounding: half width of a bracket at which its root is found.
    """
    found = np.empty(ends[0].shape)
    if not found.size:
        return found
    numbers = np.arange(found.size)
    function = function_of(numbers)
    state = np.array(
        [*ends, ends[0], *values, values[0]]
    )  # a, b, c and the values of the function at these places
    fraction = np.full(found.shape, 0.5)
    for _ in range(MOST_EVALUATIONS):
        a, b, _, f_a, f_b, _ = state
        place = b + fraction * (a - b)
        value = function(place)
        state = np.where(
            (value > 0.0) == (f_b > 0.0),
            [a, place, b, f_a, value, f_b],
            [b, place, a, f_b, value, f_a],
        )
        width = np.abs(state[0] - state[1])
        going = (width > 2.0 * rounding) & (value != 0.0)
        found[numbers] = place
        left = np.count_nonzero(going)
        if not left:
            break
        if 2 * left < numbers.size:
            numbers = numbers[going]
            state = state[:, going]
            width = width[going]
            function = function_of(numbers)
        least = np.minimum(rounding / np.maximum(width, rounding), 0.5)
        fraction = np.clip(_fraction(*state), least, 1.0 - least)
    return found


def _fraction(a: Array, b: Array, c: Array, f_a: Array, f_b: Array, f_c: Array) -> Array:
    """Return the next place as a fraction of the bracket from b to a.

    It is found by inverse quadratic interpolation where that is safe; otherwise it is the middle.
    """
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        xi = (b - a) / (c - a)
        phi = (f_b - f_a) / (f_c - f_a)
        safe = (phi * phi < xi) & ((1.0 - phi) ** 2 < 1.0 - xi)
        quadratic = (f_b / (f_a - f_b)) * (f_c / (f_a - f_c)) + (c - b) / (a - b) * (
            f_b / (f_c - f_b)
        ) * (f_a / (f_c - f_a))
    return np.where(safe & np.isfinite(quadratic), quadratic, 0.5)


LAST_STEP = 1e-9
"""Step of Newton's method, rad, after which the next one is below rounding."""

Sloped = Callable[[Array], tuple[Array, Array]]


def newton_root(
    function_of: Callable[[Chosen], Sloped],
    ends: tuple[Array, Array],
    values: tuple[Array, Array],
    slopes: tuple[Array, Array],
) -> Array:
    """Return a root in each bracket by Newton's method, halving the bracket where a step leaves it.

    It begins at the root of the cubic through the inverse function's values and slopes at the ends.

    Args:
        function_of: function that returns, for the numbers of some brackets, the function whose
            roots are in them; it returns values and slopes.
        ends: lower and upper ends of the brackets.
        values: values of the function at the ends, of opposite signs.
        slopes: derivatives of the function at the ends.
    """
    found = np.empty(ends[0].shape)
    numbers = np.arange(found.size)
    function = function_of(numbers)
    low, high = ends
    rises = values[1] > 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        rise = values[1] - values[0]
        part = -values[0] / rise
        bend = rise * ((1.0 - part) / slopes[0] - part / slopes[1])
        place = low + part * part * (3.0 - 2.0 * part) * (high - low) + part * (1.0 - part) * bend
        for _ in range(MOST_EVALUATIONS):
            place = np.where((place > low) & (place < high), place, 0.5 * (low + high))
            value, slope = function(place)
            above = (value > 0.0) == rises
            low = np.where(above, low, place)
            high = np.where(above, place, high)
            step = value / slope
            found[numbers] = np.clip(place - step, low, high)
            going = (
                ~(np.abs(step) < LAST_STEP) & (high - low > 2.0 * ROOT_ROUNDING) & (value != 0.0)
            )
            place = place - step
            left = np.count_nonzero(going)
            if not left:
                break
            if 2 * left < numbers.size:
                numbers, place, low, high, rises = (
                    each[going] for each in (numbers, place, low, high, rises)
                )
                function = function_of(numbers)
    return found
