"""A tool without a bar: the bristle is thrown by its own inertia when its belt runs onto the pulley.

On the belt's straight run the bristle translates; where the belt meets the pulley its root begins to turn with omega while
the bristle does not, so that relative to the radial direction it starts at alpha = 0 with alpha' = -omega. It lags, the belt
whips it back, and it passes the radial direction again. Undamped and without gravity the energy in the pulley's frame,

    I alpha'^2/2 + k alpha^2/2 + g (1 - cos alpha) = I omega^2/2,    g = m r_h (L/2) omega^2,

is kept (g is the rotating root's field, see ``cueing``), so that it is radial again with alpha' = +omega, whatever the belt:
its rate is 2 omega and its tip's speed (2 L + r_h) omega. The energy gives the largest retraction, and its quadrature the time.

Arguments are single numbers in SI units and rad.
"""

from __future__ import annotations

import math

import numpy as np

from bristle_sim.quantity import Range
from bristle_sim.theory.checks import ranges, require, single

__all__ = ["hub_speed_for_tip_speed", "largest_retraction", "radial_tip_speed", "time_to_radial"]

_arguments = ranges(
    Range("hub_speed", "rad/s", 1e-100, 1e6, True, "US 10925386"),
    Range("hub_radius", "m", 0.0, 1e3, True, "Zhang 2020, fig. 2.2"),
    Range("length", "m", 1e-30, 1e3, True, "Zhang 2020, fig. 2.2"),
    Range("inertia", "kg m^2", 1e-60, 1e6, True, "m L^2/3"),
    Range("stiffness", "N m/rad", 0.0, 1e12, True, "Zhang 2020, sec. 2.2"),
    Range("centrifugal", "N m/rad", 0.0, 1e12, True, "m r_h (L/2) omega^2"),
    Range("tip_speed", "m/s", 0.0, 1e12, True, "asked for"),
)
"""What the arguments of these names must be."""

_RULE = np.polynomial.legendre.leggauss(60)
NODES, WEIGHTS = 0.25 * math.pi * (_RULE[0] + 1.0), 0.25 * math.pi * _RULE[1]
"""Gauss-Legendre rule on (0, pi/2); the integrand is analytic there."""


@_arguments
def largest_retraction(inertia: float, stiffness: float, centrifugal: float, hub_speed: float) -> float:
    """Largest lag, the root of k alpha^2/2 + g (1 - cos alpha) = I omega^2/2, rad.

    Raises:
        ValueError: if the bristle would lean over by more than 90 degrees, where it lies on the pulley.
    """
    for name, value in (("inertia", inertia), ("stiffness", stiffness), ("hub_speed", hub_speed)):
        single(name, value)
    from scipy.optimize import brentq

    energy = 0.5 * inertia * hub_speed**2

    def excess(angle: float) -> float:
        return (0.5 * stiffness * angle**2 + 2.0 * centrifugal * math.sin(0.5 * angle) ** 2) / energy - 1.0

    flat = 0.5 * math.pi
    require(
        "stiffness", stiffness, excess(flat) >= 0.0, "must be enough to stop the bristle within 90 deg (in N m/rad)"
    )
    # Near 0 both terms are parabolas: the root is at most that of either, and at least a parabola's of the whole curvature.
    return float(brentq(excess, 0.9 * min(flat, math.sqrt(2.0 * energy / (stiffness + centrifugal))), flat, xtol=1e-16))


@_arguments
def time_to_radial(inertia: float, stiffness: float, centrifugal: float, hub_speed: float) -> float:
    """Time from the pulley's tangent point until the bristle is radial again, T = 2 int_0^A d alpha/alpha', s.

    With alpha = A sin(u) the inverse root at the turning point goes away: d alpha/alpha' = du/sqrt(k/I + (2 g/I) [cos alpha -
    cos A]/(A cos u)^2), and cos alpha - cos A = 2 sin((A + alpha)/2) sin((A - alpha)/2) with A - alpha = A cos(u)^2/(1 + sin u).
    """
    top = largest_retraction(inertia, stiffness, centrifugal, hub_speed)
    sine = np.sin(NODES)
    half = 0.5 * top * np.cos(NODES) ** 2 / (1.0 + sine)
    field = np.sin(0.5 * top * (1.0 + sine)) * np.sinc(half / math.pi) / (top * (1.0 + sine))
    return 2.0 * float(np.sum(WEIGHTS / np.sqrt((stiffness + 2.0 * centrifugal * field) / inertia)))


@_arguments
def radial_tip_speed(hub_speed: float, hub_radius: float, length: float) -> float:
    """Speed of the tip when the bristle is radial again, (2 L + r_h) omega, m/s."""
    return (2.0 * length + hub_radius) * hub_speed


@_arguments
def hub_speed_for_tip_speed(tip_speed: float, hub_radius: float, length: float) -> float:
    """Speed of the pulley for a speed of the tip when radial, rad/s."""
    return tip_speed / (2.0 * length + hub_radius)
