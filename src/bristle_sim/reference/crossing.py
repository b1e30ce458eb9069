"""Where a function of time changes sign, without stepping over a short dip.

A smooth function on a short interval *is* its Chebyshev series to rounding, and a companion matrix gives all the roots
of the series at once. Where 17 points do not resolve the function (a kink, a jump) the interval is halved. The roots
only separate intervals of one sign; the crossing itself is bracketed and located on the function.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray
from scipy.optimize import brentq

__all__ = ["Piece", "crossings", "integral", "nodes"]

Function = Callable[[Any], Any]
"""Times of shape (n,) -> values of shape (n,)."""

DEGREE = 16
NODES = chebyshev.chebpts1(DEGREE + 1)
WEIGHTS = 2.0 / (DEGREE + 1) * chebyshev.chebvander(NODES, DEGREE).T
WEIGHTS[0] *= 0.5

DEEPEST = 24
"""Halvings at most: a jump is confined to 6e-8 of the interval before the bracketing search takes over."""

MOST_PIECES = 400
"""Pieces at most: a kink or a jump takes fifty; a function that is nothing but rounding would take them all."""

ROUNDING = 1e-13
"""Share of a function's size below which the series' last coefficients count as resolved."""

ENOUGH = 1e-10
"""The same for integrals: forces near a jam are differences that keep no more digits."""


class Piece(NamedTuple):
    """A Chebyshev series on an interval."""

    start: float
    end: float
    coefficients: NDArray[np.float64]

    @classmethod
    def through(cls, values: NDArray[np.float64], start: float, end: float) -> Piece:
        """The series through a function's values at :func:`nodes`."""
        return cls(start, end, WEIGHTS @ values)

    @property
    def sign(self) -> float:
        """Sign of the whole series where its constant outweighs all else, otherwise 0."""
        first, others = self.coefficients[0], np.abs(self.coefficients[1:]).sum()
        return float(np.sign(first)) if abs(first) > others else 0.0

    def resolved(self, values: NDArray[np.float64], resolution: float, share: float = ROUNDING) -> bool:
        """Whether the last coefficients are rounding, so that the series is the function."""
        return bool(np.abs(self.coefficients[-3:]).max() <= max(resolution, share * np.abs(values).max()))

    def roots(self) -> list[float]:
        """Real roots in the interval."""
        sizes = np.abs(self.coefficients)
        if self.sign or not sizes.any():
            return []
        found = chebyshev.chebroots(chebyshev.chebtrim(self.coefficients, np.finfo(float).eps * sizes.max()))
        # A double root splits into a pair that is off the real axis by the root of rounding.
        real = found.real[(np.abs(found.imag) < 1e-6) & (np.abs(found.real) < 1.0)]
        return [float(each) for each in 0.5 * (self.start + self.end) + 0.5 * (self.end - self.start) * real]

    def integral(self) -> float:
        """Integral over the interval."""
        orders = np.arange(0, DEGREE + 1, 2)
        return float((self.end - self.start) * (self.coefficients[::2] / (1.0 - orders**2)).sum())


def nodes(start: float, end: float) -> NDArray[np.float64]:
    """The 17 times of an interval at which a series takes a function's values."""
    return np.asarray(0.5 * (start + end) + 0.5 * (end - start) * NODES)


def _pieces(function: Function, start: float, end: float, resolution: float, share: float = ROUNDING) -> list[Piece]:
    """Chebyshev series on intervals short enough that the last coefficients are rounding."""
    done: list[Piece] = []
    waiting = [(start, end, DEEPEST)]
    while waiting:
        left, right, depth = waiting.pop()
        values = function(nodes(left, right))
        piece = Piece.through(values, left, right)
        if depth and len(done) + len(waiting) < MOST_PIECES and not piece.resolved(values, resolution, share):
            middle = 0.5 * (left + right)
            waiting += [(middle, right, depth - 1), (left, middle, depth - 1)]
        else:
            done.append(piece)
    return done


def crossings(function: Function, start: float, end: float, resolution: float) -> list[tuple[float, int]]:
    """Every change of sign in [start, end], in order.

    Args:
        function: of an array of times.
        start, end: interval, s.
        resolution: size below which the function's values mean nothing.

    Returns:
        (time in s, direction): +1 from negative to positive, -1 from positive to negative.
    """
    edges = {start, end}
    for piece in _pieces(function, start, end, resolution):
        edges.update((piece.start, *piece.roots()))
    ordered = np.array(sorted(edges))
    probes = np.concatenate(([start], 0.5 * (ordered[1:] + ordered[:-1]), [end]))
    return list(_sign_changes(function, probes, np.asarray(function(probes))))


def _sign_changes(
    function: Function, probes: NDArray[np.float64], values: NDArray[np.float64]
) -> Iterator[tuple[float, int]]:
    """Locate the root in each pair of neighbours of opposite sign; a zero takes the sign that went before."""
    sign, last = 0.0, probes[0]
    for probe, value in zip(probes, values, strict=True):
        if value and sign * value < 0.0:
            yield _root(function, float(last), float(probe)), int(np.sign(value))
        sign, last = (np.sign(value) if value else sign), probe


def _root(function: Function, low: float, high: float) -> float:
    return float(brentq(lambda time: float(function(np.array([time]))[0]), low, high, xtol=1e-300, maxiter=400))


def integral(function: Function, start: float, end: float) -> float:
    """Integral of a piecewise smooth function, to 1e-10 of its size or better."""
    size = float(np.abs(function(nodes(start, end))).max())
    return sum(piece.integral() for piece in _pieces(function, start, end, ENOUGH * size, ENOUGH))
