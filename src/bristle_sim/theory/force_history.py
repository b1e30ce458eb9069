"""Force history of an impact: an exponential times a shifted cosine (Zhang 2020, chapter 3).

The dissertation fits (3.3) to a measured impact of a steel ball on a plate. One of its exponential
terms suffices:

    F(t) = c e^(-lambda t) (F*/2) [cos(2 pi t_o/T) - cos(2 pi (t + t_o)/T)],   t_o = t_f/10,  T = t_f + 2 t_o,

It applies the shape to the bristle: the bristle's impulse is divided in the same fractions. The
bracket vanishes at t = 0 and t = t_f, and its constant part is fixed by the swing: offset = swing
cos(2 pi t_o/T) = 0.866025 swing, since t_o/T = 1/12 whatever t_f. The printed 145 and 26 N are
145.059 and 25.981, rounded, which leaves the printed curves with F(0) = -0.083 N (ball) and +0.020
N (bristle) where (3.3) has zero.
"""

from __future__ import annotations

import cmath
import dataclasses
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.arrays import Array, Number

LEAD_RATIO = 0.1  # t_o/t_f (Zhang 2020, below eq. 3.3).


@dataclass(frozen=True, slots=True)
class ForceCurve:
    """F(t) = amplitude e^(-decay t) [offset - swing cos(2 pi (t + lead)/period)], N (Zhang 2020, eq. 3.3).

    The amplitude c is dimensionless, the decay lambda in 1/s, offset and swing in N, lead t_o < T/2 and period T in s. For
    an impact of the form (3.3), offset = swing cos(2 pi lead/period).

    Without decay the curve (3.3) is highest in the middle, with F* (1 + cos(pi/6))/2 = 0.933013 F*:

    >>> curve = ForceCurve.of_impact(1.0, 0.0, peak_force=60.0, duration=1e-4)
    >>> print(f"{curve.peak_time():.3e} s, {curve.peak_force():.4f} N")
    5.000e-05 s, 55.9808 N
    """

    amplitude: float
    decay: float
    offset: float
    swing: float
    lead: float
    period: float

    @classmethod
    def of_impact(
        cls, amplitude: float, decay: float, peak_force: float, duration: float
    ) -> ForceCurve:
        """Return the curve (3.3) of an impact with F* in N and t_f in s; it vanishes at both ends."""
        lead = LEAD_RATIO * duration
        swing = 0.5 * peak_force
        period = duration + 2.0 * lead
        return cls(
            amplitude, decay, swing * math.cos(2.0 * math.pi * lead / period), swing, lead, period
        )

    @property
    def duration(self) -> float:
        """Return t_f = T - 2 t_o, s."""
        return self.period - 2.0 * self.lead

    @property
    def _turn(self) -> float:
        return 2.0 * math.pi / self.period

    def __call__(self, time: ArrayLike) -> Number:
        """Return the force, N, at times in s of any shape."""
        t = np.asarray(time, dtype=float)
        bracket = self.offset - self.swing * np.cos(self._turn * (t + self.lead))
        return self.amplitude * np.exp(-self.decay * t) * bracket

    def rate(self, time: ArrayLike) -> Number:
        """Return dF/dt, N/s."""
        t = np.asarray(time, dtype=float)
        growth = self.swing * self._turn * np.sin(self._turn * (t + self.lead))
        return self.amplitude * np.exp(-self.decay * t) * growth - self.decay * self(t)

    def impulse(self, end: ArrayLike, start: ArrayLike = 0.0) -> Number:
        """Return the integral of F from start to end, N s (3.1); start and end in s, broadcast."""
        return self._integral(end) - self._integral(start)

    def _integral(self, time: ArrayLike) -> Number:
        """Return the integral of F from 0 to times in s, N s.

        The cosine is the real part of e^(i w (t + t_o)); with the decay its exponent is z t + i w
        t_o, z = -lambda + i w.
        """
        t = np.asarray(time, dtype=float)
        exponent = complex(-self.decay, self._turn)
        constant = -np.expm1(-self.decay * t) / self.decay if self.decay else t
        turning = cmath.exp(1j * self._turn * self.lead) * np.expm1(exponent * t) / exponent
        return self.amplitude * (self.offset * constant - self.swing * turning.real)

    def peak_time(self) -> float:
        """Return the time t_c of the largest force, s, where F' = 0 (3.6): the end of compression.

        It is the second root of sin(w (t + t_o) + phi) = lambda offset/(swing sqrt(w^2 + lambda^2))
        with tan(phi) = lambda/w.

        The ball's, as printed (Zhang 2020, below eq. 3.6):

        >>> print(f"{1e3 * BALL.peak_time():.3f} ms, {BALL.peak_force():.0f} N")
        2.328 ms, 341 N
        """
        ratio = self.decay * self.offset / (self.swing * math.hypot(self._turn, self.decay))
        late = math.asin(max(-1.0, min(ratio, 1.0))) + math.atan2(self.decay, self._turn)
        peak = (math.pi - late) / self._turn - self.lead
        if not (self.amplitude > 0.0 and abs(ratio) < 1.0 and 0.0 < peak < self.duration):
            raise ValueError(
                f"decay = {self.decay}: must give a curve that rises and falls within its duration (in 1/s)"
            )
        return peak

    def inflection_time(self) -> float:
        """Return the time at which the force rises fastest, s, where F'' = 0 (Zhang 2020, fig.
        3.2)."""
        turn = self._turn
        decay = self.decay
        cosine = -(decay**2) * self.offset / (self.swing * (turn**2 + decay**2))
        return (
            math.acos(cosine) - math.atan2(2.0 * decay * turn, turn**2 - decay**2)
        ) / turn - self.lead

    def peak_force(self) -> float:
        """Return the largest force, N."""
        return float(self(self.peak_time()))

    def rescaled(self, impulse: float, compression_time: float) -> ForceCurve:
        """Return the same shape with another compressive impulse (N s) and compression time (s).

        In both impacts the same fraction of the compression time carries the same fraction of the impulse (3.14), so with k
        the ratio of the compression times F_new(t) = (impulse / (k p_c)) F(t/k): times grow by k, rates shrink by it.
        """
        peak = self.peak_time()
        factor = compression_time / peak
        scale = impulse / (factor * float(self.impulse(peak)))
        return dataclasses.replace(
            self,
            decay=self.decay / factor,
            offset=self.offset * scale,
            swing=self.swing * scale,
            lead=self.lead * factor,
            period=self.period * factor,
        )


