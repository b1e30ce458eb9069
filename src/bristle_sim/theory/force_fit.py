"""Fit the force history (Zhang 2020, eqs. 3.2-3.4) to measured points or to a record that holds a contact somewhere.

Written with t_o = t_f/10 and T = 1.2 t_f, (3.3) is F(t) = sum_i c_i e^(-lambda_i t) (F*/2) [cos 30 deg -
cos(2 pi t/(1.2 t_f) + 30 deg)]. F* only scales the c_i, so it is not fitted: it is read off the points. The unknowns
are c_i and lambda_i and, where it is not given, t_f.

A record has its own clock and zero. Where the contact's start is not given it is an unknown too, and so is the baseline if
the record holds samples from outside the contact. The search begins at a contact that a matched filter finds: the curve (3.3)
without decay, of duration D and start s, is compared with the record at every s, for D from a few samples to twice the record.
With the record's mean level left out, the least-squares amplitude is a = cov(F, g)/var(g), and the filter's score is the
reduction of the sum of squares, a^2 var(g): for white noise the largest one is the likeliest pulse. Each D is searched on
averages over D/16, which cost less than the samples and let noise through least.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.arrays import Array
from bristle_sim.theory.checks import checked_arguments
from bristle_sim.theory.force_history import ForceCurve
from bristle_sim.theory.force_least_squares import FitProblem, ForceFit

AROUND = 0.5  # part of the duration before and after the contact that the fit takes in: nearer than other contacts
ENDS = 0.05  # part of the duration by which the start found may be late and the end early
FEWEST_OUTSIDE = 4  # samples from outside the contact that a baseline needs

MOST_CHANCE = 0.01  # probability that noise alone, independent and normal, shows as good a contact in the record
LEVEL = 0.03  # part of the peak by which both ends of a record of the contact alone may be off zero
PLACES = 50.0  # contacts that noise may show for each further duration: 16 starts, and durations that differ
MISSING_START = 0.1  # part of the duration by which a contact may begin before the record does: extrapolated there
NO_CONTACT = "force: no contact found in the record; there must be a force in it that rises and falls above the noise"

BINS = 16  # averages in a duration: a start located to D/16 is close enough for least squares to converge
LEVEL_BINS = 8  # averages before and after the pulse that fix the level on which it stands
RATIO = 1.2  # ratio of successive durations: the best one is at most 10 % off
LEAST_BINS = 7  # averages of the pulse that the record must hold, i.e. nearly up to its peak
SHORTEST = 3.0  # shortest duration, in median sampling intervals
FLAT = 1e-12  # rounding of a force, as a fraction of the largest
MOST_BINS = 1 << 20  # averages in a record; a record of unequal sampling intervals could ask for any number


@checked_arguments
def fit_force_history(
    time: ArrayLike,
    force: ArrayLike,
    *,
    duration: float | None = None,
    peak_force: float | None = None,
    start: float | None = None,
) -> ForceFit:
    """Fit (3.3) with one exponential to a measured force history by least squares (3.2).

    Times in s on any clock, increasing, and forces in N, positive where the tip is pushed, of shape (n,), are those of a
    contact or its beginning, and of what the record shows before and after it. t_f in s is fitted too by default; F* in N,
    which scales the c_i, is by default the largest measured force. Where the contact's start, s, is known, the points from
    there on are one contact without a baseline; by default it is found and fitted, and the baseline with it if the record
    holds samples outside the contact.

    Raises:
        ValueError: for points that are no force history, fewer points than unknowns, and for a record in which no contact is
            found or whose contact began before it.
    """
    time, force = np.asarray(time), np.asarray(force)
    _check(time, force, duration, start)
    if start is None:
        return _converged(_fit_record(time, force, duration, peak_force))
    scale = float(force.max()) if peak_force is None else peak_force
    later = time - start
    # A contact may be recorded to its end or only to its peak; the better of both guesses wins.
    unit, peak = float(later[-1]), float(later[np.argmax(force)])
    guesses = [duration] if duration is not None else [unit, max(2.0 * peak, unit)]
    return _converged(FitProblem(later, force, duration, scale, unit).solve(guesses, origin=start))


def _converged(fit: ForceFit) -> ForceFit:
    """Refuse a search that was given up."""
    if not fit.converged:
        raise ValueError("force: the search for a curve of (3.3) does not converge; there must be less noise")
    return fit


def _fit_record(time: Array, force: Array, duration: float | None, peak_force: float | None) -> ForceFit:
    """Find the contact in the record, then fit its start and the baseline with its curve."""
    found = _find_contact(time, force)
    if found is None:
        raise ValueError(NO_CONTACT)
    since = (time - found.start) / found.duration
    near = (since >= -AROUND) & (since <= 1.0 + AROUND)
    outside = near & ((since < -ENDS) | (since > 1.0 + ENDS))
    based = int(outside.sum()) >= FEWEST_OUTSIDE
    length, time, force = float(time[-1] - time[0]), time[near], force[near]
    scale = peak_force if peak_force is not None else (found.amplitude if based else float(force.max()))
    if not scale > 0.0:
        raise ValueError(NO_CONTACT)
    problem = FitProblem(time - found.start, force, duration, scale, found.duration, True, based)
    guesses = [found.duration] if duration is None else [duration]
    fit = problem.solve(guesses, origin=found.start, baseline=found.baseline if based else 0.0)
    _check_found(fit, time, force, length)
    return fit


def _check_found(fit: ForceFit, time: Array, force: Array, length: float) -> None:
    """Refuse a fit that noise alone could give, by the F test, or whose contact begins before the record."""
    from scipy.special import fdtrc

    try:
        peak = fit.curve.peak_time()
    except ValueError:
        raise ValueError(NO_CONTACT) from None
    unknowns = len(fit.names)
    unexplained, total = float(np.sum(fit.residuals**2)), float(np.sum((force - force.mean()) ** 2))
    freedom = force.size - unknowns
    ratio = (total - unexplained) / unknowns / max(unexplained / freedom, np.finfo(float).tiny)
    places = max(1.0, PLACES * (length / fit.curve.duration - 1.0))
    if not (ratio > 0.0 and places * fdtrc(unknowns, freedom, ratio) <= MOST_CHANCE):
        raise ValueError(NO_CONTACT)
    if fit.start < time[0] - MISSING_START * fit.curve.duration - (time[1] - time[0]):
        raise ValueError(
            f"time: begins at {time[0]:.9g} s; its start must be before that of the contact, {fit.start:.9g} s"
        )
    if fit.start + peak > time[-1] + MISSING_START * fit.curve.duration:
        raise ValueError(f"time: ends at {time[-1]:.9g} s; its end must be after the peak of the force")
    level = max(LEVEL * float(fit.curve(peak)), 4.0 * fit.root_mean_square)
    if "baseline" not in fit.names and force[0] * force[-1] > 0.0 and min(abs(force[0]), abs(force[-1])) > level:
        ends = f"begins at {force[0]:g} N and ends at {force[-1]:g} N"
        raise ValueError(
            f"force: {ends}, where a contact has 0; samples outside the contact must be in it, for its zero"
        )


def _check(time: Array, force: Array, duration: float | None, start: float | None) -> None:
    """Refuse what is not one row of increasing times, more than the unknowns, of one contact where its start is known."""
    if time.ndim != 1 or time.shape != force.shape:
        raise ValueError(f"time, force of shapes {time.shape}, {force.shape}: must be one row of equal lengths")
    if (np.diff(time) <= 0.0).any():
        raise ValueError("time: must be increasing values (in s)")
    unknowns = 2 + (duration is None) + (start is None)
    if force.size <= unknowns:
        raise ValueError(f"force: {force.size} points; there must be more than the {unknowns} unknowns")
    if start is None:
        return
    if not (force > 0.0).any():
        raise ValueError("force: the largest value must be above 0 (in N)")
    if time[0] < start:
        raise ValueError(f"time = {time[0]:g}: must be increasing values from start = {start:g} on (in s)")
    if duration is not None and time[-1] - start > duration:
        raise ValueError(f"duration = {duration:g}: must be at least the last time, {time[-1] - start:g} (in s)")


class _Pulse(NamedTuple):
    """A pulse found in a record: score, N^2 s, start and duration on its clock, s, to a tenth of it, level and height in N."""

    score: float
    start: float
    duration: float
    baseline: float
    amplitude: float


def _find_contact(time: Array, force: Array) -> _Pulse | None:
    """Find the pulse that explains most of a record of forces, N, at increasing times, s; None where nothing in it rises."""
    length = float(time[-1] - time[0])
    if not (length > 0.0 and np.ptp(force) > FLAT * np.abs(force).max()):
        return None
    integral = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(time) * (force[1:] + force[:-1]))])
    shortest = max(SHORTEST * float(np.median(np.diff(time))), BINS * length / MOST_BINS)
    count = int(np.ceil(np.log(2.0 * length / min(shortest, length)) / np.log(RATIO))) + 1
    found = [_best(time, integral, each) for each in 2.0 * length * RATIO ** -np.arange(count, dtype=float)]
    return max((each for each in found if each is not None), default=None)


def _best(time: Array, integral: Array, duration: float) -> _Pulse | None:
    """Return the pulse of that duration with the best start."""
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
    return _Pulse(float(score[top]), float(edges[top]), duration, baseline, float(amplitude[top]))


def _sums(average: Array) -> tuple[Array, Array, Array, Array, Array]:
    """Return the sums over a pulse and its surroundings that starts at each average: of 1, F, g, F g and g^2."""
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
