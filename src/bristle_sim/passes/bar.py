"""Contact of straight wires with the bar, a fixed circle: gap, velocities, and the motion of a wire
that lies on the bar.

All lengths are divided by the bristle's length. The hub's radius is rho, and the bar's centre is at
the distance S from the hub's axis. The wire's root on the hub's rim is nearest to the bar's centre
at the hub angle psi = psi_b, and chi is the difference psi - psi_b. Vectors are complex numbers,
whose real axis points from the hub's axis to the bar's centre. The vector from the root to the
bar's centre is w = S - rho exp(i chi) = D exp(i delta).

Let R be the sum of the radii of bar and wire. If a wire lies on the bar, its centre line or its end
is at the distance R from the bar's centre. The angle at the root between the wire and the vector w
is eta. The angle between the wire and the real axis is delta - s eta, with s = 1 for a wire that
the bar holds back, and s = -1 otherwise. The angle eta follows from

    sin eta = R/D if the bar touches the wire's flank,
    cos eta = (D^2 + 1 - R^2)/(2 D) if the bar touches the wire's end.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.passes.motion import Vector, direction, free_acceleration
from bristle_sim.passes.state import Chosen, Passes


def half_turn(angle: Array) -> Array:
    """Return angles reduced by whole revolutions to the range from -pi to pi, rad."""
    return np.asarray(angle - 2.0 * np.pi * np.rint(angle / (2.0 * np.pi)))


def half_window(radius: Array, distance: Array, square: Array) -> Array:
    """Return the largest hub angle, from the bar's direction (rad), at which the bristle's root is
    within a given distance of the bar's centre.

    All lengths are divided by the bristle's length; R is the sum of the radii of bar and wire. With
    ``square`` = (1 + R)^2 the result is the largest angle at which the wire can reach the bar. With
    ``square`` = 1 + R^2 it is the largest angle at which the bar can touch the wire's flank; at
    larger angles it touches the wire's end. The result is -1 if the root is never so close.

    Args:
        radius: radius of the hub.
        distance: distance of the bar's centre from the hub's axis.
        square: square of the given distance.
    """
    room = radius**2 + distance**2 - square
    double = 2.0 * radius * distance
    cosine = np.divide(room, double, out=np.where(room > 0.0, 2.0, -1.0), where=double > 0.0)
    return np.where(cosine > 1.0, -1.0, np.arccos(np.clip(cosine, -1.0, 1.0)))


def meeting_angle(radius: Array, distance: Array, reach: Array) -> Array:
    """Return the hub angle chi from the bar's direction (rad) at which an undeflected wire first
    touches the bar.

    All lengths are divided by the bristle's length: the hub's radius rho is ``radius``, the
    distance S from the hub's axis to the bar's centre is ``distance``, and the sum R of the radii
    of bar and wire is ``reach``. The angle is negative, since the wire touches the bar before it
    points at the bar's centre. A wire that is long enough touches with its flank, and then
    S sin chi = -R. A shorter wire touches with its end, and then
    S^2 + (1 + rho)^2 - 2 S (1 + rho) cos chi = R^2. The angle is infinite if the wire is too short
    to reach the bar.
    """
    foot = np.sqrt(np.maximum(distance**2 - reach**2, 0.0)) - radius
    cosine = (distance**2 + (1.0 + radius) ** 2 - reach**2) / (2.0 * distance * (1.0 + radius))
    end = np.where(cosine <= 1.0, -np.arccos(np.minimum(cosine, 1.0)), np.inf)
    return np.where(foot <= 1.0, -np.arcsin(np.minimum(reach / distance, 1.0)), end)


class Closest(NamedTuple):
    """The point of a wire that is closest to the bar; lengths are divided by the bristle's length.

    Attributes:
        gap: gap between the surfaces of wire and bar.
        rate: derivative of the gap with respect to the hub angle.
        along: distance from the root to the point P of the wire's centre line that is closest to
            the bar.
        offset: vector from the point P to the bar's centre.
        root: vector from the hub's axis to the root.
        wire: unit vector along the wire.
    """

    gap: Array
    rate: Array
    along: Array
    offset: Vector
    root: Vector
    wire: Vector


def closest(passes: Passes, hub_angle: Array, angle: Array, rate: Array) -> Closest:
    """Return the point of each wire that is closest to the bar, with the gap and its derivative.

    ``hub_angle`` is psi (rad), ``angle`` the wire's angle alpha from the radial direction (rad) and
    ``rate`` the derivative d(alpha)/d(psi), all of shape (..., passes).
    """
    chi = hub_angle - passes.bar_angle
    root = passes.radius * direction(chi)
    wire = direction(chi + angle)
    offset = passes.bar_distance - root
    along = np.minimum(np.maximum((offset * wire.conj()).real, 0.0), 1.0)
    offset -= along * wire
    distance = np.abs(offset)
    velocity = root + along * (1.0 + rate) * wire  # of the wire's point, divided by i
    opening = (offset.conj() * velocity).imag / distance
    return Closest(distance - passes.reach, opening, along, offset, root, wire)


def levers(
    passes: Passes, hub_angle: Array, angle: Array, rate: Array
) -> tuple[Array, Array, Array, Array, Array]:
    """Return the lever arms and the velocity of the point at which each wire's surface touches the
    bar.

    A lever arm is the derivative of a velocity component with respect to the wire's angular
    velocity. The normal points from the bar to the wire. The tangent is the normal rotated
    clockwise by a right angle. Lengths are divided by the bristle's length, and the hub angle is
    the time. The arguments are those of ``closest``.

    Returns:
        The lever arms of the normal and of the tangential velocity.
        The normal and the tangential velocity.
        The side: 1 for a wire behind the bar, which holds the wire back, and -1 for a wire ahead of
        the bar.
    """
    near = closest(passes, hub_angle, angle, rate)
    normal = -near.offset / np.abs(near.offset)
    # in the axes of the normal and of the tangent, which is -i times the normal
    lever = 1j * (near.along * near.wire * normal.conj() - passes.wire_radius)
    velocity = 1j * near.root * normal.conj() + (1.0 + rate) * lever
    side = np.where((near.offset * near.wire.conj()).imag >= 0.0, 1.0, -1.0)
    return lever.real, -lever.imag, velocity.real, -velocity.imag, side


class Lying(NamedTuple):
    """Motion of a wire that lies on the bar, and the moment of the contact force.

    Attributes:
        angle, rate, acceleration: wire's angle alpha from the radial direction (rad), and its first
            and second derivatives with respect to the hub angle.
        pressure: moment of the contact force about the root, divided by the wire's moment of
            inertia; positive if the wire presses on the bar. The quotient equals the angular
            acceleration towards the bar that the wire would have without the bar, minus the actual
            one.
    """

    angle: Array
    rate: Array
    acceleration: Array
    pressure: Array


def lying(passes: Passes, hub_angle: Array, at_end: Chosen) -> Lying:
    """Return the motion of wires that lie on the bar, at hub angles of shape (..., passes).

    Args:
        passes: passes of the wires.
        hub_angle: hub angles psi, rad.
        at_end: whether a wire touches with its end rather than its flank.
    """
    chi = hub_angle - passes.bar_angle
    root = passes.radius * direction(chi)
    apart = passes.bar_distance - root
    # first and second derivatives of ln D + i delta
    first = -1j * root / apart
    second = root / apart - first * first
    distance = np.abs(apart)
    tilts = zip(_end_tilt(passes, distance), _flank_tilt(passes, distance), strict=True)
    eta, slope, bend = (np.where(at_end, *each) for each in tilts)
    eta_1 = slope * first.real
    eta_2 = slope * second.real - bend * (eta_1**2 + first.real**2)
    angle = np.arctan2(apart.imag, apart.real) - passes.side * eta - chi
    rate = first.imag - passes.side * eta_1 - 1.0
    acceleration = second.imag - passes.side * eta_2
    pressure = passes.side * (free_acceleration(passes, hub_angle, angle, rate) - acceleration)
    return Lying(angle, rate, acceleration, pressure)


LEAST_SQUARE = 1e-60
"""Lower bound of squares whose roots are divisors, dimensionless. For a wire whose end touches the
bar, the square is zero where the wire points at the bar's centre."""