BALL = ForceCurve(1.3935, 101.6189, offset=145.0, swing=167.5, lead=5e-4, period=6e-3)
"""Steel ball on a steel plate, fitted to the measurement of Yu et al. (Zhang 2020, eq. 3.5): t_f = 5 ms, F* = 335 N."""

BRISTLE = ForceCurve(1.0160, 5.4990, offset=26.0, swing=30.0, lead=1e-5, period=1.2e-4)
"""Resultant force on the bristle tip (Zhang 2020, eq. 3.19): t_f = 0.1 ms, F* = 60 N."""


def segment_impulses(
    curve: ForceCurve, impulse: ArrayLike, segments: int = 10, compression_time: float | None = None
) -> Array:
    """Divide an impulse in the fractions of another impact's curve: p_i = p_c p'_i/p'_c.

    (Zhang 2020, eq. 3.15 and table 3.1.)

    Args:
        curve: force curve of the other impact.
        impulse: p_c, compressive impulse to be divided, N s, shape (...).
        segments: number of equal parts of the compression time.
        compression_time: compression time of the curve, s; by default its peak time, which the
            dissertation rounds to 2.328 ms.

    Returns:
        p_i, N s, shape (..., segments); their sum is the impulse.

    Up to the middle of an undecaying curve the fractions add up to the whole:

    >>> curve = ForceCurve.of_impact(1.0, 0.0, peak_force=60.0, duration=1e-4)
    >>> parts = segment_impulses(curve, 2.0, segments=2)
    >>> print(f"{parts.sum():.6f}")
    2.000000
    """
    end = curve.peak_time() if compression_time is None else compression_time
    edges = np.linspace(0.0, end, segments + 1)
    parts = curve.impulse(edges[1:], edges[:-1])
    return np.asarray(
        np.asarray(impulse, dtype=float)[..., np.newaxis] * parts / curve.impulse(end)
    )
