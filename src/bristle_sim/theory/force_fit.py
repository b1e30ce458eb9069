"""Fit of the force history (Zhang 2020, eqs. 3.2-3.4) to measured points, or to a record that
contains a contact.

The duration of the contact is t_f. With the lead t_f/10 and the period 1.2 t_f the force (3.3) is

    F(t) = sum_i c_i e^(-lambda_i t) (F*/2) [cos 30 deg - cos(2 pi t/(1.2 t_f) + 30 deg)].

The force F* only scales the amplitudes c_i. F* is therefore not fitted but taken from the points.
The unknowns are one amplitude c, one decay rate lambda, the duration t_f and the start s of the
contact. If the record holds samples from outside the contact, the baseline b is an unknown too: the
measured force is b + F(t - s) during the contact, and b elsewhere. (3.3) is 0 at both ends of the
contact, so the model is continuous in s and t_f.

Several fits are computed. Each fit starts from the highest pulse of the points, or of a moving
average of the points. The fit that explains most of the record is chosen.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.arrays import Array
from bristle_sim.theory.force_history import ForceCurve

# Time before and after the contact that the fit includes, as a fraction of the contact's duration.
# The time is short, so that other contacts in the record stay outside.
AROUND = 0.5
# Error of the estimated start and end of the contact, as a fraction of its duration. Only samples
# farther from both than this count as outside the contact.
ENDS = 0.05
SHORTEST = 3.0  # shortest duration of a contact, as a multiple of the median sampling interval
UNKNOWNS = 4  # number of unknowns without a baseline: amplitude, decay, duration and start
FEWEST_OUTSIDE = 4  # least number of samples outside the contact that determine a baseline
# Two times of the curve (3.3) without decay, as fractions of its duration: the time from the start
# to half the peak force, and the time during which the force is above half the peak.
RISE = 0.2127
HALF_WIDTH = 0.5745

# Largest accepted probability that independent normal noise alone would give as good a fit.
MOST_CHANCE = 0.01
# A record that is longer than the contact by n contact durations counts as n times this number of
# independent F tests, because the contact could have 16 n different starts and several durations.
PLACES = 50.0
# Largest force at both ends of a record without samples outside the contact, as a fraction of the
# peak force.
LEVEL = 0.03
# Longest time by which a contact may begin before the record, as a fraction of its duration.
MISSING_START = 0.1
NO_CONTACT = "force: no contact found in the record; there must be a force in it that rises and falls above the noise"
# Shortest and longest duration of a record (s), so that no square of a time or rate overflows.
SPAN = (1e-12, 1e6)


@dataclass(frozen=True, slots=True)
class ForceFit:
    """The fit of a force history with p parameters to n measured points.

    Attributes:
        curve: the fitted curve; its time 0 is the start of the contact.
        names: names of the parameters: ``amplitude 1``, ``decay 1``, ``duration``, ``start``, and
            ``baseline`` if the fit has one.
        values: values of the parameters, shape (p,): the amplitude (dimensionless), the decay rate
            (1/s), duration and start (s), and the baseline (N).
        covariance: covariance of the parameters, shape (p, p). The errors of the points are taken
            to be independent and of equal standard deviation.
        residuals: fitted minus measured force (N), shape (n,).
        noise: standard deviation of the error of a point (N), estimated from the residuals.
        explained: sum of squares of the force about its mean, minus the sum of squares of the
            residuals, N^2.
        start: time of the record at which the contact starts, s.
        baseline: force that the record shows outside the contact, N.
    """

    curve: ForceCurve
    names: tuple[str, ...]
    values: Array
    covariance: Array
    residuals: Array
    noise: float
    explained: float
    start: float
    baseline: float

    @property
    def standard_errors(self) -> Array:
        """Standard errors of the parameters, in the units of ``values``, shape (p,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def root_mean_square(self) -> float:
        """Root mean square of the residuals, N."""
        return float(np.sqrt(np.mean(self.residuals**2)))


class _Pulse(NamedTuple):
    """A pulse in a record, from which a fit starts.

    Attributes:
        start: estimated start of the contact, s.
        duration: estimated duration of the contact, s.
        height: largest force, measured from ``level``, N.
        level: force outside the pulse, N.
    """

    start: float
    duration: float
    height: float
    level: float


def fit_decay(time: ArrayLike, force: ArrayLike, duration: float, peak_force: float) -> ForceCurve:
    """Return the force curve of known duration that fits measured forces best.

    The amplitude and the decay rate of the curve are fitted by least squares (Zhang 2020, eq. 3.2).

    Args:
        time: times since first touch (s), shape (n,).
        force: forces (N), shape (n,).
        duration: duration t_f of the contact, s.
        peak_force: force F* that scales the amplitude, N.

    The fit to points of a curve of amplitude 0.7 and decay -150 1/s gives these values back:

    >>> curve = ForceCurve.of_impact(0.7, -150.0, 100.0, 5e-3)
    >>> time = np.linspace(0.0, 5e-3, 21)
    >>> fitted = fit_decay(time, curve(time), 5e-3, 100.0)
    >>> print(f"{fitted.amplitude:.6f} {fitted.decay:.4f}")
    0.700000 -150.0000
    """
    from scipy.optimize import curve_fit

    def curve(amplitude: float, fading: float) -> ForceCurve:
        return ForceCurve.of_impact(amplitude, fading / duration, peak_force, duration)

    found, _ = curve_fit(
        lambda since, *unknowns: curve(*unknowns)(since), time, force, (1.0, 0.0), xtol=1e-14
    )
    return curve(*found.tolist())


def fit_force_history(time: ArrayLike, force: ArrayLike) -> ForceFit:
    """Fit the force history of one contact to a measured record by least squares.

    The fitted curve is ``ForceCurve``, eq. 3.3 of Zhang (2020) with one exponential. The
    least-squares criterion is eq. 3.2.

    Args:
        time: increasing times with any origin (s), shape (n,). The record must contain the start
            and the peak of the contact. The record may contain samples before and after the
            contact.
        force: forces (N), shape (n,), positive where the tip is pushed.

    Raises:
        ValueError: if the arrays are not a force history; if there are not more points than
            unknowns; if there is no contact in the record; or if the contact began before the
            record.
    """
    time = np.asarray(time, dtype=float)
    force = np.asarray(force, dtype=float)
    _check(time, force)
    tried = (_fitted(time, force, pulse) for pulse in _pulses(time, force))
    fits = [each for each in tried if each is not None]
    if not fits:
        raise ValueError(NO_CONTACT)
    best = max(fits, key=lambda each: each.explained)
    _check_found(best, time, force)
    return best


def _pulses(time: Array, force: Array) -> Iterator[_Pulse]:
    """Yield different estimates of the contact, from which the fits start.

    Each estimate is the highest pulse of a moving average of the record. There are two estimates
    for each average. In the first the pulse's height is measured from the median of the record, in
    the second from the mean of the first and the last value of the average.
    """
    interval = float(np.median(np.diff(time)))
    for width in (2**power for power in range(max(1, int(math.log2(force.size)) - 1))):
        weights = np.ones(width) / width
        smooth = np.convolve(force, weights, "valid")
        clock = np.convolve(time, weights, "valid")
        top = int(np.argmax(smooth))
        ends = 0.5 * float(smooth[0] + smooth[-1])
        for level in (float(np.median(force)), ends):
            high = smooth > 0.5 * (smooth[top] + level)
            before = np.flatnonzero(~high[:top])
            after = np.flatnonzero(~high[top:])
            left = float(clock[before[-1]] if before.size else clock[0])
            right = float(
                clock[top + after[0]] if after.size else max(clock[-1], 2.0 * clock[top] - left)
            )
            length = max((right - left) / HALF_WIDTH, SHORTEST * interval)
            begin = left - RISE * length
            if smooth[top] > level:
                yield _Pulse(begin, length, float(smooth[top]) - level, level)


def _fitted(time: Array, force: Array, pulse: _Pulse) -> ForceFit | None:
    """Return the least-squares fit that starts from a pulse, or None if the fit fails."""
    from scipy.optimize import OptimizeWarning, curve_fit

    length = pulse.duration
    since = (time - pulse.start) / length
    near = (since >= -AROUND) & (since <= 1.0 + AROUND)
    outside = near & ((since < -ENDS) | (since > 1.0 + ENDS))
    based = int(outside.sum()) >= FEWEST_OUTSIDE
    since = since[near]
    force = force[near]
    scale = pulse.height if based else float(force.max(initial=0.0))
    if not scale > 0.0:
        return None
    amplitude = pulse.height / ForceCurve.of_impact(1.0, 0.0, scale, 1.0).peak_force()
    guesses = {
        "amplitude 1": (amplitude, 1.0),
        "decay 1": (1.0 / length, 0.0),
        "duration": (length, 1.0),
        "start": (length, 0.0),
    }
    if based:
        guesses["baseline"] = (pulse.height, pulse.level / pulse.height)
    if force.size <= len(guesses):
        return None
    units, first = np.transpose([*guesses.values()])

    def model(unknowns: Array) -> tuple[ForceCurve, float, float]:
        """Return curve, start (s) and baseline (N) for unknowns divided by their ``units``."""
        amplitude, decay, span, begins, *level = (units * unknowns).tolist()
        curve = ForceCurve.of_impact(amplitude, decay, scale, abs(span))
        return curve, begins, level[0] if based else 0.0

    def forces(since: Array, *unknowns: float) -> Array:
        """Return the model's force (N) at times since the pulse's start, in pulse durations."""
        curve, begins, level = model(np.array(unknowns))
        return np.asarray(curve(np.clip(length * since - begins, 0.0, curve.duration))) + level

    try:
        with np.errstate(over="ignore", invalid="ignore"), warnings.catch_warnings():
            warnings.simplefilter(
                "error", OptimizeWarning
            )  # the points do not determine the unknowns
            found, covariance = curve_fit(
                forces, since, force, first, ftol=1e-14, xtol=1e-14, gtol=0.0
            )
    except (RuntimeError, ValueError, ZeroDivisionError, OptimizeWarning):
        return None
    curve, begins, level = model(found)
    outside = (length * since < begins) | (length * since > begins + curve.duration)
    if based and int(outside.sum()) < FEWEST_OUTSIDE:
        return None
    residuals = forces(since, *found) - force
    origin = pulse.start + begins
    values = found * units
    values[2:4] = curve.duration, origin
    unexplained = float(residuals @ residuals)
    total = float(np.sum((force - force.mean()) ** 2))
    noise = math.sqrt(unexplained / (force.size - found.size))
    spread = covariance * np.outer(units, units)
    return ForceFit(
        curve=curve,
        names=tuple(guesses),
        values=values,
        covariance=spread,
        residuals=residuals,
        noise=noise,
        explained=total - unexplained,
        start=origin,
        baseline=level,
    )


def _check_found(fit: ForceFit, time: Array, force: Array) -> None:
    """Raise ValueError if noise could explain the fit or if the record misses part of the contact.

    An F test decides whether noise could explain the fit. The record must include the start and the
    peak of the contact.
    """
    from scipy.special import fdtrc

    try:
        peak = fit.curve.peak_time()
    except ValueError:
        raise ValueError(NO_CONTACT) from None
    unknowns = len(fit.names)
    length = fit.curve.duration
    freedom = fit.residuals.size - unknowns
    ratio = fit.explained / unknowns / max(fit.noise**2, np.finfo(float).tiny)
    places = max(1.0, PLACES * ((time[-1] - time[0]) / length - 1.0))
    resolved = length >= SHORTEST * float(np.median(np.diff(time)))
    if not (resolved and ratio > 0.0 and places * fdtrc(unknowns, freedom, ratio) <= MOST_CHANCE):
        raise ValueError(NO_CONTACT)
    if fit.start < time[0] - MISSING_START * length - (time[1] - time[0]):
        must = f"its start must be before that of the contact, {fit.start:.9g} s"
        raise ValueError(f"time: begins at {time[0]:.9g} s; {must}")
    if fit.start + peak > time[-1] + MISSING_START * length:
        raise ValueError(
            f"time: ends at {time[-1]:.9g} s; its end must be after the peak of the force"
        )
    level = max(LEVEL * float(fit.curve(peak)), 4.0 * fit.root_mean_square)
    if (
        "baseline" not in fit.names
        and force[0] * force[-1] > 0.0
        and min(abs(force[0]), abs(force[-1])) > level
    ):
        ends = f"begins at {force[0]:g} N and ends at {force[-1]:g} N"
        must = "samples outside the contact must be in it, for its zero"
        raise ValueError(f"force: {ends}, where a contact has 0; {must}")


def _check(time: Array, force: Array) -> None:
    """Raise ValueError for arguments that cannot be the force history of one contact.

    The times must be ascending, with more samples than there are unknowns.
    """
    if time.ndim != 1 or time.shape != force.shape:
        raise ValueError(
            f"time, force of shapes {time.shape}, {force.shape}: must be one row of equal lengths"
        )
    if not (np.isfinite(time).all() and np.isfinite(force).all() and (np.diff(time) > 0.0).all()):
        raise ValueError("time, force: must be finite numbers, the times increasing (in s, N)")
    if force.size <= UNKNOWNS:
        raise ValueError(
            f"force: must have more points than the {UNKNOWNS} unknowns, not {force.size}"
        )
    if not SPAN[0] <= time[-1] - time[0] <= SPAN[1]:
        raise ValueError(
            f"time: spans {time[-1] - time[0]:g}: must be {SPAN[0]:g} to {SPAN[1]:g} (in s)"
        )
