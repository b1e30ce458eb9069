"""Position of the bar at which the tip strikes at its highest speed (Zhang 2020, eqs. 2.1-2.3).

The bar releases the bristle when the wire lags the radial direction by the retraction theta_p. Seen
from the hub's centre, the tip then lags the root by the angle A. The belt throws the bristle ahead.
The cue time t_c is the time from the release to the highest speed. In this time the hub turns by
theta_1. At its highest speed the bristle should touch the workpart radially, at the impact angle
gamma. The bar must therefore stand at the angle A + theta_1 + gamma from the workpart's normal.

Between contacts, with alpha the bristle's angle relative to the radial direction,

    I alpha'' + c alpha' + k alpha + g sin alpha = 0,    g = m r_h (L/2) omega^2.

The dissertation has c = g = 0. The centrifugal stiffness g comes from the force m r_h omega^2 that
acts on the centre of mass in the frame of the rotating root. The lever of this force about the root
is (L/2) sin alpha.

Arguments are floats or arrays that broadcast, in SI units and rad. Functions raise ValueError where
the geometry or the motion does not exist, and where the tool lacks a bar or a workpart.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bristle_sim.arrays import Number
from bristle_sim.parameters import RETRACTION_AT_RELEASE, Tool
from bristle_sim.theory.numbers import require

# Gauss-Legendre rule on [-1, 1]; 64 nodes leave only rounding error for retractions up to 150 deg.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(64)


def impact_angle(hub_radius: Number, length: Number, penetration: Number) -> Number:
    """Return the angle of a radial bristle to the workpart's normal at its first touch, rad.

    This impact angle gamma satisfies cos(gamma) = (r_h + L - Delta)/(r_h + L), with the hub's
    radius r_h, the wire's length L and the penetration Delta, all in m.

    If the penetration is half the radius of the tip's circle, cos(gamma) = 1/2:

    >>> print(f"{np.degrees(impact_angle(0.4, 0.6, 0.5)):.6f}")
    60.000000
    """
    reach = hub_radius + length
    inside = (penetration >= 0.0) & (penetration <= reach)
    require("penetration", penetration, inside, "must be 0 to hub_radius + length (in m)")
    # arccos of nearly 1 loses half of the digits; 1 - cos gamma = 2 sin^2(gamma/2) keeps them.
    return 2.0 * np.arcsin(np.sqrt(penetration / (2.0 * reach)))


def tip_radius(hub_radius: Number, length: Number, retraction: Number) -> Number:
    """Return the distance of the tip from the hub's centre at a retraction of the bristle, m.

    The distance is sqrt(r_h^2 + L^2 + 2 r_h L cos(theta_p)), with the hub's radius r_h (m), the
    wire's length L (m) and the retraction theta_p (rad).

    A hub radius of 3 m and a wire of 4 m at a right angle give:

    >>> print(f"{tip_radius(3.0, 4.0, np.pi / 2.0):.6f}")
    5.000000
    """
    return np.hypot(hub_radius + length * np.cos(retraction), length * np.sin(retraction))


def tip_lag(hub_radius: Number, length: Number, retraction: Number) -> Number:
    """Return the angle between the tip and the root as seen from the hub's centre, rad.

    The result is the angle A of Zhang (2020), fig. 2.3. Lengths are in m, the retraction is in rad.

    >>> print(f"{np.degrees(tip_lag(1.0, 1.0, np.pi / 2.0)):.6f}")  # an isosceles right triangle
    45.000000
    """
    return np.arctan2(length * np.sin(retraction), hub_radius + length * np.cos(retraction))


def retraction_at_bar(
    bar_horizontal: Number,
    bar_vertical: Number,
    bar_reach: Number,
    hub_radius: Number,
    length: Number,
) -> Number:
    """Return the retraction at which the tip slips off the bar, rad.

    The distance of the tip from the hub's centre is then that of the bar's centre minus
    ``bar_reach``. The function is the inverse of ``tip_radius``.

    Args:
        bar_horizontal, bar_vertical: coordinates of the bar from the hub's centre, along and normal
            to the workpart, m.
        bar_reach: distance from the bar's centre to the wire's axis, m.
        hub_radius, length: radius of the hub and length of the wire, m.

    Raises:
        ValueError: if no retraction puts the tip at this distance from the hub's centre.

    A bar at 6 m from the hub's centre with a reach of 1 m releases the tip at 5 m, as in
    ``tip_radius``:

    >>> print(f"{np.degrees(retraction_at_bar(6.0, 0.0, 1.0, 3.0, 4.0)):.6f}")
    90.000000
    """
    radius = np.hypot(bar_horizontal, bar_vertical) - bar_reach
    reaches = (radius <= hub_radius + length) & (radius >= np.abs(hub_radius - length))
    rule = "must be |hub_radius - length| to hub_radius + length (in m)"
    require("bar_horizontal, bar_vertical: tip radius", radius, reaches, rule)
    # Half-angle form of the law of cosines, exact also near the radial bristle.
    beyond = (hub_radius + length - radius) * (hub_radius + length + radius)
    half = np.sqrt(beyond / (4.0 * hub_radius) / length)
    return 2.0 * np.arcsin(np.minimum(half, 1.0))


def natural_rate(stiffness: Number, inertia: Number) -> Number:
    """Return the natural angular frequency sqrt(k/I) of the bristle on its belt, rad/s.

    The belt stiffness is k (N m/rad), the inertia about the root I (kg m^2). A hub's rotation adds
    the centrifugal stiffness to k.

    >>> print(f"{natural_rate(9.0, 4.0):.6f}")
    1.500000
    """
    return np.sqrt(stiffness) / np.sqrt(inertia)


def centrifugal_stiffness(
    mass: Number, hub_radius: Number, length: Number, hub_speed: Number
) -> Number:
    """Return the stiffness that the hub's rotation adds to the belt's at small angles, N m/rad.

    This centrifugal stiffness is g = m r_h (L/2) omega^2, with the bristle's mass m, the hub's
    radius r_h, the wire's length L and the hub's speed omega, in SI units.

    >>> print(f"{centrifugal_stiffness(2.0, 3.0, 4.0, 5.0):.6f}")  # 2 x 3 x 2 x 25
    300.000000
    """
    return 0.5 * mass * hub_radius * length * hub_speed**2


def stiffened_highest_speed(
    retraction: Number, stiffness: Number, centrifugal: Number, inertia: Number
) -> Number:
    """Return the highest angular velocity of the undamped bristle relative to the hub, rad/s.

    The energy integral gives sqrt((k theta_p^2 + 2 g (1 - cos theta_p))/I), with the retraction
    theta_p at release (rad), the belt stiffness k and the centrifugal stiffness g (N m/rad), and
    the inertia I about the root (kg m^2).

    Released at 90 deg without a belt, the bristle is a pendulum, fastest at sqrt(2 g/I):

    >>> print(f"{stiffened_highest_speed(np.pi / 2.0, 0.0, 2.0, 1.0):.6f}")
    2.000000
    """
    chord = 2.0 * np.sin(0.5 * retraction)
    return np.sqrt(stiffness * retraction**2 + centrifugal * chord**2) / np.sqrt(inertia)


def stiffened_cue_time(
    retraction: Number, stiffness: Number, centrifugal: Number, inertia: Number
) -> Number:
    """Return the time that the undamped bristle takes from its release to the radial direction, s.

    The bristle is released at rest at the retraction theta_p, |theta_p| < pi. k is the belt
    stiffness, g the centrifugal stiffness and I the inertia about the root. The substitution alpha
    = theta_p sin u removes the singularity of the energy integral at the release:

        t_c = integral over 0 <= u <= pi/2 of sqrt(I/(k + g sinc((theta_p + alpha)/2) sinc((theta_p - alpha)/2))) du

    where sinc x = sin x/x, since cos alpha - cos theta_p = 2 sin((theta_p + alpha)/2) sin((theta_p
    - alpha)/2).

    Without centrifugal stiffness the time is a quarter of the period, (pi/2) sqrt(I/k):

    >>> print(f"{stiffened_cue_time(0.5, 4.0, 0.0, 1.0):.6f}")
    0.785398
    """
    amplitude, stiff, extra, heavy = (
        np.asarray(each)[..., np.newaxis] for each in (retraction, stiffness, centrifugal, inertia)
    )
    alpha = amplitude * np.sin(np.pi / 4.0 * (_NODES + 1.0))
    shape = np.sinc(0.5 * (amplitude + alpha) / np.pi) * np.sinc(0.5 * (amplitude - alpha) / np.pi)
    return np.pi / 4.0 * np.sum(_WEIGHTS * np.sqrt(heavy) / np.sqrt(stiff + extra * shape), axis=-1)


def damped_cue_time(natural_rate: Number, damping_ratio: Number) -> Number:
    """Return the time from release at rest to the highest relative angular velocity, s.

    The centrifugal stiffness is neglected. With the natural frequency Omega (rad/s) and the damping
    ratio zeta of the belt the time is

        t = f(zeta)/Omega,    f = arccos(zeta)/sqrt(1 - zeta^2), or arccosh(zeta)/sqrt(zeta^2 - 1) for zeta > 1

    For zeta < 1 the angular velocity relative to the hub is proportional to e^(-zeta Omega t)
    sin(Omega_d t), with Omega_d = Omega sqrt(1 - zeta^2). It is largest where tan(Omega_d t) =
    sqrt(1 - zeta^2)/zeta. A damped bristle has not yet reached the radial direction at that time.

    >>> print(f"{damped_cue_time(2.0, 0.0):.6f} {damped_cue_time(2.0, 1.0):.6f}")  # (pi/2)/Omega, and 1/Omega at critical damping
    0.785398 0.500000
    """
    return _phase(damping_ratio) / natural_rate


def damped_highest_speed(retraction: Number, natural_rate: Number, damping_ratio: Number) -> Number:
    """Return the highest relative angular velocity of a bristle on a damped belt, rad/s.

    The velocity is theta_p Omega e^(-zeta f(zeta)), with the retraction theta_p at release (rad),
    the natural frequency Omega (rad/s), the damping ratio zeta and f of ``damped_cue_time``.

    >>> print(f"{damped_highest_speed(0.5, 2.0, 0.0):.6f} {damped_highest_speed(0.5, 2.0, 1.0):.6f}")  # times 1/e when critical
    1.000000 0.367879
    """
    return retraction * natural_rate * np.exp(-_phase(damping_ratio) * damping_ratio)


LEAST_TURN = 1e-100
"""Angle x (rad) below which sin(x)/x is set to 1, since the quotient would overflow."""


def released_motion(tool: Tool, retraction: float, time: Number) -> tuple[Number, Number]:
    """Return the retraction and the relative angular velocity of the bristle after its release.

    Without centrifugal stiffness the retraction is

        theta_p e^(-zeta Omega t) (cosh w t + (zeta Omega/w) sinh w t),

    with the natural angular frequency Omega, the damping ratio zeta and w = Omega sqrt(zeta^2 - 1).

    Args:
        tool: the tool.
        retraction: retraction theta_p at release, rad.
        time: time t since the release, s.

    Returns:
        The retraction, rad.
        The angular velocity relative to the hub (rad/s), positive while the retraction decreases.
    """
    rate = natural_rate(tool.belt.stiffness, tool.bristle.inertia_about_root)
    decay = tool.belt.damping_ratio * rate
    turns = 1j * np.sqrt(complex(decay**2 - rate**2)) * time
    turns = np.where(abs(turns) < LEAST_TURN, 0.0, turns)
    # sinh(w t)/w = t sin(i w t)/(i w t), which has its limit t at critical damping.
    swing = np.cos(turns)
    drift = time * np.sinc(turns / np.pi)
    fading = np.exp(-decay * time)
    position = retraction * fading * (swing + decay * drift).real
    return position, retraction * rate**2 * fading * drift.real


def _phase(damping_ratio: Number) -> Number:
    """Return f(zeta) of ``damped_cue_time``, the cue time times the natural frequency."""
    zeta = damping_ratio
    root = np.sqrt(np.abs((1.0 - zeta) * (1.0 + zeta)))
    angle = np.arccos(np.minimum(zeta, 1.0)) + np.arccosh(np.maximum(zeta, 1.0))
    return np.where(root > 0.0, angle / np.where(root > 0.0, root, 1.0), 1.0)[()]


@dataclass(frozen=True, slots=True)
class Cue:
    """The position of the bar at which the bristle strikes at its highest speed, and the motion.

    Attributes:
        impact_angle: angle of the wire to the workpart's normal at the strike, rad.
        tip_radius: distance of the tip from the hub's centre as it slips off the bar, m.
        tip_lag: angle by which the tip lags the root at that time, seen from the hub's centre, rad.
        cue_time: time from the release to the highest speed, s.
        hub_turn: angle by which the hub turns in the cue time, rad.
        highest_relative_speed: highest angular velocity of the bristle relative to the hub, rad/s.
        bar_distance: distance of the bar from the hub's centre, m.
        bar_direction: angle between the workpart's normal and the line from the hub's centre to the
            bar, tip_lag + hub_turn + impact_angle, rad.
        bar_horizontal, bar_vertical: coordinates of the bar from the hub's centre, along and normal
            to the workpart, m.
    """

    impact_angle: float
    tip_radius: float
    tip_lag: float
    cue_time: float
    hub_turn: float
    highest_relative_speed: float
    bar_distance: float
    bar_direction: float
    bar_horizontal: float
    bar_vertical: float


def cue(tool: Tool, retraction: float = RETRACTION_AT_RELEASE) -> Cue:
    """Return the bar's position by the dissertation's formulas, and the bristle's motion.

    The formulas include the belt's damping and neglect the centrifugal stiffness. ``retraction`` is
    measured at the release, rad.
    """
    rate = natural_rate(tool.belt.stiffness, tool.bristle.inertia_about_root)
    damping = tool.belt.damping_ratio
    speed = damped_highest_speed(retraction, rate, damping)
    return placed_cue(tool, retraction, damped_cue_time(rate, damping), speed)


def stiffened_cue(tool: Tool, retraction: float = RETRACTION_AT_RELEASE) -> Cue:
    """Return the cue of a bristle with centrifugal stiffness: the bar's position and the swing.

    The swing is the motion from the release to the radial direction. The belt's damping is
    neglected; without damping the result is exact. ``retraction`` is measured at the release, rad.
    """
    inertia = tool.bristle.inertia_about_root
    swing = (retraction, tool.belt.stiffness, field_stiffness(tool), inertia)
    return placed_cue(tool, retraction, stiffened_cue_time(*swing), stiffened_highest_speed(*swing))


def field_stiffness(tool: Tool) -> float:
    """Return the centrifugal stiffness g of ``centrifugal_stiffness`` for a tool, N m/rad."""
    bristle = tool.bristle
    hub = tool.hub
    return float(centrifugal_stiffness(bristle.mass, hub.radius, bristle.length, hub.speed))


def placed_cue(tool: Tool, retraction: float, time: float, relative_speed: float) -> Cue:
    """Return the bar's position for a bristle that is fastest at a given time after its release.

    The bar stands at S sin(A + theta_1 + gamma) along the workpart and S cos(A + theta_1 + gamma)
    normal to it (Zhang 2020, eq. 2.1), with the tip lag A, the hub's rotation theta_1 in the cue
    time and the impact angle gamma. S is the tip's distance from the hub's centre plus the bar's
    radius plus half the wire's diameter. The dissertation neglects the half diameter.

    Args:
        tool: the tool; it must have a bar and a workpart.
        retraction: retraction at release, rad.
        time: time from the release to the highest speed, s.
        relative_speed: highest angular velocity relative to the hub, rad/s.

    At the dissertation's operating point the retraction is 44.5 deg. The formulas of ``cue`` give:

    >>> found = cue(Tool())
    >>> print(f"{1e3 * found.tip_radius:.3f} mm, {np.degrees(found.tip_lag):.3f} deg, {1e3 * found.cue_time:.4f} ms")
    50.442 mm, 22.035 deg, 1.4631 ms
    """
    if tool.bar is None or tool.workpart is None:
        raise ValueError("bar, workpart: must both be there")
    geometry = (tool.hub.radius, tool.bristle.length)
    turn = tool.hub.speed * time
    angle = impact_angle(*geometry, tool.workpart.penetration)
    lag = tip_lag(*geometry, retraction)
    radius = tip_radius(*geometry, retraction)
    distance = tool.bar_reach + radius
    direction = lag + turn + angle
    place = (distance * np.sin(direction), distance * np.cos(direction))
    return Cue(
        *map(float, (angle, radius, lag, time, turn, relative_speed, distance, direction, *place))
    )
