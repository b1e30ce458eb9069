"""The least-squares fit of section 3.1 tried on points of a known curve, exact and noisy (Zhang 2020, eqs. 3.2-3.4)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bristle_sim.comparison import Quantity
from bristle_sim.theory.force_fit import ForceFit, fit_force_history
from bristle_sim.theory.force_history import ForceCurve

__all__ = [
    "FitTrial",
    "fit_as_dict",
    "fit_in_words",
    "fit_trials",
    "noisy_points",
    "peak_of",
    "trial_as_dict",
    "trial_in_words",
    "trial_row",
]

Array = NDArray[np.float64]

SEED = 1
"""Of the noise: same inputs, same numbers."""

OFFSET_ROUNDING = 1e-3
"""The printed curves have their offset rounded to 26 and 145 N, by 0.019 and 0.059 N; of their peaks, 57 and 341 N, that
is 3.4e-4 and 1.7e-4. A curve with its exact offset, as (3.3) has it, fits them no closer."""


@dataclass(frozen=True, slots=True)
class FitTrial:
    """Points of a curve and what the fit makes of them; None where it finds no curve.

    Attributes:
        name: ``exact`` or ``noisy``.
        time, force: the points, s and N.
        noise: standard deviation of a point, N.
        fit: see ForceFit.
    """

    name: str
    time: Array
    force: Array
    noise: float
    fit: ForceFit | None

    @property
    def peak_force(self) -> float | None:
        """Of the fitted curve, N."""
        return None if self.fit is None else peak_of(self.fit.curve)


def noisy_points(curve: ForceCurve, points: int, noise: float) -> tuple[Array, Array]:
    """Points of a curve at equal steps of time, s, with normal errors of one standard deviation, N."""
    time = np.linspace(0.0, curve.duration, points)
    return time, np.asarray(curve(time)) + noise * np.random.default_rng(SEED).standard_normal(points)


def peak_of(curve: ForceCurve) -> float | None:
    """Largest force, N; None for a curve that does not rise and fall."""
    try:
        return curve.peak_force()
    except ValueError:
        return None


def fit_trials(curve: ForceCurve, points: int, noise: float) -> tuple[FitTrial, ...]:
    """With the curve's own F* and t_f, as the dissertation reads them off."""
    found = []
    for name, spread in (("exact", 0.0), ("noisy", noise)):
        time, force = noisy_points(curve, points, spread)
        try:
            fit = fit_force_history(time, force, duration=curve.duration, peak_force=2.0 * curve.swing, start=0.0)
        except ValueError:
            fit = None
        found.append(FitTrial(name, time, force, spread, fit))
    return tuple(found)


def trial_row(trial: FitTrial, curve: ForceCurve) -> Quantity:
    """The peak of a fit beside the peak of what it was fitted to.

    Errors of n points leave a fit with p unknowns, here at most three, a mean variance of noise^2 p/n; the tolerance is
    five of its roots. Where that exceeds the peak itself the points say nothing, and there is nothing to check; elsewhere a
    fit that finds no curve is wrong.
    """
    peak = curve.peak_force()
    tolerance = OFFSET_ROUNDING + 5.0 * trial.noise * math.sqrt(3.0 / len(trial.time)) / peak
    name = f"{trial.name}_fit_peak_force"
    return Quantity(name, "N", trial.peak_force, peak, tolerance=tolerance if tolerance < 1.0 else None)


def trial_as_dict(trial: FitTrial) -> dict[str, Any]:
    """The trial as plain values; without the fit's where there is none."""
    return {"points": trial.name, "noise": trial.noise, **({} if trial.fit is None else fit_as_dict(trial.fit))}


def fit_as_dict(fit: ForceFit) -> dict[str, Any]:
    """Values and standard errors by name, start in s, baseline and the residuals' root mean square in N."""
    return {
        "start": fit.start,
        "baseline": fit.baseline,
        "values": dict(zip(fit.names, fit.values.tolist(), strict=True)),
        "standard_errors": dict(zip(fit.names, fit.standard_errors.tolist(), strict=True)),
        "root_mean_square": fit.root_mean_square,
    }


def trial_in_words(trial: FitTrial) -> str:
    """One line for the terminal."""
    if trial.fit is None:
        return f"  {trial.name}, noise {trial.noise:g} N: no curve"
    return f"  {trial.name}, noise {trial.noise:g} N: {fit_in_words(trial.fit)}"


def fit_in_words(fit: ForceFit) -> str:
    """Values, standard errors and residuals for the terminal."""
    pairs = zip(fit.names, fit.values.tolist(), fit.standard_errors.tolist(), strict=True)
    shown = ", ".join(f"{name} = {value:.6g} +- {error:.1g}" for name, value, error in pairs)
    return f"{shown}; residuals {fit.root_mean_square:.2g} N"
