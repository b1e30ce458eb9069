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

from typing import NamedTuple

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.passes.state import Chosen, Passes

ORDER = 24
"""Order of the series.

The search for touches costs as much as 15 further terms, so a high order with fewer steps is
cheaper."""

SAFETY = 0.9
"""Length of a step over that at which the last terms of the series equal the tolerance."""

LONGEST_STEP = 1.0
"""Longest step, rad of the hub.

A bristle at rest has no other bound, and the height of its tip over the workpart is curved within a
radian."""

INTERVALS = 8
"""Number of equal parts of a step; a gap has at most one minimum in a part, by assumption."""

FRACTIONS = np.linspace(0.0, 1.0, INTERVALS + 1)[:, np.newaxis]
FRACTION_POWERS = FRACTIONS ** np.arange(ORDER + 1)

ONE_THREAD = 1024  # columns of a product of matrices; with more, threads would wait for each other


class Pose(NamedTuple):
    """Sine and cosine of the hub angle and of the wire's absolute angle, and the rate
    d(alpha)/d(psi).
    """

    hub_sine: Array
    hub_cosine: Array
    sine: Array
    cosine: Array
    rate: Array


def sine_and_cosine(angle: Array) -> tuple[Array, Array]:
    """Return sine and cosine, from the tangent of the half angle.

    They are accurate to rounding, and take a fifth of the time of NumPy's sine and cosine.
    """
    half = np.tan(0.5 * angle)
    double = half + half
    square = half * half
    size = 1.0 / (1.0 + square)
    return double * size, (1.0 - square) * size


def pose_of(hub_angle: Array, angle: Array, rate: Array) -> Pose:
    """Return the pose at a hub angle, alpha and alpha'."""
    return Pose(*sine_and_cosine(hub_angle), *sine_and_cosine(hub_angle + angle), rate)


class Course(NamedTuple):
    """A flight as series about the present hub angle.

    Attributes:
        hub_angle: present psi, rad.
        angle: Taylor terms a_k of alpha, shape (ORDER + 1, passes).
        rate: Taylor terms (k + 1) a_(k+1) of alpha', of the same shape, without the last.
    """

    hub_angle: Array
    angle: Array
    rate: Array

    def take(self, chosen: Chosen) -> Course:
        """Return the courses of the chosen passes."""
        return Course(*(each.take(chosen, axis=-1) for each in self))

    def at(self, step: Array) -> tuple[Array, Array]:
        """Return alpha and alpha' after the hub has turned by ``step``, rad."""
        powers = powers_of(step)
        angle = np.einsum("kn,kn->n", self.angle, powers)
        return angle, np.einsum("kn,kn->n", self.rate, powers[:-1])

    def turning_at(self, step: Array) -> tuple[Array, Array]:
        """Return alpha' and alpha'' after the hub has turned by ``step``, rad."""
        powers = powers_of(step)[:-1]
        bend = np.einsum("kn,kn,k->n", self.rate[1:], powers[:-1], np.arange(1.0, ORDER))
        return np.einsum("kn,kn->n", self.rate, powers), bend

    def pose_at(self, step: Array) -> Pose:
        """Return the pose after the hub has turned by ``step``, rad."""
        return pose_of(self.hub_angle + step, *self.at(step))

    def sampled(self, step: Array) -> tuple[Array, Array]:
        """Return alpha and alpha' at FRACTIONS of steps, shape (fractions, passes)."""
        powers = powers_of(step)
        angles = np.empty((len(FRACTIONS), step.size))
        rates = np.empty_like(angles)
        for start in range(0, step.size, ONE_THREAD):
            part = slice(start, start + ONE_THREAD)
            np.matmul(FRACTION_POWERS, self.angle[:, part] * powers[:, part], out=angles[:, part])
            np.matmul(
                FRACTION_POWERS[:, :-1],
                self.rate[:, part] * powers[:-1, part],
                out=rates[:, part],
            )
        return angles, rates


def powers_of(step: Array) -> Array:
    """Return the powers 0 to ORDER of steps, shape (ORDER + 1, passes)."""
    powers = np.empty((ORDER + 1, step.size))
    powers[0] = 1.0
    powers[1] = step
    known = 2
    while known <= ORDER:  # twice as many each time
        more = powers[known : 2 * known - 1]
        np.multiply(powers[1 : len(more) + 1], powers[known - 1], out=more)
        known += len(more)
    return powers


def free_acceleration(passes: Passes, hub_angle: Array, angle: Array, rate: Array) -> Array:
    """Return alpha'' of bristles without a contact; all angles and rates have the shape (...,
    passes).
    """
    torque = passes.damping * rate + passes.stiffness * angle
    torque += passes.centrifugal * sine_and_cosine(angle)[0]
    if passes.heavy:
        torque += passes.gravity * sine_and_cosine(hub_angle + angle)[0]
    return -torque


def course_of(passes: Passes) -> Course:
    """Return the flights as series about the present hub angles."""
    arcs = [passes.angle]
    pulls = [-passes.stiffness, -passes.damping, -passes.centrifugal]
    if passes.heavy:
        arcs.append(passes.hub_angle + passes.angle)
        pulls.append(-passes.gravity)
    factors = np.array(pulls)
    terms = np.empty((2 + 2 * len(arcs), ORDER + 1, passes.size))
    angle, rate = terms[:2]
    # sines and cosines of the angles alpha and psi + alpha, shape (2, angles, terms, passes)
    bent = terms[2:].reshape(2, len(arcs), ORDER + 1, passes.size)
    bent[:, :, 0] = np.swapaxes([sine_and_cosine(each) for each in arcs], 0, 1)
    angle[0] = passes.angle
    rate[0] = passes.rate
    for k in range(ORDER):
        np.multiply(rate[k], 1.0 / (k + 1.0), out=angle[k + 1])
        if k == ORDER - 1:
            break
        np.einsum("cn,cn->n", factors, terms[: len(factors), k], out=rate[k + 1])
        rate[k + 1] *= 1.0 / (k + 1.0)
        product = np.einsum("kn,abkn->abn", rate[: k + 1], bent[:, :, k::-1])
        product[:, 1:] += bent[:, 1:, k]  # psi has the rate 1
        np.multiply(product[1], 1.0 / (k + 1.0), out=bent[0, :, k + 1])
        np.multiply(product[0], -1.0 / (k + 1.0), out=bent[1, :, k + 1])
    return Course(passes.hub_angle, angle, rate[:-1])


def step_length(passes: Passes, course: Course, tolerance: float) -> Array:
    """Return the longest steps, rad, at which the last two terms of the rate are within the
    tolerance.

    The tolerance is relative to the scale of the bristle's rates.
    """
    longest = np.full(passes.size, LONGEST_STEP)
    for k in (ORDER - 2, ORDER - 1):
        size = np.abs(course.rate[k]) / (tolerance * passes.rate_scale)
        with np.errstate(divide="ignore"):
            np.minimum(longest, SAFETY * size ** (-1.0 / k), out=longest)
    return longest
