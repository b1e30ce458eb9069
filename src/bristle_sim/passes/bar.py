"""Contact of straight wires with the bar, a fixed circle: gap, velocities, and the motion of a wire
that lies on it.

All lengths are divided by the bristle's length: the hub's radius rho, and the distance S of the bar's
centre from the hub's axis. The hub angle from the bar's direction is chi = psi - psi_b. The vector
from the root to the bar's centre has the length D, D^2 = S^2 + rho^2 - 2 S rho cos chi, and the
angle delta from the bar's direction.

A wire that lies on the bar keeps its centre line, or its end, at the distance R from the bar's
centre. The angle between the wire and the vector to the bar's centre is eta. The wire's absolute
angle from the bar's direction is delta - s eta, with s = 1 for a wire held back, and

    sin eta = R/D on its flank,    cos eta = (D^2 + 1 - R^2)/(2 D) at its end.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from bristle_sim.arrays import Array, Number
from bristle_sim.passes.motion import Pose, free_acceleration, pose_of, sine_and_cosine
from bristle_sim.passes.state import Chosen, Passes


def half_turn(angle: Array) -> Array:
    """Return angles reduced by whole revolutions to the range from -pi to pi, rad."""
    return np.asarray(angle - 2.0 * np.pi * np.rint(angle / (2.0 * np.pi)))


def half_window(radius: Array, distance: Array, square: Array) -> Array:
    """Return the largest hub angle |chi| from the bar's direction (rad) at which D^2 <= ``square``.

    D is the distance of the bar's centre from the root, and R the sum of the radii of bar and wire.
    All lengths are divided by the bristle's length. The wire reaches the bar if D <= 1 + R, and
    touches with its flank if D^2 <= 1 + R^2, otherwise with its end. The result is -1 if D^2 is
    larger than ``square`` at every hub angle.

    Args:
        radius: radius of the hub.
        distance: distance of the bar's centre from the hub's axis.
        square: bound of D^2.
    """
    room = radius**2 + distance**2 - square
    double = 2.0 * radius * distance
    cosine = np.divide(room, double, out=np.where(room > 0.0, 2.0, -1.0), where=double > 0.0)
    return np.where(cosine > 1.0, -1.0, np.arccos(np.clip(cosine, -1.0, 1.0)))


def flank_window(passes: Passes) -> Array:
    """Return the largest hub angle at which the bar can touch the wire's flank (rad), at least 0.

    The angle is measured from the hub angle at which the root is nearest to the bar.
    """
    square = 1.0 + passes.reach**2
    return np.maximum(half_window(passes.radius, passes.bar_distance, square), 0.0)


def meeting_angle(radius: Array, distance: Array, reach: Array) -> Array:
    """Return the hub angle chi from the bar's direction (rad) at which an undeflected wire first
    touches the bar.

    All lengths are divided by the bristle's length: the hub's radius rho is ``radius``, the
    distance S from the hub's axis to the bar's centre is ``distance``, and the sum R of the radii
    of bar and wire is ``reach``. The wire touches with its flank where S sin chi = -R, and with its
    end where S^2 + (1 + rho)^2 - 2 S (1 + rho) cos chi = R^2. The angle is infinite if the wire is
    too short to reach the bar.
    """
    foot = np.sqrt(np.maximum(distance**2 - reach**2, 0.0)) - radius
    cosine = (distance**2 + (1.0 + radius) ** 2 - reach**2) / (2.0 * distance * (1.0 + radius))
    end = np.where(cosine <= 1.0, -np.arccos(np.minimum(cosine, 1.0)), np.inf)
    return np.where(foot <= 1.0, -np.arcsin(np.minimum(reach / distance, 1.0)), end)


class Closest(NamedTuple):
    """The shortest distance between wire and bar; all lengths are divided by the bristle's length.

    Attributes:
        gap: gap between the surfaces of wire and bar.
        rate: derivative of the gap with respect to the hub angle.
        x, y: vector from the nearest point of the wire's centre line to the bar's centre.
        distance: length of this vector.
        along: distance of the nearest point from the root.
    """

    gap: Array
    rate: Array
    x: Array
    y: Array
    distance: Array
    along: Array


def closest(passes: Passes, pose: Pose) -> Closest:
    """Return the shortest distance between each wire and the bar.

    The arrays of the pose have the shape (..., passes).
    """
    moving_x = passes.radius * pose.hub_cosine
    moving_y = passes.radius * pose.hub_sine
    x = passes.bar_x - moving_y
    y = passes.bar_y + moving_x
    along = np.minimum(np.maximum(x * pose.sine - y * pose.cosine, 0.0), 1.0)
    x -= along * pose.sine
    y += along * pose.cosine
    distance = np.sqrt(x * x + y * y)
    spin = along * (1.0 + pose.rate)
    opening = -(x * (moving_x + spin * pose.cosine) + y * (moving_y + spin * pose.sine)) / distance
    return Closest(distance - passes.reach, opening, x, y, distance, along)


class Levers(NamedTuple):
    """Velocity of the point of the wire's surface that touches the bar, and its lever arms.

    A lever arm is the derivative of a velocity component with respect to the wire's angular
    velocity. Lengths are divided by the bristle's length, and the hub angle is the time.

    Attributes:
        normal, tangential: lever arms of the normal and of the tangential velocity.
        normal_velocity, tangential_velocity: components of the velocity.
        side: 1 for a wire behind the bar, which holds the wire back, and -1 for a wire ahead of it.
    """

    normal: Number
    tangential: Number
    normal_velocity: Number
    tangential_velocity: Number
    side: Array


def levers(passes: Passes, pose: Pose) -> Levers:
    """Return the velocity of the point of the wire's surface that touches the bar, and its lever
    arms.

    The normal points from the bar to the wire. The tangent is the normal rotated clockwise by a
    right angle.
    """
    near = closest(passes, pose)
    normal = -(near.x + 1j * near.y) / near.distance
    arm = near.along * (pose.sine - 1j * pose.cosine) - passes.wire_radius * normal
    root = passes.radius * (pose.hub_cosine + 1j * pose.hub_sine)
    # in the axes of the normal and of the tangent, which is -i times the normal
    lever = 1j * arm * np.conj(normal)
    velocity = root * np.conj(normal) + (1.0 + pose.rate) * lever
    side = np.where(pose.sine * near.y + pose.cosine * near.x >= 0.0, 1.0, -1.0)
    return Levers(lever.real, -lever.imag, velocity.real, -velocity.imag, side)


class Lying(NamedTuple):
    """Motion of a wire that lies on the bar, and the moment of the contact force.

    Attributes:
        angle, rate, acceleration: relative angle alpha (rad), and its first and second derivatives
            with respect to the hub angle.
        pressure: moment of the contact force about the root, divided by the wire's moment of
            inertia; positive if the wire presses on the bar. It equals the acceleration towards the
            bar that the wire would have without the bar, minus the actual acceleration.
    """

    angle: Array
    rate: Array
    acceleration: Array
    pressure: Array


def lying(passes: Passes, hub_angle: Array, side: Array, at_end: Chosen | bool) -> Lying:
    """Return the motion of wires that lie on the bar, at hub angles of shape (..., passes).

    Args:
        passes: passes of the wires.
        hub_angle: hub angles psi, rad.
        side: 1 for a wire behind the bar, and -1 for a wire ahead of it.
        at_end: whether a wire touches with its end rather than its flank.
    """
    chi = hub_angle - passes.bar_angle
    sine, cosine = sine_and_cosine(chi)
    product = passes.radius * passes.bar_distance
    square = passes.bar_distance**2 + passes.radius**2 - 2.0 * product * cosine  # D^2
    square_1 = 2.0 * product * sine
    square_2 = 2.0 * product * cosine
    delta = np.arctan2(-passes.radius * sine, passes.bar_distance - passes.radius * cosine)
    delta_1 = (passes.radius**2 - product * cosine) / square
    delta_2 = (0.5 - delta_1) * square_1 / square
    if at_end is True:
        eta, slope, bend = _held_at_end(passes, square)
    else:
        eta, slope, bend = _held_at_flank(passes, square)
        if np.any(at_end):
            ends = _held_at_end(passes, square)
            eta, slope, bend = np.where(at_end, ends, (eta, slope, bend))
    angle = delta - side * eta - chi
    rate = delta_1 - side * slope * square_1 - 1.0
    acceleration = delta_2 - side * (bend * square_1**2 + slope * square_2)
    pressure = side * (free_acceleration(passes, hub_angle, angle, rate) - acceleration)
    return Lying(angle, rate, acceleration, pressure)


LEAST_SQUARE = 1e-60
"""Lower bound of the square of a sine or a length; it prevents a division by zero where the wire
points at the bar's centre."""

