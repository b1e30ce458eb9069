"""Flight of straight rigid bristles: Taylor series of their angles, in arrays.

With the hub angle psi as time, lengths over the bristle's length, and alpha the angle from the
radial direction,

  alpha'' = -d alpha' - k alpha - b sin alpha - g sin(psi + alpha),

k = k_T/(I omega^2), d = c/(I omega), b = 3 r_h/(2 L), g = 3 g_0/(2 L omega^2). The series of sin
and cos follow from (sin u)' = u' cos u and (cos u)' = -u' sin u by Cauchy products. Step: A. Jorba
and M. Zou, *A software package for the numerical integration of ODEs by means of high-order Taylor
methods*, Experimental Mathematics 14 (2005) 99-117.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.passes.state import Chosen, Passes

ORDER = 20
"""Order of the series.

The search for touches costs as much as 15 further terms, so a high order with fewer steps is
cheaper."""

SAFETY = 0.9
"""Length of a step over that at which the last terms of the series equal the tolerance."""

LONGEST_STEP = 1.0
"""Longest step, rad of the hub.

A bristle at rest has no other bound, and the height of its tip over the workpart is curved within a
radian."""

POWERS = np.arange(ORDER + 1)[:, np.newaxis]
SINE_TERMS = np.array([(0.0, 1.0, 0.0, -1.0)[k % 4] / math.factorial(k) for k in range(ORDER + 1)])
COSINE_TERMS = np.array(
    [(1.0, 0.0, -1.0, 0.0)[k % 4] / math.factorial(k) for k in range(ORDER + 1)]
)


class Pose(NamedTuple):
    """Sine and cosine of the hub angle and of the wire's absolute angle, and the rate
    d(alpha)/d(psi).
    """

    hub_sine: Array
    hub_cosine: Array
    sine: Array
    cosine: Array
    rate: Array


def pose_of(hub_angle: Array, angle: Array, rate: Array) -> Pose:
    """Return the pose at a hub angle, alpha and alpha'."""
    turn = hub_angle + angle
    return Pose(np.sin(hub_angle), np.cos(hub_angle), np.sin(turn), np.cos(turn), rate)


class Course(NamedTuple):
    """A flight as series about the present hub angle.

    Attributes:
        angle, sine, cosine: Taylor terms of alpha, sin and cos of the relative angle, shape (ORDER
            + 1, passes).
        rate: Taylor terms k a_k of alpha', with a row of zeros before them, shape (ORDER + 1,
            passes).
        hub_sine, hub_cosine: sine and cosine of psi.
    """

    angle: Array
    rate: Array
    sine: Array
    cosine: Array
    hub_sine: Array
    hub_cosine: Array

    def take(self, chosen: Chosen) -> Course:
        """Return the courses of the chosen passes."""
        return Course(*(each[..., chosen] for each in self))

    def angle_at(self, step: Array) -> Array:
        """Return alpha after the hub has turned by ``step``, rad."""
        return _horner(self.angle, step)

    def rate_at(self, step: Array) -> Array:
        """Return alpha' after the hub has turned by ``step``, rad."""
        return _horner(self.rate[1:], step)

    def pose_at(self, step: Array) -> Pose:
        """Return the pose after the hub has turned by ``step``, rad."""
        turned = (np.sin(step), np.cos(step))
        bent = (_horner(self.sine, step), _horner(self.cosine, step))
        return self._pose(*turned, *bent, self.rate_at(step))

    def sampled(self, step: Array, fractions: Array) -> Pose:
        """Return the pose at fractions of steps, shape (fractions, passes)."""
        values = fractions[:, np.newaxis] ** POWERS.T
        powers = np.ones_like(self.angle)
        np.multiply.accumulate(np.broadcast_to(step, powers[1:].shape), axis=0, out=powers[1:])
        turned = (
            values @ (SINE_TERMS[:, np.newaxis] * powers),
            values @ (COSINE_TERMS[:, np.newaxis] * powers),
        )
        bent = (values @ (self.sine * powers), values @ (self.cosine * powers))
        rate = values[:, :-1] @ (self.rate[1:] * powers[:-1])
        return self._pose(*turned, *bent, rate)

    def _pose(
        self, turn_sine: Array, turn_cosine: Array, sine: Array, cosine: Array, rate: Array
    ) -> Pose:
        hub_sine = self.hub_sine * turn_cosine + self.hub_cosine * turn_sine
        hub_cosine = self.hub_cosine * turn_cosine - self.hub_sine * turn_sine
        return Pose(
            hub_sine,
            hub_cosine,
            hub_sine * cosine + hub_cosine * sine,
            hub_cosine * cosine - hub_sine * sine,
            rate,
        )


