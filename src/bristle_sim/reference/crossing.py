"""Where a function of time changes sign, without stepping over a short dip.

A smooth function on a short interval is its Chebyshev series to rounding, and a companion matrix gives all the roots of the
series at once. Where 17 points do not resolve the function (a kink, a jump) the interval is halved. The roots only separate
intervals of one sign; the crossing itself is bracketed and located on the function.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.polynomial import chebyshev
from scipy.optimize import brentq

from bristle_sim.arrays import Array

Function = Callable[[Array], Array]  # times of shape (n,) -> values of shape (n,)

DEGREE = 16
NODES = chebyshev.chebpts1(DEGREE + 1)
WEIGHTS = 2.0 / (DEGREE + 1) * chebyshev.chebvander(NODES, DEGREE).T
WEIGHTS[0] *= 0.5

DEEPEST = 24  # halvings at most: a jump is confined to 6e-8 of the interval before the bracketing search takes over
MOST_PIECES = 400  # pieces at most: a kink or a jump takes fifty; a function that is nothing but rounding all
ROUNDING = 1e-13  # the series' last coefficients are rounding below this fraction of the function's size


def nodes(start: float, end: float) -> Array:
    """Return the 17 times of an interval, ascending, at which a series takes a function's values."""
    return np.asarray(0.5 * (start + end) + 0.5 * (end - start) * NODES)


def of_one_sign(values: Array, resolution: float) -> int:
    """Return the sign that a function has on a whole interval, from its values at the nodes; 0 if it may change."""
    series = WEIGHTS @ values
    certain = abs(series[0]) > np.abs(series[1:]).sum() and _resolved(series, values, resolution)
    return int(np.sign(series[0])) if certain else 0


def _resolved(series: Array, values: Array, resolution: float) -> bool:
    """Whether the last coefficients are rounding, so that the series is the function."""
    return bool(np.abs(series[-3:]).max() <= max(resolution, ROUNDING * np.abs(values).max()))


def crossings(function: Function, start: float, end: float, resolution: float) -> list[tuple[float, int]]:
    """Return every change of sign in [start, end], s, in order: its time, s, and +1 to positive or -1 to negative.

    Values of the function that are smaller than ``resolution`` mean nothing.
    """
    edges = {start, end}
    waiting, done = [(start, end, DEEPEST)], 0
    while waiting:
        left, right, depth = waiting.pop()
        values = function(nodes(left, right))
        series = WEIGHTS @ values
        if depth and done + len(waiting) < MOST_PIECES and not _resolved(series, values, resolution):
            middle = 0.5 * (left + right)
            waiting += [(middle, right, depth - 1), (left, middle, depth - 1)]
        else:
            done += 1
            edges.update((left, *_roots(series, left, right)))
    ordered = np.array(sorted(edges))
    probes = np.concatenate(([start], 0.5 * (ordered[1:] + ordered[:-1]), [end]))
    return list(_sign_changes(function, probes, function(probes)))


def _roots(series: Array, left: float, right: float) -> list[float]:
    """Return the real roots of a series in its interval."""
    sizes = np.abs(series)
    if sizes[0] > sizes[1:].sum() or not sizes.any():
        return []
    found = chebyshev.chebroots(chebyshev.chebtrim(series, np.finfo(float).eps * sizes.max()))
    # A double root splits into a pair that is off the real axis by the root of rounding.
    real = found.real[(np.abs(found.imag) < 1e-6) & (np.abs(found.real) < 1.0)]
    return [float(each) for each in 0.5 * (left + right) + 0.5 * (right - left) * real]


def _sign_changes(function: Function, probes: Array, values: Array) -> Iterator[tuple[float, int]]:
    """Locate the root in each pair of neighbours of opposite sign; a zero takes the sign that went before."""
    sign, last = 0.0, probes[0]
    for probe, value in zip(probes, values, strict=True):
        if value and sign * value < 0.0:
            at = brentq(lambda time: float(function(np.array([time]))[0]), last, probe, xtol=1e-300, maxiter=400)
            yield float(at), int(np.sign(value))
        sign, last = (np.sign(value) if value else sign), probe
