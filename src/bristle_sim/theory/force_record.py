"""Find a contact in a measured force record whose clock and zero are arbitrary: a matched filter over all durations.

The curve (3.3) without decay, of duration D and start s, is compared with the record at every s, for D from a few samples
to twice the record. With the record's mean level left out, the least-squares amplitude is a = cov(F, g)/var(g), and the
filter's score is the reduction of the sum of squares, a^2 var(g): for white noise the largest one is the likeliest pulse.
Each D is searched on averages over D/16, which cost less than the samples and let noise through least.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.theory.force_history import ForceCurve

BINS = 16
"""Averages in a duration: the start is located to D/16, which is close enough for a least-squares fit to converge."""

LEVEL_BINS = 8
"""Averages before and after the pulse that fix the level on which it stands."""

RATIO = 1.2
"""Ratio of successive durations: the best one is at most 10 % off."""

LEAST_BINS = 7
"""Averages of the pulse that the record must hold, i.e. nearly up to its peak."""

SHORTEST = 3.0
"""Shortest duration, in median sampling intervals."""

FLAT = 1e-12
"""Rounding of a force, as a fraction of the largest."""

MOST_BINS = 1 << 20
"""Averages in a record; a record of unequal sampling intervals could ask for any number."""


@dataclass(frozen=True, slots=True)
class FoundContact:
    """A pulse found in a record: start and duration on its clock, s, to a tenth of the duration, level and height in N."""

    start: float
    duration: float
    baseline: float
    amplitude: float


def find_contact(time: Array, force: Array) -> FoundContact | None:
    """Find the pulse that explains most of a record of forces, N, at increasing times, s; None where nothing in it rises."""
    length = float(time[-1] - time[0])
    if not (length > 0.0 and np.ptp(force) > FLAT * np.abs(force).max()):
        return None
    integral = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(time) * (force[1:] + force[:-1]))])
    shortest = max(SHORTEST * float(np.median(np.diff(time))), BINS * length / MOST_BINS)
    count = int(np.ceil(np.log(2.0 * length / min(shortest, length)) / np.log(RATIO))) + 1
    found = [_best(time, integral, each) for each in 2.0 * length * RATIO ** -np.arange(count, dtype=float)]
    scored = [each for each in found if each is not None]
    return max(scored, key=lambda each: each[0])[1] if scored else None


def _best(time: Array, integral: Array, duration: float) -> tuple[float, FoundContact] | None:
    """Return the best start of a pulse of that duration, with its score, N^2 s."""
    width = duration / BINS
    bins = int((time[-1] - time[0]) / width * (1.0 + 1e-9))
    if bins < LEAST_BINS:
        return None
    edges = time[0] + width * np.arange(bins + 1)
    average = np.diff(np.interp(edges, time, integral)) / width
    level = float(average.mean())
    number, of_force, of_shape, of_both, of_squares = _sums(average - level)
    variance = of_squares - of_shape**2 / number
    covariance = of_both - of_shape * of_force / number
    amplitude = np.divide(covariance, variance, out=np.zeros(bins), where=variance > 0.0)
    score = width * np.where(amplitude > 0.0, amplitude * covariance, 0.0)
    score[bins - LEAST_BINS + 1 :] = 0.0
    top = int(np.argmax(score))
    if not score[top] > 0.0:
        return None
    baseline = level + float((of_force[top] - amplitude[top] * of_shape[top]) / number[top])
    return float(score[top]), FoundContact(float(edges[top]), duration, baseline, float(amplitude[top]))


def _sums(average: Array) -> tuple[Array, Array, Array, Array, Array]:
    """Return the sums over a pulse and its surroundings that starts at each average: of 1, F, g, F g and g^2.

    Outside the record there is nothing to sum.
    """
    curve = ForceCurve.of_impact(1.0, 0.0, 1.0, 1.0)
    edges = np.linspace(0.0, 1.0, BINS + 1)
    shape = np.zeros(BINS + 2 * LEVEL_BINS)
    shape[LEVEL_BINS:-LEVEL_BINS] = BINS * np.diff(curve.impulse(edges)) / curve.peak_force()
    padding = (LEVEL_BINS, BINS + LEVEL_BINS)
    inside = np.pad(np.ones(average.size), padding)
    values = np.pad(average, padding)
    whole = np.ones(shape.size)

    def sums(of: Array, weights: Array) -> Array:
        return np.correlate(of, weights, "valid")[: average.size]

    return sums(inside, whole), sums(values, whole), sums(inside, shape), sums(values, shape), sums(inside, shape**2)
