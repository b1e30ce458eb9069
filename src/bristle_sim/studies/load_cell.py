"""What a load cell of finite bandwidth makes of a periodic force: a low-pass of second order, applied exactly to impulses.

A load cell is a mass on a spring. With the damping of Butterworth's filter its response to a unit impulse is
h(t) = sqrt(2) w exp(-w t/sqrt 2) sin(w t/sqrt 2), w = 2 pi bandwidth, at which it passes half the power.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

Impact = tuple[float, float]
"""Time in s and impulse in N s."""

Interval = tuple[float, float, Callable[[Array], Array]]
"""Beginning and end in s of a force that acts in between, and the force, N, as a function of time."""

NODES, WEIGHTS = np.polynomial.legendre.leggauss(8)
"""Gauss's rule integrates a cubic times exp(p t) over |p| h <= 1 to rounding: its error is 1e-16 of the 16th derivative's."""


def load_cell_response(
    impacts: Iterable[Impact], intervals: Iterable[Interval], period: float, bandwidth: float, times: Array
) -> Array:
    """Return what the load cell shows, in N, at some times, of forces that come back every period since ever.

    Each impact leaves J h(s + k T) for k = 0, 1, ..., a geometric series in exp(p T) with the filter's pole p. A force that
    acts for a while is cut in parts, shorter than half a period and 1/|p|, each of which is integrated with exp(p t).
    """
    pole = 2.0 * math.pi * bandwidth * complex(-1.0, 1.0) / math.sqrt(2.0)
    state = np.zeros(len(times), dtype=complex)
    for time, impulse in impacts:
        state += impulse * np.exp(pole * np.mod(times - time, period))
    for begin, end, force in intervals:
        _add_interval(state, times, (begin, end, force), period, pole)
    # Residue of w^2/((s - p)(s - p*)) at p, the sum over k included.
    return np.asarray(2.0 * (-1j * abs(pole) / math.sqrt(2.0) * state / -np.expm1(pole * period)).real)


def _add_interval(
    state: NDArray[np.complex128], times: Array, interval: Interval, period: float, pole: complex
) -> None:
    begin, end, force = interval
    parts = math.ceil((end - begin) * max(2.0 / period, abs(pole)) + 1.0)
    length = (end - begin) / parts
    for start in begin + length * np.arange(parts):
        since = np.mod(times - start, period)
        whole = complex(_weighed(force, np.array([start]), np.array([length]), pole)[0])
        inside = since < length
        state += whole * np.exp(pole * (since - length + np.where(inside, period, 0.0)))
        # While the part still acts, it has left this much; the others of the series are complete.
        sofar = _weighed(force, np.full(int(inside.sum()), start), since[inside], pole)
        state[inside] += -np.expm1(pole * period) * sofar


def _weighed(force: Callable[[Array], Array], start: Array, length: Array, pole: complex) -> NDArray[np.complex128]:
    """Return the integral of exp(p (end - t)) F(t) over each interval."""
    offset = 0.5 * length[:, np.newaxis] * (1.0 + NODES)
    values = force((start[:, np.newaxis] + offset).ravel()).reshape(offset.shape)
    return np.asarray(0.5 * length * ((values * np.exp(pole * (length[:, np.newaxis] - offset))) @ WEIGHTS))
