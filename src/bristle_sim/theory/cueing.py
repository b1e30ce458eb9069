"""Where the bar must stand so that the tip strikes at its highest speed (Zhang 2020, sec. 2.2, eqs. 2.1-2.3).

The bar releases the bristle when it lags its radial direction by the retraction theta_p. The tip then lags the hub's root
radius by A. The belt throws the bristle forward, and after the cue time t_c, in which the hub turns by theta_1, it is
fastest; it should then touch the workpart radially, at the impact angle gamma. Hence the bar's direction from the
workpart's normal, A + theta_1 + gamma.

Between contacts, with alpha the bristle's angle relative to the radial direction,

    I alpha'' + c alpha' + k alpha + g sin alpha = 0,    g = m r_h (L/2) omega^2.

The dissertation has c = g = 0. The centrifugal stiffness g is the moment about the root, with lever (L/2) sin alpha, of the
force m r_h omega^2 that acts on the centre of mass in the rotating root's frame.

Arguments are floats or arrays that broadcast, in SI units and rad. Functions raise ValueError where no such geometry or
motion exists, and where the tool lacks a part.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bristle_sim.arrays import Number
from bristle_sim.parameters import RETRACTION_AT_RELEASE, Tool
from bristle_sim.theory.numbers import require

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(
    64
)  # on [-1, 1]; 64 leave only rounding up to 150 deg


def impact_angle(hub_radius: Number, length: Number, penetration: Number) -> Number:
    """Return gamma of a radial bristle whose tip touches the workpart: cos gamma = (r_h + L - Delta)/(r_h + L), rad.

    Where the workpart cuts into half of the circle of tips, cos(gamma) = 1/2:

    >>> print(f"{np.degrees(impact_angle(0.4, 0.6, 0.5)):.6f}")
    60.000000
    """
    reach = hub_radius + length
    inside = (penetration >= 0.0) & (penetration <= reach)
    require("penetration", penetration, inside, "must be 0 to hub_radius + length (in m)")
    # arccos of nearly 1 loses half of the digits; 1 - cos gamma = 2 sin^2(gamma/2) keeps them.
    return 2.0 * np.arcsin(np.sqrt(penetration / (2.0 * reach)))


def tip_radius(hub_radius: Number, length: Number, retraction: Number) -> Number:
    """Return the distance of the tip from the hub's centre, sqrt(r_h^2 + L^2 + 2 r_h L cos theta_p), m.

    With hub and wire at a right angle, of 3 and 4 m:

    >>> print(f"{tip_radius(3.0, 4.0, np.pi / 2.0):.6f}")
    5.000000
    """
    return np.hypot(hub_radius + length * np.cos(retraction), length * np.sin(retraction))


def tip_lag(hub_radius: Number, length: Number, retraction: Number) -> Number:
    """Return A, the angle by which the tip lags the root as seen from the hub's centre, rad (fig. 2.3).

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
    """Return theta_p at which the tip slips off a bar that stands at (S_H, S_V): the inverse of tip_radius, rad.

    A bar 6 m from the hub's centre that reaches 1 m holds the tip at 5 m, as in ``tip_radius``:

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
    """Return sqrt(k/I), rad/s, of a belt stiffness in N m/rad and the inertia about the root in kg m^2.

    With ``stiffness`` k + g it is the stiffened bristle's, for small angles.

    >>> print(f"{natural_rate(9.0, 4.0):.6f}")
    1.500000
    """
    return np.sqrt(stiffness) / np.sqrt(inertia)


def centrifugal_stiffness(
    mass: Number, hub_radius: Number, length: Number, hub_speed: Number
) -> Number:
    """Return g = m r_h (L/2) omega^2, N m/rad.

    >>> print(f"{centrifugal_stiffness(2.0, 3.0, 4.0, 5.0):.6f}")  # 2 x 3 x 2 x 25
    300.000000
    """
    return 0.5 * mass * hub_radius * length * hub_speed**2


def stiffened_highest_speed(
    retraction: Number, stiffness: Number, centrifugal: Number, inertia: Number
) -> Number:
    """Return sqrt((k theta_p^2 + 2 g (1 - cos theta_p))/I), rad/s: the energy integral of the undamped motion.

    Without a belt, from 90 deg, it is a pendulum's: sqrt(2 g/I):

    >>> print(f"{stiffened_highest_speed(np.pi / 2.0, 0.0, 2.0, 1.0):.6f}")
    2.000000
    """
    chord = 2.0 * np.sin(0.5 * retraction)
    return np.sqrt(stiffness * retraction**2 + centrifugal * chord**2) / np.sqrt(inertia)


def stiffened_cue_time(
    retraction: Number, stiffness: Number, centrifugal: Number, inertia: Number
) -> Number:
    """Return the time from rest at theta_p to the radial direction, undamped, s; |theta_p| < pi.

    With alpha = theta_p sin u the energy integral becomes, without a singularity at the start,

        t_c = integral over 0 <= u <= pi/2 of sqrt(I/(k + g sinc((theta_p + alpha)/2) sinc((theta_p - alpha)/2))) du

    where sinc x = sin x/x, since cos alpha - cos theta_p = 2 sin((theta_p + alpha)/2) sin((theta_p - alpha)/2).

    Without the field it is a quarter of the period, (pi/2) sqrt(I/k):

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
    """Return the time from release at rest to the highest speed, s, without g.

        t = f(zeta)/Omega,    f = arccos(zeta)/sqrt(1 - zeta^2), or arccosh(zeta)/sqrt(zeta^2 - 1) for zeta > 1

    since alpha' = theta_p Omega/sqrt(1 - zeta^2) e^(-zeta Omega t) sin(Omega_d t), Omega_d = Omega sqrt(1 - zeta^2), is
    largest where tan(Omega_d t) = sqrt(1 - zeta^2)/zeta. The bristle is then still short of radial.

    >>> print(f"{damped_cue_time(2.0, 0.0):.6f} {damped_cue_time(2.0, 1.0):.6f}")  # (pi/2)/Omega, and 1/Omega at critical damping
    0.785398 0.500000
    """
    return _phase(damping_ratio) / natural_rate