Turns = tuple[Array, Array, Array]
"""Angle (rad), and its first and second derivatives with respect to the square of a distance."""


def _held_at_flank(passes: Passes, square: Array) -> Turns:
    """Return the angle eta between a wire touched on its flank and the vector to the bar's centre.

    The angle obeys sin eta = R/D, with the distance D of the bar's centre from the root and the sum
    R of the radii of bar and wire. ``square`` is D^2.

    Returns:
        The angle (rad), and its first and second derivatives with respect to D^2.
    """
    foot = np.maximum(square - passes.reach**2, LEAST_SQUARE)
    slope = -0.5 * passes.reach / (square * np.sqrt(foot))
    bend = -slope * (1.0 / square + 0.5 / foot)
    return np.arctan2(passes.reach, np.sqrt(foot)), slope, bend


def _held_at_end(passes: Passes, square: Array) -> Turns:
    """Return the angle eta between a wire touched at its end and the vector to the bar's centre.

    By the law of cosines cos eta = (D^2 + 1 - R^2)/(2 D). Here 1 is the length of the wire, D the
    distance of the bar's centre from the root, and R the distance of the wire's end from the bar's
    centre. ``square`` is D^2.

    Returns:
        The angle (rad), and its first and second derivatives with respect to D^2.
    """
    rest = 1.0 - passes.reach**2
    distance = np.sqrt(square)
    cosine = 0.5 * (square + rest) / distance
    # not from the cosine, whose rounding error is large beside a small angle
    product = (passes.reach**2 - (distance - 1.0) ** 2) * ((distance + 1.0) ** 2 - passes.reach**2)
    sine = 0.5 * np.sqrt(np.maximum(product, LEAST_SQUARE)) / distance
    slope = -0.25 * (square - rest) / (square * distance * sine)
    curve = 0.125 * (3.0 * rest - square) / (square**2 * distance)
    return np.arctan2(sine, cosine), slope, -(curve + cosine * slope**2) / sine


def locks(passes: Passes, hub_angle: Array, angle: Array, rate: Array) -> Chosen:
    """Return whether friction locks each wire on the bar.

    A wire is locked if no normal force on it, together with the friction force, rotates the wire
    away from the bar.
    """
    touch = levers(passes, pose_of(hub_angle, angle, rate))
    rub = passes.bar_friction * np.sign(touch.tangential_velocity) * touch.tangential
    return np.asarray(touch.normal * (touch.normal - rub) <= 0.0)
