"""Force history of an impact: an exponential times a shifted cosine (Zhang 2020, chapter 3).

The dissertation fits a measured impact of a steel ball on a plate with (3.3)

    F(t) = sum_i c_i e^(-lambda_i t) (F*/2) [cos(2 pi t_o/T) - cos(2 pi (t + t_o)/T)],   t_o = t_f/10,  T = t_f + 2 t_o,

and carries its shape over to the bristle by sharing out the impulse. The bracket vanishes at t = 0 and t = t_f, and its
constant part is fixed by the swing: offset = swing cos(2 pi t_o/T) = 0.866025 swing, since t_o/T = 1/12 whatever t_f.
The printed 145 and 26 N are 145.059 and 25.981, rounded, which leaves the printed curves with F(0) = -0.083 N (ball) and
+0.020 N (bristle) where (3.3) has zero.

Derivatives and integral come from one form, F = Re sum_i c_i [offset e^(-lambda_i t) - swing e^(z_i t + i w t_o)] with
z_i = -lambda_i + i w and w = 2 pi/T: each derivative multiplies by the exponent, the integral divides by it.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bristle_sim.arrays import Array, Number
from bristle_sim.theory.checks import finite, positive

LEAD_SHARE = 0.1  # t_o/t_f (Zhang 2020, below eq. 3.3).

SCAN = 512  # grid on which a peak is located before it is refined; the curve turns once or twice in a contact


@dataclass(frozen=True, slots=True)
class ForceCurve:
    """F(t) = sum_i amplitude_i e^(-decay_i t) [offset - swing cos(2 pi (t + lead)/period)], N (Zhang 2020, eq. 3.3).

    Attributes:
        amplitude, decay: c_i, dimensionless, and lambda_i, 1/s; one entry per exponential term.
        offset, swing: N; of one impact as (3.3) has it, offset = swing cos(2 pi lead/period).
        lead, period: t_o and T, s.

    Raises:
        ValueError: if amplitude and decay differ in number, a value is not finite, swing or period is not positive, or
            lead is not within 0 <= lead < period/2.
    """

    amplitude: tuple[float, ...]
    decay: tuple[float, ...]
    offset: float
    swing: float
    lead: float
    period: float

    def __post_init__(self) -> None:
        if not self.amplitude or len(self.amplitude) != len(self.decay):
            raise ValueError(
                f"amplitude, decay of lengths {len(self.amplitude)}, {len(self.decay)}: must be equal numbers, at least one"
            )
        for name, unit in (("amplitude", "1"), ("decay", "1/s"), ("offset", "N"), ("lead", "s")):
            finite(name, getattr(self, name), unit)
        positive("swing", self.swing, "N")
        positive("period", self.period, "s")
        if not 0.0 <= self.lead < self.period / 2.0:
            raise ValueError(f"lead = {self.lead:g}: must be 0 <= lead < period/2 = {self.period / 2.0:g} (in s)")

    @classmethod
    def of_impact(cls, amplitude: ArrayLike, decay: ArrayLike, peak_force: float, duration: float) -> ForceCurve:
        """Return the curve (3.3) of an impact with F* in N and t_f in s; it vanishes at both ends."""
        positive("peak_force", peak_force, "N")
        positive("duration", duration, "s")
        lead = LEAD_SHARE * duration
        period = duration + 2.0 * lead
        swing = 0.5 * peak_force
        offset = swing * math.cos(2.0 * math.pi * lead / period)
        terms = [tuple(np.atleast_1d(np.asarray(each, dtype=float)).tolist()) for each in (amplitude, decay)]
        return cls(terms[0], terms[1], offset, swing, lead, period)

    @property
    def duration(self) -> float:
        """Return t_f = T - 2 t_o, s."""
        return self.period - 2.0 * self.lead

    def __call__(self, time: ArrayLike) -> Number:
        """Return the force, N, at times in s of any shape."""
        return self._derivative(time, 0)

    def rate(self, time: ArrayLike) -> Number:
        """Return dF/dt, N/s."""
        return self._derivative(time, 1)

    def impulse(self, end: ArrayLike, start: ArrayLike = 0.0) -> Number:
        """Return the integral of F from start to end, N s (3.1); start and end in s, broadcast."""
        return self._integral(end) - self._integral(start)

    def peak_time(self) -> float:
        """Return the time of the largest force, F' = 0 (3.6), s: the end of compression t_c."""
        return self._crest(0)

    def inflection_time(self) -> float:
        """Return the time before the peak at which the force rises fastest, F'' = 0 (Zhang 2020, fig. 3.2), s."""
        return self._crest(1)

    def peak_force(self) -> float:
        """Return the largest force, N."""
        return float(self(self.peak_time()))

    def rescaled(self, impulse: float, compression_time: float) -> ForceCurve:
        """Return the same shape with another compressive impulse (N s) and compression time (s).

        In both impacts the same fraction of the compression time carries the same fraction of the impulse (3.14), so with k
        the ratio of the compression times F_new(t) = (impulse / (k p_c)) F(t/k): times grow by k, rates shrink by it.
        """
        positive("impulse", impulse, "N s")
        positive("compression_time", compression_time, "s")
        peak = self.peak_time()
        factor = compression_time / peak
        scale = impulse / (factor * float(self.impulse(peak)))
        return dataclasses.replace(
            self,
            decay=tuple(each / factor for each in self.decay),
            offset=self.offset * scale,
            swing=self.swing * scale,
            lead=self.lead * factor,
            period=self.period * factor,
        )

    def _derivative(self, time: ArrayLike, order: int) -> Number:
        decay, exponent = self._exponents()
        t = np.asarray(time, dtype=float)[..., np.newaxis]
        constant = self.offset * (-decay) ** order * np.exp(-decay * t)
        turning = exponent**order * np.exp(exponent * t + 1j * exponent.imag * self.lead)
        return self._sum(constant - self.swing * turning.real)

    def _integral(self, time: ArrayLike) -> Number:
        decay, exponent = self._exponents()
        t, slow = np.asarray(time, dtype=float)[..., np.newaxis], decay == 0.0
        constant = np.where(slow, t, -np.expm1(-decay * t) / np.where(slow, 1.0, decay))
        turning = np.exp(1j * exponent.imag * self.lead) * np.expm1(exponent * t) / exponent
        return self._sum(self.offset * constant - self.swing * turning.real)

    def _sum(self, terms: Array) -> Number:
        total = np.sum(np.asarray(self.amplitude) * terms, axis=-1)
        return float(total) if total.ndim == 0 else total

    def _exponents(self) -> tuple[Array, NDArray[np.complex128]]:
        decay = np.asarray(self.decay)
        return decay, -decay + 2j * math.pi / self.period

    def _crest(self, order: int) -> float:
        """Return where the derivative of that order is largest in the contact: the next derivative's root."""
        from scipy.optimize import brentq

        grid = np.linspace(0.0, self.duration, SCAN + 1)
        top = int(np.argmax(self._derivative(grid, order)))
        if not 0 < top < SCAN:
            raise ValueError(
                f"decay = {self.decay}: must give a curve that rises and falls within its duration (in 1/s)"
            )
        low, high = grid[top - 1], grid[top + 1]
        return float(brentq(lambda t: self._derivative(t, order + 1), low, high, xtol=1e-15 * self.duration))