def damped_highest_speed(retraction: Number, natural_rate: Number, damping_ratio: Number) -> Number:
    """Return the highest speed relative to the hub, theta_p Omega e^(-zeta f(zeta)), rad/s.

    >>> print(f"{damped_highest_speed(0.5, 2.0, 0.0):.6f} {damped_highest_speed(0.5, 2.0, 1.0):.6f}")  # times 1/e when critical
    1.000000 0.367879
    """
    return retraction * natural_rate * np.exp(-_phase(damping_ratio) * damping_ratio)


LEAST_TURN = 1e-100
"""Below it, rad, sin(x)/x is 1, and the quotient would overflow."""


def released_motion(tool: Tool, retraction: float, time: Number) -> tuple[Number, Number]:
    """Return retraction and speed relative to the hub of the released bristle without g, rad and rad/s, at times in s.

    alpha(t) = -theta_p e^(-zeta Omega t) (cosh w t + zeta Omega/w sinh w t),    w = Omega sqrt(zeta^2 - 1)
    """
    rate = natural_rate(tool.belt.stiffness, tool.bristle.inertia_about_root)
    decay = tool.belt.damping_ratio * rate
    turns = 1j * np.sqrt(complex(decay**2 - rate**2)) * time
    turns = np.where(abs(turns) < LEAST_TURN, 0.0, turns)
    # sinh(w t)/w = t sin(i w t)/(i w t), which has its limit t at critical damping.
    swing = np.cos(turns)
    drift = time * np.sinc(turns / np.pi)
    fading = np.exp(-decay * time)
    return retraction * fading * (
        swing + decay * drift
    ).real, retraction * rate**2 * fading * drift.real


def _phase(damping_ratio: Number) -> Number:
    """Return f(zeta); 1 at zeta = 1."""
    zeta = damping_ratio
    root = np.sqrt(np.abs((1.0 - zeta) * (1.0 + zeta)))
    angle = np.arccos(np.minimum(zeta, 1.0)) + np.arccosh(np.maximum(zeta, 1.0))
    return np.where(root > 0.0, angle / np.where(root > 0.0, root, 1.0), 1.0)[()]


@dataclass(frozen=True, slots=True)
class Cue:
    """The position of the bar that cues a tool's strike; rad, m, s, rad/s.

    gamma is the impact angle, A the tip's lag as it slips off the bar, and t_c the cue time, in which the hub turns by
    theta_1 = omega t_c. The highest speed is the bristle's relative to the hub. The bar is at the distance S from the hub's
    centre, in the direction A + theta_1 + gamma from the workpart's normal; S_H is measured along the workpart and S_V
    normal to it.
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
    """Return the dissertation's cue of a tool, without g but with the belt's damping; retraction in rad."""
    rate = natural_rate(tool.belt.stiffness, tool.bristle.inertia_about_root)
    damping = tool.belt.damping_ratio
    speed = damped_highest_speed(retraction, rate, damping)
    return placed_cue(tool, retraction, damped_cue_time(rate, damping), speed)


def stiffened_cue(tool: Tool, retraction: float = RETRACTION_AT_RELEASE) -> Cue:
    """Return the cue with centrifugal stiffening, exact for an undamped belt; retraction in rad."""
    swing = (
        retraction,
        tool.belt.stiffness,
        field_stiffness(tool),
        tool.bristle.inertia_about_root,
    )
    return placed_cue(tool, retraction, stiffened_cue_time(*swing), stiffened_highest_speed(*swing))


def field_stiffness(tool: Tool) -> float:
    """Return g of a tool, N m/rad."""
    bristle = tool.bristle
    hub = tool.hub
    return float(centrifugal_stiffness(bristle.mass, hub.radius, bristle.length, hub.speed))


def placed_cue(tool: Tool, retraction: float, time: float, relative_speed: float) -> Cue:
    """Place the bar for a cue time (2.1): S (sin, cos)(A + theta_1 + gamma) along and normal to the workpart.

    S is the tip's distance from the hub's centre plus the bar's reach, which is its radius and half the wire's diameter; the
    dissertation neglects that diameter. Retraction in rad, time in s, highest speed in rad/s.

    At the printed operating point (44.5 deg) the tip is at 50.442 mm and lags by 22.035 deg; the quarter period is 1.4631 ms and the
    highest speed 833.8 rad/s, by the plain formulas of ``cue``:

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
