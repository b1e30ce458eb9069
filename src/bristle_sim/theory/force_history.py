"""Force history of an impact: an exponential times a shifted cosine (Zhang 2020, chapter 3).

The dissertation fits (3.3) to a measured impact of a steel ball on a plate. One exponential term of
(3.3) suffices:

    F(t) = c e^(-lambda t) (F*/2) [cos(2 pi t_o/T) - cos(2 pi (t + t_o)/T)],   t_o = t_f/10,  T = t_f + 2 t_o,

t_f is the duration of the contact. The dissertation applies the shape to the bristle: the bristle's
impulse is divided in the same fractions as the ball's. The bracket is 0 at t = 0 and t = t_f.
Multiplied by F*/2, the bracket is a constant (``offset``) minus a cosine of the amplitude
``swing``. Hence offset = swing cos(2 pi t_o/T) = 0.866025 swing, since t_o/T = 1/12. The printed
offsets 145 and 26 N are rounded from 145.059 and 25.981 N. The printed curves therefore have
F(0) = -0.083 N (ball) and +0.020 N (bristle), where (3.3) has zero.
"""

from __future__ import annotations

import cmath
import dataclasses
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.arrays import Array, Number

LEAD_RATIO = 0.1  # ratio of the lead t_o to the contact's duration t_f (Zhang 2020, below eq. 3.3)


@dataclass(frozen=True, slots=True)
class ForceCurve:
    """Force history of an impact: an exponential times a shifted cosine (Zhang 2020, eq. 3.3).

    The force is F(t) = amplitude e^(-decay t) [offset - swing cos(2 pi (t + lead)/period)], N, with
    the time t since first touch. F is 0 at first touch if offset = swing cos(2 pi lead/period), as
    in (3.3).

    Attributes:
        amplitude: dimensionless amplitude.
        decay: decay rate, 1/s.
        offset: constant term, N.
        swing: amplitude of the cosine, N.
        lead: time by which the cosine is shifted, less than period/2, s.
        period: period of the cosine, s.

    The argument ``peak_force`` of ``of_impact`` is a scale, not the largest force. Without decay
    the largest force is (1 + cos(pi/6))/2 = 0.933013 times the scale, in the middle of the contact.
    pi/6 is the phase of the lead:

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
        """Return the curve (3.3), whose force is 0 at both ends of the contact.

        Args:
            amplitude: dimensionless amplitude c.
            decay: decay rate lambda, 1/s.
            peak_force: force F* that scales the curve, N. The largest force of the curve differs
                from F*.
            duration: duration t_f of the contact, s.
        """
        lead = LEAD_RATIO * duration
        swing = 0.5 * peak_force
        period = duration + 2.0 * lead
        return cls(
            amplitude, decay, swing * math.cos(2.0 * math.pi * lead / period), swing, lead, period
        )

    @property
    def duration(self) -> float:
        """Duration of the contact, period - 2 lead, s."""
        return self.period - 2.0 * self.lead

    @property
    def _turn(self) -> float:
        return 2.0 * math.pi / self.period

    def __call__(self, time: ArrayLike) -> Number:
        """Return the force (N) at times in s of any shape."""
        t = np.asarray(time, dtype=float)
        bracket = self.offset - self.swing * np.cos(self._turn * (t + self.lead))
        return self.amplitude * np.exp(-self.decay * t) * bracket

    def rate(self, time: ArrayLike) -> Number:
        """Return the time derivative of the force (N/s) at times in s of any shape."""
        t = np.asarray(time, dtype=float)
        growth = self.swing * self._turn * np.sin(self._turn * (t + self.lead))
        return self.amplitude * np.exp(-self.decay * t) * growth - self.decay * self(t)

    def impulse(self, end: ArrayLike, start: ArrayLike = 0.0) -> Number:
        """Return the impulse of the force between the times ``start`` and ``end`` (s), N s.

        This is eq. 3.1 of Zhang (2020). The times broadcast.
        """
        return self._integral(end) - self._integral(start)

    def _integral(self, time: ArrayLike) -> Number:
        """Return the impulse (N s) of the force from first touch to each of the times (s).

        The varying part of the force is proportional to e^(-lambda t) cos(w (t + t_o)), with w = 2
        pi/period and the lead t_o. This part is integrated as the real part of e^(z t + i w t_o),
        with z = -lambda + i w.
        """
        t = np.asarray(time, dtype=float)
        exponent = complex(-self.decay, self._turn)
        constant = -np.expm1(-self.decay * t) / self.decay if self.decay else t
        turning = cmath.exp(1j * self._turn * self.lead) * np.expm1(exponent * t) / exponent
        return self.amplitude * (self.offset * constant - self.swing * turning.real)

    def peak_time(self) -> float:
        """Return the time of the largest force, which is the end of compression, s.

        At this time F' = 0 (Zhang 2020, eq. 3.6). The time is the second root of sin(w (t + t_o) +
        phi) = lambda offset/(swing sqrt(w^2 + lambda^2)) with tan(phi) = lambda/w, w = 2 pi/period,
        the lead t_o and the decay rate lambda.

        Raises:
            ValueError: if the force does not rise and fall within the duration.

        The time and the largest force of the ball agree with those printed below (3.6):

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
        """Return the time at which the force rises fastest, s (Zhang 2020, fig. 3.2)."""
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
        """Return the force curve of an impact with another impulse and another compression time.

        ``impulse`` (N s) is the impulse up to the peak of the new curve, ``compression_time`` (s)
        the time of that peak. In both impacts the same fraction of the compressive impulse acts in
        the same fraction of the compression time (3.14): F_new(t) = (impulse/(k p_c)) F(t/k), with
        the ratio k of the new to the old compression time and the compressive impulse p_c of this
        curve.
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
"""Force of a steel ball on a steel plate, fitted to the measurement of Yu et al. (Zhang 2020, eq.
3.5): contact of t_f = 5 ms, F* = 335 N."""

BRISTLE = ForceCurve(1.0160, 5.4990, offset=26.0, swing=30.0, lead=1e-5, period=1.2e-4)
"""Resultant force on the bristle's tip (Zhang 2020, eq. 3.19): t_f = 0.1 ms, F* = 60 N."""


def segment_impulses(
    curve: ForceCurve, impulse: ArrayLike, segments: int = 10, compression_time: float | None = None
) -> Array:
    """Divide an impulse among equal parts of the compression time, in proportion to a force curve.

    The impulse in part i is p_i = p_c p'_i/p'_c. p_c is the impulse to be divided; p'_i and p'_c
    are the impulses of the force curve in part i and in the whole compression (Zhang 2020, eq.
    3.15, table 3.1).

    Args:
        curve: force curve, possibly of another impact, that gives the proportions.
        impulse: compressive impulse p_c to be divided (N s), shape (...).
        segments: number of equal parts of the compression time.
        compression_time: compression time of the curve, s; by default the time of its peak. For the
            ball the dissertation rounds this time to 2.328 ms.

    Returns:
        The impulses of the parts (N s), shape (..., segments).

    The parts add up to the whole:

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