BALL = ForceCurve((1.3935,), (101.6189,), offset=145.0, swing=167.5, lead=5e-4, period=6e-3)
"""Steel ball on a steel plate, fitted to the measurement of Yu et al. (Zhang 2020, eq. 3.5): t_f = 5 ms, F* = 335 N."""

BRISTLE = ForceCurve((1.0160,), (5.4990,), offset=26.0, swing=30.0, lead=1e-5, period=1.2e-4)
"""Resultant force on the bristle tip (Zhang 2020, eq. 3.19): t_f = 0.1 ms, F* = 60 N."""


def segment_impulses(
    curve: ForceCurve, impulse: ArrayLike, segments: int = 10, compression_time: float | None = None
) -> Array:
    """Divide an impulse as another impact's curve does, p_i = p_c p'_i/p'_c (Zhang 2020, eq. 3.15 and table 3.1).

    p_c, shape (...), N s, is that of the impact that takes the curve's shape over; the compression time, s, is by default the
    curve's peak time, which the dissertation rounds to 2.328 ms. Returns p_i, shape (..., segments), N s, for equal parts of
    the compression time; their sum is the impulse.
    """
    end = curve.peak_time() if compression_time is None else compression_time
    edges = np.linspace(0.0, end, segments + 1)
    parts = curve.impulse(edges[1:], edges[:-1])
    return np.asarray(np.asarray(impulse, dtype=float)[..., np.newaxis] * parts / curve.impulse(end))
