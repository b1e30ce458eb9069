"""Flight of straight rigid bristles: Taylor series of their angles, in arrays.

The hub angle psi serves as the time, and alpha is the wire's angle from the radial direction. The
equation of motion is

  alpha'' = -d alpha' - k alpha - b sin alpha - g sin(psi + alpha),

with k = k_T/(I omega^2), d = c/(I omega), b = 3 r_h/(2 L), g = 3 g_0/(2 L omega^2). L is the wire's
length and I its moment of inertia about the root. The belt has the stiffness k_T and the damping c,
the hub the radius r_h and the angular velocity omega. The acceleration of gravity is g_0.

For an angle u the series of sin u and cos u follow from their derivatives, u' cos u and -u' sin u,
by Cauchy products. The step length follows A. Jorba and M. Zou, *A software package for the
numerical integration of ODEs by means of high-order Taylor methods*, Experimental Mathematics 14
(2005) 99-117.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bristle_sim.arrays import Array
from bristle_sim.passes.state import Chosen, Passes

ORDER = 20
"""Order of the Taylor series.

The search for touches in a step costs as much as 15 terms. A high order with few steps is therefore
cheaper, up to the order at which the sine's series bounds the step."""

DEGREES = np.arange(ORDER + 1.0)[:, np.newaxis]  # degrees of a series' terms, as a column

SAFETY = 0.9
"""Ratio of the step length to the length at which the last terms of the series equal the tolerance."""

LONGEST_STEP = 1.0
"""Longest step, as a rotation of the hub, rad.

The series of a bristle at rest does not bound the step. In a step longer than a radian, the height
of the tip could have more than one minimum in a segment."""

SEGMENT = 0.125  # longest segment of a step, as a fraction of the step
FRACTIONS = np.array([0.0, 0.03125, *np.arange(SEGMENT, 1.01, SEGMENT)])[:, np.newaxis]
FRACTION_POWERS = FRACTIONS**DEGREES.T
"""Ends of a step's segments, as fractions of the step, and the powers of these fractions.

A gap is assumed to have at most one minimum in a segment. The first segment is shorter: a wire that
has just left the bar may touch it again at once."""

ONE_THREAD = 1024  # most columns of a matrix product; beyond, threads would wait for each other

Function = Callable[[Array, Chosen], Any]
"""Function of the hub's rotation (rad) and the indices of some passes. The function returns values
of these passes, such as angles or gaps, and then their derivatives, or None if the derivatives are
unknown."""

Vector = NDArray[np.complex128]  # array of vectors in the plane, as complex numbers


def direction(angle: Array) -> Vector:
    """Return the unit vectors at the given angles (rad), as complex numbers cos + i sin."""
    found = np.empty(np.shape(angle), dtype=complex)
    np.cos(angle, out=found.real)
    np.sin(angle, out=found.imag)
    return found


def powers(turn: Array) -> Array:
    """Return the powers 0 to ORDER of each rotation ``turn``, shape (ORDER + 1, passes).

    NumPy's own power function takes ten times as long.
    """
    found = np.empty((ORDER + 1, len(turn)))
    found[0] = 1.0
    for degree in range(ORDER):
        np.multiply(found[degree], turn, out=found[degree + 1])
    return found


class Course(NamedTuple):
    """Taylor series of the motion of bristles in flight, about the present hub angle.

    Attributes:
        series: Taylor coefficients of the angle alpha from the radial direction, and of its
            derivative with respect to the hub angle, shape (2, ORDER + 1, passes).
    """

    series: Array

    def at(self, turn: Array, chosen: Chosen) -> Array:
        """Return the angles from the radial direction (rad) and their derivatives after a rotation
        ``turn`` of the hub (rad), shape (2, chosen passes).
        """
        every = len(chosen) == self.series.shape[-1]
        series = self.series if every else self.series.take(chosen, axis=-1)
        found: Array = np.einsum("skn,kn->sn", series, powers(turn))
        return found

    def sampled(self, step: Array) -> Array:
        """Return the angles from the radial direction (rad) and their derivatives at the ends of
        each step's segments, shape (2, segments + 1, passes).

        ``step`` is the hub's rotation in each step, rad.
        """
        terms = self.series * powers(step)
        found = np.empty((2, len(FRACTIONS), step.size))
        for start in range(0, step.size, ONE_THREAD):
            part = slice(start, start + ONE_THREAD)
            np.matmul(FRACTION_POWERS, terms[..., part], out=found[..., part])
        return found


def free_acceleration(passes: Passes, hub_angle: Array, angle: Array, rate: Array) -> Array:
    """Return the angular acceleration alpha'' of bristles without a contact, relative to the hub.

    ``hub_angle`` is psi (rad), ``angle`` is alpha (rad), and ``rate`` is alpha'. A prime is a
    derivative with respect to the hub angle. All arrays have the shape (..., passes).
    """
    torque = passes.damping * rate + passes.stiffness * angle + passes.centrifugal * np.sin(angle)
    if passes.gravity.any():
        torque += passes.gravity * np.sin(hub_angle + angle)
    return -torque


def course_of(passes: Passes) -> Course:
    """Return the Taylor series of the motion in flight, about the present hub angles."""
    arcs = [passes.angle]
    pulls = [passes.centrifugal]
    if passes.gravity.any():
        arcs.append(passes.hub_angle + passes.angle)
        pulls.append(passes.gravity)
    count = len(arcs)
    factors = -np.array([passes.stiffness, passes.damping, *[0.0 * pulls[0]] * (count - 1), *pulls])
    # the angle alpha; rates, sines and cosines of the angles alpha and psi + alpha
    terms = np.empty((1 + 3 * count, ORDER + 1, passes.size))
    rates = terms[1 : 1 + count]
    bent = terms[1 + count :].reshape(2, count, ORDER + 1, passes.size)
    turned = bent[::-1]
    scales = 1.0 / DEGREES[1:, np.newaxis] * np.ones((len(terms), 1))
    scales[:, -count:] *= -1.0  # the derivative of a cosine
    terms[0, 0] = passes.angle
    rates[:, 0] = passes.rate
    rates[1:, 0] += 1.0  # psi has the rate 1
    bent[:, :, 0] = np.sin(arcs), np.cos(arcs)
    for k in range(ORDER - 1):
        terms[0, k + 1] = rates[0, k]
        rates[:, k + 1] = np.einsum("cn,cn->n", factors, terms[: len(factors), k])
        np.einsum("akn,bakn->ban", rates[:, : k + 1], turned[:, :, k::-1], out=bent[:, :, k + 1])
        terms[:, k + 1] *= scales[k]
    terms[0, ORDER] = rates[0, ORDER - 1] / ORDER
    rates[0, ORDER] = 0.0  # beyond the order of the angle's series
    return Course(terms[:2])


def step_length(passes: Passes, course: Course, tolerance: float) -> Array:
    """Return the longest step of each pass (rad) in which the Taylor series is accurate enough.

    The last two terms of the series of the angular velocity alpha' must not exceed ``tolerance``
    times ``passes.rate_scale``.
    """
    last = slice(ORDER - 2, ORDER)
    size = np.abs(course.series[1, last]) / (tolerance * passes.rate_scale)
    with np.errstate(divide="ignore"):
        steps = SAFETY * size ** (-1.0 / DEGREES[last])
    longest: Array = steps.min(axis=0, initial=LONGEST_STEP)
    return longest