def _horner(terms: Array, step: Array) -> Array:
    value = terms[-1] * step
    for term in terms[-2:0:-1]:
        value += term
        value *= step
    value += terms[0]
    return np.asarray(value)


def free_acceleration(passes: Passes, hub_angle: Array, angle: Array, rate: Array) -> Array:
    """Return alpha'' of bristles without a contact; all angles and rates have the shape (...,
    passes).
    """
    torque = passes.damping * rate + passes.stiffness * angle + passes.centrifugal * np.sin(angle)
    if passes.heavy:
        torque += passes.gravity * np.sin(hub_angle + angle)
    return -torque


def course_of(passes: Passes) -> Course:
    """Return the flights as series about the present hub angles."""
    angle = np.empty((ORDER + 1, passes.size))
    rate = np.empty_like(angle)
    angle[0] = passes.angle
    angle[1] = passes.rate
    rate[0] = 0.0
    rate[1] = passes.rate
    radial = _sine(passes.angle)
    upright = _sine(passes.hub_angle + passes.angle) if passes.heavy else None
    turn = np.empty_like(angle)  # k a_k of psi + alpha
    for k in range(ORDER):
        if k < ORDER - 1:
            torque = passes.damping * rate[k + 1]
            torque += passes.stiffness * angle[k]
            torque += passes.centrifugal * radial[0][k]
            if upright is not None:
                torque += passes.gravity * upright[0][k]
            np.multiply(torque, -1.0 / (k + 1.0), out=rate[k + 2])
            np.multiply(rate[k + 2], 1.0 / (k + 2.0), out=angle[k + 2])
        _extend(radial, rate, k)
        if upright is not None:
            turn[k + 1] = rate[k + 1]
            turn[1] = rate[1] + 1.0
            _extend(upright, turn, k)
    return Course(angle, rate, *radial, np.sin(passes.hub_angle), np.cos(passes.hub_angle))


def _sine(angle: Array) -> tuple[Array, Array]:
    """Return the series of sine and cosine with their first terms set."""
    sine = np.empty((ORDER + 1, angle.size))
    cosine = np.empty_like(sine)
    np.sin(angle, out=sine[0])
    np.cos(angle, out=cosine[0])
    return sine, cosine


def _extend(pair: tuple[Array, Array], rates: Array, k: int) -> None:
    """Set the terms k + 1 of sine and cosine, from the products of u' with the other series."""
    sine, cosine = pair
    np.einsum("ij,ij->j", rates[1 : k + 2], cosine[k::-1], out=sine[k + 1])
    np.einsum("ij,ij->j", rates[1 : k + 2], sine[k::-1], out=cosine[k + 1])
    sine[k + 1] *= 1.0 / (k + 1.0)
    cosine[k + 1] *= -1.0 / (k + 1.0)


def step_length(passes: Passes, course: Course, tolerance: float) -> Array:
    """Return the longest steps, rad, at which the last two terms of the rate are within the
    tolerance.

    The tolerance is relative to the scale of the bristle's rates.
    """
    longest = np.full(passes.size, LONGEST_STEP)
    for k in (ORDER - 1, ORDER):
        size = np.abs(course.rate[k]) / (tolerance * passes.rate_scale)
        with np.errstate(divide="ignore"):
            np.minimum(longest, SAFETY * size ** (-1.0 / (k - 1.0)), out=longest)
    return longest
