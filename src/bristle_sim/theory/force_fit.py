"""Least-squares fit of the force history (Zhang 2020, eqs. 3.2-3.4) to measured points, and reading them from a file.

Written with t_o = t_f/10 and T = 1.2 t_f, (3.3) is F(t) = sum_i c_i e^(-lambda_i t) (F*/2) [cos 30 deg -
cos(2 pi t/(1.2 t_f) + 30 deg)]. F* only scales the c_i, so it is not fitted: it is read off the points. The unknowns
are c_i and lambda_i and, where it is not given, t_f.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bristle_sim.quantity import Range
from bristle_sim.theory.checks import numbers, positive, ranges, require, single, whole
from bristle_sim.theory.force_history import ForceCurve

__all__ = ["ForceFit", "fit_force_history", "read_force_csv"]

Array = NDArray[np.float64]

MOST_FORCE = 1e30
"""Beyond this squares of residuals overflow; likewise times."""

FEWEST_POINTS = 4
"""A file with fewer points than this determines no curve: one term has three unknowns."""

MOST_TERMS = 10
"""Sums of exponentials are ill-conditioned; two terms already ask for very good points."""

INDISTINCT = 1e-10
"""Ratio of singular values of the scaled Jacobian below which the points leave a parameter undetermined."""

TRUSTED_SHARE = 0.2
"""Points whose bracket in (3.3) is below this share of its largest value say little about the exponential."""


@dataclass(frozen=True, slots=True)
class ForceFit:
    """A fitted force history; p parameters, n points.

    Attributes:
        curve: the fitted curve.
        names: of the parameters: ``amplitude 1``..., ``decay 1``..., and ``duration`` where it was fitted.
        values: c_i, lambda_i in 1/s, t_f in s, shape (p,).
        covariance: of the values, shape (p, p), for independent errors of one standard deviation in all points.
        residuals: fitted minus measured, shape (n,), N.
        noise: standard deviation of one point, from the residuals unless it was given, N.
    """

    curve: ForceCurve
    names: tuple[str, ...]
    values: Array
    covariance: Array
    residuals: Array
    noise: float

    @property
    def standard_errors(self) -> Array:
        """Standard deviations of the values, shape (p,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def root_mean_square(self) -> float:
        """Root mean square of the residuals, N."""
        return float(np.sqrt(np.mean(self.residuals**2)))


@ranges(
    Range("duration", "s", -1e30, 1e30, True, "given"),
    Range("peak_force", "N", -1e30, 1e30, True, "given"),
    Range("noise", "N", -1e30, 1e30, True, "given"),
)
def fit_force_history(
    time: ArrayLike,
    force: ArrayLike,
    *,
    terms: int = 1,
    duration: float | None = None,
    peak_force: float | None = None,
    noise: float | None = None,
) -> ForceFit:
    """Fit (3.3) to a measured force history by least squares (3.2).

    Args:
        time: s from the first touch, increasing, of one contact or its beginning, shape (n,).
        force: N, shape (n,).
        terms: number of exponential terms.
        duration: t_f, s; fitted too by default.
        peak_force: F*, N, which scales the c_i; by default the largest measured force.
        noise: standard deviation of one point, N, where it is known; by default taken from the residuals.

    Raises:
        ValueError: for points that are no force history, fewer points than unknowns, and for more terms than the points
            can tell apart.
    """
    time, force = _checked_points(time, force)
    _check_settings(time, force, terms, duration, peak_force, noise)
    problem = _Problem(time, force, int(terms), duration, float(force.max()) if peak_force is None else peak_force)
    return problem.solve(noise)


@dataclass(frozen=True, slots=True)
class _Problem:
    """The points and what is asked of them; unknowns are scaled to order one by the time of the last point."""

    time: Array
    force: Array
    terms: int
    duration: float | None
    peak_force: float

    def solve(self, noise: float | None) -> ForceFit:
        from scipy.optimize import least_squares

        # A contact may be recorded to its end or only to its peak; the better of both guesses wins.
        peak = float(self.time[np.argmax(self.force)])
        guesses = [self.duration] if self.duration is not None else [float(self.time[-1]), max(2.0 * peak, self._unit)]
        # A step may try decays whose exponential overflows; it is refused and shortened.
        with np.errstate(over="ignore", invalid="ignore"):
            runs = [least_squares(self.residuals, self.start(guess), jac="3-point", xtol=1e-14) for guess in guesses]
        best = min(runs, key=lambda run: float(run.cost))
        return self.report(best.x, best.jac, noise)

    def residuals(self, unknowns: Array) -> Array:
        return np.asarray(self.curve(unknowns)(self.time)) - self.force

    def curve(self, unknowns: Array) -> ForceCurve:
        values = unknowns * self.units
        duration = abs(values[-1]) if self.duration is None else self.duration
        return ForceCurve.of_impact(
            values[: self.terms], values[self.terms : 2 * self.terms], self.peak_force, float(duration)
        )

    def start(self, duration: float) -> Array:
        """Start values: a straight line through ln(F/bracket), its slope spread over the terms."""
        bracket = np.asarray(ForceCurve.of_impact(1.0, 0.0, self.peak_force, duration)(self.time))
        trusted = (bracket > TRUSTED_SHARE * bracket.max()) & (self.force > 0.0)
        slope = 0.0
        if trusted.sum() >= 2:
            logarithm = np.log(self.force[trusted] / bracket[trusted])
            slope = -float(np.polyfit(self.time[trusted], logarithm, 1, w=bracket[trusted])[0])
        spread = np.arange(self.terms) - 0.5 * (self.terms - 1)
        decays = slope + 2.0 * spread / self._unit
        columns = np.exp(-decays * self.time[:, np.newaxis]) * bracket[:, np.newaxis]
        amplitudes = np.linalg.lstsq(columns, self.force, rcond=None)[0]
        free = [] if self.duration is not None else [duration]
        return np.concatenate([amplitudes, decays, free]) / self.units

    def report(self, unknowns: Array, jacobian: Array, noise: float | None) -> ForceFit:
        residuals = self.residuals(unknowns)
        freedom = residuals.size - unknowns.size
        spread = math.sqrt(float(residuals @ residuals) / freedom) if noise is None else noise
        covariance = spread**2 * self._inverse_normal(jacobian) * np.outer(self.units, self.units)
        values = unknowns * self.units
        if self.duration is None:
            values[-1] = abs(values[-1])
        return ForceFit(self.curve(unknowns), self.names, values, covariance, residuals, spread)

    def _inverse_normal(self, jacobian: Array) -> Array:
        """(J^T J)^-1 through the singular values of J with its columns scaled to length one."""
        lengths = np.linalg.norm(jacobian, axis=0)
        if not lengths.all():
            raise self._indistinct()
        _, singular, rows = np.linalg.svd(jacobian / lengths, full_matrices=False)
        if singular[-1] < INDISTINCT * singular[0]:
            raise self._indistinct()
        scaled = rows.T / singular
        return np.asarray(scaled @ scaled.T / np.outer(lengths, lengths))

    def _indistinct(self) -> ValueError:
        return ValueError(f"terms = {self.terms}: the points do not tell so many terms apart; fewer are allowed")

    @property
    def _unit(self) -> float:
        return float(self.time[-1])

    @property
    def units(self) -> Array:
        free = [] if self.duration is not None else [self._unit]
        return np.array([1.0] * self.terms + [1.0 / self._unit] * self.terms + free)

    @property
    def names(self) -> tuple[str, ...]:
        numbered = [f"{name} {i + 1}" for name in ("amplitude", "decay") for i in range(self.terms)]
        return (*numbered, *(() if self.duration is not None else ("duration",)))


def read_force_csv(path: str | Path) -> tuple[Array, Array]:
    """Read points of a force history: two columns, time in s and force in N, separated by comma, semicolon or tab.

    The first line may be a header; blank lines and lines that begin with # are skipped.

    Returns:
        Times and forces, each of shape (n,).

    Raises:
        ValueError: in one line that names the file and the line, for anything else: no such file, not text, not two
            columns, not a number, not finite, a time that does not increase or is negative, fewer than four points.
    """
    try:
        lines = Path(path).read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError:
        raise ValueError(f"{path}: text in UTF-8 is allowed") from None
    except (OSError, TypeError, ValueError) as error:
        told = getattr(error, "strerror", None) or "no name of a file"
        name = " ".join(str(path).split())[-100:]
        raise ValueError(f"{name}: a readable file is allowed ({told})") from None
    rows: list[tuple[float, float]] = []
    header_allowed = True
    for number, line in enumerate(lines, start=1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        row = _numbers(f"{path}, line {number}", line, header_allowed)
        header_allowed = False
        if row is not None:
            previous = rows[-1][0] if rows else None
            _check_time(f"{path}, line {number}", row[0], previous)
            rows.append(row)
    if len(rows) < FEWEST_POINTS:
        raise ValueError(f"{path}: {len(rows)} points; at least {FEWEST_POINTS} are allowed")
    time, force = np.array(rows).T
    return time, force


def _numbers(where: str, line: str, header_allowed: bool) -> tuple[float, float] | None:
    """The two numbers of a line, or None for the header."""
    separator = next((each for each in "\t;," if each in line), ",")
    cells = [cell.strip().strip('"') for cell in line.split(separator)]
    if len(cells) != 2:
        raise ValueError(f"{where}: {len(cells)} columns; two are allowed, time in s and force in N")
    values = [_number(cell) for cell in cells]
    if header_allowed and values[0] is None and values[1] is None:
        return None
    for cell, value in zip(cells, values, strict=True):
        if value is None or not math.isfinite(value):
            raise ValueError(f"{where}: {cell!r}: a finite number is allowed")
    time, force = values
    assert time is not None
    assert force is not None
    return time, force


def _number(cell: str) -> float | None:
    try:
        return float(cell)
    except ValueError:
        return None


def _check_time(where: str, time: float, previous: float | None) -> None:
    if time < 0.0:
        raise ValueError(f"{where}: time = {time:g}: at least 0 is allowed, from the first touch (in s)")
    if previous is not None and time <= previous:
        raise ValueError(f"{where}: time = {time:g}: more than the time before, {previous:g}, is allowed (in s)")


def _checked_points(time: ArrayLike, force: ArrayLike) -> tuple[Array, Array]:
    time = numbers("time", time, "increasing numbers from 0 on are allowed (in s)")
    force = numbers("force", force, "numbers, the largest above 0, are allowed (in N)")
    if time.ndim != 1 or time.shape != force.shape:
        raise ValueError(f"time, force of shapes {time.shape}, {force.shape}: one row of equal lengths is allowed")
    if not (np.isfinite(time).all() and np.isfinite(force).all()):
        raise ValueError("time, force: finite numbers are allowed (in s, N)")
    require("force", force, np.abs(force) <= MOST_FORCE, f"at most {MOST_FORCE:g} is allowed (in N)")
    require("time", time, time <= MOST_FORCE, f"at most {MOST_FORCE:g} is allowed (in s)")
    if time.size and (time[0] < 0.0 or (np.diff(time) <= 0.0).any()):
        raise ValueError("time: increasing values from 0 on are allowed (in s)")
    if not (force > 0.0).any():
        raise ValueError("force: a largest value above 0 is allowed (in N)")
    return time, force


def _check_settings(
    time: Array, force: Array, terms: int, duration: float | None, peak_force: float | None, noise: float | None
) -> None:
    whole("terms", terms, MOST_TERMS)
    single("terms", terms)
    for name, value, unit in (("duration", duration, "s"), ("peak_force", peak_force, "N"), ("noise", noise, "N")):
        if value is not None:
            positive(name, value, unit)
            require(name, value, value > 1e-30, f"more than 1e-30 is allowed (in {unit})")
            single(name, value)
    unknowns = 2 * terms + (duration is None)
    if force.size <= unknowns:
        raise ValueError(f"force: {force.size} points; more than the {unknowns} unknowns are allowed")
    if duration is not None and time[-1] > duration:
        raise ValueError(f"duration = {duration:g}: at least the last time, {time[-1]:g}, is allowed (in s)")
