"""A tool without a bar, whose bristle is thrown by its own inertia when the belt runs onto the
pulley.

On the belt's straight run the bristle translates. Where the belt meets the pulley, the root begins
to turn at the pulley's speed omega, but the bristle does not. The bristle's angle alpha from the
radial direction is therefore 0 at first, with alpha' = -omega. The bristle lags until the belt
drives it back through the radial direction. Without damping and gravity the energy in the pulley's
frame,

    I alpha'^2/2 + k alpha^2/2 + g (1 - cos alpha) = I omega^2/2,    g = m r_h (L/2) omega^2,

is conserved. I is the bristle's inertia about its root, k the belt stiffness, g the centrifugal
stiffness of ``cueing``. For any belt, the bristle is therefore radial again with alpha' = +omega.
Its absolute angular velocity is then 2 omega, and the speed of its tip is (2 L + r_h) omega. The
energy gives the largest retraction, and the quadrature of ``cueing`` the time. Arguments are single
numbers in SI units and rad.
"""

from __future__ import annotations

import math

from bristle_sim.theory.cueing import natural_rate, stiffened_cue_time, stiffened_highest_speed
from bristle_sim.theory.numbers import require

LEAST_SPEED = 1e-100  # least hub speed, rad/s; at a smaller speed the energy would underflow


def largest_retraction(
    inertia: float, stiffness: float, centrifugal: float, hub_speed: float
) -> float:
    """Return the largest retraction of a bristle that is thrown by its own inertia, rad.

    The belt carries the bristle onto the pulley, where the bristle's root begins to rotate at the
    pulley's angular velocity omega. The largest retraction is the angle alpha at which k alpha^2/2
    + g (1 - cos alpha) = I omega^2/2.

    Args:
        inertia: inertia I of the bristle about its root, kg m^2.
        stiffness: belt stiffness k, N m/rad.
        centrifugal: centrifugal stiffness g, N m/rad.
        hub_speed: angular velocity omega of the pulley, rad/s.

    Raises:
        ValueError: if the bristle would lean over by more than 90 degrees, where it lies on the
            pulley, or if the hub speed is too small.

    Without centrifugal stiffness the amplitude is omega sqrt(I/k), here 0.5 rad:

    >>> print(f"{largest_retraction(1.0, 4.0, 0.0, 1.0):.9f}")
    0.500000000
    """
    require(
        "hub_speed",
        hub_speed,
        hub_speed >= LEAST_SPEED,
        f"must be at least {LEAST_SPEED:g} (in rad/s)",
    )
    from scipy.optimize import brentq

    bristle = (stiffness, centrifugal, inertia)

    def excess(angle: float) -> float:
        """Return the potential energy at an angle over the initial kinetic energy, minus 1."""
        return float((stiffened_highest_speed(angle, *bristle) / hub_speed) ** 2) - 1.0

    flat = 0.5 * math.pi
    require(
        "stiffness",
        stiffness,
        excess(flat) >= 0.0,
        "must be enough to stop the bristle within 90 deg (in N m/rad)",
    )
    # The root is at least that of the parabola with the curvature at 0, since 1 - cos alpha grows
    # less than its parabola.
    least = hub_speed / natural_rate(stiffness + centrifugal, inertia)
    return float(brentq(excess, 0.9 * min(flat, least), flat, xtol=1e-16))


def time_to_radial(inertia: float, stiffness: float, centrifugal: float, hub_speed: float) -> float:
    """Return the time from the start of the belt's arc on the pulley to the radial direction, s.

    Arguments and errors are those of ``largest_retraction``. The bristle first swings back to its
    largest retraction and then forward to the radial direction. Both take the same time, which is
    the cue time of a bristle released at this retraction.

    Without centrifugal stiffness the time is half a period on the belt, pi sqrt(I/k), here pi/2 s:

    >>> print(f"{time_to_radial(1.0, 4.0, 0.0, 1.0):.9f}")
    1.570796327
    """
    top = largest_retraction(inertia, stiffness, centrifugal, hub_speed)
    return 2.0 * float(stiffened_cue_time(top, stiffness, centrifugal, inertia))
