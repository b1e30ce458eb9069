"""The times in an integration step at which a function changes its sign.

The search also finds two changes of sign in quick succession. On a short interval a smooth function
equals its Chebyshev series up to rounding error, and a companion matrix gives all roots of the
series at once. The roots of the series only divide the interval into intervals of one sign. The
root of the function itself is then bracketed and located. If 17 samples do not resolve the function
(a kink, a jump), the interval is halved.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.polynomial import chebyshev
from scipy.optimize import brentq

from bristle_sim.arrays import Array

Function = Callable[[Array], Array]  # times of shape (n,) -> values of shape (n,)

# Degree of the Chebyshev series on one interval, its points in [-1, 1], and the matrix that turns
# values at the points into coefficients.
DEGREE = 16
NODES = chebyshev.chebpts1(DEGREE + 1)
WEIGHTS = np.linalg.inv(chebyshev.chebvander(NODES, DEGREE))
# Largest number of intervals that are examined in a step: fifty halvings confine a kink or a jump
# to rounding error.
MOST_PIECES = 100
# Ratio of a series' constant coefficient to the sum of its other coefficients above which the
# function has one sign. For an exact series a ratio of 1 suffices. The series of a function with a
# kink has an error, which is smaller than that sum.
FAR = 2.0
# Size of the last coefficients of a series, as a fraction of the function's size, below which they
# are rounding error.
SERIES_ROUNDING = 1e-13


def nodes(start: float, end: float) -> Array:
    """Return the 17 Chebyshev points of an interval in ascending order."""
    return np.asarray(0.5 * (start + end) + 0.5 * (end - start) * NODES)


def crossings(
    function: Function,
    start: float,
    end: float,
    resolution: float,
    before: int = 0,
    values: Array | None = None,
) -> list[tuple[float, int]]:
    """Return the times at which a function changes its sign in [start, end], ascending.

    A value of magnitude below ``resolution`` counts as having the sign of the value before it.

    Args:
        function: the function of time.
        start, end: ends of the interval, s.
        resolution: magnitude below which a value of the function is rounding error.
        before: sign of the function before the interval. With 0 the first sign in the interval does
            not count as a change.
        values: values of the function at the times of ``nodes``; by default they are computed.

    Returns:
        Pairs of the time (s) and the sign of the function after it, +1 or -1.
    """
    edges = {start, end}
    pieces = [(start, end)]
    for left, right in pieces:  # the list grows
        values = function(nodes(left, right)) if values is None else values
        series = WEIGHTS @ values
        sizes = np.abs(series)
        size = np.abs(values).max()
        constant = sizes[0] > FAR * sizes[1:].sum()
        resolved = constant or sizes[-3:].max() <= max(resolution, SERIES_ROUNDING * size)
        if len(pieces) == 1 and (size <= resolution or (constant and series[0] * before >= 0.0)):
            return []
        middle = 0.5 * (left + right)
        if not resolved and len(pieces) < MOST_PIECES:
            pieces += [(left, middle), (middle, right)]
        elif not constant:
            roots = chebyshev.chebroots(chebyshev.chebtrim(series, np.finfo(float).eps * size))
            # A double root splits into a pair that is off the real axis by the root of rounding.
            inner = roots.real[(np.abs(roots.imag) < 1e-6) & (np.abs(roots.real) < 1.0)]
            edges.update((middle + 0.5 * (right - left) * inner).tolist())
        edges.add(left)
        values = None
    ordered = np.array(sorted(edges))
    probes = np.array([start, *(0.5 * (ordered[1:] + ordered[:-1])), end])
    values = function(probes)
    found = []
    sense = before
    last = 0
    for probe in np.flatnonzero(np.abs(values) > resolution).tolist():
        after = int(np.sign(values[probe]))
        if sense * after < 0:
            time = probes[last]
            if values[last] * after < 0.0:  # otherwise rounding has moved the root to this time
                time = brentq(
                    lambda time: float(function(np.array([time]))[0]),
                    time,
                    probes[probe],
                    xtol=1e-300,
                    maxiter=400,
                )
            found.append((float(time), after))
        sense = after
        last = probe
    return found
