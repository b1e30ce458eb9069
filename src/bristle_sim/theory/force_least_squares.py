"""The least-squares problem of (3.2): parameters of (3.3) from points, with their covariance.

The unknowns are c, lambda and, where they are not given, t_f, the contact's start s and the baseline b:
F_measured(t) = b + F(t - s) during the contact and b elsewhere. (3.3) vanishes at both ends, so the model is continuous in s
and t_f, and a search that begins close to them converges.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.theory.force_history import ForceCurve

INDISTINCT = 1e-10  # singular values below this fraction of the largest leave a parameter undetermined

INDISTINCT_WORDS = "force: no contact found in the record; there must be more points, or less noise"

TRUSTED_SHARE = 0.2  # points whose bracket in (3.3) is a smaller fraction of its largest say little of the exponential
STEEPEST = 3.0  # largest decay times duration from which the search begins in a record


@dataclass(frozen=True, slots=True)
class ForceFit:
    """A fitted force history; p parameters, n points.

    The curve's time 0 is the contact's start, s on the record's clock. Names of the parameters are ``amplitude 1``, ``decay 1``,
    and ``duration``, ``start`` and ``baseline`` where they were fitted; their values c, lambda in 1/s, t_f in s, s in s, b in N
    have the shape (p,), their covariance, for independent errors of one standard deviation in all points, (p, p). Residuals,
    fitted minus measured, N, have the shape (n,); the noise, N, is the standard deviation of a point from them. A search that
    has not ``converged`` is as far as it got.
    """

    curve: ForceCurve
    names: tuple[str, ...]
    values: Array
    covariance: Array
    residuals: Array
    noise: float
    start: float = 0.0
    baseline: float = 0.0
    converged: bool = True

    @property
    def standard_errors(self) -> Array:
        """Return the standard deviations of the values, shape (p,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def root_mean_square(self) -> float:
        """Return the root mean square of the residuals, N."""
        return float(np.sqrt(np.mean(self.residuals**2)))


@dataclass(frozen=True, slots=True)
class FitProblem:
    """Minimize the sum of squared residuals of (3.3) at given points; unknowns are scaled to order one.

    Attributes:
        unit: of time, s; a duration in order of magnitude.
        shifted, based: whether start and baseline are unknowns, on the clock of these points.
    """

    time: Array
    force: Array
    duration: float | None
    peak_force: float
    unit: float
    shifted: bool = False
    based: bool = False

    def solve(self, guesses: list[float], *, origin: float = 0.0, baseline: float = 0.0) -> ForceFit:
        """Search from each guess of the duration, s, and report the best; origin is the clock's zero of these points, s.

        Raises ValueError if the points are too few or do not tell the unknowns apart.
        """
        from scipy.optimize import least_squares

        if self.force.size <= self.units.size:
            points = f"{self.force.size} points in and around the contact"
            raise ValueError(f"force: {points}; there must be more than the {self.units.size} unknowns")
        try:
            # A step may try decays whose exponential overflows; it is refused and shortened.
            with np.errstate(over="ignore", invalid="ignore"):
                runs = [
                    least_squares(self.residuals, self.first(guess, baseline), jac="3-point", xtol=1e-14)
                    for guess in guesses
                ]
                best = min(runs, key=lambda run: float(run.cost))
                return self.report(best.x, best.jac, origin, best.status > 0)
        except np.linalg.LinAlgError:
            raise ValueError("force: no curve of (3.3) fits; it must be a force that rises and falls once") from None

    def residuals(self, unknowns: Array) -> Array:
        """Return the fitted minus measured force, N."""
        curve, start, baseline = self.model(unknowns)
        # (3.3) vanishes at both ends, and so the force does beyond them.
        later = np.clip(self.time - start, 0.0, curve.duration) if self.shifted else self.time
        return np.asarray(curve(later)) + baseline - self.force

    def model(self, unknowns: Array) -> tuple[ForceCurve, float, float]:
        """Return the curve, start in s and baseline in N."""
        values = dict(zip(self.sizes, (unknowns * self.units).tolist(), strict=True))
        duration = abs(values["duration"]) if self.duration is None else self.duration
        curve = ForceCurve.of_impact(values["amplitude 1"], values["decay 1"], self.peak_force, duration)
        return curve, values.get("start", 0.0), values.get("baseline", 0.0)

    def first(self, duration: float, baseline: float) -> Array:
        """Return start values: a straight line through ln(F/bracket)."""
        bracket = np.asarray(ForceCurve.of_impact(1.0, 0.0, self.peak_force, duration)(self.time))
        if self.shifted:
            bracket = np.where((self.time > 0.0) & (self.time < duration), bracket, 0.0)
        force = self.force - baseline
        trusted = (bracket > TRUSTED_SHARE * bracket.max()) & (force > 0.0)
        slope = 0.0
        if trusted.sum() >= 2 and np.ptp(self.time[trusted]) > 0.0:
            logarithm = np.log(force[trusted] / bracket[trusted])
            slope = -float(np.polyfit(self.time[trusted], logarithm, 1, w=bracket[trusted])[0])
        if self.shifted:
            # Noise may tilt the line at will; a contact's decay is of the order of its duration.
            slope = float(np.clip(slope, -STEEPEST / duration, STEEPEST / duration))
        column = np.exp(-slope * np.where(bracket != 0.0, self.time, 0.0)) * bracket
        amplitude = float(np.linalg.lstsq(column[:, np.newaxis], force, rcond=None)[0][0])
        begin = {"amplitude 1": amplitude, "decay 1": slope, "duration": duration, "start": 0.0, "baseline": baseline}
        return np.array([begin[name] for name in self.sizes]) / self.units

    def report(self, unknowns: Array, jacobian: Array, origin: float, converged: bool) -> ForceFit:
        """Return the fit with its covariance, from the normal equations at the solution."""
        residuals = self.residuals(unknowns)
        freedom = residuals.size - unknowns.size
        spread = math.sqrt(float(residuals @ residuals) / freedom)
        covariance = spread**2 * self._inverse_normal(jacobian) * np.outer(self.units, self.units)
        curve, start, baseline = self.model(unknowns)
        exact = {"duration": curve.duration, "start": start + origin}
        found = dict(zip(self.sizes, (unknowns * self.units).tolist(), strict=True))
        values = np.array([exact.get(name, value) for name, value in found.items()])
        return ForceFit(curve, tuple(found), values, covariance, residuals, spread, start + origin, baseline, converged)

    def _inverse_normal(self, jacobian: Array) -> Array:
        """Return (J^T J)^-1 through the singular values of J with its columns scaled to length one."""
        lengths = np.linalg.norm(jacobian, axis=0)
        if not lengths.all():
            raise ValueError(INDISTINCT_WORDS)
        _, singular, rows = np.linalg.svd(jacobian / lengths, full_matrices=False)
        if singular[-1] < INDISTINCT * singular[0]:
            raise ValueError(INDISTINCT_WORDS)
        scaled = rows.T / singular
        return np.asarray(scaled @ scaled.T / np.outer(lengths, lengths))

    @property
    def sizes(self) -> dict[str, float]:
        """Return the size that each unknown is measured in, by name and in order."""
        duration = {"duration": self.unit} if self.duration is None else {}
        start = {"start": self.unit} if self.shifted else {}
        baseline = {"baseline": self.peak_force} if self.based else {}
        return {"amplitude 1": 1.0, "decay 1": 1.0 / self.unit, **duration, **start, **baseline}

    @property
    def units(self) -> Array:
        """Return the sizes as an array."""
        return np.array(list(self.sizes.values()))