Tilt = tuple[Array, Array, Array]
"""Angle eta (rad) at the root between wire and line to the bar's centre, and two coefficients.

The coefficients p and c give the derivatives of eta with respect to the hub angle, eta' = p u' and
eta'' = p u'' - c (eta'^2 + u'^2). Here u = ln D, with the distance D from root to bar's centre."""


def _flank_tilt(passes: Passes, distance: Array) -> Tilt:
    """Return the angle at the root between a wire whose flank touches the bar and the line to the
    bar's centre.

    The angle eta follows from sin eta = R/D. R is the sum of the radii of bar and wire (``reach``),
    and D the distance from the root to the bar's centre (``distance``).
    """
    foot = np.sqrt(np.maximum(distance**2 - passes.reach**2, LEAST_SQUARE))
    slope = -passes.reach / foot
    return np.arctan2(passes.reach, foot), slope, slope


def _end_tilt(passes: Passes, distance: Array) -> Tilt:
    """Return the angle at the root between a wire whose end touches the bar and the line to the
    bar's centre.

    The triangle of root, wire's end and bar's centre has the sides 1 (the wire), R (``reach``, the
    sum of the radii of bar and wire) and D (``distance``, from root to bar's centre). The angle eta
    at the root follows from cos eta = (D^2 + 1 - R^2)/(2 D).
    """
    rest = (1.0 - passes.reach**2) / distance
    cosine = 0.5 * (distance + rest)
    # not from the cosine, whose rounding error is large beside a small angle
    product = (passes.reach**2 - (distance - 1.0) ** 2) * ((distance + 1.0) ** 2 - passes.reach**2)
    sine = 0.5 * np.sqrt(np.maximum(product, LEAST_SQUARE)) / distance
    return np.arctan2(sine, cosine), 0.5 * (rest - distance) / sine, cosine / sine


def locks(passes: Passes, hub_angle: Array, angle: Array, rate: Array) -> Chosen:
    """Return whether friction locks each wire on the bar.

    A wire is locked if the moment of the friction force about the root is at least as large as the
    opposite moment of the normal force. The arguments are those of ``closest``.
    """
    normal, tangential, _, slip, _ = levers(passes, hub_angle, angle, rate)
    rub = passes.bar_friction * np.sign(slip) * tangential
    return np.asarray(normal * (normal - rub) <= 0.0)
